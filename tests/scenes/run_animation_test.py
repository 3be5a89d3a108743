#!/usr/bin/env python3
"""Renders all frames of a scene whose mesh has a rest pose, and checks that only its pose is made anew.

    run_animation_test.py --stfrecord BIN --scene FILE --output FOLDER --frames A:B

The cache starts out empty. In a second run the synthesised map comes from there.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np

from compare_images import read_rgb


def render(arguments, frames, cache, name):
    """Runs stfrecord; returns the statistics of each frame and the images."""
    folder = arguments.output / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    command = [arguments.stfrecord, arguments.scene, folder / "####.exr", "--frames", frames, "--stats"]
    command += [folder / "stats.json", "--imageWidth", 48, "--samples", 4, "--threads", 2, "--seed", 1]
    subprocess.run([str(part) for part in command], check=True, env={**os.environ, "HDSTF_CACHE_DIR": str(cache)})
    stats = json.loads((folder / "stats.json").read_text())
    return stats, [read_rgb(image) for image in sorted(folder.glob("*.exr"))]


def entry(stats, stage):
    (found,) = [e for e in stats["plan"] if e["object"].endswith("Body") and e["stage"] == stage]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stfrecord", required=True)
    parser.add_argument("--scene", required=True)
    parser.add_argument("--output", required=True, type=pathlib.Path)
    parser.add_argument("--frames", required=True)
    arguments = parser.parse_args()
    first, last = map(int, arguments.frames.split(":"))
    cache = arguments.output / "cache"
    shutil.rmtree(cache, ignore_errors=True)

    stats, images = render(arguments, arguments.frames, cache, "frames")
    assert len(stats) == len(images) == last - first + 1
    made = [frame["made"] for frame in stats]
    print(made[-1])
    assert all(m["syntheses"] == 1 and m["grids"] == 1 for m in made)
    assert made[0]["poses"] == 0, "the first frame is the rest pose"
    for before, after, frame in zip(stats, stats[1:], stats[1:]):
        assert after["made"]["poses"] - before["made"]["poses"] == int(entry(frame, "pose")["runs"])
        for stage in ("synthesis", "shell", "surface"):
            assert not entry(frame, stage)["runs"] and "already in memory" in entry(frame, stage)["why"]
    poses = [image for image, frame in zip(images, stats) if entry(frame, "pose")["runs"]]
    assert len(poses) > len(images) // 2
    assert all(np.all(np.isfinite(image)) for image in images)
    assert all(np.abs(a - b).max() > 0.05 for a, b in zip(images, images[1:])), "it moves"
    assert not [m for m in stats[-1]["messages"] if m["severity"] == "error"]

    # Another run finds the map on disk and gives the same picture.
    again, pictures = render(arguments, str(first + 3), cache, "again")
    assert again["made"]["syntheses"] == 0
    assert "kept from an earlier run" in entry(again, "synthesis")["why"]
    assert np.array_equal(pictures[0], images[3])


if __name__ == "__main__":
    sys.exit(main())
