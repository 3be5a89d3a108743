#!/usr/bin/env python3
"""Writes two frames of an animated scene with usdrecord and the renderer Stf, and compares them with stfrecord's.

    run_usdrecord_test.py --usd PREFIX --plugin FOLDER --stfrecord BIN --scene FILE --output FOLDER
"""

import argparse
import pathlib

import hosts

WIDTH, SAMPLES, FRAMES = 96, 4, (1, 12)


def main():
    """Records with both and compares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("usd", "plugin", "stfrecord", "scene", "output"):
        parser.add_argument("--" + name, required=True, type=pathlib.Path)
    arguments = parser.parse_args()
    output = hosts.fresh(arguments.output)
    cache = arguments.output.parent / "cache"

    frames = ",".join(map(str, FRAMES))
    hosts.stfrecord(arguments.stfrecord, arguments.plugin, cache, arguments.scene, output / "stfrecord.####.exr",
                    "--imageWidth", WIDTH, "--samples", SAMPLES, "--frames", frames)
    hosts.run([arguments.usd / "bin" / "usdrecord", "--renderer", "Stf", "--camera", "/World/Camera", "--imageWidth",
               WIDTH, "--frames", frames, "--colorCorrectionMode", "sRGB", arguments.scene, output / "usdrecord.####.png"],
              arguments.usd, arguments.plugin, cache, {"HDSTF_SAMPLES": str(SAMPLES)}, output / "usdrecord.log")
    pictures = []
    for frame in FRAMES:
        expected = hosts.to_srgb(hosts.layer(hosts.read_channels(output / f"stfrecord.{frame:04}.exr"), "color", "RGB"))
        pictures.append(hosts.read_png(output / f"usdrecord.{frame:04}.png", arguments.usd))
        # 20.08 takes the whole part of the height, stfrecord the nearest number.
        found = hosts.difference(pictures[-1], expected[:pictures[-1].shape[0]])
        print(f"frame {frame}, {expected.shape[1]} x {expected.shape[0]}, against stfrecord: {found}")
        assert found["mean"] < 0.6 and found["off"] < 0.02, f"frame {frame} is not stfrecord's picture: {found}"
    assert hosts.difference(*pictures)["off"] > 0.05, "both frames are the same"


if __name__ == "__main__":
    main()
