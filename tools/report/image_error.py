"""How far images are from a reference that is noisy itself, and how well that is known. No files, no programs.

Images are arrays [height, width, 3] of linear radiance. A reference is two independent halves R1, R2 of equal mean:
where I has nothing to do with either, the mean of (I - R1)(I - R2) is the mean square error of I alone, for the noise
of the halves is uncorrelated with each other and with I. Of two images of independent samples and tables, the mean of
(I1 - R1)(I2 - R2) is the square of what they have in common, the bias.
"""

import dataclasses

import numpy as np

BLOCK = 8  # pixels; errors within a block are alike
RESAMPLES = 400
EPSILON = 0.01  # of relMSE: Rousselle, Knaus, Zwicker, Adaptive sampling and reconstruction, 2011


@dataclasses.dataclass
class Estimate:
    """A number and its standard error, by bootstrap over blocks of pixels (Efron, Tibshirani 1993)."""
    value: float
    error: float


class Blocks:
    """Sums over blocks of the pixels in `mask`, and the same draws of blocks for everything that is compared."""

    def __init__(self, mask, seed=0):
        self.mask = np.asarray(mask, bool)
        if not self.mask.any():
            raise ValueError("no pixel to compare")
        rows, columns = (np.arange(n) // BLOCK for n in self.mask.shape)
        self._block = rows[:, None] * (columns[-1] + 1) + columns[None, :]
        self._count = int(self._block.max()) + 1
        self._pixels = self._sums(np.ones(self.mask.shape))
        used = np.flatnonzero(self._pixels)
        draws = np.random.default_rng(seed).integers(0, len(used), (RESAMPLES, len(used)))
        self._draws = used[draws]

    def _sums(self, values):
        return np.bincount(self._block[self.mask], weights=values[self.mask], minlength=self._count)

    def means(self, values):
        """Mean of a map [height, width] or [height, width, 3] over the pixels, and its resampled means."""
        flat = values.mean(axis=2) if values.ndim == 3 else values
        sums = self._sums(flat)
        resampled = sums[self._draws].sum(axis=1) / self._pixels[self._draws].sum(axis=1)
        return sums.sum() / self._pixels.sum(), resampled

    def estimate(self, function, *maps):
        """`function` of the means of the maps, with its standard error."""
        pairs = [self.means(m) for m in maps]
        resampled = np.array(function(*(r for _, r in pairs)))
        return Estimate(float(function(*(m for m, _ in pairs))), float(np.std(resampled, ddof=1)))


def signed_root(value):
    """Square root that keeps the sign: a squared bias that noise made negative stays visible as that."""
    return np.sign(value) * np.sqrt(np.abs(value))


def square_error(image, halves):
    """Map of the square error of an image that is independent of both halves."""
    return (image - halves[0]) * (image - halves[1])


def square_bias(images, halves):
    """Map of the square of what two independent images have in common against the reference; both pairings."""
    a, b = images
    return 0.5 * ((a - halves[0]) * (b - halves[1]) + (a - halves[1]) * (b - halves[0]))


def variance(images):
    """Map of the variance of one of two independent images of equal mean."""
    return 0.5 * (images[0] - images[1])**2


def combined(images, weights):
    """Mean of images by weights, numbers of samples."""
    return np.average(np.stack(images), axis=0, weights=weights)


def errors(images, halves, blocks):
    """What is known of two independent images: rmse, bias and deviation relative to the reference's mean radiance,
    relMSE = mean of (I - R)^2 / (R^2 + 0.01), and the signed difference of the means."""
    reference = 0.5 * (halves[0] + halves[1])
    squares = 0.5 * (square_error(images[0], halves) + square_error(images[1], halves))
    relative = squares / (reference**2 + EPSILON)

    def root(mean, scale):
        return signed_root(mean) / scale

    both = 0.5 * (images[0] + images[1])
    return {
        "rmse": blocks.estimate(root, squares, reference),
        "bias": blocks.estimate(root, square_bias(images, halves), reference),
        "deviation": blocks.estimate(root, variance(images), reference),
        "relMSE": blocks.estimate(lambda m: m, relative),
        "mean": blocks.estimate(lambda d, scale: d / scale, both - reference, reference),
    }


def reference_noise(halves, blocks):
    """Standard deviation of the mean of both halves, relative to their mean radiance."""
    reference = 0.5 * (halves[0] + halves[1])
    return blocks.estimate(lambda v, scale: np.sqrt(v / 2) / scale, variance(halves), reference)


def paired_difference(changed, limit, blocks, scale_image):
    """What a setting changes, from images [seed] that share seeds with those at the limit: the root of the mean
    product of the differences of two seeds, free of noise, and the mean difference; relative to the mean radiance."""
    d = [c - l for c, l in zip(changed, limit)]
    return {
        "rms": blocks.estimate(lambda m, scale: signed_root(m) / scale, d[0] * d[1], scale_image),
        "mean": blocks.estimate(lambda m, scale: m / scale, 0.5 * (d[0] + d[1]), scale_image),
    }
