#!/usr/bin/env python3
"""Times of the chain on this machine: light transport (transport.py), frames, what is left out (left_out.py), camera
rays (rays.py) and scenes without shells (plain.py).

Usage: run.py [--build FOLDER] [--quick] [--only transport|frames|left-out|rays|plain] [--mesh MESH] [--mitsuba-python PYTHON]

Prints tables and writes FOLDER/bench/transport.json, results.json and, where meshes are given, rays.json. Machines are
noisy: compare numbers of one run with each other (ratios), not with those of another day.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile

import left_out
import plain
import rays
import transport


def render(build, scene, samples, width):
    """One frame with tables from the store; its statistics."""
    with tempfile.TemporaryDirectory() as folder:
        stats = pathlib.Path(folder) / "stats.json"
        command = [build / "bin/stfrecord", scene, pathlib.Path(folder) / "frame.exr", "--samples", str(samples),
                   "--imageWidth", str(width), "--stats", stats, "--quiet"]
        subprocess.run(command, check=True, capture_output=True)
        return json.loads(stats.read_text())


def frames(build, quick):
    """Frames of the examples at two numbers of samples."""
    examples = build / "usd_examples"
    results = {"frames": []}
    print(f"\n{'frame':<14}{'samples':>8}{'shell s':>9}{'core s':>8}{'render s':>10}{'error %':>9}{'Mrays/s':>9}")
    width = 160 if quick else 400
    for name in ("marble_slab", "wax_sphere", "hero"):
        render(build, examples / f"{name}.usda", 1, 32)  # fills the store
        for samples in (4, 16) if quick else (16, 64):
            s = render(build, examples / f"{name}.usda", samples, width)
            seconds = s["seconds"]
            results["frames"].append({"scene": name, **s})
            print(f"{name:<14}{samples:>8}{seconds['shell']:>9.2f}{seconds['core']:>8.2f}{seconds['render']:>10.2f}"
                  f"{100 * s['estimatedError']:>9.2f}{s['rays'] / 1e6 / seconds['render']:>9.2f}")

    target = build / "bench" / "results.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(results, indent=1))
    print(f"\n{target}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    transport.add_options(parser)
    parser.add_argument("--only", choices=("transport", "frames", "left-out", "rays", "plain"))
    parser.add_argument("--mesh", type=pathlib.Path, action="append", default=[], help="for rays, plain: OBJ, PLY, STL or OFF")
    arguments = parser.parse_args()
    if arguments.only in (None, "transport"):
        transport.main(arguments)
    if arguments.only in (None, "frames"):
        frames(arguments.build.resolve(), arguments.quick)
    if arguments.only in (None, "left-out"):
        left_out.measure(arguments.build.resolve(), rounds=1 if arguments.quick else 3)
    if arguments.mesh and arguments.only in (None, "plain"):
        plain.measure(arguments.build.resolve(), arguments.mesh, 2 if arguments.quick else 8)
    if arguments.mesh and arguments.only in (None, "rays"):
        rays.measure(arguments.build.resolve(), arguments.mesh)


if __name__ == "__main__":
    main()
