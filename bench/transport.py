#!/usr/bin/env python3
"""What light transport costs: tables, walks, threads, and Mitsuba 3 beside them.

Usage: transport.py [--build FOLDER] [--quick] [--mitsuba-python PYTHON]

Prints tables and writes FOLDER/bench/transport.json (and tile_check.npz). Machines are noisy: numbers of one run
compare with each other, and the load at its beginning is written down. PYTHON is one that has mitsuba and numpy; where
it has none, or no usable variant, that part is left out with a message.
"""

import argparse
import json
import os
import pathlib
import sys
import tempfile

import transport_mitsuba
import transport_tables
from programs import Mitsuba, Skipped, Stf, threads_of_machine


def measure(build, quick, mitsuba_python, budget, names):
    """All of it; the path of the JSON."""
    stf = Stf(build)
    target = build / "bench"
    target.mkdir(exist_ok=True)
    samples = build / "usd_examples" / "volumes"
    threads = threads_of_machine()
    results = {"threads": threads, "load": os.getloadavg()[0], "quick": quick}
    print(f"{threads} threads, load before: {results['load']:.1f}\n")
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        tile = stf.make_random(folder / "tile.vdb", **transport_mitsuba.RANDOM_TILE)
        volumes = [(name, samples / f"{name}.vdb") for name in ("marble", "wax")] + [("random", tile)]
        limit = 1_000_000 if quick else 150_000_000
        results["tables"] = transport_tables.error_against_time(
            stf, [v for v in volumes if v[0] in names], budget, limit)
        results["walks"] = transport_tables.collisions_per_second(stf, folder, 1 if quick else 3)
        results["scaling"] = transport_tables.threads(stf, *volumes[0], 0.1 if quick else 0.05, limit)
        try:
            mitsuba = Mitsuba(mitsuba_python)
            results["mitsuba"] = transport_mitsuba.slabs(stf, mitsuba, folder, 0.5 if quick else 2.5,
                                                         1 if quick else 3, threads)
            results["tileCheck"] = transport_mitsuba.tile_check(
                stf, mitsuba, folder, target / "tile_check.npz", 200_000 if quick else 8_000_000,
                128 if quick else 4096, threads)
        except Skipped as reason:
            print(f"\nnot compared with Mitsuba: {reason}")
    path = target / "transport.json"
    path.write_text(json.dumps(results, indent=1))
    print(f"\n{path}")
    return path


def add_options(parser):
    """Those that run.py shares."""
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent / "build")
    parser.add_argument("--quick", action="store_true", help="small frames, few photons")
    parser.add_argument("--mitsuba-python", default=sys.executable, help="a Python with mitsuba and numpy")
    parser.add_argument("--volumes", default="marble,wax,random", help="whose tables are measured")
    parser.add_argument("--budget", type=float, help="seconds a table may take (default: 30, quick: 5)")


def main(arguments):
    measure(arguments.build.resolve(), arguments.quick, arguments.mitsuba_python,
            arguments.budget or (5 if arguments.quick else 30), arguments.volumes.split(","))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add_options(parser)
    main(parser.parse_args())
