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
FAILED, INTERRUPTED = 2, 130  # as stfrecord


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
    parser.add_argument("--replay", action="store_true", help="write the page again from what FOLDER holds")
    parser.add_argument("--mitsuba-python", metavar="PYTHON",
                        help="a Python with Mitsuba 3, for scenes that it can show too (docs/report.md)")
    parser.add_argument("--stfrecord", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    given = parser.parse_args(words)
    if given.width < 8 or given.samples < 1 or not given.time_limit > 0 or not given.reference_noise > 0:
        parser.error("--width is at least 8, --samples 1, --time-limit and --reference-noise are positive")
    given.output = given.output or pathlib.Path(f"{given.scene.stem}_report")
    return given


def main(words):
    given = options(words)
    try:
        import document
        import found_file
        from measure import measure
        from recorder import RunFailed
    except ImportError as missing:
        print(f"stf report: Python package missing: {missing.name}; python -m pip install -r {REQUIREMENTS}",
              file=sys.stderr)
        return FAILED
    try:
        kept = given.output / "found.json"
        if given.replay:
            found = found_file.load(kept, given.output / "runs")
        else:
            found = measure(given)
            found_file.save(found, kept)
        if not found.reference or 1 not in found.stf:
            print("stf report: stopped before the first images of both renderers were there; a longer --time-limit, or "
                  "the same command again", file=sys.stderr)
            return FAILED
        print(document.Document(given, found).write())
        return INTERRUPTED if found.interrupted else 0
    except KeyboardInterrupt:
        print("stf report: interrupted; the same command goes on", file=sys.stderr)
        return INTERRUPTED
    except (RunFailed, ValueError, OSError) as error:
        print(f"stf report: {error}", file=sys.stderr)
        return FAILED


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    sys.exit(main(sys.argv[1:]))
