#!/usr/bin/env python3
"""Renders a marble ball in Blender's Python module through the add-on, and judges pictures and messages.

    run_blender_test.py --python PYTHON --bpy FOLDER --addon FOLDER --plugin FOLDER --volume FILE --output FOLDER

PYTHON is of the version that the module bpy in FOLDER is for. The plugin has to be built for its OpenUSD. Where bpy cannot be
imported the test is skipped (exit code 77) with a sentence.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np

import hosts

SIZE = (120, 100)
SKIPPED = 77


def picture(output, name):
    """A picture of the session: height x width x 3, 0 to 255."""
    return hosts.to_srgb(hosts.layer(hosts.read_channels(output / (name + ".exr")), "color", "RGB"))


def check(output, seen):
    """What the session saw."""
    assert not seen["error"], seen["error"]
    for key, (value, default) in seen["settings"].items():
        same = abs(value - default) < 1e-6 if isinstance(default, float) else value == default
        assert same and type(value) is type(default), f"{key} is offered as {value!r}, not {default!r}"
    assert {"stf:samples", "stf:quality", "stf:denoise", "stf:transport"} <= seen["settings"].keys()
    assert {"baseVolume", "thickness", "mapping", "coreSigmaA"} <= set(seen["properties"]), seen["properties"]
    for name in ("plain", "marble"):
        assert seen[name] == {"messages": [], "raised": ""}, seen[name]
    errors = [m["text"] for m in seen["missing"]["messages"] if m["severity"] == "error"]
    assert len(errors) == 1 and "none.vdb" in errors[0] and "none.vdb" in seen["missing"]["raised"], seen["missing"]
    assert seen["unset"] == [False, 0.0], seen["unset"]

    plain, marble = picture(output, "plain"), picture(output, "marble")
    assert plain.shape == SIZE[::-1] + (3,), plain.shape
    # The ball: of one colour without a shell, veined and warmer in its veins with one. Away from it nothing changes.
    ball = (slice(int(0.3 * SIZE[1]), int(0.6 * SIZE[1])), slice(int(0.4 * SIZE[0]), int(0.6 * SIZE[0])))
    corner = (slice(int(0.85 * SIZE[1]), None), slice(int(0.85 * SIZE[0]), None))
    spread = {n: float(np.std(p[ball][..., 0] - p[ball][..., 2])) for n, p in (("plain", plain), ("marble", marble))}
    print(f"red less blue on the ball deviates by {spread}")
    assert plain[corner].mean() > 20, "the table is not seen"
    assert spread["plain"] < 1 and spread["marble"] > 2, f"no veins, or veins without marble: {spread}"
    assert np.abs(plain[corner] - marble[corner]).mean() < 8


def main():
    """Runs the session and judges it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("python", "bpy", "addon", "plugin", "volume", "output"):
        parser.add_argument("--" + name, required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    output = arguments.output.resolve()
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    environment = dict(os.environ, PYTHONPATH=str(arguments.bpy), PXR_PLUGINPATH_NAME=str(arguments.plugin.resolve()),
                       HDSTF_CACHE_DIR=str(output.parent / "cache"), PYTHONDONTWRITEBYTECODE="1")
    probe = subprocess.run([arguments.python, "-c", "import bpy"], env=environment, capture_output=True, text=True)
    if probe.returncode:
        why = (probe.stderr.strip() or "it crashed").splitlines()[-1]
        print(f"skipped: {arguments.python} cannot import bpy from {arguments.bpy}: {why}")
        sys.exit(SKIPPED)
    asked = output / "settings.json"
    asked.write_text(json.dumps({"addon": str(arguments.addon), "volume": str(arguments.volume), "output": str(output),
                                 "size": SIZE, "samples": 16}))
    session = pathlib.Path(__file__).with_name("blender_session.py")
    with open(output / "blender.log", "w") as log:
        code = subprocess.run([arguments.python, session, asked], env=environment, stdout=log,
                              stderr=subprocess.STDOUT).returncode
    assert code == 0, f"Blender ended with {code}: {output / 'blender.log'}"
    seen = json.loads((output / "session.json").read_text())
    print(f"Blender {seen['blender']}")
    check(output, seen)
    progress = [line for line in (output / "blender.log").read_text().splitlines() if "Done: " in line]
    # Blender from 5.0 on prints none without a window.
    assert not progress or any("Done: 0%" not in line for line in progress), "Blender saw no progress"


if __name__ == "__main__":
    main()
