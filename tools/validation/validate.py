#!/usr/bin/env python3
"""Measures light transport against exact solutions and writes docs/validation.md with its plots.

Usage: validate.py [--build FOLDER] [--docs FOLDER] [--quick] [--stderr 2e-4] [--seconds 4] [--quality .01]

Runs `stf slab` over tests/data/reference/slab_cases.json, renders scenes of flat shells, reads what `./run bench` has
written to FOLDER/bench (transport.json, scene_tiles.json), and fills the placeholders of validation.md.in. The
measurements are kept in FOLDER/validation.json; --replay writes the document from there again.
"""

import argparse
import json
import pathlib
import re
import tempfile
import time

import flat_scene
import plots
import scene_runs
import slab_runs
import tables

import numpy as np

TOP = pathlib.Path(__file__).resolve().parent.parent.parent
NOT_MEASURED = "*Not measured: `./run bench` has not been run in this build folder.*"
NO_TILES = "*Not measured: `bench/scene_tiles.py --mitsuba-python PYTHON` has not been run for this build folder.*"
NO_MITSUBA = "*Not measured: `./run bench --mitsuba-python PYTHON` wants a Python with Mitsuba 3.*"


def measure(arguments):
    """Everything that `stf slab` tells; minutes."""
    cases = json.loads((TOP / "tests/data/reference/slab_cases.json").read_text())
    slab = slab_runs.Slab(arguments.build, arguments.stderr, arguments.seconds, arguments.quality)
    start = time.monotonic()

    def log(text):
        print(f"[{time.monotonic() - start:5.0f} s] {text}", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        recorder = flat_scene.Recorder(arguments.build, folder)
        scenes = scene_runs.measure(slab, recorder, 0.05 if arguments.quick else 0.003, 64 if arguments.quick else 512,
                                    log)
    isotropic = next(c for c in cases["cases"] if c["n"] == 1 and c["tau"] == 16)
    return {"stderr": arguments.stderr, "seconds": arguments.seconds, "quality": arguments.quality,
            "scenes": scenes,
            "homogeneous": slab_runs.homogeneous(slab, cases["cases"], log),
            "layered": slab_runs.layered(slab, cases["layered"], log),
            "profiles": slab_runs.profiles(slab, cases["internal_fluence"], log),
            "overG": slab_runs.forms_over_g(slab, arguments.quick, log),
            "qualityCase": isotropic,
            "overQuality": slab_runs.quality(slab, isotropic, arguments.quick, log)}


def transport_chapter(bench, maps, images):
    """Placeholders filled from the benchmark; plots where there is something to plot."""
    told = dict.fromkeys(("table_costs", "walk_costs", "scaling", "time_plot"), NOT_MEASURED)
    told.update(dict.fromkeys(("mitsuba", "mitsuba_load", "tile_check", "tile_plot"), NO_MITSUBA))
    told["time_plot"] = told["mitsuba_load"] = told["tile_plot"] = ""
    if bench:
        plots.error_against_time(bench["tables"], images / "table_error_time.svg")
        scaling = bench["scaling"]
        told.update(
            table_costs=tables.table_costs(bench["tables"]), walk_costs=tables.walk_costs(bench["walks"]),
            time_plot="![Error of tables against time](images/table_error_time.svg)",
            scaling=f"The table of `{scaling['volume']}` at {100 * scaling['quality']:g} %: "
                    f"{scaling['seconds']['1']:.1f} s with one thread, {scaling['seconds']['2']:.1f} s with two, "
                    f"{scaling['speedUp']:.2f} times as fast. The machine had {bench['threads']} processors and a load "
                    f"of {bench['load']:.1f} before this began.")
    if bench and "mitsuba" in bench:
        told.update(mitsuba=tables.mitsuba(bench["mitsuba"]),
                    mitsuba_load=f"The machine was not idle (a load of {bench['load']:.1f} on {bench['threads']} "
                                 "processors before it began), so processor time says more than the clock.")
    if bench and bench.get("tileCheck") and maps.exists():
        check = bench["tileCheck"]
        with np.load(maps) as layers:
            plots.tile(dict(layers), images / "tile_check.png")
        tile, size = check["tile"], "x".join(map(str, check["tile"]["size"]))
        told.update(
            tile_plot="![Maps of one tile by walks, Mitsuba and tables](images/tile_check.png)",
            tile_check=f"A {size} tile of random voxels (extinction log-uniform over 1 to {tile['ratio']:g}, mean "
                       f"optical depth {tile['tau']:g}, albedo {tile['albedo']:g}, g = {tile['g']:g}), oblique light. "
                       f"Walks against Mitsuba: chi-square {check['chiSquarePerPixel']:.3f} for each of "
                       f"{check['pixels']} pixels (noise {100 * check['noise']:.1f} % of the mean, largest deviation "
                       f"{check['largestSigmas']:.1f} sigma), means {100 * check['meanDifference']:+.3f} % apart, "
                       f"+- {100 * check['meanDifferenceStderr']:.3f} %. Against the walks, the `dE1` map is "
                       f"{100 * check['dE1']['meanDifference']:+.2f} % off in the mean and "
                       f"{100 * check['dE1']['rms']:.2f} % rms by pixel (noise taken away), the `classic` one "
                       f"{100 * check['classic']['meanDifference']:+.2f} % and {100 * check['classic']['rms']:.2f} %.")
    return told


def scene_chapter(found, bench, maps, images):
    """Rendered scenes: flat slabs, and heterogeneous tiles beside Mitsuba."""
    told = {"scene_quality": f"{100 * found['quality']:g}", "scene_tables": tables.views(found["tables"]),
            "scene_walks": tables.views(found["walks"]), "furnaces": tables.views(found["furnaces"]),
            "reciprocity": tables.reciprocity(found["reciprocity"]), "scene_tiles": NO_TILES, "scene_tile_plot": ""}
    if bench and maps.exists():
        with np.load(maps) as layers:
            plots.scene_tiles(dict(layers), [r["case"] for r in bench["rows"]], images / "scene_tiles.png")
        told.update(scene_tiles=tables.scene_tiles(bench["rows"]),
                    scene_tile_plot="![Rendered tiles, Mitsuba and differences](images/scene_tiles.png)")
    return told


def write_document(told, docs):
    """The template with all placeholders filled; one that nobody fills is a mistake."""
    text = (pathlib.Path(__file__).resolve().parent / "validation.md.in").read_text()
    text = re.sub(r"@(\w+)@", lambda m: str(told[m.group(1)]), text)
    path = docs / "validation.md"
    path.write_text(re.sub(r"\n{3,}", "\n\n", text))
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=TOP / "build")
    parser.add_argument("--docs", type=pathlib.Path, default=TOP / "docs")
    parser.add_argument("--quick", action="store_true", help="few photons, fewer points of the plots")
    parser.add_argument("--stderr", type=float, help="wanted of R and T by walks (default: 2e-4, quick: 2e-3)")
    parser.add_argument("--seconds", type=float, help="limit of one walk (default: 4, quick: 0.5)")
    parser.add_argument("--quality", type=float, help="of tables (default: .01, quick: .05)")
    parser.add_argument("--replay", action="store_true", help="write the document from the last measurements")
    arguments = parser.parse_args()
    arguments.stderr = arguments.stderr or (2e-3 if arguments.quick else 2e-4)
    arguments.seconds = arguments.seconds or (0.5 if arguments.quick else 4)
    arguments.quality = arguments.quality or (0.05 if arguments.quick else 0.01)

    kept = arguments.build / "validation.json"
    if not arguments.replay:
        kept.write_text(json.dumps(measure(arguments), indent=1))
    found = json.loads(kept.read_text())
    images = arguments.docs / "images"
    images.mkdir(parents=True, exist_ok=True)
    plots.forms(found["overG"], images / "forms_over_g.svg")
    plots.quality(found["overQuality"], images / "error_over_quality.svg")
    case = found["qualityCase"]
    bench = arguments.build / "bench" / "transport.json"
    tiles = arguments.build / "bench" / "scene_tiles.json"
    told = {
        "walk_stderr": f"{found['stderr']:g}", "walk_seconds": f"{found['seconds']:g}",
        "table_quality": f"{100 * found['quality']:g}",
        "walks": tables.walks(found["homogeneous"]), "chi_square": tables.chi_square(found["homogeneous"]),
        "forms": tables.forms(found["homogeneous"]), "layers": tables.layers(found["layered"]),
        "profiles": tables.profiles(found["profiles"]), "over_g": tables.over_g(found["overG"]),
        "quality": tables.quality(found["overQuality"]),
        "quality_case": f"tau {case['tau']:g}, albedo {case['albedo']:g}, isotropic, index 1",
        **scene_chapter(found["scenes"], json.loads(tiles.read_text()) if tiles.exists() else None,
                        tiles.with_suffix(".npz"), images),
        **transport_chapter(json.loads(bench.read_text()) if bench.exists() else None,
                            arguments.build / "bench" / "tile_check.npz", images)}
    print(write_document(told, arguments.docs))


if __name__ == "__main__":
    main()
