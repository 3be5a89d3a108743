"""Runs of the programs that benchmarks compare: their JSON, with seconds of the clock and of all processors."""

import json
import os
import pathlib
import resource
import subprocess
import time

SKIP = 77  # as mitsuba_common says that Mitsuba is missing


class Skipped(Exception):
    """A program that is compared with is not installed."""


def run_json(command, environment=None):
    """The JSON that a command prints last, its seconds and its seconds of processors (start and end included)."""
    def processors():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    command = [str(word) for word in command]
    cpu, wall = processors(), time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, env=environment, stdin=subprocess.DEVNULL)
    wall, cpu = time.perf_counter() - wall, processors() - cpu
    if done.returncode == SKIP:
        raise Skipped(done.stderr.strip())
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}\nfailed with exit code {done.returncode}\n{done.stderr[-2000:]}")
    return json.loads(done.stdout.strip().splitlines()[-1]), wall, cpu


class Stf:
    """The stf of a build folder."""

    def __init__(self, build):
        self.program = pathlib.Path(build) / "bin" / "stf"

    def __call__(self, *words):
        """One command with --json: what it printed, with the processors' seconds as cpu_seconds."""
        result, _, cpu = run_json([self.program, *words, "--json"])
        result["cpu_seconds"] = cpu
        return result

    def make_random(self, path, size, tau, albedo, g=0.0, ratio=100.0, voxel=1.0, seed=0):
        self("make", "random", path, "--size", ",".join(map(str, size)), "--voxel", voxel, "--tau", tau, "--albedo",
             albedo, "--g", g, "--ratio", ratio, "--seed", seed)
        return path

    def dump(self, volume, folder):
        """The volume for programs that read no OpenVDB."""
        subprocess.run([self.program, "inspect", volume, "--raw", folder], check=True)
        return folder


class Mitsuba:
    """The scripts of this folder, in a Python that has Mitsuba."""

    def __init__(self, python):
        self.python = python

    def __call__(self, script, *words):
        return run_json([self.python, pathlib.Path(__file__).resolve().parent / script, *words])[0]


def threads_of_machine():
    """Processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
