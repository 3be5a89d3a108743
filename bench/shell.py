#!/usr/bin/env python3
"""What shell grids cost: time and memory by voxel count, and lookups a second (needs stf_bench_shell for those).

Usage: shell.py MESH [--build FOLDER] [--quick]

MESH is a closed OBJ, PLY, STL or OFF, such as the Stanford bunny. Prints tables and writes FOLDER/bench/shell.json.
"""

import argparse
import json
import os
import pathlib
import tempfile

from programs import Stf, run_json, threads_of_machine


def building(stf, mesh, wanted):
    """Grids of growing size, one level each; coordinates are of the quickest kind, so that the grid is what is timed."""
    rows = []
    print(f"{'samples':>12}{'seconds':>9}{'cpu s':>8}{'bytes each':>12}{'peak MB':>9}{'M/s and core':>14}")
    with tempfile.TemporaryDirectory() as scratch:
        volume = pathlib.Path(scratch) / "uniform.vdb"
        stf("make", "uniform", volume)
        common = ("shell", mesh, volume, "--mapping", "anywhere", "--samples", 300000, "--levels", 1, "--memory", 1e6)
        first = stf(*common, "--voxel", stf(*common)["thickness"] / 16)
        voxel, samples = first["levels"][0]["voxel"], first["levels"][0]["samples"]
        for count in wanted:
            r = stf(*common, "--voxel", voxel * (samples / count) ** (1 / 3) * 0.97)
            level = r["levels"][0]
            rows.append({"samples": level["samples"], "seconds": r["stageSeconds"]["grid"],
                         "cpuSeconds": r["cpu_seconds"], "bytes": level["bytes"], "peakBytes": r["peakBytes"]})
            print(f"{level['samples']:>12}{r['stageSeconds']['grid']:>9.2f}{r['cpu_seconds']:>8.2f}"
                  f"{level['bytes'] / level['samples']:>12.1f}{r['peakBytes'] / 1e6:>9.0f}"
                  f"{level['samples'] / 1e6 / r['cpu_seconds']:>14.2f}")
    return rows


def lookups(build, mesh, wanted):
    """Along rays and at random, in grids of several sizes."""
    program = build / "bin" / "stf_bench_shell"
    if not program.exists():
        print("\nno lookups: build the target stf_bench_shell")
        return []
    rows = []
    print(f"\nmillions a second{'lookup':>10}{'prefetched':>12}{'bare':>8}{'of bare':>9}{'index':>8}{'OpenVDB':>9}"
          f"{'NanoVDB':>9}")
    for count in wanted:
        r = run_json([program, mesh, "--samples", count, "--lookups", 1_000_000])[0]
        rows.append(r)
        for kind in ("rays", "random"):
            k = r[kind]
            print(f"{r['samples']:>10} {kind:<6}{k['lookup'] / 1e6:>10.2f}{k['lookupPrefetched'] / 1e6:>12.2f}"
                  f"{k['bare'] / 1e6:>8.2f}{k['ofBare']:>9.2f}{k['index'] / 1e6:>8.1f}{k['indexOpenVDB'] / 1e6:>9.1f}"
                  f"{k.get('indexNanoVDB', 0) / 1e6:>9.1f}")
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", type=pathlib.Path)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent / "build")
    parser.add_argument("--quick", action="store_true", help="small grids")
    arguments = parser.parse_args()
    build = arguments.build.resolve()
    print(f"{threads_of_machine()} threads, load before: {os.getloadavg()[0]:.1f}\n")
    results = {
        "threads": threads_of_machine(), "load": os.getloadavg()[0],
        "building": building(Stf(build), arguments.mesh, (1e5, 1e6) if arguments.quick else (1e6, 5e6, 2e7, 5e7)),
        "lookups": lookups(build, arguments.mesh, (1e5,) if arguments.quick else (5e4, 1e6, 2e7)),
    }
    target = build / "bench" / "shell.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(results, indent=1))
    print(f"\n{target}")


if __name__ == "__main__":
    main()
