"""The measures of the image tests, on images whose difference is known."""

import pathlib
import sys

import numpy as np
import OpenEXR
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from compare_images import compare, read_rgb, write_difference, write_rgb_half  # noqa: E402


def grey(value=0.5, size=(8, 10)):
    return np.full((*size, 3), value)


def test_equal_images():
    assert compare(grey(), grey(), 0.01) == {"rmse": 0, "mean": 0, "outliers": 0, "worst": 0}


def test_bias_and_noise_are_told_apart():
    biased = compare(grey(0.55), grey(0.5), 0.2)
    assert biased["rmse"] == pytest.approx(0.1) and biased["mean"] == pytest.approx(0.1)
    checker = grey() + 0.05 * (-1) ** np.indices((8, 10)).sum(0)[..., None]
    noisy = compare(checker, grey(), 0.2)
    assert noisy["rmse"] == pytest.approx(0.1) and noisy["mean"] == pytest.approx(0)


def test_outliers_are_per_cent_of_pixels():
    image = grey()
    image[0, :4, 1] += 1
    assert compare(image, grey(), 0.05)["outliers"] == pytest.approx(5)


def test_what_cannot_be_compared():
    with pytest.raises(ValueError, match="sizes"):
        compare(grey(), grey(size=(4, 4)), 0.1)
    image = grey()
    image[1, 1, 1] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        compare(image, grey(), 0.1)


def test_files(tmp_path):
    write_rgb_half(tmp_path / "half.exr", grey(0.25))
    assert np.array_equal(read_rgb(tmp_path / "half.exr"), grey(0.25))
    named = {f"color.{c}": np.full((8, 10), 0.1 * i, np.float32) for i, c in enumerate("RGB")}
    with OpenEXR.File({"type": OpenEXR.scanlineimage}, {**named, "depth": named["color.R"]}) as image:
        image.write(str(tmp_path / "layers.exr"))
    assert np.allclose(read_rgb(tmp_path / "layers.exr")[0, 0], (0, 0.1, 0.2))
    write_difference(tmp_path / "difference.png", grey(), grey(size=(4, 4)))
    assert (tmp_path / "difference.png").read_bytes().startswith(b"\x89PNG")


if __name__ == "__main__":
    sys.exit(pytest.main([__file__, "-q", *sys.argv[1:]]))
