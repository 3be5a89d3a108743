"""From runs to numbers: errors over time, time to equal error, frames until tables pay, errors by source."""

import dataclasses

import numpy as np

import image_error as errors
from recorder import layer

FRAMES = 3  # the tables are to be paid by then
PARTS = ("stf:single", "stf:multiple", "stf:core", "stf:reflection")  # of light on shells: AOVs


def frame_mask(image):
    return np.ones(image.shape[:2], bool)


def halves_of(reference):
    """The two halves of the reference, weighted by samples, and the samples of one."""
    pairs = [(samples, pair) for samples, entries in sorted(reference.items()) for pair in entries]
    weights = [samples for samples, _ in pairs]
    images = [errors.combined([pair[half].color() for _, pair in pairs], weights) for half in (0, 1)]
    return images, sum(weights)


def shell_mask(parts):
    """Pixels that show a shell: one of its parts of light is there."""
    return sum(np.abs(layer(parts.image, name)) for name in PARTS).max(axis=2) > 0


def mean_of(runs, what):
    return float(np.mean([getattr(r, what) for r in runs]))


def stage_seconds(runs):
    """Mean seconds of each stage, with those of one pass over the image."""
    stages = {k: float(np.mean([r.seconds[k] for r in runs])) for k in runs[0].seconds}
    stages["perPass"] = stages["render"] / runs[0].samples
    return stages


def stf_rows(found, halves, masks):
    """For each number of samples: errors by mask, and seconds warm (tables kept) and cold (tables made)."""
    extra = {what: mean_of(found.cold, what) - mean_of(found.stf[1], what) for what in ("wall", "cpu")}
    rows = []
    for samples, runs in sorted(found.stf.items()):
        images = [r.color() for r in runs]
        rows.append({
            "samples": samples,
            "errors": {name: errors.errors(images, halves, blocks) for name, blocks in masks.items()},
            "warm": {what: mean_of(runs, what) for what in ("wall", "cpu")},
            "cold": {what: mean_of(runs, what) + extra[what] for what in ("wall", "cpu")},
            "stages": stage_seconds(runs)})
    return rows, extra


def unbiased_rows(reference, masks, scale):
    """Deviation of an unbiased renderer for each number of samples, by the difference of the halves; its seconds."""
    rows = []
    for samples, pairs in sorted(reference.items()):
        squares = np.mean([errors.variance([r.color() for r in pair]) for pair in pairs], axis=0)
        runs = [r for pair in pairs for r in pair]
        rows.append({
            "samples": samples,
            "errors": {name: {"rmse": blocks.estimate(lambda v, s: np.sqrt(v) / s, squares, scale),
                              "relMSE": blocks.estimate(lambda m: m, squares / (scale**2 + errors.EPSILON))}
                       for name, blocks in masks.items()},
            "warm": {what: mean_of(runs, what) for what in ("wall", "cpu")},
            "stages": stage_seconds(runs)})
    return rows


def add_flip(rows, pairs_of, halves, blocks, flip):
    """FLIP of each row's runs, each against the half of the reference that it has nothing to do with. `flip(reference,
    image)` gives the map."""
    for row in rows:
        maps = [flip(halves[1 - half], pair[half].color()) for pair in pairs_of(row["samples"]) for half in (0, 1)]
        row["flip"] = blocks.estimate(lambda m: m, np.mean(maps, axis=0))


@dataclasses.dataclass
class UnbiasedTime:
    """Seconds of an unbiased renderer to an error: set-up and passes, of which the error takes variance / error^2.
    All from its largest run; a run of fewer passes follows the same law exactly, one of more does as long as the
    variance is what that run shows."""
    setup: float
    per_sample: float
    variance: float  # of one sample, relative to the square of the mean radiance
    variance_error: float
    largest: int  # samples that were run

    def samples(self, error):
        return self.variance / error**2

    def seconds(self, error):
        """Seconds to an Estimate of the error, as an Estimate, and whether they take more samples than were run."""
        samples = max(1.0, self.samples(error.value))
        relative = np.hypot(self.variance_error / max(self.variance, 1e-30), 2 * error.error / error.value)
        told = errors.Estimate(self.setup + self.per_sample * samples, self.per_sample * samples * relative)
        return told, samples > self.largest


def unbiased_time(rows, mask, what):
    """From the largest run of an unbiased renderer; `what`: wall or cpu."""
    last, first = rows[-1], rows[0]
    seconds = last["warm"][what]
    if what == "wall" or last is first:
        per_sample = last["stages"]["perPass"] * (1 if what == "wall" else seconds / max(last["warm"]["wall"], 1e-9))
    else:
        per_sample = (seconds - first["warm"][what]) / (last["samples"] - first["samples"])
    error = last["errors"][mask]["rmse"]
    return UnbiasedTime(max(0.0, seconds - per_sample * last["samples"]), per_sample,
                        last["samples"] * error.value**2, 2 * last["samples"] * error.value * error.error,
                        last["samples"])


def break_even(rows, extra, other, mask, what):
    """For each STF row the seconds of the other renderer to the same error: the ratios of both with tables kept, and
    for FRAMES frames with the tables made before the first; and the frames after which the tables have paid (None:
    never, for the other is as quick in each frame)."""
    result = []
    for row in rows:
        rmse = row["errors"][mask]["rmse"]
        if not rmse.value > 0:
            continue
        told, beyond = other.seconds(rmse)
        theirs, warm = told.value, row["warm"][what]
        saved = theirs - warm
        result.append({
            "samples": row["samples"], "error": rmse.value, "seconds": warm, "other": theirs,
            "otherError": told.error, "otherSamples": max(1.0, other.samples(rmse.value)), "beyond": beyond,
            "ratio": theirs / warm, "ratioError": told.error / warm,
            "ratioOfFrames": FRAMES * theirs / (extra[what] + FRAMES * warm),
            "frames": max(1, int(np.ceil(extra[what] / saved))) if saved > 0 else None})
    return result


def source_rows(sources, halves, blocks):
    """Each source's difference, and what is left against the reference with everything at its limit."""
    scale = 0.5 * (halves[0] + halves[1])
    rows = []
    for s in sources.rows:
        told = errors.paired_difference([r.color() for r in s.changed], [r.color() for r in s.limit], blocks, scale)
        for estimate in told.values():
            estimate.value *= s.scale
            estimate.error *= s.scale
        rows.append({"name": s.name, "change": s.change, **told})
    left = errors.errors([r.color() for r in sources.limit], halves, blocks) if sources.limit else None
    return rows, left
