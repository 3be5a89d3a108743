#!/usr/bin/env python3
"""How the cost of a frame grows: with pixels, with lights, and with the samples of a core.

Usage: growth.py [--build FOLDER] [--quick]

Frames of the examples in the build folder, with tables from the store. Prints tables and writes
FOLDER/bench/growth.json. Seconds are of the clock; compare rows of one run.
"""

import argparse
import json
import os
import pathlib
import random
import re
import tempfile

from run import render


def over(example, text):
    """A scene of an example and more opinions about it."""
    return f'#usda 1.0\n(\n    defaultPrim = "World"\n    metersPerUnit = 0.01\n    upAxis = "Y"\n    ' \
           f'subLayers = [@{example}@]\n)\n\nover "World"\n{{\n{text}}}\n'


def spheres(count):
    """So many small lights around the object, of the same power all together."""
    numbers = random.Random(1)
    text = ""
    for i in range(count):
        x, y, z = numbers.uniform(-8, 8), numbers.uniform(3, 9), numbers.uniform(-8, 8)
        text += f"""
    def SphereLight "Light{i}"
    {{
        float radius = 0.05
        float inputs:radius = 0.05
        float intensity = {4000 / count:.6g}
        float inputs:intensity = {4000 / count:.6g}
        double3 xformOp:translate = ({x:.4f}, {y:.4f}, {z:.4f})
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
"""
    return text


def core(factor):
    """Marble's core (Jensen et al. 2001), its coefficients times `factor`: samples lie by the mean free path."""
    absorption, scattering = (tuple(factor * c for c in of) for of in ((0.0021, 0.0041, 0.0071), (2.19, 2.62, 3.0)))
    return f"""
    over "Vase"
    {{
        color3f primvars:stf:coreSigmaA = {absorption}
        color3f primvars:stf:coreSigmaSPrime = {scattering}
    }}
"""


def table(title, unit, rows):
    print(f"\n{title:<22}{'seconds':>10}{unit:>22}{'to the row above':>18}")
    for before, (count, seconds) in zip([None] + rows, rows):
        growth = f"{count / before[0]:.1f}x in {seconds / before[1]:.2f}x" if before else ""
        print(f"{count:<22}{seconds:>10.2f}{1e6 * seconds / count:>22.3f}{growth:>18}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent / "build")
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    examples = build / "usd_examples"
    quick = arguments.quick
    results = {"load": os.getloadavg()[0]}

    def seconds(scene, samples, width, stage="render"):
        stats = render(build, scene, samples, width)
        return stats["seconds"][stage], stats

    pixels = []
    for width in (100, 200) if quick else (100, 200, 400, 800):
        spent, stats = seconds(examples / "marble_slab.usda", 16, width)
        pixels.append((stats["width"] * stats["height"], spent))
    table("pixels", "us a pixel", pixels)

    lights, cores = [], []
    with tempfile.TemporaryDirectory() as folder:
        scene = pathlib.Path(folder) / "scene.usda"
        for count in (1, 100) if quick else (1, 10, 100, 1000, 10000):
            scene.write_text(over(examples / "marble_slab.usda", spheres(count)))
            spent, stats = seconds(scene, 16, 100 if quick else 300)
            lights.append((count, spent))
        table("lights", "us a light", lights)

        for factor in (0.4, 1.2) if quick else (0.2, 0.4, 0.8, 1.2):
            scene.write_text(over(examples / "hero.usda", core(factor)))
            _, stats = seconds(scene, 1, 32, "core")
            why = next(e["why"] for e in stats["plan"] if e["stage"] == "core" and e["object"] == "scene")
            cores.append((int(re.search(r"first: (\d+) samples", why).group(1)), stats["seconds"]["core"]))
        table("samples of a core", "us a sample", cores)

    results.update(pixels=pixels, lights=lights, coreSamples=cores)
    target = build / "bench" / "growth.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(results, indent=1))
    print(f"\n{target}")


if __name__ == "__main__":
    main()
