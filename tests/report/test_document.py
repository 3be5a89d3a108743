"""The page and its numbers from runs whose error is known; and the same again from the file of what was found."""

import json
import re
import types

import numpy as np
import OpenEXR
import pytest

for package in ("flip_evaluator", "jinja2", "matplotlib", "tqdm"):
    pytest.importorskip(package, reason="packages of tools/report/requirements.txt")

import document  # noqa: E402
import found_file  # noqa: E402
from measurement import Found  # noqa: E402
from recorder import Run  # noqa: E402
from sources import Source, Sources  # noqa: E402

SIZE = (40, 48, 3)
NOISE, BIAS = 0.3, -0.04  # of one sample; of the STF where there is a shell
SECONDS = dict.fromkeys(("load", "precompute", "synthesis", "shell", "core", "indirect", "firstPixel"), 0.1)


class Runs:
    def __init__(self, folder):
        self.folder, self.rng = folder / "runs", np.random.default_rng(1)
        self.folder.mkdir()
        self.shell = np.zeros(SIZE)
        self.shell[8:32, 8:40] = 1

    def __call__(self, name, samples, bias=0.0, per_sample=0.5, setup=1.0):
        image = 0.5 + bias * self.shell + NOISE / samples**0.5 * self.rng.standard_normal(SIZE)
        planes = {c: image[..., i].astype(np.float32) for i, c in enumerate("RGB")}
        for part in ("single", "multiple", "core", "reflection"):
            planes.update({f"stf:{part}.{c}": self.shell[..., i].astype(np.float32) for i, c in enumerate("RGB")})
        with OpenEXR.File({"type": OpenEXR.scanlineimage}, planes) as out:
            out.write(str(self.folder / f"{name}.exr"))
        wall = setup + per_sample * samples
        return Run(name, samples, wall, 2 * wall, {**SECONDS, "render": per_sample * samples, "total": wall},
                   self.folder / f"{name}.exr", [])

    def pair(self, name, samples, **more):
        return [self(f"{name}_{samples}_{half}", samples, **more) for half in (0, 1)]


@pytest.fixture
def found(tmp_path):
    runs = Runs(tmp_path)
    limit = runs.pair("limit", 16)
    return tmp_path, Found(
        cold=runs.pair("cold", 1, bias=BIAS, setup=31.0), parts=runs("parts", 4, bias=BIAS),
        stf={n: runs.pair("stf", n, bias=BIAS, per_sample=0.01) for n in (1, 16, 64)},
        reference={n: [runs.pair("reference", n)] for n in (1, 16, 256)},
        sources=Sources({"quality": 0.01}, limit, [Source("tables", "0.01 to 0.08", runs.pair("changed", 16, bias=BIAS),
                                                          limit)], [("step", "no setting")]))


def write(folder, found):
    options = types.SimpleNamespace(output=folder, scene=types.SimpleNamespace(name="a<b.usda"))
    page = document.Document(options, found).write().read_text()
    return page, json.loads((folder / "report.json").read_text())


def test_numbers_are_those_of_the_runs(found):
    _, told = write(*found)
    assert told["mask"] == "shells"
    for row in told["stf"]["rows"]:
        e = row["errors"]["shells"]
        for name, value in {"mean": BIAS / 0.5, "bias": -BIAS / 0.5,
                            "deviation": NOISE / 0.5 / row["samples"]**0.5}.items():
            assert abs(e[name]["value"] - value) < 4 * e[name]["error"] + 1e-3, (row["samples"], name)
        assert row["cold"]["wall"] == pytest.approx(row["warm"]["wall"] + 30, abs=0.6)
    outside = told["stf"]["rows"][-1]["errors"]["frame"]["bias"]["value"]
    assert 0 < outside < -BIAS / 0.5  # the frame has pixels without the bias
    best = told["breakEven"]["the reference"]["wall"][-1]
    samples = (NOISE / 0.5 / best["error"])**2
    assert best["otherSamples"] == pytest.approx(samples, rel=0.1)
    assert best["other"] == pytest.approx(1 + 0.5 * samples, rel=0.1)
    source = told["sources"]["rows"][0]
    assert abs(source["mean"]["value"] - BIAS / 0.5) < 4 * source["mean"]["error"]


def test_the_page_needs_nothing_else(found):
    page, _ = write(*found)
    assert "a&lt;b.usda" in page and "<b.usda" not in page
    # Names of SVG's namespaces apart, nothing points out of the page.
    assert not re.findall(r'(?:src|href)="(?!data:|#)', page)
    assert page.count("<svg") == 7 and page.count("data:image/png") == 7
    assert "step: no setting" in page


def test_the_page_again_from_the_file(found):
    folder, runs = found
    first = write(folder, runs)
    found_file.save(runs, folder / "found.json")
    assert write(folder, found_file.load(folder / "found.json", folder / "runs")) == first
    with pytest.raises(ValueError, match="nothing to write a page from"):
        found_file.load(folder / "nowhere.json", folder)


def test_what_was_stopped_early_is_shown(found):
    folder, runs = found
    runs.stf, runs.reference = {1: runs.stf[1]}, {1: runs.reference[1]}
    runs.parts = runs.sources = runs.mitsuba = None
    runs.notes.append("interrupted")
    page, told = write(folder, runs)
    assert told["mask"] == "frame" and "interrupted" in page
