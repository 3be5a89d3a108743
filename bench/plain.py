#!/usr/bin/env python3
"""What shells cost a scene that has none (needs stf_bench_plain and stf_bench_plain_without_shells).

Usage: plain.py MESH... [--build FOLDER] [--rounds N]

The same picture by the renderer and by a copy of it in which paths know of no shell, by turns; the quickest pass of
each counts. Both pictures have to be the same. Prints a table and writes FOLDER/bench/plain.json.
"""

import argparse
import json
import os
import pathlib

from programs import run_json


def measure(build, meshes, rounds):
    programs = [build / "bin" / name for name in ("stf_bench_plain", "stf_bench_plain_without_shells")]
    for program in programs:
        if not program.exists():
            raise SystemExit(f"build the target {program.name} first")
    runs = [[], []]
    for _ in range(rounds):
        for way, program in enumerate(programs):
            runs[way].append(run_json([program, *meshes])[0])
    if len({(r["rays"], r["sum"]) for r in runs[0] + runs[1]}) > 1:
        raise SystemExit("the two pictures are not the same")
    best = [min(r["seconds"] for r in way) for way in runs]
    row = {"meshes": [m.name for m in meshes], "rays": runs[0][0]["rays"], "seconds": best[0],
           "secondsWithoutShells": best[1], "ratio": best[0] / best[1], "load": os.getloadavg()[0]}
    print(f"a pass over {', '.join(row['meshes'])}: {1e3 * best[0]:.1f} ms, with the code of shells left out"
          f" {1e3 * best[1]:.1f} ms: {row['ratio']:.3f}")
    target = build / "bench" / "plain.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(row, indent=1))
    print(target)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", type=pathlib.Path, nargs="+")
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent / "build")
    parser.add_argument("--rounds", type=int, default=6, help="of both programs (%(default)s)")
    arguments = parser.parse_args()
    measure(arguments.build.resolve(), arguments.mesh, arguments.rounds)


if __name__ == "__main__":
    main()
