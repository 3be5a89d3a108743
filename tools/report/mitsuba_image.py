#!/usr/bin/env python3
"""One image of a flat shell by Mitsuba 3, for `stf report`. Runs in a Python that has mitsuba and numpy.

Usage: mitsuba_image.py SCENE.json TILE_FOLDER IMAGE.exr STATS.json --samples N [--seed N] [--threads N]

SCENE.json is told by flat_shell.py, TILE_FOLDER was written by `stf inspect --raw`. STATS.json is as stfrecord's.
"""

import argparse
import json
import pathlib
import time

import mitsuba_common as common  # first: it says so where numpy is missing

import numpy as np

PASS = 64  # samples of a pixel at a time: paths of a pass are in memory together


def scene(mi, tile, told, channel, rr_depth):
    """`channel`: the colour of the lights, None for all."""
    depth = float(tile.extent[2])
    # The camera is in the medium, which begins at its planes; everything else as in mitsuba_tile.py.
    medium = common.periodic_medium(mi, tile, True)
    camera = told["camera"]
    wide = 1e4 * max(depth, *(abs(c) for c in camera["origin"]))

    def color(values):
        return {"type": "rgb", "value": list(values)} if channel is None else float(values[channel])

    lights = {}
    for i, light in enumerate(told["lights"]):
        quantity = "irradiance" if light["type"] == "directional" else "radiance"
        lights[f"light{i}"] = {**light, quantity: color(light[quantity])}
    transform = mi.ScalarTransform4f
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": rr_depth},
        "floor": {"type": "disk", "to_world": transform().translate([0, 0, -2 * depth]).scale([wide, wide, 1]),
                  "bsdf": {"type": "conductor", "specular_reflectance": 0.0}},
        **lights,
        "camera": {
            "type": "perspective", "medium": medium, "near_clip": 1e-3 * depth, "far_clip": wide,
            "fov": camera["fov"], "fov_axis": "x",
            "to_world": transform().look_at(origin=camera["origin"], target=camera["target"], up=camera["up"]),
            "film": {"type": "hdrfilm", "width": camera["width"], "height": camera["height"],
                     "rfilter": {"type": "box"}, "sample_border": False,
                     "pixel_format": "rgb" if channel is None else "luminance"},
            "sampler": {"type": "independent"}}}, optimize=False)


def render(mi, s, samples, seed):
    """Image and seconds; passes have seeds of their own."""
    total, seconds, done = 0.0, 0.0, 0
    while done < samples:
        n = min(PASS, samples - done)
        image, wall, _ = common.timed_render(mi, s, n, seed * 100_003 + done)
        total, seconds, done = total + n * image, seconds + wall, done + n
    return total / samples, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("scene", "tile", "image", "stats"):
        parser.add_argument(name, type=pathlib.Path)
    parser.add_argument("--samples", type=int, required=True)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--rr-depth", type=int, default=common.NEVER)
    arguments = parser.parse_args()

    start = time.perf_counter()
    tile = common.load_tile(arguments.tile)
    # Colours together only where the extinction is one for all (bench/mitsuba_tile.py says why).
    together = tile.extinction.ndim == 3
    mi = common.start("llvm_ad_rgb" if together else "llvm_ad_mono", arguments.threads)
    told = json.loads(arguments.scene.read_text())
    parts = [(tile, None)] if together else [(tile.channel(c), c) for c in range(3)]
    images, seconds = zip(*(render(mi, scene(mi, t, told, c, arguments.rr_depth), arguments.samples,
                                   arguments.seed + 7919 * (c or 0)) for t, c in parts))
    image = np.concatenate([i.reshape(*i.shape[:2], -1) for i in images], axis=2)
    mi.Bitmap(np.ascontiguousarray(image, np.float32)).write(str(arguments.image))
    stages = dict.fromkeys(("precompute", "synthesis", "shell", "core", "indirect"), 0.0)
    total = time.perf_counter() - start
    arguments.stats.write_text(json.dumps({
        "samples": arguments.samples, "messages": [],
        "seconds": {**stages, "load": total - sum(seconds), "firstPixel": total - sum(seconds),
                    "render": sum(seconds), "total": total}}))


if __name__ == "__main__":
    main()
