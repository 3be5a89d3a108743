"""Runs of stfrecord, each kept on disk with what it cost, so that a report that was stopped goes on from there."""

import dataclasses
import hashlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time

import numpy as np
import OpenEXR


POLL = 0.02  # seconds; what a run may seem longer than it was


class RunFailed(Exception):
    """A run that gave no image; the text says which and why."""


class OutOfTime(Exception):
    """A run that was ended because the time was up."""


@dataclasses.dataclass
class Run:
    """One image and what it cost. `wall` and `cpu` are seconds of the whole process, all threads."""
    name: str
    samples: int
    wall: float
    cpu: float
    seconds: dict  # of the stages, by the renderer
    image: pathlib.Path
    messages: list

    def color(self):
        return layer(self.image, "color")


def layer(path, aov):
    """A layer of an EXR of stfrecord, [height, width, 3]; ValueError where a value is not finite."""
    with OpenEXR.File(str(path), separate_channels=True) as image:
        channels = image.parts[0].channels
        names = [c if aov == "color" else f"{aov}.{c}" for c in "RGB"]
        values = np.stack([np.asarray(channels[n].pixels, np.float64) for n in names], axis=2)
    if not np.isfinite(values).all():
        raise ValueError(f"{path}: {np.count_nonzero(~np.isfinite(values))} values are not finite")
    return values


def wait_with_usage(process, deadline, tick):
    """Seconds of CPU of a process once it has ended; `tick` is called meanwhile. OutOfTime where it had to be stopped.
    On an interrupt of the user the process, which has got it too, is waited for."""
    try:
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                process.returncode = os.waitstatus_to_exitcode(status)
                return usage.ru_utime + usage.ru_stime
            if time.monotonic() > deadline:
                process.send_signal(signal.SIGINT)
                raise OutOfTime
            tick()
            time.sleep(POLL)
    except BaseException:
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        raise


class Recorder:
    """Renders with `program` into `folder`/runs, with tables kept in `folder`/cache. `common`: words of every call.
    `spent` counts seconds of runs that were really made, not of those found on disk; `deadline` is one of
    time.monotonic() that ends a run; `tick` is called with the seconds spent while one goes on."""

    def __init__(self, program, folder, common):
        self.program, self.common = pathlib.Path(program), list(common)
        self.folder, self.cache = pathlib.Path(folder) / "runs", pathlib.Path(folder) / "cache"
        self.folder.mkdir(parents=True, exist_ok=True)
        self.spent, self.deadline, self.tick = 0.0, float("inf"), lambda seconds: None

    def run(self, name, scene, samples, seed, table_seed=0, settings=(), aovs=("color",), cold=False):
        """The image of that name by stfrecord. `cold`: without any table kept."""
        cache = self.cache / f"tables{table_seed}"
        words = ["--samples", samples, "--seed", seed, "--aov", ",".join(aovs), "--quiet", *self.common, "--set",
                 f"stf:tableSeed={table_seed}"]
        for key, value in settings:
            words += ["--set", f"{key}={value}"]

        def call(image, stats):
            return [self.program, scene, image, "--stats", stats, *words]
        return self.kept(name, call, [scene], {"HDSTF_CACHE_DIR": str(cache)}, cache if cold else None)

    def kept(self, name, call, inputs, environment=None, clear=None):
        """The run of that name, made unless one of the same call is there. `call(image, stats)`: words of a program
        that writes an image and statistics in the format of stfrecord; `inputs`: files that it reads; `clear`: a
        folder to remove first."""
        image, told, stats = (self.folder / f"{name}.{kind}" for kind in ("exr", "json", "stats"))
        words = [str(word) for word in call(image, stats)]
        key = _key(words, inputs)
        found = _read(told)
        if found and found["key"] == key and image.exists():
            return _as_run(found, image)
        if clear:
            shutil.rmtree(clear, ignore_errors=True)
        start = time.monotonic()
        try:
            cpu = self._start(words, {**os.environ, **(environment or {})})
        finally:
            wall = time.monotonic() - start
            self.spent += wall
        statistics = json.loads(stats.read_text())
        stats.unlink()
        found = {"key": key, "name": name, "samples": statistics["samples"], "wall": wall, "cpu": cpu,
                 "seconds": statistics["seconds"],
                 "messages": [m["text"] for m in statistics["messages"] if m["severity"] != "info"]}
        temporary = told.with_suffix(".new")
        temporary.write_text(json.dumps(found, indent=1))
        temporary.replace(told)
        return _as_run(found, image)

    def _start(self, call, environment):
        start = time.monotonic()
        if start > self.deadline:
            raise OutOfTime
        with open(self.folder / "log", "w+", encoding="utf-8", errors="replace") as log:
            process = subprocess.Popen(call, stdin=subprocess.DEVNULL, stdout=log, stderr=log, env=environment)
            cpu = wait_with_usage(process, self.deadline, lambda: self.tick(self.spent + time.monotonic() - start))
            if process.returncode not in (0, 1):
                log.seek(0)
                last = (log.read().strip().splitlines() or [f"exit code {process.returncode}"])[-1]
                raise RunFailed(f"{' '.join(call)}: {last}")
        return cpu


def _key(words, inputs):
    digest = hashlib.sha256(json.dumps(words).encode())
    digest.update(str(os.stat(shutil.which(words[0]) or words[0]).st_mtime_ns).encode())
    for path in inputs:
        digest.update(pathlib.Path(path).read_bytes())
    return digest.hexdigest()


def _read(path):
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return None


def _as_run(found, image):
    return Run(found["name"], found["samples"], found["wall"], found["cpu"], found["seconds"], image,
               found["messages"])
