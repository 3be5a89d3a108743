#!/usr/bin/env python3
"""Camera rays a second of the renderer beside bare Embree (needs stf_bench_rays), over meshes of files.

Usage: rays.py MESH... [--build FOLDER]

`first hit`: rays of the camera with what they meet, its position, normal and other AOVs. `picture`: samples of a picture
of a white surface under one distant light, shadow rays counted too. Both over what a loop of nothing but Embree's
queries makes of the same rays in the same run. Prints a table and writes FOLDER/bench/rays.json.
"""

import argparse
import json
import os
import pathlib

from programs import run_json, threads_of_machine


def measure(build, meshes):
    program = build / "bin" / "stf_bench_rays"
    if not program.exists():
        raise SystemExit("build the target stf_bench_rays first")
    rows = []
    print(f"millions a second {'triangles':>12}{'bare':>8}{'scene':>8}{'first hit':>11}{'of bare':>9}"
          f"{'bare, shadows':>15}{'picture':>9}{'of bare':>9}")
    for mesh in meshes:
        r = run_json([program, mesh])[0]
        rows.append({"mesh": mesh.name, **r})
        print(f"{mesh.name:<18}{r['triangles']:>12}{r['bare'] / 1e6:>8.2f}{r['scene'] / 1e6:>8.2f}"
              f"{r['firstHit'] / 1e6:>11.2f}{r['firstHitOfBare']:>9.2f}{r['bareWithShadows'] / 1e6:>15.2f}"
              f"{r['picture'] / 1e6:>9.2f}{r['pictureOfBare']:>9.2f}")
    target = build / "bench" / "rays.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps({"threads": threads_of_machine(), "load": os.getloadavg()[0], "rays": rows}, indent=1))
    print(f"\n{target}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", type=pathlib.Path, nargs="+")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent / "build")
    arguments = parser.parse_args()
    measure(arguments.build.resolve(), arguments.mesh)


if __name__ == "__main__":
    main()
