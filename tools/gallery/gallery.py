#!/usr/bin/env python3
"""Renders the gallery: every object of gallery.json in every sample, to docs/gallery, and a sheet of all.

Objects are meshes of a Debian package, which is downloaded and unpacked into the cache folder; samples are those of
samples/. None of the objects is given texture coordinates: the samples are grown over them (docs/synthesis.md).
"""

import argparse
import json
import pathlib
import subprocess
import sys
import time

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TOP / "tools" / "samples"))
import samples as library  # noqa: E402
import gallery_scene as scene  # noqa: E402
import studio  # noqa: E402
from PIL import Image  # noqa: E402


def say(text):
    print(f"[gallery] {text}", flush=True)


def render(stfrecord, usd, image, width, paths, error, quality):
    call = [stfrecord, usd, usd.with_suffix(".exr"), "--png", image, "--imageWidth", str(width), "--quiet",
            "--samples", str(paths), "--set", f"stf:errorTarget={error}", "--set", f"stf:quality={quality}",
            "--stats", usd.with_suffix(".stats.json")]
    done = subprocess.run(call, capture_output=True, text=True)
    if done.returncode > 1:
        raise SystemExit(f"[gallery] {usd.stem}: {done.stderr.strip()}")
    for line in done.stderr.splitlines():
        say(f"{usd.stem}: {line}")


def sheet(images, columns, target):
    """All pictures at half size, row by row."""
    tiles = [Image.open(path) for path in images]
    width, height = tiles[0].width // 2, tiles[0].height // 2
    whole = Image.new("RGB", (width * columns, height * -(-len(tiles) // columns)))
    for i, tile in enumerate(tiles):
        small = tile.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)
        whole.paste(small, (i % columns * width, i // columns * height))
    whole.save(target, optimize=True)


def main():
    plan = json.loads((pathlib.Path(__file__).parent / "gallery.json").read_text())
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--objects", nargs="+", choices=sorted(plan["objects"]), metavar="NAME",
                        default=list(plan["objects"]), help="default: all: %(default)s")
    parser.add_argument("--samples", nargs="+", choices=sorted(plan["samples"]), metavar="NAME",
                        default=list(plan["samples"]), help="default: all: %(default)s")
    parser.add_argument("--width", type=int, default=400, help="of a picture (%(default)s)")
    parser.add_argument("--paths", type=int, default=64, help="per pixel, at most (%(default)s)")
    parser.add_argument("--error", type=float, default=0.06,
                        help="relative error at which a pixel gets no more (%(default)s)")
    parser.add_argument("--grey", action="store_true", help="objects without a sample, for a look at them")
    parser.add_argument("--build", type=pathlib.Path, default=TOP / "build", help="folder of the build (%(default)s)")
    parser.add_argument("--out", type=pathlib.Path, default=TOP / "docs" / "gallery", help="pictures (%(default)s)")
    arguments = parser.parse_args()

    work = arguments.build / "gallery"
    work.mkdir(parents=True, exist_ok=True)
    arguments.out.mkdir(parents=True, exist_ok=True)
    stf, stfrecord = arguments.build / "bin" / "stf", arguments.build / "bin" / "stfrecord"
    for soft in (False, True):
        studio.write(work / ("studio_soft.exr" if soft else "studio.exr"), soft)
    if not arguments.grey:
        for name in arguments.samples:
            library.build(name, library.read_recipe(TOP / "samples" / f"{name}.json"), stf, work)
    images = []
    for object_name in arguments.objects:
        entry = plan["objects"][object_name]
        path = library.fetch({**plan["data"], "member": f"data/meshes/{entry['file']}"})
        for sample in arguments.samples:
            options, start = plan["samples"][sample], time.monotonic()
            mesh = scene.read_object(path, entry["turn"], options["heightMm"])
            usd = work / f"{object_name}_{sample}.usda"
            scene.write(usd, mesh, None if arguments.grey else f"./{sample}.vdb",
                        "./studio_soft.exr" if options.get("soft") else "./studio.exr", options["light"])
            image = arguments.out / f"{object_name}_{sample}.png"
            render(stfrecord, usd, image, arguments.width, arguments.paths, arguments.error, options["quality"])
            images.append(image)
            say(f"{image}: {time.monotonic() - start:.0f} s")
    if len(images) > 1:
        sheet(images, len(arguments.samples), arguments.out / "sheet.png")
        say(f"{arguments.out / 'sheet.png'}")


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    main()
