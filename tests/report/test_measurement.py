"""How the time is shared: runs of a recorder whose clock is a number."""

import pathlib
import types
import zlib

import numpy as np
import pytest

import measurement
import recorder

STAGES = dict.fromkeys(("load", "synthesis", "shell", "core", "indirect", "firstPixel", "total"), 0.0)


class FakeRun(recorder.Run):
    def color(self):
        noise = np.random.default_rng(zlib.crc32(self.name.encode())).standard_normal((16, 16, 3))
        return 1 + FakeRecorder.deviation / self.samples**0.5 * noise


class FakeRecorder:
    """`seconds(name, samples)`: what a run takes. Calls are kept in `calls`."""
    deviation = 1.0

    def __init__(self, seconds, clock, interrupt=None):
        self.seconds, self.clock, self.interrupt = seconds, clock, interrupt
        self.folder, self.spent, self.deadline, self.calls = pathlib.Path("out/runs"), 0.0, float("inf"), []

    def run(self, name, scene, samples, seed, table_seed=0, settings=(), aovs=(), cold=False):
        if name == self.interrupt:
            raise KeyboardInterrupt
        taken = min(self.seconds(name, samples), max(0.0, self.deadline - self.clock.now))
        self.clock.now += taken
        self.spent += taken
        if taken < self.seconds(name, samples):
            raise recorder.OutOfTime
        self.calls.append((name, seed, table_seed, dict(settings)))
        stages = {**STAGES, "precompute": 5.0 if cold else 0.0, "render": 0.1 * samples}
        return FakeRun(name, samples, taken, taken, stages, None, [])


@pytest.fixture
def measured(monkeypatch):
    clock = types.SimpleNamespace(now=1000.0)
    monkeypatch.setattr(measurement.time, "monotonic", lambda: clock.now)
    shells = types.SimpleNamespace(
        shells=["a shell"], write=lambda path, **values: path,
        values=lambda name: {"quality": [0.08], "coreModel": ["auto"]}[name])

    def measure(seconds, limit=300, noise=0.01, interrupt=None, earlier=None):
        options = types.SimpleNamespace(scene=pathlib.Path("a.usda"), samples=128, time_limit=limit,
                                        reference_noise=noise, mitsuba_python=None)
        fake = FakeRecorder(seconds, clock, interrupt)
        return measurement.Measurement(options, fake, shells, lambda text: None, earlier).all(), fake
    return measure


def usual(name, samples):
    return 1 + 0.1 * samples + (5 if name.startswith("cold") else 0)


def test_everything_within_the_time(measured):
    found, fake = measured(usual)
    assert fake.spent <= 300
    assert sorted(found.stf) == [1, 2, 4, 8, 16, 32, 64, 128]
    assert {r.name for r in found.sources.rows} == {
        "resolution of tables", "noise of tables", "core model", "irradiance cache", "bounces off surfaces",
        "regularization", "form of anisotropy", "step of the march", "coarser levels of shell and sample",
        "sums over the core"}
    # Tables of many directions, and for halved voxels, take longer.
    assert ("direction resolution", "the time did not suffice") in found.sources.left_out
    assert max(found.reference) >= 64 and "--mitsuba-python" in found.mitsuba.why
    # The halves share neither samples nor tables, the runs of the reference no seed.
    for pair in (found.cold, *found.stf.values()):
        calls = {c[0]: c for c in fake.calls}
        (_, a, ta, _), (_, b, tb, _) = (calls[r.name] for r in pair)
        assert a != b and ta != tb
    seeds = [c[1] for c in fake.calls if c[0].startswith("reference")]
    assert len(set(seeds)) == len(seeds) and not set(seeds) & {0, 1}


def test_resolutions_of_tables_are_free_of_their_noise(measured):
    found, fake = measured(usual, limit=2000)
    runs = {c[0]: c for c in fake.calls}
    rows = {r.name: r for r in found.sources.rows}
    for name, flag in (("direction resolution", "directions"), ("voxel resolution of tables", "voxels")):
        assert [runs[r.name][1:3] for r in rows[name].changed] == [(0, 0), (1, 1)]  # seeds of samples and of tables
        assert [runs[r.name][1:3] for r in rows[name].limit] == [(0, 0), (1, 1)]
        settings = [{runs[r.name][3]["stf:exact"] for r in side} for side in (rows[name].changed, rows[name].limit)]
        assert settings == [{"levels,step,coreTree"}, {f"levels,step,coreTree,{flag}"}]


def test_what_takes_too_long_leaves_time_for_the_reference(measured):
    found, fake = measured(lambda name, samples: 500 if name.startswith("source") else usual(name, samples))
    assert any("sources of error" in note for note in found.notes)
    assert found.sources.limit is None and found.sources.rows == []
    assert max(found.reference) >= 32 and fake.spent <= 300


def test_a_first_image_that_takes_too_long(measured):
    found, _ = measured(lambda name, samples: 400)
    assert not found.reference and not found.stf
    assert any("300 s" in note for note in found.notes)


def test_a_report_that_goes_on_keeps_its_limit(measured):
    assert measured(usual)[0].sources.limits["quality"] < 0.06
    assert measured(usual, earlier={"quality": 0.033})[0].sources.limits["quality"] == 0.033


def test_an_interrupt_keeps_what_is_there(measured):
    found, _ = measured(usual, interrupt="stf_8_1")
    assert found.interrupted and sorted(found.stf) == [1, 2, 4]
    assert list(found.reference) == [1] and found.sources is None


def test_the_reference_ends_at_the_noise_that_is_wanted(measured):
    found, fake = measured(usual, noise=0.2)
    # 2 (1 + 2 + 4 + 8) samples have a noise of 1 / sqrt(30) = 0.18.
    assert sorted(found.reference) == [1, 2, 4, 8] and fake.spent < 300
    assert not any("noise" in note for note in found.notes)
