#!/usr/bin/env python3
"""Time and memory of synthesis as the number of samples grows, on one mesh: is it linear?

Usage: synthesis_growth.py MESH [--build FOLDER] [--volume NAME ...] [--millions M ...]

Prints a table and writes BUILD/bench/synthesis_growth.json. Processor seconds of `stf synthesize` without its measures are
those of its stages on one thread; the last column is what a sample costs against what it costs in the first row.
"""

import argparse
import json
import os
import pathlib
import subprocess


def measure(stf, mesh, volume, samples, report):
    """One synthesis on one thread: its report, and the memory of the process in MB."""
    command = [stf, "synthesize", mesh, volume, "--samples", str(int(samples)), "--report", report, "--json", "--threads",
               "1"]
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(f"stf synthesize ended with {child.returncode}")
    return {**json.loads(report.read_text()), "megabytes": usage.ru_maxrss / 1024,
            "cpuSeconds": usage.ru_utime + usage.ru_stime}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", type=pathlib.Path)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"))
    parser.add_argument("--volume", nargs="+", default=["marble", "wax"], help="names that `stf make` knows")
    parser.add_argument("--millions", type=float, nargs="+", default=[0.1, 0.3, 1, 2, 4])
    arguments = parser.parse_args()
    stf = arguments.build.resolve() / "bin/stf"
    folder = arguments.build.resolve() / "bench"
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in arguments.volume:
        volume = folder / f"{name}.vdb"
        subprocess.run([stf, "make", name, volume], check=True, stdout=subprocess.DEVNULL)
        first = None
        print(f"\n{name:<8}{'samples':>10}{'CPU s':>9}{'MB':>7}{'us/sample':>11}{'ratio':>7}   stages, s")
        for millions in arguments.millions:
            row = measure(stf, arguments.mesh, volume, millions * 1e6, folder / "growth.json")
            each = row["cpuSeconds"] / row["samples"] * 1e6
            first = first or each
            rows.append({"volume": name, **row})
            print(f"{'':<8}{row['samples']:>10}{row['cpuSeconds']:>9.1f}{row['megabytes']:>7.0f}{each:>11.1f}"
                  f"{each / first:>7.2f}   " +
                  " ".join(f"{stage} {seconds:.1f}" for stage, seconds in row["stageSeconds"].items()), flush=True)
    target = folder / "synthesis_growth.json"
    target.write_text(json.dumps(rows, indent=1))
    print(f"\n{target}")


if __name__ == "__main__":
    main()
