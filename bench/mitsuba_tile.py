#!/usr/bin/env python3
"""Radiance map of a periodic tile of translucent voxels under parallel light, by Mitsuba 3.

Usage: mitsuba_tile.py TILE.npz|FOLDER OUT.npz --light 0,0,1 [--samples 1024] [--threads 2]

TILE.npz: extinction [nz,ny,nx] or [nz,ny,nx,3] in 1/mm, albedo likewise, g, voxel_mm [3]; constant in each voxel,
periodic in x and y, z = 0 the top layer. --light points to the light in x, y and the outward normal; its irradiance on
a plane facing it is 1. Index 1, black below. OUT.npz: radiance [ny,nx] or [ny,nx,3] towards a viewer straight above,
the mean over each column of voxels, its stderr (from the spread of the renders) and the seconds (all renders at the
pace of the quickest), cpu_seconds and samples (a pixel's).
"""

import argparse
import json
import sys

import mitsuba_common as common  # first: it says so where numpy is missing

import numpy as np


def scene(mi, tile, light, integrator, rr_depth):
    transform = mi.ScalarTransform4f
    nx, ny, _ = tile.size
    width, height, depth = (float(length) for length in tile.extent)
    medium = common.periodic_medium(mi, tile, True)
    # Mitsuba takes a parallel light to shine from the scene's bounding sphere. The medium has no bounds of its own, so
    # a wide black floor below it says how far that is; nothing else is needed, for the medium ends at its planes.
    wide = 1e4 * max(width, height, depth)
    to_film = transform().scale([width / 2, height / 2 * nx / ny, 1])
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": integrator, "max_depth": -1, "rr_depth": rr_depth},
        "light": {"type": "directional", "direction": [-float(c) for c in light], "irradiance": 1.0},
        "floor": {"type": "disk", "to_world": transform().translate([0, 0, -2 * depth]).scale([wide, wide, 1]),
                  "bsdf": {"type": "conductor", "specular_reflectance": 0.0}},
        "camera": {
            "type": "orthographic", "medium": medium, "near_clip": 1e-7 * depth, "far_clip": wide,
            "to_world": transform().look_at(origin=[width / 2, height / 2, 0], target=[width / 2, height / 2, -depth],
                                            up=[0, 1, 0]) @ to_film,
            "film": {"type": "hdrfilm", "width": nx, "height": ny, "rfilter": {"type": "box"}, "sample_border": False,
                     "pixel_format": "rgb" if tile.albedo.ndim == 4 else "luminance"},
            "sampler": {"type": "independent"},
        },
    }, optimize=False)


def radiance(mi, tile, light, arguments):
    """Renders [renders,ny,nx,channels] of a tile of one extinction, seconds, seconds of CPU and the roulette."""
    spp = max(arguments.samples // arguments.renders, 1)

    def build(rr_depth):
        return scene(mi, tile, light, arguments.integrator, rr_depth)

    rr_depth = common.roulette(mi, arguments.rr_depth, build, spp, tile.albedo.max(), tile.steps)
    s = build(rr_depth)
    first = 1 + arguments.seed * (arguments.renders + 1)
    common.timed_render(mi, s, spp, first)  # compiles
    renders = [common.timed_render(mi, s, spp, first + 1 + i) for i in range(arguments.renders)]
    # The camera looks down with +y up: the image's first row is the tile's last.
    images = np.stack([image.reshape(tile.size[1], tile.size[0], -1)[::-1] for image, _, _ in renders])
    return (images, min(wall for _, wall, _ in renders) * len(renders),
            min(cpu for _, _, cpu in renders) * len(renders), rr_depth)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tile", help=".npz, .json or a folder of stf inspect --raw")
    parser.add_argument("output", help=".npz")
    parser.add_argument("--light", default="0,0,1",
                        help="x,y,z towards the light, z outward (as --light=-1,0,1 where x is negative)")
    parser.add_argument("--samples", type=int, default=1024, help="walks a pixel, over all renders")
    parser.add_argument("--renders", type=int, default=16, help="of different seeds")
    parser.add_argument("--threads", type=int, default=0, help="0 = all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--variant", help="of Mitsuba; llvm_ad_rgb where only albedo has colours, else llvm_ad_mono")
    parser.add_argument("--integrator", choices=("volpath", "volpathmis"), default="volpath")
    parser.add_argument("--rr-depth", default="auto", help="first depth of Russian roulette, 'never', or by trial")
    arguments = parser.parse_args()

    light = np.array([float(c) for c in arguments.light.split(",")])
    if light.shape != (3,) or not light[2] > 0:
        parser.error("--light x,y,z with z > 0")
    light /= np.linalg.norm(light)
    tile = common.load_tile(arguments.tile)
    coloured = tile.extinction.ndim == 4 or tile.albedo.ndim == 4
    # Walks carry all colours at once only where the extinction is one for all: else a walk chosen for one colour is a
    # poor sample of another, and a render for each colour is both quicker and less noisy.
    together = tile.albedo.ndim == 4 and tile.extinction.ndim == 3
    variant = arguments.variant or ("llvm_ad_rgb" if together else "llvm_ad_mono")
    together = together and variant.endswith("rgb")
    mi = common.start(variant, arguments.threads)

    tiles = [tile] if together or not coloured else [tile.channel(c) for c in range(3)]
    parts = [radiance(mi, t, light, arguments) for t in tiles]
    images = np.concatenate([part[0] for part in parts], axis=3)
    if not coloured:
        images = images[..., :1]
    mean, stderr = images.mean(axis=0), images.std(axis=0, ddof=1) / np.sqrt(len(images))
    if not coloured:
        mean, stderr = mean[..., 0], stderr[..., 0]
    seconds, cpu_seconds = sum(part[1] for part in parts), sum(part[2] for part in parts)
    samples = max(arguments.samples // arguments.renders, 1) * arguments.renders
    np.savez(arguments.output, radiance=mean, stderr=stderr, seconds=seconds, cpu_seconds=cpu_seconds, samples=samples)
    json.dump({"mean": np.atleast_1d(mean.mean(axis=(0, 1))).tolist(),
               "stderr": np.atleast_1d(np.sqrt((stderr**2).mean(axis=(0, 1)))).tolist(),
               "seconds": seconds, "cpu_seconds": cpu_seconds, "samples": samples, "variant": variant,
               "integrator": arguments.integrator, "rr_depth": [common.roulette_name(part[3]) for part in parts],
               "mitsuba": mi.__version__}, sys.stdout)
    print()


if __name__ == "__main__":
    main()
