"""Runs that are kept, and what is said of those that fail. The program is a script that counts how often it ran."""

import json
import stat
import time

import numpy as np
import OpenEXR
import pytest

import recorder

STATS = {"samples": 4, "seconds": {"render": 1.0, "total": 2.0},
         "messages": [{"severity": "warning", "text": "thin"}, {"severity": "info", "text": "fine"}]}


@pytest.fixture
def lab(tmp_path):
    """A recorder of a program `body`, the text of a shell script after it has counted itself."""
    scene = tmp_path / "scene.usda"
    scene.write_text("#usda 1.0\n")
    (tmp_path / "stats").write_text(json.dumps(STATS))
    write(tmp_path / "image.exr", np.full((4, 6, 3), 0.25, np.float32))

    def make(body=f"cp {tmp_path}/image.exr $2; cp {tmp_path}/stats $4"):
        program = tmp_path / "program"
        program.write_text(f"#!/bin/sh\necho x >> {tmp_path}/count\n{body}\n")
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        return recorder.Recorder(program, tmp_path / "out", ["--imageWidth", 6]), scene
    make.runs = lambda: (tmp_path / "count").read_text().count("x")
    make.folder = tmp_path
    return make


def write(path, pixels):
    with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": pixels}) as image:
        image.write(str(path))


def test_a_run_is_made_once(lab):
    runs, scene = lab()
    first = runs.run("a", scene, 4, 0)
    assert np.all(first.color() == 0.25) and first.color().shape == (4, 6, 3)
    assert first.messages == ["thin"] and first.samples == 4 and first.wall > 0
    spent = runs.spent
    assert runs.run("a", scene, 4, 0) == first
    assert lab.runs() == 1 and runs.spent == spent
    runs.run("a", scene, 4, 1)
    assert lab.runs() == 2
    scene.write_text("#usda 1.0\n# edited\n")
    runs.run("a", scene, 4, 1)
    assert lab.runs() == 3


def test_a_cold_run_finds_no_tables(lab):
    runs, scene = lab()
    kept = runs.cache / "tables1" / "table"
    kept.parent.mkdir(parents=True)
    kept.write_text("")
    runs.run("a", scene, 4, 0, table_seed=1)
    assert kept.exists()
    runs.run("b", scene, 4, 0, table_seed=1, cold=True)
    assert not kept.exists()


def test_what_failed_is_told(lab):
    runs, scene = lab("echo first; echo the volume is missing >&2; exit 2")
    with pytest.raises(recorder.RunFailed, match="the volume is missing$"):
        runs.run("a", scene, 4, 0)


def test_the_deadline_ends_a_run(lab):
    runs, scene = lab("exec sleep 30")
    runs.deadline = time.monotonic() + 0.2
    start = time.monotonic()
    with pytest.raises(recorder.OutOfTime):
        runs.run("a", scene, 4, 0)
    assert time.monotonic() - start < 10
    assert runs.spent > 0.1


def test_values_that_are_no_numbers_are_named(lab):
    bad = np.zeros((4, 6, 3), np.float32)
    bad[1, 2, 0] = np.nan
    write(lab.folder / "image.exr", bad)
    runs, scene = lab()
    with pytest.raises(ValueError, match="a.exr: 1 values are not finite"):
        runs.run("a", scene, 4, 0).color()
