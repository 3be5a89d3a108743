"""The scene that `stf inspect --usd` writes is one that OpenUSD understands: a UsdVol Volume with its fields."""

import os
import subprocess

from pxr import Usd, UsdGeom, UsdVol

STF = os.environ["STF"]


def test_fields(tmp_path):
    subprocess.run([STF, "make", "wax", tmp_path / "wax.vdb", "--size", "8,8,4"], check=True)
    subprocess.run([STF, "inspect", tmp_path / "wax.vdb", "--usd", tmp_path / "wax.usda"], check=True)
    stage = Usd.Stage.Open(str(tmp_path / "wax.usda"))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.001
    volume = UsdVol.Volume(stage.GetDefaultPrim())
    paths = volume.GetFieldPaths()
    assert sorted(paths) == ["albedo", "extinction", "surface"]
    for name, path in paths.items():
        asset = UsdVol.OpenVDBAsset(stage.GetPrimAtPath(path))
        assert asset
        assert asset.GetFieldNameAttr().Get() == name
        assert asset.GetFilePathAttr().Get().resolvedPath == str(tmp_path / "wax.vdb")
        assert asset.GetFieldDataTypeAttr().Get() == ("float" if name == "surface" else "float3")
    # Up is out: the top of the tile is the highest of the scene.
    matrix = UsdGeom.Xformable(volume).GetLocalTransformation()
    assert matrix.Transform((0, 0, 1))[2] == -1
