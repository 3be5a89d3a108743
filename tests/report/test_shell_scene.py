"""Scenes whose shells are drawn in another way, and what Mitsuba is told of flat ones."""

import pathlib

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

import flat_shell
import shell_scene

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "usd_examples"
VOLUME = {"grids": {"extinction": {}, "albedo": {}}, "size": [96, 96, 20], "voxelMm": [0.4, 0.4, 0.4]}


@pytest.mark.parametrize("name", ["hero", "wax_sphere"])
def test_overrides_reach_the_shells_and_nothing_else_changes(tmp_path, name):
    scene = shell_scene.ShellScene(EXAMPLES / f"{name}.usda")
    assert scene.values("quality") == [0.08] and scene.values("coreModel") == ["auto"]
    path = scene.write(tmp_path / "x.usda", quality=0.01, coreModel="walk")
    over, before = Usd.Stage.Open(str(path)), scene.stage
    assert UsdGeom.GetStageMetersPerUnit(over) == UsdGeom.GetStageMetersPerUnit(before)
    assert UsdGeom.GetStageUpAxis(over) == UsdGeom.GetStageUpAxis(before)
    assert [p.GetPath() for p in over.Traverse()] == [p.GetPath() for p in before.Traverse()]
    changed = shell_scene.ShellScene(path)
    assert changed.values("quality") == [0.01] and changed.values("coreModel") == ["walk"]
    assert changed.values("transport") == scene.values("transport")
    shell = changed.shells[0]
    assert changed.primvar(shell, "baseVolume").resolvedPath or changed.primvar(shell, "baseVolume").path
    # The same again leaves the file alone, for runs are kept by what is in it.
    stamp = path.stat().st_mtime_ns
    scene.write(path, quality=0.01, coreModel="walk")
    assert path.stat().st_mtime_ns == stamp


def test_what_is_no_scene_is_named(tmp_path):
    with pytest.raises(ValueError, match="nowhere.usda: no such file"):
        shell_scene.ShellScene(tmp_path / "nowhere.usda")
    bad = tmp_path / "bad.usda"
    bad.write_text("garbage")
    with pytest.raises(ValueError, match="bad.usda is no USD file"):
        shell_scene.ShellScene(bad)


def test_a_flat_scene_in_millimetres_of_its_tile():
    shells = shell_scene.ShellScene(EXAMPLES / "marble_tile.usda")
    told = flat_shell.describe(shells, VOLUME, None, (128, 128))
    camera = told["camera"]
    # Turned by 40 degrees about x, 200 back along its own axis.
    angle = np.radians(40)
    assert np.allclose(camera["origin"], (0, -200 * np.sin(angle), 200 * np.cos(angle)), atol=1e-4)
    assert np.allclose(np.subtract(camera["target"], camera["origin"]), (0, np.sin(angle), -np.cos(angle)), atol=1e-6)
    assert camera["fov"] == pytest.approx(2 * np.degrees(np.arctan(12 / 70)), rel=1e-5)
    sun, sky = told["lights"]
    assert np.allclose(sun["irradiance"], (2.6, 2.6 * 0.96, 2.6 * 0.9))
    assert np.allclose(sky["radiance"], (0.255, 0.276, 0.3))
    assert sun["direction"][2] < 0 and np.linalg.norm(sun["direction"]) == pytest.approx(1)


def test_a_turned_and_scaled_tile_is_told_alike(tmp_path):
    """Everything turned, moved and in other units: in the tile's own space nothing has changed."""
    straight = shell_scene.ShellScene(EXAMPLES / "marble_tile.usda")
    stage = Usd.Stage.CreateNew(str(tmp_path / "turned.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 0.001)
    world = UsdGeom.Xform.Define(stage, "/World")
    world.GetPrim().GetReferences().AddReference(str(straight.path))
    world.AddTransformOp().Set(Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 2, 3), 70)) *
                               Gf.Matrix4d().SetTranslate(Gf.Vec3d(5, -7, 11)))
    stage.Save()
    told = [flat_shell.describe(s, VOLUME, None, (64, 64))
            for s in (straight, shell_scene.ShellScene(tmp_path / "turned.usda"))]
    for key in ("origin", "target", "up"):
        assert np.allclose(told[0]["camera"][key], told[1]["camera"][key], atol=1e-3), key
    assert np.allclose(told[0]["lights"][0]["direction"], told[1]["lights"][0]["direction"], atol=1e-5)


@pytest.mark.parametrize("name, why", [("marble_slab", "other surfaces"), ("hero", "other surfaces")])
def test_what_cannot_be_told_is_said(name, why):
    with pytest.raises(flat_shell.NotComparable, match=why):
        flat_shell.describe(shell_scene.ShellScene(EXAMPLES / f"{name}.usda"), VOLUME, None, (128, 128))


def test_a_camera_that_sees_the_rim_is_refused(tmp_path):
    shells = shell_scene.ShellScene(EXAMPLES / "marble_tile.usda")
    stage = shells.stage
    UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera")).GetFocalLengthAttr().Set(10)
    with pytest.raises(flat_shell.NotComparable, match="rim|more than the shell"):
        flat_shell.describe(shells, VOLUME, None, (128, 128))
    relief = {**VOLUME, "grids": {**VOLUME["grids"], "surface": {}}}
    with pytest.raises(flat_shell.NotComparable, match="relief"):
        flat_shell.describe(shells, relief, None, (128, 128))
