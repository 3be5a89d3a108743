"""Errors of synthetic images whose bias and variance are known, against a reference that is noisier than they are."""

import numpy as np
import pytest

import image_error as errors

SHAPE = (128, 160, 3)
NOISE, BIAS, REFERENCE_NOISE = 0.06, 0.05, 0.4  # absolute; the truth has a mean of about 1


def truth():
    y, x = np.mgrid[0:SHAPE[0], 0:SHAPE[1]] / 32
    return np.stack([1 + 0.3 * np.sin(x + c) * np.cos(y) for c in range(3)], axis=2)


def bias_map():
    """Of both signs, so that it is not seen in the mean; its root mean square is BIAS."""
    y, x = np.mgrid[0:SHAPE[0], 0:SHAPE[1]]
    return BIAS * np.where(((x // 16 + y // 16) % 2 == 0)[..., None], 1.0, -1.0) * np.ones(3)


class Draw:
    """Images of one experiment; another seed gives an independent one."""

    def __init__(self, seed, bias=None, noise=NOISE, scene=None):
        rng = np.random.default_rng(seed)
        t, b = truth() if scene is None else scene, bias_map() if bias is None else bias
        self.images = [t + b + noise * rng.standard_normal(SHAPE) for _ in range(2)]
        self.halves = [t + REFERENCE_NOISE * rng.standard_normal(SHAPE) for _ in range(2)]
        self.blocks = errors.Blocks(np.ones(SHAPE[:2], bool))

    def told(self):
        return errors.errors(self.images, self.halves, self.blocks)


def test_noise_of_the_reference_cancels():
    draw = Draw(1)
    told, scale = draw.told(), truth().mean()
    expected = {"rmse": (NOISE**2 + BIAS**2)**0.5, "bias": BIAS, "deviation": NOISE}
    for name, value in expected.items():
        e = told[name]
        assert e.error < 0.2 * value / scale, name
        assert abs(e.value - value / scale) < 4 * e.error, name
    # Taken naively the reference's own noise would be most of it.
    naive = np.sqrt(np.mean((draw.images[0] - 0.5 * (draw.halves[0] + draw.halves[1]))**2)) / scale
    assert naive > 2.5 * told["rmse"].value


def test_rel_mse_is_its_definition():
    draw = Draw(2)
    reference = truth()
    expected = np.mean((NOISE**2 + BIAS**2) / (reference**2 + 0.01))
    # The noisy reference in the denominator makes it larger; with one of little noise it is the definition.
    quiet = [reference + 0.01 * np.random.default_rng(i).standard_normal(SHAPE) for i in (7, 8)]
    e = errors.errors(draw.images, quiet, draw.blocks)["relMSE"]
    assert abs(e.value - expected) < 4 * e.error + 0.01 * expected
    assert e.error < 0.05 * expected


def test_an_offset_is_seen_in_the_mean():
    told = Draw(3, bias=np.full(SHAPE, -0.1)).told()
    scale = truth().mean()
    assert abs(told["mean"].value + 0.1 / scale) < 4 * told["mean"].error
    assert abs(told["bias"].value - 0.1 / scale) < 4 * told["bias"].error


def test_no_bias_is_told_as_none():
    """Over experiments the squared bias of unbiased images is zero in the mean, of both signs."""
    values = [Draw(100 + i, bias=np.zeros(SHAPE)).told()["bias"].value for i in range(24)]
    squares = np.sign(values) * np.square(values)
    assert np.any(squares < 0) and np.any(squares > 0)
    assert abs(squares.mean()) < 4 * squares.std(ddof=1) / len(squares)**0.5


def test_standard_errors_are_those_of_repeated_experiments():
    """Of a scene that is the same everywhere: blocks that differ make them larger, for those could be others too."""
    told = [Draw(200 + i, scene=np.ones(SHAPE)).told() for i in range(40)]
    for name in ("rmse", "bias", "deviation"):
        spread = np.std([t[name].value for t in told], ddof=1)
        claimed = np.mean([t[name].error for t in told])
        # 40 experiments know a spread to 11 %.
        assert 0.6 * claimed < spread < 1.5 * claimed, name


def test_noise_of_the_reference_itself():
    draw = Draw(4)
    e = errors.reference_noise(draw.halves, draw.blocks)
    expected = REFERENCE_NOISE / 2**0.5 / truth().mean()
    assert abs(e.value - expected) < 4 * e.error < 0.1 * expected


def test_only_pixels_of_the_mask_count():
    draw = Draw(5)
    mask = np.zeros(SHAPE[:2], bool)
    mask[20:90, 30:60] = True
    inside = errors.Blocks(mask)
    before = errors.errors(draw.images, draw.halves, inside)["rmse"].value
    for image in draw.images:
        image[~mask] += 100
    assert errors.errors(draw.images, draw.halves, inside)["rmse"].value == before
    values = np.random.default_rng(6).random(SHAPE)
    assert inside.means(values)[0] == pytest.approx(values[mask].mean())
    with pytest.raises(ValueError, match="no pixel"):
        errors.Blocks(np.zeros((4, 4)))


def test_paired_difference_is_free_of_noise():
    rng = np.random.default_rng(9)
    noise = [NOISE * rng.standard_normal(SHAPE) for _ in range(2)]
    own = [0.02 * rng.standard_normal(SHAPE) for _ in range(2)]  # what the change does to the noise
    limit = [truth() + n for n in noise]
    changed = [truth() + bias_map() + n + o for n, o in zip(noise, own)]
    told = errors.paired_difference(changed, limit, errors.Blocks(np.ones(SHAPE[:2], bool)), truth())
    scale = truth().mean()
    assert abs(told["rms"].value - BIAS / scale) < 4 * told["rms"].error < 0.05 * BIAS
    assert abs(told["mean"].value) < 4 * told["mean"].error


def test_halves_are_combined_by_their_samples():
    a, b = np.full((4, 4, 3), 1.0), np.full((4, 4, 3), 4.0)
    assert np.allclose(errors.combined([a, b], [1, 2]), 3.0)
