#!/usr/bin/env python3
"""Grows samples over every mesh of a folder and tells what came of it: `stf synthesize` against all that modellers make.

Usage: synthesis_meshes.py FOLDER [--build FOLDER] [--samples N] [--seconds S] [--gigabytes G] [--only PATTERN]
                           [--volume NAME ...] [--jobs N]

FOLDER holds OBJ, PLY, STL, OFF or USD files, whole or broken. Prints a table and writes BUILD/bench/synthesis_meshes.json
and .md. Exit code 1 where a run crashed, hung, outgrew its memory, ended without one sentence or folded a manifold mesh.
"""

import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import resource
import signal
import subprocess
import sys
import time

MEASURES = ("samples", "foldOvers", "seamRate", "reuseMax", "ks", "deltaR", "deltaRSeams", "neighbourhoodError",
            "exemplarError")


def manifold(path):
    """What the triangles and polygons of an OFF file join to: closed, open, or why it is no manifold; None: unknown."""
    if path.suffix != ".off":
        return None
    words = []
    with open(path, errors="replace") as file:
        for line in file:
            words.append(line.split("#")[0].split())
    rows = [row for row in words if row]
    if not rows or not rows[0][0].endswith("OFF"):
        return None
    rows[0] = rows[0][1:]
    rows = [row for row in rows if row]
    try:
        points, faces = int(rows[0][0]), int(rows[0][1])
        places = [tuple(map(float, row[:3])) for row in rows[1:points + 1]]
        # Points at one place are one: meshes are often cut along seams of texture.
        number = {}
        same = [number.setdefault(place, i) for i, place in enumerate(places)]
        sides = collections.Counter()
        used = set()
        for row in rows[points + 1:points + 1 + faces]:
            corners = [same[int(c)] for c in row[1:int(row[0]) + 1]]
            used.update(corners)
            for a, b in zip(corners, corners[1:] + corners[:1]):
                if a != b:
                    sides[a, b] += 1
    except (ValueError, IndexError):
        return "unreadable"
    if not sides:
        return "no faces"
    around = collections.Counter()
    for (a, b), n in sides.items():
        around[min(a, b), max(a, b)] += n
    if any(n > 2 for n in around.values()):
        return "non-manifold edges"
    if any(n > 1 for n in sides.values()):
        return "turned faces"
    kind = "closed" if all(n == 2 for n in around.values()) else "open"
    return kind + (" + lone points" if len(used) < len(set(same)) else "")


