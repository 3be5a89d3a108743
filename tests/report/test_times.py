"""Times to equal error, of a renderer whose error is known."""

import numpy as np
import pytest

import analysis
import image_error as errors
import sources


def unbiased(setup, per_sample, deviation, counts):
    """Rows as analysis.unbiased_rows gives them."""
    rows = []
    for n in counts:
        seconds = setup + per_sample * n
        rows.append({"samples": n, "warm": {"wall": seconds, "cpu": 2 * seconds},
                     "stages": {"perPass": per_sample, "total": seconds},
                     "errors": {"frame": {"rmse": errors.Estimate(deviation / n**0.5, 0.01 * deviation / n**0.5)}}})
    return rows


@pytest.mark.parametrize("what, factor", [("wall", 1), ("cpu", 2)])
def test_seconds_follow_the_law_of_noise(what, factor):
    time = analysis.unbiased_time(unbiased(3, 0.5, 0.8, [1, 4, 16]), "frame", what)
    for error, samples, beyond in ((0.8, 1, False), (0.2, 16, False), (0.1, 64, True)):
        told, past = time.seconds(errors.Estimate(error, 0.0))
        assert told.value == pytest.approx(factor * (3 + 0.5 * samples), rel=1e-6)
        assert told.error == pytest.approx(factor * 0.5 * samples * 0.02, rel=1e-6)
        assert past == beyond
        # An error that is known to 3 % asks for samples that are known to 6 %.
        unsure, _ = time.seconds(errors.Estimate(error, 0.03 * error))
        assert unsure.error == pytest.approx(factor * 0.5 * samples * (0.02**2 + 0.06**2)**0.5, rel=1e-6)
    # Less than one sample cannot be taken.
    assert time.seconds(errors.Estimate(5.0, 0.0))[0].value == pytest.approx(factor * 3.5)


def row(samples, error, wall):
    return {"samples": samples, "warm": {"wall": wall}, "errors": {"frame": {"rmse": errors.Estimate(error, 0.0)}}}


def test_frames_until_the_tables_pay():
    other = analysis.UnbiasedTime(setup=1.0, per_sample=0.5, variance=0.64, variance_error=0.0, largest=1000)
    # Error 0.08: 100 samples, 51 seconds, against 1 in each frame and 120 for the tables.
    (told,) = analysis.break_even([row(8, 0.08, 1.0)], {"wall": 120.0}, other, "frame", "wall")
    assert told["other"] == pytest.approx(51) and told["ratio"] == pytest.approx(51)
    assert told["frames"] == 3  # 2.4 frames save 120 seconds
    assert told["ratioOfFrames"] == pytest.approx(3 * 51 / 123)
    (never,) = analysis.break_even([row(8, 0.8, 2.0)], {"wall": 120.0}, other, "frame", "wall")
    assert never["frames"] is None and never["ratio"] < 1
    # An error that noise made negative can be compared with nothing.
    assert analysis.break_even([row(8, -0.01, 2.0)], {"wall": 120.0}, other, "frame", "wall") == []


def test_a_table_at_its_limit():
    assert sources.limit_quality(0.08, 10, 40) == pytest.approx(0.04)
    assert sources.limit_quality(0.08, 10, 1e9) == pytest.approx(0.01)  # an eighth at most
    assert np.isfinite(sources.limit_quality(0.08, -0.1, 60))  # tables that were quicker cold than kept
