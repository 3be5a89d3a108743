"""FLIP, by its authors' package (Andersson et al. 2020, 2021: the version for high dynamic range)."""

import flip_evaluator
import numpy as np


def flip(reference, image):
    """Map [height, width] of the error, 0 to 1, at 67 pixels per degree; exposures follow from the reference."""
    linear = [np.ascontiguousarray(np.maximum(i, 0), np.float32) for i in (reference, image)]
    found, _, _ = flip_evaluator.evaluate(*linear, "HDR", inputsRGB=True, applyMagma=False)
    return np.asarray(found, np.float64).reshape(image.shape[:2])
