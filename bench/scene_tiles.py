#!/usr/bin/env python3
"""Rendered images of heterogeneous tiles, with and without a core, beside Mitsuba 3's volumetric path tracer.

Usage: scene_tiles.py --mitsuba-python PYTHON [--build FOLDER] [--quick] [--only NAMES]

A flat shell of each tile is rendered by stfrecord, straight from above under one oblique distant light, a pixel for each
column of voxels; Mitsuba walks through the same voxels (and, for a core, through its medium below them). Writes
FOLDER/bench/scene_tiles.json and scene_tiles.npz. This Python needs numpy and OpenEXR.
"""

import argparse
import json
import pathlib
import sys
import tempfile

import numpy as np

TOP = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(TOP / "tools" / "validation"))
import flat_scene as flat  # noqa: E402
from programs import Mitsuba, Skipped, Stf, threads_of_machine  # noqa: E402

LIGHT = (0.5, 0.3, 0.8124038)
# `stf make` of each; the largest relative error that is wanted of its image (root mean square, noise taken away).
TILES = {
    "random, g .5": {"make": ("random", "--size", "32,32,16", "--voxel", 1, "--tau", 4, "--albedo", 0.9, "--g", 0.5,
                              "--ratio", 30), "g": 0.5, "allowed": 0.03, "core": (0.02, 0.5)},
    "marble": {"make": ("marble", "--size", "32,32,20"), "allowed": 0.03, "core": (0.02, 1.0)},
    "random, g .9, tau 12": {"make": ("random", "--size", "32,32,16", "--voxel", 1, "--tau", 12, "--albedo", 0.99,
                                      "--g", 0.9, "--ratio", 30), "g": 0.9, "allowed": 0.08, "core": (0.01, 0.5)},
    "random, g .9, tau 2": {"make": ("random", "--size", "32,32,16", "--voxel", 1, "--tau", 2, "--albedo", 0.99,
                                     "--g", 0.9, "--ratio", 30), "g": 0.9, "allowed": 0.3, "core": (0.01, 0.5)},
}


def with_core(raw, core, diffusion_lengths=6):
    """The tile's grids with the core's medium below, deep enough to be without end; its phase function is the tile's, so
    that sigma_s' is sigma_s (1 - g)."""
    header = json.loads((raw / "volume.json").read_text())
    nx, ny, nz = header["size"]

    def grid(name):
        entry = header["grids"][name]
        return np.fromfile(raw / entry["file"], np.float32).reshape(nz, ny, nx, entry["channels"])

    extinction, albedo = grid("extinction"), grid("albedo")
    g = float(grid("g").flat[0]) if "g" in header["grids"] else 0.0
    if core is not None:
        absorption, reduced = core
        scattering = reduced / (1 - g)
        depth = diffusion_lengths / np.sqrt(3 * absorption * (absorption + reduced))
        below = int(np.ceil(depth / header["voxelMm"][2]))
        extinction = np.concatenate([extinction, np.full((below, *extinction.shape[1:]), absorption + scattering,
                                                         np.float32)])
        albedo = np.concatenate([albedo, np.full((below, *albedo.shape[1:]), scattering / (absorption + scattering),
                                                 np.float32)])

    def grey(values):
        return values[..., 0] if np.all(values == values[..., :1]) else values

    return {"extinction": grey(extinction), "albedo": grey(albedo), "g": g, "voxel_mm": header["voxelMm"]}


