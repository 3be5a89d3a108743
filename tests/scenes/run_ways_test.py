#!/usr/bin/env python3
"""Renders a scene by UsdImaging's scene delegate and by its scene indices: the pictures of all frames are the same.

    run_ways_test.py --stfrecord BIN --scene FILE --output FOLDER

What hdStf adds to the scene indices of its renderer (sceneIndexPlugins.cpp) is seen only here: the Hydra
tests have a delegate of their own, for which Hydra finds no plugins.
"""

import argparse
import pathlib
import subprocess
import sys

import numpy as np
import OpenEXR

FRAMES = "1,2,3"
AOVS = "color,depth,normal,primId,albedo"


def render(arguments, name, *options):
    """All channels by frame and name."""
    for image in arguments.output.glob(f"{name}.*.exr"):
        image.unlink()
    command = [arguments.stfrecord, arguments.scene, arguments.output / f"{name}.####.exr", "--frames", FRAMES, "--quiet",
               "--imageWidth", 96, "--samples", 8, "--seed", 1, "--threads", 2, "--aov", AOVS]
    subprocess.run([str(part) for part in [*command, *options]], check=True)
    channels = {}
    for image in sorted(arguments.output.glob(f"{name}.*.exr")):
        with OpenEXR.File(str(image), separate_channels=True) as file:
            channels |= {f"frame {image.suffixes[-2][1:]} {channel}": np.array(pixels.pixels)
                         for part in file.parts for channel, pixels in part.channels.items()}
    return channels


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stfrecord", required=True)
    parser.add_argument("--scene", required=True)
    parser.add_argument("--output", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    delegate, indices = render(arguments, "delegate"), render(arguments, "indices", "--sceneIndices")
    if delegate.keys() != indices.keys():
        sys.exit(f"channels {sorted(delegate)} and {sorted(indices)}")
    for channel, pixels in sorted(delegate.items()):
        others = indices[channel]
        if "primId" in channel:  # numbers go by who came first; -1, where nothing is, is kept without a sign
            pixels, others = pixels.astype(np.uint32) == 2**32 - 1, others.astype(np.uint32) == 2**32 - 1
        if not np.array_equal(pixels, others, equal_nan=pixels.dtype.kind == "f"):
            off = np.abs(pixels.astype(np.float64) - others.astype(np.float64))
            sys.exit(f"{channel}: {np.count_nonzero(off)} of {off.size} pixels differ, by up to {np.nanmax(off)}")
    if not all(np.ptp(pixels) > 0.05 for channel, pixels in delegate.items() if channel.endswith(" R")):
        sys.exit("nothing to be seen")


if __name__ == "__main__":
    main()
