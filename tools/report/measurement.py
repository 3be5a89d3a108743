"""Which runs a report is made of, in which order, and what there is of them once the time is up.

Half 0 and half 1 of everything have nothing in common: neither seeds of samples nor tables."""

import dataclasses
import math
import time

import image_error as errors
import mitsuba_runs
import sources
from analysis import PARTS, frame_mask, halves_of
from recorder import OutOfTime

HALVES = (0, 1)
REFERENCE_SEED = 1000  # of the first run; apart from those of the STF
# Of the time that the first images leave, up to the end of each part; the rest is the reference's.
STF_SHARE, SOURCES_SHARE, MITSUBA_SHARE = 0.3, 0.55, 0.7
GRACE = 0.05  # of the time limit


@dataclasses.dataclass
class Found:
    """All runs so far. `stf`: pairs by samples; `reference`: the same, a pair for each number of samples."""
    scene: str = ""  # name of the file
    cold: list = dataclasses.field(default_factory=list)
    stf: dict = dataclasses.field(default_factory=dict)
    reference: dict = dataclasses.field(default_factory=dict)
    parts: object = None  # a run with the parts of light on shells
    sources: object = None
    mitsuba: object = None
    notes: list = dataclasses.field(default_factory=list)
    interrupted: bool = False


class Measurement:
    """`earlier_limits`: of the sources of error, where the report goes on."""

    def __init__(self, options, recorder, shells, say, earlier_limits=None):
        self.options, self.recorder, self.shells, self.say = options, recorder, shells, say
        self.earlier_limits = earlier_limits or {}
        self.found = Found(options.scene.name)

    def all(self):
        """Runs everything that fits into the time; Found."""
        limit = self.options.time_limit
        self.recorder.deadline = time.monotonic() + limit
        try:
            self._first()
            spent = self.recorder.spent
            for name, part, share in (("images of the STF", self._ladder, STF_SHARE),
                                      ("sources of error", lambda until: sources.measure(self, until), SOURCES_SHARE),
                                      ("Mitsuba 3", lambda until: mitsuba_runs.measure(self, until), MITSUBA_SHARE),
                                      ("reference", self._reference, 1.0)):
                self._part(name, part, spent + share * (limit - spent))
        except KeyboardInterrupt:
            self.found.interrupted = True
            self.found.notes.append("The measurement was interrupted; what was complete is shown.")
        except OutOfTime:
            self.found.notes.append(f"The time limit of {limit:g} s ended a run; what was complete is shown.")
        return self.found

    def _part(self, name, part, until):
        """Runs a part up to its share of the time, and a run that takes longer than foreseen a little beyond."""
        limit = self.options.time_limit
        self.recorder.deadline = time.monotonic() + self.left(min(until + GRACE * limit, limit))
        try:
            part(until)
        except OutOfTime:
            self.found.notes.append(f"The time ended a run of: {name}; what was complete is shown.")

    def left(self, until):
        """Seconds up to that many of the time limit."""
        return until - self.recorder.spent

    def stf(self, name, half, samples, **more):
        self.say(f"STF, {samples} samples, half {half + 1} ({name})")
        more.setdefault("scene", self.options.scene)
        return self.recorder.run(name, samples=samples, seed=half, table_seed=half, **more)

    def _first(self):
        """The shortest of everything: cold tables, the parts of light, one sample of both halves."""
        for half in HALVES:
            self.found.cold.append(self.stf(f"cold_{half}", half, 1, cold=True))
        self.found.stf[1] = [self.stf(f"stf_1_{half}", half, 1) for half in HALVES]
        self.found.parts = self.stf("parts", 0, 4, aovs=("color",) + PARTS)
        self._reference_pair(1)

    def _ladder(self, until):
        samples = 1
        while 2 * samples <= self.options.samples:
            run = self.found.stf[samples][0]
            render = run.seconds["render"]
            samples *= 2
            if 2 * (run.wall + render) > self.left(until):
                self.found.notes.append(f"No STF images of {samples} samples and more: the time did not suffice.")
                return
            self.found.stf[samples] = [self.stf(f"stf_{samples}_{half}", half, samples) for half in HALVES]

    def _reference_pair(self, samples, number=0):
        pair = []
        for half in HALVES:
            self.say(f"reference, {samples} samples, half {half + 1}")
            name = f"reference_{samples}_{half}" + (f"_{number}" if number else "")
            # Every run its own seed: with one in common, its first samples would be those of the others.
            seed = REFERENCE_SEED + 1000 * number + 2 * int(math.log2(samples)) + half
            pair.append(self.recorder.run(name, self.options.scene, samples, seed,
                                          settings=[("stf:integrator", "reference")]))
        self.found.reference.setdefault(samples, []).append(pair)

    def _reference(self, until):
        """Doubles the samples while the time suffices for both halves, then repeats the last number; until the noise
        of all together is as low as wanted."""
        samples, number = 1, 0
        while self._noise() > self.options.reference_noise:
            run = self.found.reference[samples][-1][0]
            longer = 2 * (run.wall + run.seconds["render"])
            if number == 0 and longer < 0.6 * self.left(until):
                samples *= 2
            elif 2.1 * run.wall < self.left(until):
                number += 1
            else:
                wanted = 100 * self.options.reference_noise
                self.found.notes.append(f"The reference's noise is {100 * self._noise():.2g} %, not the {wanted:g} % "
                                        "that were wanted: the time did not suffice.")
                return
            self._reference_pair(samples, number)

    def _noise(self):
        halves, _ = halves_of(self.found.reference)
        if not halves[0].any():
            raise ValueError(f"{self.options.scene}: the reference is black, there is no error to measure")
        return errors.reference_noise(halves, errors.Blocks(frame_mask(halves[0]))).value
