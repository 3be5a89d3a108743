#!/usr/bin/env python3
"""Times of the chain on this machine: tables, shells, frames.

Usage: run.py [--build FOLDER] [--quick]

Prints a table and writes FOLDER/bench/results.json. Machines are noisy: compare numbers of one run with each other
(ratios), not with those of another day.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile


def precompute(build, volume, quality):
    """One table from nothing, in an empty store."""
    with tempfile.TemporaryDirectory() as cache:
        command = [build / "bin/stf", "precompute", volume, "--quality", str(quality), "--cache", cache, "--json"]
        output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return json.loads(output)


def render(build, scene, samples, width):
    """One frame with tables from the store; its statistics."""
    with tempfile.TemporaryDirectory() as folder:
        stats = pathlib.Path(folder) / "stats.json"
        command = [build / "bin/stfrecord", scene, pathlib.Path(folder) / "frame.exr", "--samples", str(samples),
                   "--imageWidth", str(width), "--stats", stats, "--quiet"]
        subprocess.run(command, check=True, capture_output=True)
        return json.loads(stats.read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent / "build")
    parser.add_argument("--quick", action="store_true", help="small frames, coarse tables")
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    examples = build / "usd_examples"
    results = {"tables": [], "frames": []}

    print(f"{'table':<12}{'quality':>9}{'photons':>10}{'noise %':>9}{'MB':>7}{'s':>8}")
    for name in ("marble", "wax"):
        for quality in (0.1,) if arguments.quick else (0.1, 0.05, 0.02):
            r = precompute(build, examples / "volumes" / f"{name}.vdb", quality)
            results["tables"].append({"volume": name, "quality": quality, **r})
            print(f"{name:<12}{quality:>9}{r['photons']:>10}{100 * r['relativeError']:>9.1f}"
                  f"{r['bytes'] / 1e6:>7.1f}{r['seconds']:>8.1f}")

    print(f"\n{'frame':<14}{'samples':>8}{'shell s':>9}{'core s':>8}{'render s':>10}{'error %':>9}{'Mrays/s':>9}")
    width = 160 if arguments.quick else 400
    for name in ("marble_slab", "wax_sphere", "hero"):
        render(build, examples / f"{name}.usda", 1, 32)  # fills the store
        for samples in (4, 16) if arguments.quick else (16, 64):
            s = render(build, examples / f"{name}.usda", samples, width)
            seconds = s["seconds"]
            results["frames"].append({"scene": name, **s})
            print(f"{name:<14}{samples:>8}{seconds['shell']:>9.2f}{seconds['core']:>8.2f}{seconds['render']:>10.2f}"
                  f"{100 * s['estimatedError']:>9.2f}{s['rays'] / 1e6 / seconds['render']:>9.2f}")

    target = build / "bench" / "results.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(results, indent=1))
    print(f"\n{target}")


if __name__ == "__main__":
    main()