class Comparison:
    def __init__(self, build, mitsuba, folder, quick, threads):
        self.stf, self.mitsuba, self.folder, self.threads = Stf(build), mitsuba, folder, threads
        self.record = flat.Recorder(build, folder)
        self.samples, self.paths, self.quality = (128, 64, 0.05) if quick else (512, 1024, 0.01)
        self.maps = {}

    def __call__(self, name, tile, core):
        key = f"{name}, {'core' if core else 'black below'}"
        stem = key.replace(" ", "_").replace(",", "")
        volume = self.folder / f"{stem}.vdb"
        self.stf("make", tile["make"][0], volume, *tile["make"][1:])
        raw = self.stf.dump(volume, self.folder / stem)
        grids = with_core(raw, core)
        np.savez(self.folder / f"{stem}.npz", **grids)
        told = self.mitsuba("mitsuba_tile.py", self.folder / f"{stem}.npz", self.folder / f"{stem}_theirs.npz",
                            f"--light={','.join(map(str, LIGHT))}", "--samples", self.samples, "--renders", 32,
                            "--threads", self.threads)
        with np.load(self.folder / f"{stem}_theirs.npz") as theirs:
            reference, stderr = theirs["radiance"], theirs["stderr"]
        nz, ny, nx = grids["extinction"].shape[:3]
        dx, dy, _ = grids["voxel_mm"]
        width, height = nx * dx, ny * dy
        shell = flat.FlatShell(volume, (width, height), core, self.quality)
        camera = flat.parallel_camera(np.array((0.0, 0, 1)), (width / 2, height / 2, 0), width, height)
        images, seconds = [], []
        for seed in (1, 2):  # two halves: their difference is the noise
            layers, stats = self.record(f"{stem}_{seed}", shell.text(flat.distant(LIGHT), camera), nx, self.paths // 2,
                                        settings=[f"stf:seed={seed}"])
            images.append(layers["color"][::-1])  # the first row is the tile's last
            seconds.append(stats["seconds"]["render"])
        image = np.mean(images, axis=0)
        if reference.ndim == 2:
            reference, stderr, image = reference[..., None], stderr[..., None], image[..., :1]
        halves = (images[0] - images[1])[..., :image.shape[2]]
        scale = reference.mean()
        variance = stderr**2 + halves**2 / 4
        noise = float(variance.mean())
        difference = image - reference
        self.maps[f"{key}|ours"], self.maps[f"{key}|mitsuba"] = image / scale, reference / scale
        row = {"case": key, "g": grids["g"], "core": core, "allowed": tile["allowed"],
               "meanDifference": float(difference.mean() / scale),
               "rms": float(max(np.mean(difference**2) - noise, 0)**0.5 / scale),
               "relative": float(max(np.mean((difference**2 - variance) / reference**2), 0)**0.5),
               "noise": noise**0.5 / scale, "borders": borders(difference / scale, noise**0.5 / scale),
               "seconds": seconds, "mitsubaSeconds": told["seconds"]}
        print(f"{key:<38}{100 * row['meanDifference']:>+8.2f}{100 * row['rms']:>8.2f}{100 * row['relative']:>10.2f}"
              f"{100 * row['noise']:>8.2f}{row['borders']:>10.2f}", flush=True)
        return row


def borders(difference, noise):
    """How much more the difference changes across the tile's border than elsewhere, in standard deviations of such
    steps: 0 where the border is like any other place."""
    sigmas = []
    for axis in (0, 1):
        steps = np.abs(np.diff(np.concatenate([difference, np.take(difference, [0], axis)], axis=axis), axis=axis))
        lines = steps.mean(axis=tuple(a for a in range(steps.ndim) if a != axis))
        sigmas.append((lines[-1] - lines[:-1].mean()) / max(lines[:-1].std(ddof=1), 1e-3 * noise))
    return float(max(sigmas))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=TOP / "build")
    parser.add_argument("--mitsuba-python", required=True, help="a Python with mitsuba and numpy")
    parser.add_argument("--quick", action="store_true", help="few paths, coarse tables")
    parser.add_argument("--only", nargs="+", choices=TILES, default=list(TILES))
    arguments = parser.parse_args()
    target = arguments.build / "bench"
    target.mkdir(exist_ok=True)
    print(f"{'image against Mitsuba, %':<38}{'mean':>8}{'rms':>8}{'relative':>10}{'noise':>8}{'border':>10}")
    with tempfile.TemporaryDirectory() as folder:
        compare = Comparison(arguments.build.resolve(), Mitsuba(arguments.mitsuba_python), pathlib.Path(folder),
                             arguments.quick, threads_of_machine())
        try:
            rows = [compare(name, TILES[name], core) for name in arguments.only
                    for core in (None, TILES[name]["core"])]
        except Skipped as reason:
            raise SystemExit(f"not compared with Mitsuba: {reason}")
    np.savez_compressed(target / "scene_tiles.npz", **compare.maps)
    (target / "scene_tiles.json").write_text(json.dumps({"quality": compare.quality, "rows": rows}, indent=1))
    print(target / "scene_tiles.json")


if __name__ == "__main__":
    main()
