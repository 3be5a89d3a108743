"""The runs of a report, with a progress bar where somebody looks at it."""

import sys

from tqdm import tqdm

import found_file
from measurement import Measurement
from recorder import Recorder
from shell_scene import ShellScene


def common_words(given):
    """What every call of stfrecord has in common."""
    words = ["--imageWidth", given.width]
    if given.camera:
        words += ["--camera", given.camera]
    if given.threads:
        words += ["--threads", given.threads]
    if given.mitsuba_python:  # the filter that both have
        words += ["--set", "stf:pixelFilter=box", "--set", "stf:pixelFilterWidth=1"]
    for setting in given.set:
        words += ["--set", setting]
    return words


def earlier_limits(folder):
    """The limits of the sources of error of a report that was begun in the folder."""
    try:
        earlier = found_file.load(folder / "found.json", folder / "runs")
    except ValueError:
        return {}
    return earlier.sources.limits if earlier.sources else {}


def measure(given):
    """Everything that the time allows; Found. ValueError, RunFailed."""
    shells = ShellScene(given.scene)
    recorder = Recorder(given.stfrecord, given.output, common_words(given))
    terminal = sys.stderr.isatty()
    with tqdm(total=given.time_limit, bar_format="{percentage:3.0f} %|{bar:30}| {desc}", disable=not terminal) as bar:
        def tick(seconds):
            bar.n = min(seconds, given.time_limit)
            bar.refresh()

        def say(text):
            if terminal:
                bar.set_description_str(text)
            else:
                print(f"[{recorder.spent:5.0f} s] {text}", file=sys.stderr, flush=True)
        recorder.tick = tick
        return Measurement(given, recorder, shells, say, earlier_limits(given.output)).all()
