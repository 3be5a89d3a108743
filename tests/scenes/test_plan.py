"""`stf plan`: what it says before a run is what a run then does, and saying it renders and keeps nothing.

STF names the program, SCENES the folder of the examples, BAD that of the scenes with bad input.
"""

import json
import os
import pathlib
import subprocess

import pytest

STF, SCENES, BAD = os.environ["STF"], pathlib.Path(os.environ["SCENES"]), pathlib.Path(os.environ["BAD"])


@pytest.fixture
def plan(tmp_path):
    environment = {**os.environ, "HDSTF_CACHE_DIR": str(tmp_path / "cache")}

    def call(scene, *words):
        done = subprocess.run([STF, "plan", str(scene), "--json", *words], capture_output=True, text=True,
                              env=environment, cwd=tmp_path, timeout=240)
        assert done.returncode == 0, done.stderr
        return {(e["object"], e["stage"]): e for e in json.loads(done.stdout)}
    call.folder, call.environment = tmp_path, environment
    return call


def test_a_plan_renders_and_keeps_nothing(plan):
    foreseen = plan(SCENES / "marble_slab.usda")
    table = foreseen["/World/Slab", "transport"]
    assert table["runs"] and table["estimatedSeconds"] > 0
    assert foreseen["/World/Slab", "synthesis"]["why"] == "mapping is uv"
    assert not foreseen["/World/Ground", "shell"]["runs"]
    assert all(e["why"] for e in foreseen.values()), "every stage says why"
    assert not list(plan.folder.rglob("*.vdb")) and not list(plan.folder.rglob("*.exr"))


def test_what_runs_is_what_was_foreseen(plan):
    words = ("--set", "stf:samples=1")
    foreseen = plan(SCENES / "marble_slab.usda", *words)
    done = plan(SCENES / "marble_slab.usda", "--run", *words)
    both = foreseen.keys() & done.keys()
    assert {("/World/Slab", "transport"), ("scene", "lights"), ("scene", "bounces")} <= both
    assert {k: foreseen[k]["runs"] for k in both} == {k: done[k]["runs"] for k in both}
    for entry in done.values():
        assert entry["seconds"] >= 0
    assert done["/World/Slab", "transport"]["estimatedSeconds"] is not None
    # The run left a table behind, so that the next one needs no walks.
    again = plan(SCENES / "marble_slab.usda", *words)
    assert not again["/World/Slab", "transport"]["runs"]
    assert again["/World/Slab", "transport"]["estimatedSeconds"] < 0.5 * done["/World/Slab", "transport"]["seconds"]


@pytest.mark.parametrize("setting, stage, why", [
    ("stf:maxDepth=0", "bounces", "stf:maxDepth is 0"),
    ("stf:maxDepth=0", "indirect", "stf:maxDepth is 0"),
])
def test_settings_leave_stages_out(plan, setting, stage, why):
    entry = plan(SCENES / "marble_slab.usda", "--set", setting)["scene", stage]
    assert not entry["runs"] and entry["why"] == why


def test_a_missing_volume_is_said(plan):
    found = [e for e in plan(BAD / "missing_volume.usda").values() if e["stage"] == "shell" and not e["runs"]]
    assert any("not found" in e["why"] for e in found)


def test_a_missing_scene_is_an_error(plan):
    done = subprocess.run([STF, "plan", "nowhere.usda"], capture_output=True, text=True, env=plan.environment)
    assert done.returncode not in (0, -6, -11) and "nowhere.usda" in done.stderr
