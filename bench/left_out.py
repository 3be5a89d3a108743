#!/usr/bin/env python3
"""Time that the plan saves by what it leaves out of a scene (that the picture is the same: LeftOut tests).

Usage: left_out.py [--build FOLDER] [--width N] [--samples N] [--rounds N]

Each row renders the slab of the examples twice, once so that a stage is needed and once so that it is not; the quickest
of some rounds counts. Tables come from the store, but in the rows about them. Prints a table and writes
FOLDER/bench/left_out.json. This Python needs usd-core.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

from pxr import Sdf, Usd, UsdGeom, UsdLux

SHELL, KEY, CAMERA = "/World/Slab", "/World/Key", "/World/Camera"
ALL = ("synthesis", "shell", "core", "indirect", "render")


def primvar(name, kind, value):
    return lambda stage: UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(SHELL)).CreatePrimvar(f"stf:{name}", kind).Set(value)


def drop_texture_coordinates(stage):
    prim = stage.GetPrimAtPath(SHELL)
    UsdGeom.PrimvarsAPI(prim).RemovePrimvar("st")
    prim.RemoveProperty("primvars:st:indices")
    primvar("mapping", Sdf.ValueTypeNames.Token, "auto")(stage)


def drop_ground(stage):
    stage.RemovePrim("/World/Ground")


def subdivide(scheme):
    def edit(stage):
        mesh = UsdGeom.Mesh(stage.GetPrimAtPath(SHELL))
        mesh.GetSubdivisionSchemeAttr().Set(scheme)
        mesh.GetPrim().RemoveProperty("normals")
    return edit


def dim_lights(intensity):
    def edit(stage):
        for i in range(8):
            light = UsdLux.SphereLight.Define(stage, f"/World/Dim{i}")
            light.AddTranslateOp().Set((10.0 * i - 35, 60, 40))
            for spelling in ("intensity", "inputs:intensity"):
                light.GetPrim().CreateAttribute(spelling, Sdf.ValueTypeNames.Float).Set(intensity)
    return edit


def lens(stop):
    def edit(stage):
        camera = UsdGeom.Camera(stage.GetPrimAtPath(CAMERA))
        camera.CreateFStopAttr(stop)
        camera.CreateFocusDistanceAttr(150.0)
    return edit


def moves(stage):
    """By next to nothing, with the shutter open."""
    camera = UsdGeom.Camera(stage.GetPrimAtPath(CAMERA))
    camera.CreateShutterOpenAttr(-0.25)
    camera.CreateShutterCloseAttr(0.25)
    op = UsdGeom.Xformable(stage.GetPrimAtPath(SHELL)).AddTranslateOp()
    for time in (-1, 0, 1):
        op.Set((1e-6 * time, 0, 0), time)


def volume(name):
    return primvar("baseVolume", Sdf.ValueTypeNames.Asset, Sdf.AssetPath(f"./{name}.vdb"))


# What is left out: how the scene is without it and with it, stages whose seconds count, whether the store is empty.
ROWS = {
    "walks (nothing scatters)": (volume("absorbing"), volume("scattering"), ("precompute",), True),
    "walks (tables are kept)": (None, None, ("load", "precompute"), "first"),
    "core (black)": (primvar("coreModel", Sdf.ValueTypeNames.Token, "none"), None, ALL, False),
    "Fresnel (index 1)": (volume("scattering"), volume("refracting"), ALL, False),
    "synthesis (texture coordinates tile)": (None, drop_texture_coordinates, ALL, False),
    "subdivision (scheme none)": (subdivide("none"), subdivide("bilinear"), ALL, False),
    "bounces (no plain surface)": (drop_ground, None, ALL, False),
    "lights (8 that give none)": (dim_lights(0.0), dim_lights(1e-6), ALL, False),
    "lens (pinhole)": (lens(0.0), lens(22.0), ("render",), False),
    "motion (all at rest)": (None, moves, ("render",), False),
}


class Bench:
    def __init__(self, build, folder, width, samples):
        self.build, self.folder, self.width, self.samples = build, folder, width, samples
        examples = build / "usd_examples"
        shutil.copytree(examples / "volumes", folder / "volumes")
        self.scene = folder / "marble_slab.usda"
        shutil.copy(examples / "marble_slab.usda", self.scene)
        options = ("--size", "16,16,20", "--voxel", "0.4", "--extinction", "2")
        for name, more in (("absorbing", ("--albedo", "0")), ("scattering", ("--albedo", "0.9")),
                           ("refracting", ("--albedo", "0.9", "--ior", "1.3"))):
            subprocess.run([build / "bin/stf", "make", "uniform", folder / f"{name}.vdb", *options, *more], check=True,
                           capture_output=True)

    def __call__(self, edit, store):
        stage = Usd.Stage.Open(Sdf.Layer.OpenAsAnonymous(str(self.scene)))
        if edit:
            edit(stage)
        path, stats = self.folder / "edited.usda", self.folder / "stats.json"
        stage.GetRootLayer().Export(str(path))
        done = subprocess.run([self.build / "bin/stfrecord", path, self.folder / "frame.exr", "--quiet", "--imageWidth",
                               str(self.width), "--samples", str(self.samples), "--stats", stats], capture_output=True, text=True,
                              env={**os.environ, "HDSTF_CACHE_DIR": str(store)})
        if done.returncode > 1:
            raise SystemExit(f"stfrecord: {done.stderr.strip()}")
        return json.loads(stats.read_text())["seconds"]

    def row(self, without, with_it, stages, fresh, rounds):
        best = [1e300, 1e300]
        for turn in range(rounds):
            for way, edit in enumerate((without, with_it)):
                store = self.folder / ("kept" if not fresh or (fresh == "first" and way == 0)
                                       else f"store_{turn}_{way}")
                if not fresh and turn == 0 or fresh == "first" and way == 0:
                    self(edit, store)  # fills it
                seconds = self(edit, store)
                best[way] = min(best[way], sum(seconds.get(stage, 0.0) for stage in stages))
        return best


def measure(build, names=tuple(ROWS), width=256, samples=16, rounds=3):
    rows = []
    print(f"\n{'left out':<40}{'without s':>11}{'with s':>9}{'saved s':>9}  stages")
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(build, pathlib.Path(folder), width, samples)
        for name in names:
            without, with_it, stages, fresh = ROWS[name]
            best = bench.row(without, with_it, stages, fresh, rounds)
            rows.append({"leftOut": name, "without": best[0], "with": best[1], "stages": stages})
            print(f"{name:<40}{best[0]:>11.2f}{best[1]:>9.2f}{best[1] - best[0]:>9.2f}  {', '.join(stages)}", flush=True)
    target = build / "bench" / "left_out.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps(rows, indent=1))
    print(target)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parent.parent / "build")
    parser.add_argument("--width", type=int, default=256)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", nargs="+", choices=ROWS, default=list(ROWS))
    arguments = parser.parse_args()
    measure(arguments.build.resolve(), arguments.only, arguments.width, arguments.samples, arguments.rounds)


if __name__ == "__main__":
    main()
