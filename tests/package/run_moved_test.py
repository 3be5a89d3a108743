#!/usr/bin/env python3
"""An install tree that was moved: complete, naming no folder it must not, and rendering what the build tree renders."""

import argparse
import os
import pathlib
import subprocess
import sys

import numpy as np

from compare_images import read_rgb

EXPECTED = ("bin/stf bin/stf-probe bin/stfrecord plugin/plugInfo.json plugin/hdStf/resources/plugInfo.json "
            "plugin/stfSchemas/resources/generatedSchema.usda lib/libstf_base.a include/stfLib/render/renderer.h "
            "lib/cmake/stfLib/stfLibConfig.cmake share/hdstf/blender/hdstf_blender/__init__.py "
            "share/hdstf/usd_examples/marble_slab.usda share/hdstf/usd_examples/volumes/marble.vdb "
            "share/hdstf/report/report.py share/doc/hdstf/LICENSE share/doc/hdstf/docs/user_guide.md").split()


def render(stfrecord, scene, image, environment):
    image.unlink(missing_ok=True)
    command = [stfrecord, scene, image, "--imageWidth", "24", "--samples", "2", "--set", "stf:quality=0.3"]
    print(*command, flush=True)
    subprocess.run([str(c) for c in command], check=True, env=environment, cwd="/")
    return read_rgb(image)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("--tree", "--installed", "--build", "--output"):
        parser.add_argument(name, type=pathlib.Path, required=True)
    parser.add_argument("--openusd", default="", help="folder of the libraries that the build used")
    parser.add_argument("--bundled", required=True, choices=("0", "1"))
    a = parser.parse_args()
    a.output.mkdir(parents=True, exist_ok=True)
    failures = [f"{name} is not installed" for name in EXPECTED if not (a.tree / name).exists()]

    # Nothing of the search for libraries may have come along from outside.
    environment = {k: v for k, v in os.environ.items() if k not in ("LD_LIBRARY_PATH", "PXR_PLUGINPATH_NAME")}
    environment["HDSTF_CACHE_DIR"] = str(a.output / "cache")
    objects = [a.tree / "bin/stf", a.tree / "bin/stfrecord", *a.tree.glob("plugin/hdStf.*")]
    for path in objects:
        loaded = subprocess.run(["ldd", path], env=environment, capture_output=True, text=True, check=True).stdout
        if "not found" in loaded:
            failures.append(f"{path} lacks libraries:\n{loaded}")
        if a.bundled == "1" and a.openusd in loaded:
            failures.append(f"{path} loads OpenUSD from where it was built:\n{loaded}")
        if str(a.build).encode() + b"/plugin" in path.read_bytes():
            failures.append(f"{path} names the build's plugins")
    for path in a.tree.rglob("*"):
        if path.suffix in (".cmake", ".json") and path.is_file():
            text = path.read_text()
            failures += [f"{path} names {folder}" for folder in (a.installed, a.build) if str(folder) in text]

    environment["PXR_PLUGINPATH_NAME"] = str(a.tree / "plugin")
    moved = render(a.tree / "bin/stfrecord", a.tree / "share/hdstf/usd_examples/marble_slab.usda",
                   a.output / "moved.exr", environment)
    doctor = subprocess.run([a.tree / "bin/stf", "doctor"], env=environment, cwd="/", capture_output=True, text=True)
    print(doctor.stdout)
    if doctor.returncode or f"{a.tree}/plugin/hdStf" not in doctor.stdout or "render: a shell" not in doctor.stdout:
        failures.append(f"stf doctor finds fault with the moved tree ({doctor.returncode}): {doctor.stderr}")
    environment["PXR_PLUGINPATH_NAME"] = str(a.build / "plugin")
    built = render(a.build / "bin/stfrecord", a.build / "usd_examples/marble_slab.usda", a.output / "built.exr",
                   environment)
    difference = float(np.abs(moved - built).max()) if moved.shape == built.shape else float("nan")
    print(f"mean {built.mean():.4f}, largest difference {difference:g}")
    if not difference == 0:
        failures.append(f"the moved tree renders something else: largest difference {difference:g}")
    if not built.mean() > 0.01:
        failures.append("the picture is black")
    print(*failures, sep="\n")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
