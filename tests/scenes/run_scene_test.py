#!/usr/bin/env python3
"""Renders one scene with stfrecord and holds the result against what scenes.json expects of it.

    run_scene_test.py NAME --stfrecord BIN --scene FILE --output FOLDER [--update]

An entry of scenes.json has
    width, samples, seed   how to render
    arguments              more arguments of stfrecord (optional)
    exit                   expected exit code (default 0)
    says                   words that one message must contain, all of them (default: no error may be reported)
    rmse, outliers         [warn, fail] for the comparison with the stored image NAME.exr (see compare_images.py)
    tolerance              of a pixel, for `outliers`
    regions                parts of the image whose mean colour is known: box [x0, y0, x1, y1] as fractions from the top
                           left, value [r, g, b], tolerance (absolute)
`--update` stores the image that was rendered as the new reference, if all else holds.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys

import numpy as np

from compare_images import compare, read_rgb, write_difference, write_rgb_half

DATA = pathlib.Path(__file__).resolve().parents[1] / "data" / "scenes"
# Exit codes of stfrecord: 0 rendered, 1 rendered with errors reported, 2 nothing rendered, 64 usage.
RENDERED = (0, 1)
# How a line that reports an error looks: "error: ..", "Coding Error: in .."; not "estimated error 0.02".
ERROR = re.compile(r"\berror(:| in )", re.I)


class Checks:
    """Collects what failed, so that one run tells all of it."""

    def __init__(self):
        self.failures = []

    def check(self, condition, text):
        print(("ok      " if condition else "FAILED  ") + text)
        if not condition:
            self.failures.append(text)


def render(stfrecord, scene, image, stats, expected):
    """Runs stfrecord; returns exit code and everything it printed."""
    command = [stfrecord, scene, image, "--stats", stats, "--threads", 2]
    for option, key in (("--imageWidth", "width"), ("--samples", "samples"), ("--seed", "seed")):
        command += [option, expected[key]]
    command = [str(part) for part in [*command, *expected.get("arguments", [])]]
    print(" ".join(command), flush=True)
    # What an earlier run left must not be taken for this one's.
    for stale in (image, stats):
        stale.unlink(missing_ok=True)
    run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
    print(run.stdout)
    return run.returncode, run.stdout


def messages_of(stats, output):
    """All messages as (severity, text): those of the statistics, and the lines that were printed."""
    found = []
    if stats.exists():
        for message in json.loads(stats.read_text()).get("messages", []):
            if isinstance(message, dict):
                found.append((message["severity"], message["text"]))
            else:
                found.append(("error" if ERROR.search(message) else "warning", message))
    for line in output.splitlines():
        if line.strip():
            found.append(("error" if ERROR.search(line) else "printed", line))
    return found


def check_messages(test, expected, messages):
    """An expected message must be there; where none is expected, no error may be."""
    if "says" in expected:
        words = expected["says"]
        test.check(any(all(w in text for w in words) for _, text in messages), f"a message says {words}")
    else:
        errors = [text for severity, text in messages if severity == "error"]
        test.check(not errors, f"no error is reported: {errors[:5]}")


def check_regions(test, expected, pixels):
    """Mean colours of known parts of the image."""
    height, width, _ = pixels.shape
    for region in expected.get("regions", []):
        x0, y0, x1, y1 = (int(round(f * n)) for f, n in zip(region["box"], (width, height, width, height)))
        mean = pixels[y0:y1, x0:x1].mean(axis=(0, 1))
        near = np.all(np.abs(mean - region["value"]) <= region["tolerance"])
        test.check(near, f"mean of {region['box']}: {np.round(mean, 4).tolist()}, expected {region['value']}")


def check_reference(test, expected, pixels, reference, difference):
    """Comparison with the stored image."""
    if not reference.exists():
        test.check(False, f"there is no reference {reference.name}: record it with --update")
        return
    stored = read_rgb(reference)
    try:
        measured = compare(pixels, stored, expected["tolerance"])
    except ValueError as error:
        test.check(False, str(error))
        write_difference(difference, pixels, stored)
        return
    print("measured " + json.dumps(measured))
    for key in ("rmse", "outliers"):
        warn, fail = expected[key]
        test.check(measured[key] <= fail, f"{key} {measured[key]:.4g}, at most {fail}")
        if warn < measured[key] <= fail:
            print(f"warning: {key} {measured[key]:.4g} is above {warn}")
    if test.failures:
        write_difference(difference, pixels, stored)
        print(f"image, reference, difference: {difference}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", help="entry of scenes.json")
    parser.add_argument("--stfrecord", required=True)
    parser.add_argument("--scene", required=True)
    parser.add_argument("--output", required=True, type=pathlib.Path)
    parser.add_argument("--update", action="store_true")
    arguments = parser.parse_args()
    expected = json.loads((DATA / "scenes.json").read_text())[arguments.name]
    arguments.output.mkdir(parents=True, exist_ok=True)
    image = arguments.output / f"{arguments.name}.exr"
    stats = arguments.output / f"{arguments.name}.json"
    difference = arguments.output / f"{arguments.name}_difference.png"
    difference.unlink(missing_ok=True)

    test = Checks()
    code, output = render(arguments.stfrecord, arguments.scene, image, stats, expected)
    wanted = expected.get("exit", 0)
    test.check(code == wanted, f"exit code {code}, expected {wanted}")
    check_messages(test, expected, messages_of(stats, output))
    if wanted in RENDERED:
        test.check(image.exists(), f"{image.name} is written")
    else:
        test.check(not image.exists(), f"{image.name} is not written")
    if image.exists() and wanted in RENDERED:
        pixels = read_rgb(image)
        test.check(bool(np.all(np.isfinite(pixels))), "every pixel is a number")
        check_regions(test, expected, pixels)
        if "rmse" in expected:
            reference = DATA / f"{arguments.name}.exr"
            if not arguments.update:
                check_reference(test, expected, pixels, reference, difference)
            elif not test.failures:
                write_rgb_half(reference, pixels)
                print(f"recorded {reference}")
    if test.failures:
        sys.exit("failed: " + "; ".join(test.failures))


if __name__ == "__main__":
    main()
