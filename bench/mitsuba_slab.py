#!/usr/bin/env python3
"""Total reflectance of a translucent slab by Mitsuba 3, and the variance it reaches in a second.

Usage: mitsuba_slab.py --tau 10 --albedo .99 --g .9 [--threads 2]
       mitsuba_slab.py --volume TILE.npz|FOLDER | --random 64,64,32 --ratio 100 --tau 10 --albedo .95

Normal incidence, index 1, black below, no sides. By reciprocity R is the radiance seen straight down when radiance 1
shines in from the whole upper hemisphere, so walks start at the camera and count when they leave through the top.
Prints JSON: R, stderr, seconds, samples, variance_seconds (stderr^2 seconds), cpu_seconds and the set-up used.

What is set in Mitsuba's favour: the camera stands inside the slab's top face, so no walk pays for an entry; nothing is
asked of an emitter at a vertex, because meeting it on escape has less variance x time here; the emitter is the top
face itself; kernels are compiled before the clock starts; and Russian roulette's start is chosen by trial.
"""

import argparse
import json
import sys

import mitsuba_common as common  # first: it says so where numpy is missing

import numpy as np

PIXELS = 16  # a side of the film; its 256 pixels are independent estimates of one R


def random_tile(size, ratio, tau, albedo, g, seed):
    """Independent voxels, extinction log-uniform over a range of `ratio`, with a mean optical thickness of tau."""
    nx, ny, nz = size
    extinction = np.exp(np.random.default_rng(seed).random((nz, ny, nx)) * np.log(ratio))
    return common.Tile(extinction * (tau / (nz * extinction.mean())), albedo, g)


