"""The builder of the sample library: its recipes, what it makes of them, and what it does without a sample's data."""

import json
import os
import pathlib
import subprocess
import sys

import pytest

TOP = pathlib.Path(__file__).resolve().parents[2]
BUILDER = TOP / "tools" / "samples" / "samples.py"
BUILD = pathlib.Path(os.environ["STF_BUILD"])
sys.path.insert(0, str(BUILDER.parent))
import samples  # noqa: E402
import scene  # noqa: E402
import studio  # noqa: E402

RECIPES = sorted((TOP / "samples").glob("*.json"))


def run(*arguments, **environment):
    return subprocess.run([sys.executable, BUILDER, "--build", BUILD, *arguments], capture_output=True, text=True,
                          env={**os.environ, **environment})


def inspected(path):
    done = subprocess.run([BUILD / "bin" / "stf", "inspect", path, "--json"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.mark.parametrize("path", RECIPES, ids=lambda path: path.stem)
def test_recipes_are_complete(path):
    recipe = samples.read_recipe(path)
    assert recipe["about"]
    assert recipe["picture"]["radiusMm"] > 0
    assert f"**{path.stem}**" in (TOP / "docs" / "samples.md").read_text()
    image = TOP / "docs" / "samples" / f"{path.stem}.png"
    assert image.read_bytes()[1:4] == b"PNG"
    assert image.stat().st_size < 150_000


def test_modelled_samples_are_repeatable_and_seamless(tmp_path):
    modelled = [path.stem for path in RECIPES if "data" not in samples.read_recipe(path)]
    assert len(modelled) >= 7 and "terrazzo" in modelled
    for folder in ("a", "b"):
        done = run("--out", tmp_path / folder, *modelled)
        assert done.returncode == 0, done.stderr
    for name in modelled:
        first, second = (inspected(tmp_path / folder / f"{name}.vdb") for folder in ("a", "b"))
        assert first["hash"] == second["hash"], name
        assert max(first["periodicityError"]) < 1.75, name
        assert not [text for text in first["warnings"] if "seam" in text or "no core" in text], name


def test_scans_are_built_or_left_out(tmp_path):
    """Without the package and without a way to fetch it, one sample is left out and the rest is made."""
    tools = tmp_path / "bin"
    tools.mkdir()
    done = run("--out", tmp_path, "skull", "jade", PATH=str(tools), HDSTF_CACHE_DIR=str(tmp_path / "cache"))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "jade.vdb").exists()
    if (tmp_path / "skull.vdb").exists():
        assert inspected(tmp_path / "skull.vdb")["kind"] == "base volume"
    else:
        assert "skull: left out" in done.stdout and "libcgal-demo" in done.stdout


def test_unknown_names_and_keys(tmp_path):
    done = run("marbel")
    assert done.returncode != 0 and "marbel" in done.stderr and "marble" in done.stderr
    bad = tmp_path / "bad.json"
    bad.write_text('{"about": "x", "mak": {}}')
    with pytest.raises(SystemExit, match="mak"):
        samples.read_recipe(bad)
    bad.write_text('{"about": "x"}')
    with pytest.raises(SystemExit, match="make"):
        samples.read_recipe(bad)


def test_scene_is_understood(tmp_path):
    from pxr import Usd, UsdGeom

    studio.write(tmp_path / "studio.exr")
    (tmp_path / "jade.usda").write_text(scene.text("jade", {"radiusMm": 20}))
    stage = Usd.Stage.Open(str(tmp_path / "jade.usda"))
    ball = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Ball"))
    points = ball.GetPointsAttr().Get()
    st = UsdGeom.PrimvarsAPI(ball).GetPrimvar("st")
    assert len(st.Get()) == len(points)
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.001


def test_soft_boxes_give_about_as_much_light():
    sharp, soft = studio.image(False), studio.image(True)
    assert sharp.shape == (studio.HEIGHT, studio.WIDTH, 3)
    assert 0.7 < soft.mean() / sharp.mean() < 1.5
    assert soft.max() < 0.8 * sharp.max()
