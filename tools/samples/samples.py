#!/usr/bin/env python3
"""Builds the sample library: a base volume of each recipe in samples/, and on demand a picture of each.

A recipe says how its volume is made: `make` (a modelled sample of `stf make` with its options) or `scan` or `mesh` (a
recipe of `stf acquire`, docs/acquire_scan.md and docs/acquire_mesh.md). `data` names a file of a Debian package that it
is made from; the package is downloaded and unpacked into the cache folder, nothing is installed. Where that fails the
sample is left out with a message. docs/samples.md describes the rest.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time

TOP = pathlib.Path(__file__).resolve().parents[2]
WAYS = ("make", "scan", "mesh")
KEYS = {"about", "data", "picture", *WAYS}


class Missing(Exception):
    """What a sample is made of is not there."""


def say(text):
    print(f"[samples] {text}", flush=True)


def read_recipe(path):
    recipe = json.loads(path.read_text())
    unknown = set(recipe) - KEYS
    if unknown:
        raise SystemExit(f"{path}: unknown key {sorted(unknown)[0]!r} (known: {', '.join(sorted(KEYS))})")
    if sum(way in recipe for way in WAYS) != 1:
        raise SystemExit(f"{path}: one of {', '.join(WAYS)} is expected")
    return recipe


def cache_folder():
    base = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
    return pathlib.Path(os.environ.get("HDSTF_CACHE_DIR") or pathlib.Path(base) / "hdstf") / "samples"


def fetch(data):
    """The file that a recipe's `data` names: {"package", "file"} and, within an archive, "member"."""
    folder = cache_folder() / data["package"]
    within = data["file"].lstrip("/")
    for root in (pathlib.Path("/"), folder):
        if (root / within).is_file():
            found = root / within
            break
    else:
        found = unpack_package(data["package"], folder) / within
        if not found.is_file():
            raise Missing(f"package {data['package']} holds no {data['file']}")
    if "member" not in data:
        return found
    target = folder / "members" / data["member"]
    if not target.is_file():
        target.parent.mkdir(parents=True, exist_ok=True)
        with tarfile.open(found) as archive:
            source = archive.extractfile(data["member"])
            partial = target.with_suffix(".partial")
            with partial.open("wb") as out:
                shutil.copyfileobj(source, out)
        partial.rename(target)
    return target


def unpack_package(package, folder):
    if not (shutil.which("apt-get") and shutil.which("dpkg-deb")):
        raise Missing(f"the Debian package {package} is needed, and there is no apt-get to fetch it")
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder) as temporary:
        done = subprocess.run(["apt-get", "download", package], cwd=temporary, capture_output=True, text=True)
        archives = list(pathlib.Path(temporary).glob("*.deb"))
        if done.returncode or not archives:
            raise Missing(f"the Debian package {package} cannot be downloaded: {done.stderr.strip()[-200:]}")
        subprocess.run(["dpkg-deb", "-x", archives[0], folder], check=True)
    return folder


def command_of(recipe, stf, data, target, scratch):
    """The call of stf that makes the volume."""
    if "make" in recipe:
        options = dict(recipe["make"])
        call = [stf, "make", options.pop("sample"), target]
        for key, value in options.items():
            call += [f"--{key}", ",".join(map(str, value)) if isinstance(value, list) else str(value)]
        return call
    way = "scan" if "scan" in recipe else "mesh"
    inner = dict(recipe[way], name=target.stem)
    if data:
        inner["input"] = str(data)
    plain = pathlib.Path(scratch) / f"{target.stem}.json"
    plain.write_text(json.dumps(inner))
    return [stf, "acquire", way, "--recipe", plain, target]


def build(name, recipe, stf, folder):
    target = folder / f"{name}.vdb"
    data = fetch(recipe["data"]) if "data" in recipe else None
    with tempfile.TemporaryDirectory() as scratch:
        done = subprocess.run(command_of(recipe, stf, data, target, scratch), capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"[samples] {name}: {done.stderr.strip()}")
    return target


def picture(name, recipe, stfrecord, folder, pictures):
    import scene  # needs numpy and OpenEXR
    import studio

    options = recipe.get("picture", {})
    studio.write(folder / scene.studio_of(options), options.get("soft", False))
    (folder / f"{name}.usda").write_text(scene.text(name, options))
    image = pictures / f"{name}.png"
    call = [stfrecord, folder / f"{name}.usda", folder / f"{name}.exr", "--png", image, "--imageWidth",
            str(options.get("width", 320)), "--samples", str(options.get("samples", 96)), "--quiet",
            "--set", f"stf:quality={options.get('quality', 0.08)}"]
    done = subprocess.run(call, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"[samples] {name}: {done.stderr.strip()}")
    return image


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    known = sorted(path.stem for path in (TOP / "samples").glob("*.json"))
    parser.add_argument("names", nargs="*", metavar="NAME", help="samples (default: all): " + ", ".join(known))
    parser.add_argument("--build", type=pathlib.Path, default=TOP / "build", help="folder of the build (%(default)s)")
    parser.add_argument("--out", type=pathlib.Path, help="where the volumes go (BUILD/samples)")
    parser.add_argument("--pictures", type=pathlib.Path, nargs="?", const=TOP / "docs" / "samples",
                        help="also render a picture of each into this folder (%(const)s)")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in known:
            parser.error(f"no sample named {name!r} (known: {', '.join(known)})")
    folder = arguments.out or arguments.build / "samples"
    folder.mkdir(parents=True, exist_ok=True)
    if arguments.pictures:
        arguments.pictures.mkdir(parents=True, exist_ok=True)
    left_out = 0
    for name in arguments.names or known:
        recipe, start = read_recipe(TOP / "samples" / f"{name}.json"), time.monotonic()
        try:
            target = build(name, recipe, arguments.build / "bin" / "stf", folder)
        except Missing as reason:
            say(f"{name}: left out: {reason}")
            left_out += 1
            continue
        say(f"{target}: {time.monotonic() - start:.1f} s")
        if arguments.pictures:
            image = picture(name, recipe, arguments.build / "bin" / "stfrecord", folder, arguments.pictures)
            say(f"{image}: {time.monotonic() - start:.1f} s")
    if left_out:
        say(f"{left_out} left out")


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    main()