def scene(mi, arguments, tile, rr_depth):
    transform = mi.ScalarTransform4f
    lit = arguments.emitter == "nee"
    black = {"type": "conductor", "specular_reflectance": 0.0}  # ends walks without asking for light
    clear = {"type": "null"}
    if tile is None:
        # 1 mm thick. The null bottom leads to nothing, which is as black as black and has one material to call less.
        width, height, depth, gap = 1e-3, 1e-3, 1.0, 0.0
        medium = mi.load_dict({"type": "homogeneous", "sigma_t": arguments.tau, "albedo": arguments.albedo,
                               "phase": common.phase_function(arguments.g), "has_spectral_extinction": False,
                               "sample_emitters": lit})
    else:
        # A period a pixel. The medium ends by itself; the top's emitter stands a little above it.
        width, height, depth = tile.extent
        width, height = PIXELS * width, PIXELS * height
        gap = 0.01 * depth
        medium = common.periodic_medium(mi, tile, lit)
    # Disks meet rays quicker than rectangles. This wide, walks that leave at the side are none.
    wide = transform().scale([1e4 * max(width, depth), 1e4 * max(width, depth), 1])
    down = transform().rotate([1, 0, 0], 180)
    top = {"type": "disk", "to_world": transform().translate([0, 0, gap]) @ down @ wide, "exterior": medium,
           "bsdf": clear if lit or tile is None else black}
    # In the medium below its face by nothing that matters: a face met at distance 0 would count as an escape.
    camera = transform().look_at(origin=[0, 0, 0 if gap else -1e-7 * depth], target=[0, 0, -depth], up=[0, 1, 0])
    content = {
        "type": "scene",
        "integrator": {"type": arguments.integrator, "max_depth": -1, "rr_depth": rr_depth},
        "top": top,
        "camera": {
            "type": "orthographic", "medium": medium, "near_clip": 1e-7 * depth, "far_clip": 1e4 * depth,
            "to_world": camera @ transform().scale([width / 2, height / 2, 1]),
            "film": {"type": "hdrfilm", "width": PIXELS, "height": PIXELS, "pixel_format": "luminance",
                     "rfilter": {"type": "box"}, "sample_border": False},
            "sampler": {"type": "independent"},
        },
    }
    if lit:
        content["sky"] = {"type": "constant", "radiance": 1.0}
    else:
        top["emitter"] = {"type": "area", "radiance": 1.0}
    if lit or tile is None:
        content["bottom"] = {"type": "disk", "to_world": transform().translate([0, 0, -depth - gap]) @ wide,
                             "exterior": medium, "bsdf": black if lit else clear}
    # Unoptimised, because the optimiser of 3.9 merges faces of one material into one mesh, whose emitter sampling
    # through null faces is then wrong (R + T = 1.17 of a white slab).
    return mi.load_dict(content, optimize=False)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tau", type=float, help="optical thickness; of a volume its mean, rescaled")
    parser.add_argument("--albedo", type=float)
    parser.add_argument("--g", type=float, default=0.0, help="Henyey-Greenstein")
    parser.add_argument("--volume", metavar="FILE",
                        help=".npz or .json (extinction, albedo, g, voxel_mm), .npy, or a folder of stf inspect --raw")
    parser.add_argument("--random", metavar="NX,NY,NZ", help="a random volume in its place")
    parser.add_argument("--ratio", type=float, default=100.0, help="largest extinction of --random / smallest")
    parser.add_argument("--save-volume", metavar="FILE.npz", help="write the volume, for another program")
    parser.add_argument("--samples", type=int, default=1 << 20, help="walks in a render")
    parser.add_argument("--repeats", type=int, default=3, help="renders; the quickest gives the pace")
    parser.add_argument("--threads", type=int, default=0, help="0 = all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--variant", default="llvm_ad_mono",
                        help="of Mitsuba; grey has a third of the channels of llvm_ad_rgb")
    parser.add_argument("--integrator", choices=("volpath", "volpathmis"), default="volpath")
    parser.add_argument("--emitter", choices=("escape", "nee"), default="escape",
                        help="meet the emitter on escape, or sample it at each vertex too")
    parser.add_argument("--rr-depth", default="auto", help="first depth of Russian roulette, 'never', or by trial")
    arguments = parser.parse_args()

    tile = None
    if arguments.volume:
        tile = common.load_tile(arguments.volume, arguments.albedo, arguments.g)
        if tile.extinction.ndim == 4 or tile.albedo.ndim == 4:
            tile = tile.channel(0)
        if arguments.tau:
            mean = tile.extinction.mean() * tile.extent[2]
            tile = common.Tile(tile.extinction * (arguments.tau / mean), tile.albedo, tile.g, tile.voxel_mm)
    elif arguments.tau is None or arguments.albedo is None:
        parser.error("--tau and --albedo, or --volume")
    elif arguments.random:
        size = [int(n) for n in arguments.random.split(",")]
        tile = random_tile(size, arguments.ratio, arguments.tau, arguments.albedo, arguments.g, arguments.seed)
    if tile is not None and arguments.save_volume:
        tile.save(arguments.save_volume)

    mi = common.start(arguments.variant, arguments.threads)
    spp = max(arguments.samples // PIXELS**2, 4)
    albedo, steps = (arguments.albedo, 1) if tile is None else (tile.albedo.max(), tile.steps)
    rr_depth = common.roulette(mi, arguments.rr_depth, lambda depth: scene(mi, arguments, tile, depth),
                               max(spp // 4, 256), albedo, steps)
    s = scene(mi, arguments, tile, rr_depth)
    first = 1 + arguments.seed * (arguments.repeats + 1)
    common.timed_render(mi, s, spp, first)  # compiles
    renders = [common.timed_render(mi, s, spp, first + 1 + i) for i in range(arguments.repeats)]
    pixels = np.concatenate([image.ravel() for image, _, _ in renders])
    # All renders together, each at the pace of the quickest.
    seconds = min(wall for _, wall, _ in renders) * arguments.repeats
    stderr = pixels.std(ddof=1) / np.sqrt(pixels.size)
    json.dump({
        "R": pixels.mean(), "stderr": stderr, "seconds": seconds, "samples": spp * pixels.size,
        "variance_seconds": stderr**2 * seconds, "cpu_seconds": min(cpu for _, _, cpu in renders) * arguments.repeats,
        "variant": arguments.variant, "integrator": arguments.integrator, "emitter": arguments.emitter,
        "rr_depth": common.roulette_name(rr_depth), "threads": arguments.threads,
        "mitsuba": mi.__version__,
    }, sys.stdout)
    print()


if __name__ == "__main__":
    main()
