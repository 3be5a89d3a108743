#!/usr/bin/env python3
"""Error against run time of a scene's Shell Texture Functions: renders them at a ladder of budgets and the reference,
and writes one page (report.html, self-contained), report.json and pictures.

A report that was stopped (Ctrl-C, time limit) shows what is there; the same command goes on from there.
"""

import argparse
import pathlib
import sys

USAGE = 64  # as all commands of stf
REQUIREMENTS = pathlib.Path(__file__).resolve().parent / "requirements.txt"
FAILED = 2


class Parser(argparse.ArgumentParser):
    def error(self, message):
        self.print_usage(sys.stderr)
        self.exit(USAGE, f"stf report: {message}\n")


def options(words):
    parser = Parser(prog="stf report", description=__doc__,
                    formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path, metavar="SCENE", help="USD file")
    parser.add_argument("--output", type=pathlib.Path, metavar="FOLDER", help="default: SCENE_report, here")
    parser.add_argument("--width", type=int, default=128, help="pixels across (%(default)s)")
    parser.add_argument("--time-limit", type=float, default=600, metavar="SECONDS", help="of all runs (%(default)g)")
    parser.add_argument("--reference-noise", type=float, default=0.01, metavar="SHARE",
                        help="of the reference's mean radiance: where it is reached, rendering ends (%(default)g)")
    parser.add_argument("--samples", type=int, default=128, help="most of the STF, per pixel (%(default)s)")
    parser.add_argument("--camera", help="path or name (the first)")
    parser.add_argument("--threads", type=int, default=0, help="of the renderers (all cores)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                        help="render setting of all runs; may be repeated")
    parser.add_argument("--mitsuba-python", metavar="PYTHON",
                        help="a Python with Mitsuba 3, for scenes that it can show too (docs/report.md)")
    parser.add_argument("--stfrecord", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    given = parser.parse_args(words)
    if given.width < 8 or given.samples < 1 or not given.time_limit > 0 or not given.reference_noise > 0:
        parser.error("--width is at least 8, --samples 1, --time-limit and --reference-noise are positive")
    given.output = given.output or pathlib.Path(f"{given.scene.stem}_report")
    return given


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


def main(words):
    given = options(words)
    try:
        from tqdm import tqdm

        import document
        import measurement
        import mitsuba_runs
        import recorder
        import shell_scene
    except ImportError as missing:
        print(f"stf report: Python package missing: {missing.name}; python -m pip install -r {REQUIREMENTS}",
              file=sys.stderr)
        return FAILED
    try:
        shells = shell_scene.ShellScene(given.scene)
        runs = recorder.Recorder(given.stfrecord, given.output, common_words(given))
        terminal = sys.stderr.isatty()
        with tqdm(total=given.time_limit, bar_format="{percentage:3.0f} %|{bar:30}| {desc}",
                  disable=not terminal) as bar:
            def tick(seconds):
                bar.n = min(seconds, given.time_limit)
                bar.refresh()

            def say(text):
                if terminal:
                    bar.set_description_str(text)
                else:
                    print(f"[{runs.spent:5.0f} s] {text}", file=sys.stderr, flush=True)
            runs.tick = tick
            found = measurement.Measurement(given, runs, shells, say).all()
        if not found.reference or 1 not in found.stf:
            print("stf report: stopped before the first images of both renderers were there; a longer --time-limit, or "
                  "the same command again", file=sys.stderr)
            return FAILED
        print(document.Document(given, found).write())
        return 0
    except (recorder.RunFailed, ValueError, OSError) as error:
        print(f"stf report: {error}", file=sys.stderr)
        return FAILED


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    sys.exit(main(sys.argv[1:]))