def run(stf, mesh, volume, arguments, scratch):
    """One synthesis under limits of time and memory."""
    report = scratch / f"{mesh.name}.{volume.stem}.json"
    report.unlink(missing_ok=True)
    limit = int(arguments.gigabytes * 2**30)

    def limits():
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        # Of the processor, so that a busy machine does not count; what sleeps is stopped by the clock.
        resource.setrlimit(resource.RLIMIT_CPU, (int(arguments.seconds), int(arguments.seconds) + 5))

    command = [stf, "synthesize", mesh, volume, "--samples", str(arguments.samples), "--report", report, "--json",
               "--threads", str(arguments.threads)]
    started = time.monotonic()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                             preexec_fn=limits)
    row = {"mesh": mesh.name, "volume": volume.stem}
    try:
        # Messages are few: the pipe holds them all.
        deadline = started + 20 * arguments.seconds
        while True:
            pid, status, usage = os.wait4(child.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() > deadline:
                child.kill()
                _, status, usage = os.wait4(child.pid, 0)
                row["outcome"] = "too long"
                break
            time.sleep(0.02)
    finally:
        text = child.stderr.read()
        child.stderr.close()
        child.returncode = 0
    row["seconds"] = round(time.monotonic() - started, 2)
    row["cpu"] = round(usage.ru_utime + usage.ru_stime, 2)
    row["megabytes"] = usage.ru_maxrss // 1024
    lines = [line.replace(str(mesh), mesh.name) for line in text.strip().splitlines()]
    row["messages"] = lines
    if "outcome" not in row:
        if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGXCPU:
            row["outcome"] = "too long"
        elif os.WIFSIGNALED(status):
            row["outcome"] = f"killed by signal {os.WTERMSIG(status)}"
        elif os.WEXITSTATUS(status) == 0 and report.exists():
            row["outcome"] = "done"
            result = json.loads(report.read_text())
            row.update({name: result[name] for name in MEASURES if name in result})
            row["stageSeconds"] = result["stageSeconds"]
        elif len(lines) >= 1 and mesh.name in lines[-1]:
            row["outcome"] = "refused"
        else:
            row["outcome"] = f"exit code {os.WEXITSTATUS(status)} without a sentence that names the file"
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build"))
    parser.add_argument("--volume", nargs="+", default=["marble", "wax"], help="names that `stf make` knows")
    parser.add_argument("--samples", type=int, default=60000)
    parser.add_argument("--seconds", type=float, default=120, help="of the processor, limit of a run")
    parser.add_argument("--gigabytes", type=float, default=6, help="limit of a run, of addresses")
    parser.add_argument("--only", default="*", help="file names to try, as in a shell")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--threads", type=int, default=0)
    arguments = parser.parse_args()
    stf = arguments.build.resolve() / "bin/stf"
    scratch = arguments.build.resolve() / "bench/synthesis_meshes"
    scratch.mkdir(parents=True, exist_ok=True)
    volumes = []
    for name in arguments.volume:
        volumes.append(scratch / f"{name}.vdb")
        if not volumes[-1].exists():
            subprocess.run([stf, "make", name, volumes[-1]], check=True, stdout=subprocess.DEVNULL)
    meshes = sorted(f for f in arguments.folder.glob(arguments.only) if f.is_file())
    kinds = {mesh.name: manifold(mesh) for mesh in meshes}
    rows = []

    def work(job):
        return run(stf, job[0], job[1], arguments, scratch)

    jobs = [(mesh, volume) for mesh in meshes for volume in volumes]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for row in pool.map(work, jobs):
            row["kind"] = kinds[row["mesh"]] or "-"
            rows.append(row)
            print(f"{row['mesh']:<34}{row['kind']:<22}{row['volume']:<8}{row['outcome']:<10}{row['cpu']:>7.1f} s"
                  f"{row['megabytes']:>6} MB  " +
                  (f"folds {row['foldOvers']:<4} seams {100 * row['seamRate']:5.2f} % reuse {row['reuseMax']:5.2f} "
                   f"KS {row['ks']:.3f} dR {100 * row['deltaR']:+.2f} %" if row["outcome"] == "done"
                   else row["messages"][-1] if row["messages"] else ""), flush=True)

    target = scratch.parent / "synthesis_meshes"
    target.with_suffix(".json").write_text(json.dumps(rows, indent=1))
    with open(target.with_suffix(".md"), "w") as file:
        file.write("| mesh | manifold | sample | outcome | CPU s | MB | folds | seams % | reuse | KS | delta R % | message |\n"
                   "|---|---|---|---|---|---|---|---|---|---|---|---|\n")
        for row in rows:
            done = row["outcome"] == "done"
            file.write("| " + " | ".join([
                row["mesh"], row["kind"], row["volume"], row["outcome"], f"{row['cpu']:.1f}", str(row["megabytes"]),
                *([str(row["foldOvers"]), f"{100 * row['seamRate']:.2f}", f"{row['reuseMax']:.2f}", f"{row['ks']:.3f}",
                   f"{100 * row['deltaR']:+.2f}"] if done else [""] * 5),
                "; ".join(row["messages"]).replace("|", "/")]) + " |\n")
    bad = [row for row in rows if row["outcome"] not in ("done", "refused")]
    folded = [row for row in rows if row.get("foldOvers", 0) and row["kind"] in ("closed", "open")]
    print(f"\n{len(rows)} runs, {sum(row['outcome'] == 'done' for row in rows)} done, "
          f"{sum(row['outcome'] == 'refused' for row in rows)} refused, {len(bad)} failed, "
          f"{len(folded)} with folds on manifolds\n{target}.md")
    sys.exit(1 if bad or folded else 0)


if __name__ == "__main__":
    main()
