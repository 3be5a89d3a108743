"""Renders every USD file of a folder, for instance those of OpenUSD's own imaging tests, small: nothing may crash, hang,
or say the same twice. What is drawn and what is not, and why, comes out as a table (and as JSON); docs/hosts.md has it.

    run_imaging_scenes.py --stfrecord build/bin/stfrecord --plugin build/plugin --scenes FOLDER --output OUT
"""

import argparse
import collections
import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import sys

import numpy as np
import OpenEXR

SKIPPED = 77  # the exit code that CTest takes for "skipped"
SUFFIXES = {".usd", ".usda", ".usdc", ".usdz"}
ENDED = {0: "rendered", 1: "rendered with errors", 2: "nothing rendered"}  # stfrecord's exit codes
# Of the delegate itself, and of the library below: a scene must not bring them about, whatever is in it.
FAULTS = ("Coding Error", "Fatal error", "AddressSanitizer", "ThreadSanitizer", "runtime error:", "hdStf has no ")
# Why a picture shows nothing, by what stfrecord says: the first that fits.
CAUSES = (("cannot be opened", r"cannot open |not a readable scene"),
          ("volumes only", r"draws no volumes"),
          ("curves or points only", r"draws no (curves|points)"),
          ("a mesh without a usable face", r"no usable face"),
          ("other files are missing", r"[Cc]ould not open asset|Failed to (open|read)|cannot find|not found"))


