"""Runs of Mitsuba 3 beside those of the STF, where there is one and the scene is one that it can show."""

import dataclasses
import json
import pathlib
import subprocess

import flat_shell

from recorder import RunFailed, layer

SCRIPT = pathlib.Path(__file__).resolve().parent / "mitsuba_image.py"
SEED = 5000


@dataclasses.dataclass
class Mitsuba:
    """Pairs of runs by samples, as those of the reference; or why there are none."""
    pairs: dict = dataclasses.field(default_factory=dict)
    why: str = ""


def measure(measurement, until):
    """Doubles the samples while the time suffices for both halves; into `measurement.found`."""
    options, recorder = measurement.options, measurement.recorder
    found = measurement.found.mitsuba = Mitsuba()
    if not options.mitsuba_python:
        found.why = "not measured: no --mitsuba-python was given."
        return
    try:
        scene, tile = _write_scene(measurement)
        samples, wall, render = 1, 0.0, 0.0
        while True:
            pair = []
            for half in (0, 1):
                measurement.say(f"Mitsuba 3, {samples} samples, half {half + 1}")
                seed = SEED + 2 * samples.bit_length() + half

                def call(image, stats, samples=samples, seed=seed):
                    return [options.mitsuba_python, SCRIPT, scene, tile, image, stats, "--samples", samples, "--seed",
                            seed, "--threads", options.threads]
                pair.append(recorder.kept(f"mitsuba_{samples}_{half}", call, [scene, SCRIPT]))
            found.pairs[samples] = [pair]
            wall, render = max(r.wall for r in pair), max(r.seconds["render"] for r in pair)
            samples *= 2
            if 2 * (wall + render) > measurement.left(until):
                return
    except flat_shell.NotComparable as why:
        found.why = f"not comparable: {why}."
    except RunFailed as why:
        found.why = f"did not run: {why}"


def _write_scene(measurement):
    """Scene and tile for mitsuba_image.py."""
    options, shells = measurement.options, measurement.shells
    flat_shell.need(shells.shells, "there is no shell")
    folder = pathlib.Path(options.output) / "mitsuba"
    asset = shells.primvar(shells.shells[0], "baseVolume")
    stf = pathlib.Path(options.stfrecord).with_name("stf")
    done = subprocess.run([stf, "inspect", asset.resolvedPath or asset.path, "--raw", folder / "tile"],
                          capture_output=True, text=True)
    flat_shell.need(done.returncode == 0, done.stderr.strip())
    volume = json.loads((folder / "tile" / "volume.json").read_text())
    height, width = layer(measurement.found.stf[1][0].image, "color").shape[:2]
    told = flat_shell.describe(shells, volume, options.camera, (width, height))
    scene = folder / "scene.json"
    scene.write_text(json.dumps(told, indent=1))
    return scene, folder / "tile"
