#!/usr/bin/env python3
"""Starts usdview on a screen in memory, lets usdview_session.py use it, and judges what that saw.

    run_usdview_test.py --usd PREFIX --plugin FOLDER --stfrecord BIN --scene FILE --output FOLDER

The scene is the animated example (usd_examples/bending_body.usda). Its pictures in usdview are compared with those of
stfrecord by the same camera: the same samples, so that 8 bits, the display's curve and what the window does to pixels are
between them. usdview on Mesa's software shows means of neighbours (0.21, 0.58, 0.21 along either axis; usdrecord,
without a window, does not): that share is found from the edges of the normals, once for all pictures, and is below a quarter.
"""

import argparse
import json
import pathlib

import numpy as np

import hosts

SIZE = (240, 200)  # the aspect of the scene's camera
SAMPLES = 8
WIDGETS = {"stf:samples": "QSpinBox", "stf:seed": "QSpinBox", "stf:threads": "QSpinBox", "stf:maxDepth": "QSpinBox",
           "stf:quality": "QDoubleSpinBox", "stf:errorTarget": "QDoubleSpinBox", "stf:indirectClamp": "QDoubleSpinBox",
           "stf:pixelFilterWidth": "QDoubleSpinBox", "stageMetersPerUnit": "QDoubleSpinBox",
           "stf:transport": "QLineEdit", "stf:integrator": "QLineEdit", "stf:pixelFilter": "QLineEdit",
           "stf:depthOfField": "QCheckBox", "stf:motionBlur": "QCheckBox", "stf:denoise": "QCheckBox",
           "stf:regularize": "QCheckBox"}


def picture(output, seen, name):
    """A picture of the session: height x width x 3, 0 to 255."""
    width, height = seen["pictures"][name]
    raw = np.fromfile(output / (name + ".rgba"), dtype=np.uint8).reshape(height, width, 4)
    return raw[..., :3].astype(np.float64)


def check_pictures(output, seen, channels):
    """Colour, depth and normals against stfrecord's."""
    expected = {
        "color": hosts.to_srgb(hosts.layer(channels, "color", "RGB")),
        "aov_normal": 255 * np.clip(hosts.layer(channels, "normal", "XYZ"), 0, 1),
    }
    depth = np.zeros(SIZE[::-1] + (3,))
    depth[..., 0] = 255 * np.clip(channels["depth.Z"] if "depth.Z" in channels else channels["depth"], 0, 1)
    expected["aov_depth"] = depth
    normals = picture(output, seen, "aov_normal")
    side = min(np.linspace(0, 0.24, 25), key=lambda s: np.abs(hosts.smooth(expected["aov_normal"], s) - normals).mean())
    print(f"a pixel's share of its neighbour's: {side:.2f}")
    for name, wanted in expected.items():
        found = hosts.difference(picture(output, seen, name), hosts.smooth(wanted, side))
        print(f"{name} against stfrecord: {found}")
        assert wanted.std() > 5, f"{name}: nothing to see in stfrecord's picture"
        assert found["mean"] < 0.6 and found["off"] < 0.03, f"{name} is not stfrecord's picture: {found}"
    again = hosts.difference(picture(output, seen, "aov_color"), picture(output, seen, "color"))
    assert again["mean"] == 0, f"colour after other AOVs is another: {again}"


def check_panel(panel):
    """The settings' panel offers what there is, in widgets of the right kind, and setting works."""
    assert panel["widgets"].items() >= WIDGETS.items(), panel["widgets"]
    flags = {"stf:depthOfField": True, "stf:motionBlur": True, "stf:denoise": False, "stf:regularize": True}
    assert panel["flags"].items() >= flags.items(), panel["flags"]
    assert panel["converged after applying what was"], "equal values must restart nothing"
    assert not panel["converged after another number of samples"]
    assert panel["samples"] == [SAMPLES, SAMPLES + 1, SAMPLES + 1], panel["samples"]
    assert panel["samples after reset"] == SAMPLES


def check_interaction(output, seen):
    """Camera, time, size, pause, stop, picking, another renderer and back."""
    assert seen["clicks"] == {"body": ["/World/Body"], "ground": ["/World/Ground"], "sky": ["/"]}, seen["clicks"]
    marked = hosts.difference(picture(output, seen, "selected"), picture(output, seen, "color"))
    assert 0.05 < marked["off"] < 0.6, f"the selected prim is not marked: {marked}"

    assert not seen["converged after moving the camera"]
    before = picture(output, seen, "before")
    for name in ("moved", "frame_12"):
        assert hosts.difference(picture(output, seen, name), before)["off"] > 0.05, f"{name} shows what was before"
    back = hosts.difference(picture(output, seen, "moved_back"), before)
    assert back["mean"] == 0, f"the same camera gives another picture: {back}"
    smaller = picture(output, seen, "smaller")
    frame = picture(output, seen, "frame_12")
    assert smaller.shape == (SIZE[1] // 2, SIZE[0] // 2, 3), smaller.shape
    halved = frame.reshape(SIZE[1] // 2, 2, SIZE[0] // 2, 2, 3).mean(axis=(1, 3))
    assert np.abs(smaller - halved).mean() < 8, "the smaller view shows something else"

    pause = seen["pause"]
    assert pause["paused"][0] == pause["paused"][1] and not pause["paused converged"], pause
    assert pause["resumed"] > pause["paused"][1] and pause["stopped converged"], pause
    assert hosts.difference(picture(output, seen, "stopped"), frame)["mean"] < 8, "stopping lost the picture"
    assert pause["samples after restart"] == 2, pause

    assert seen["other renderer"] == "GL" and seen["renderer again"] == "Stf", seen
    assert hosts.difference(picture(output, seen, "storm"), frame)["off"] > 0.2, "GL shows Stf's picture"


def main():
    """Runs the session and judges it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("usd", "plugin", "stfrecord", "scene", "output"):
        parser.add_argument("--" + name, required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    output = hosts.fresh(arguments.output)
    cache = arguments.output.parent / "cache"
    script = pathlib.Path(__file__).with_name("usdview_session.py")

    image = output / "stfrecord.exr"
    hosts.stfrecord(arguments.stfrecord, arguments.plugin, cache, arguments.scene, image, "--imageWidth", SIZE[0],
                    "--samples", SAMPLES, "--frames", "1", "--aov", "color,depth,normal")
    hosts.run([arguments.usd / "bin" / "testusdview", "--testScript", script, arguments.scene],
              arguments.usd, arguments.plugin, cache,
              {"HDSTF_TEST_OUTPUT": str(output), "HDSTF_TEST_SIZE": "%dx%d" % SIZE, "HDSTF_SAMPLES": str(SAMPLES)},
              output / "usdview.log")
    seen = json.loads((output / "session.json").read_text())
    print(f"converged after {seen['seconds']:.1f} s; {seen['stats']['renderProgressAnnotation']}")

    assert seen["renderer"] == "Stf" and seen["aovs"][:4] == ["color", "primId", "depth", "normal"], seen["aovs"]
    assert seen["stats"]["percentDone"] == 100.0 and seen["stats"]["numCompletedSamples"] == SAMPLES
    check_pictures(output, seen, hosts.read_channels(image))
    check_panel(seen["panel"])
    check_interaction(output, seen)


if __name__ == "__main__":
    main()