def first_and_last(scene):
    """Frames to render: first, middle and last of a text layer that says its range; else none, which is the default."""
    with open(scene, "rb") as file:
        head = file.read(4096)
    if not head.startswith(b"#usda"):
        return []
    times = [re.search(rb"\b" + name + rb"\s*=\s*(-?[0-9.]+)", head) for name in (b"startTimeCode", b"endTimeCode")]
    if not all(times):
        return []
    start, end = (float(t.group(1)) for t in times)
    return sorted({start, (start + end) // 2, end}) if start < end else [start]


def coverage(image):
    """The share of pixels where something is; NaN or infinity in the colours is a fault."""
    with OpenEXR.File(str(image), separate_channels=True) as file:
        channels = {name: np.asarray(channel.pixels) for part in file.parts for name, channel in part.channels.items()}
    colours = [channels[name] for name in "RGB" if name in channels]
    if not colours or not all(np.isfinite(c).all() for c in colours):
        raise ValueError(f"{image.name}: the colour is not finite, or is missing")
    prims = next(values for name, values in channels.items() if name.startswith("primId"))
    return float(np.mean(prims.astype(np.uint32).view(np.int32) >= 0))  # -1 where nothing is; EXR has no signed integers


def render(scene, name, arguments):
    """One scene: how it ended, in what time, what was said and how much of the pictures is covered."""
    image = arguments.output / (re.sub(r"[^A-Za-z0-9]+", "_", name) + ".exr")
    frames = first_and_last(scene)
    command = [arguments.stfrecord, scene, image, "--imageWidth", "64", "--samples", "2", "--threads", "2",
               "--aov", "color,primId"]
    if arguments.sceneIndices:
        command.append("--sceneIndices")
    if frames:
        command += ["--frames", ",".join(f"{frame:g}" for frame in frames)]
    environment = dict(os.environ, PXR_PLUGINPATH_NAME=str(arguments.plugin), LC_ALL="C.UTF-8",
                       HDSTF_CACHE_DIR=str(arguments.output / "cache"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    process = subprocess.Popen([str(part) for part in command], env=environment, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace")
    try:
        said = process.communicate(timeout=arguments.limit)[1]
        code = process.returncode
    except subprocess.TimeoutExpired:
        process.kill()
        said, code = process.communicate()[1], None
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    result = {"scene": name, "code": code, "seconds": round(seconds, 2), "covered": [], "faults": []}
    lines = [line for line in said.splitlines() if re.match(r"stfrecord: (error|warning|info): ", line)]
    result["messages"] = [line.removeprefix("stfrecord: ") for line in lines]
    result["outcome"] = (f"no end within {arguments.limit} s" if code is None else
                         f"ended by {signal.Signals(-code).name}" if code < 0 else ENDED.get(code, f"exit code {code}"))
    if code not in ENDED:
        result["faults"].append(result["outcome"] + "".join("\n    " + line for line in said.splitlines()[-5:]))
    result["faults"] += [line for line in said.splitlines() if any(fault in line for fault in FAULTS)]
    result["faults"] += [f"said {count} times: {line}" for line, count in collections.Counter(lines).items() if count > 1]
    if code in (0, 1):
        pictures = sorted(arguments.output.glob(image.stem + ".*exr"))
        if len(pictures) != max(1, len(frames)):
            result["faults"].append(f"{len(pictures)} pictures of {max(1, len(frames))}")
        try:
            result["covered"] = [round(coverage(picture), 4) for picture in pictures]
        except (ValueError, StopIteration) as problem:
            result["faults"].append(str(problem))
        for picture in pictures if not arguments.keep else []:
            picture.unlink()
    return result


def cause(result):
    """Why nothing shows."""
    said = "\n".join(result["messages"])
    return next((name for name, pattern in CAUSES if re.search(pattern, said)), "nothing that could be drawn is in it")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--stfrecord", type=pathlib.Path, required=True)
    parser.add_argument("--plugin", type=pathlib.Path, required=True)
    parser.add_argument("--output", type=pathlib.Path, required=True)
    parser.add_argument("--scenes", type=pathlib.Path, default=os.environ.get("HDSTF_IMAGING_SCENES") or None,
                        help="default: HDSTF_IMAGING_SCENES of the environment")
    parser.add_argument("--limit", type=float, default=300,
                        help="seconds that a scene may take on the clock; those of the processor are what is told")
    parser.add_argument("--only", default="", help="a part of the names of the scenes to render")
    parser.add_argument("--sceneIndices", action="store_true", help="by UsdImaging's scene indices (23.11 and later)")
    parser.add_argument("--keep", action="store_true", help="leave the pictures in OUTPUT")
    arguments = parser.parse_args()
    arguments.stfrecord, arguments.plugin, arguments.output = (
        path.resolve() for path in (arguments.stfrecord, arguments.plugin, arguments.output))
    if not arguments.scenes:
        print("skipped: HDSTF_IMAGING_SCENES names no folder of USD files, such as the testenv folders of "
              "OpenUSD's pxr/usdImaging and pxr/imaging (docs/hosts.md)")
        return SKIPPED
    scenes = sorted(path for path in arguments.scenes.rglob("*") if path.suffix in SUFFIXES and path.is_file())
    scenes = [path for path in scenes if arguments.only in str(path)]
    if not scenes:
        sys.exit(f"no USD file in {arguments.scenes}" + (f" with {arguments.only} in its name" * bool(arguments.only)))
    arguments.output.mkdir(parents=True, exist_ok=True)

    results = []
    for scene in scenes:
        results.append(render(scene, str(scene.relative_to(arguments.scenes)), arguments))
        for fault in results[-1]["faults"]:
            print(f"{results[-1]['scene']}: {fault}", flush=True)
    for result in results:
        result["shows"] = ("something" if any(result["covered"]) else cause(result)) if result["code"] in (0, 1) else ""
    (arguments.output / "scenes.json").write_text(json.dumps(results, indent=1))

    for title, key in (("outcome", "outcome"), ("the picture shows", "shows")):
        print(f"\n{title}")
        for name, count in collections.Counter(r[key] for r in results if r[key]).most_common():
            print(f"  {count:5d}  {name}")
    slowest = max(results, key=lambda r: r["seconds"])
    print(f"\n{len(results)} scenes, {sum(r['seconds'] for r in results):.0f} s of the processor, "
          f"the slowest {slowest['seconds']} s: {slowest['scene']}")
    faulty = [r["scene"] for r in results if r["faults"]]
    if faulty:
        sys.exit(f"{len(faulty)} scenes with faults: " + ", ".join(faulty))
    return 0


if __name__ == "__main__":
    sys.exit(main())
