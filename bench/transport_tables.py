"""What tables cost: error against time, collisions a second, threads."""

import pathlib
import tempfile

QUALITIES = (0.1, 0.05, 0.02, 0.01)


def precompute(stf, volume, quality, max_photons, threads=0):
    """One table from nothing, in an empty store; with its size on disk."""
    with tempfile.TemporaryDirectory() as folder:
        table = pathlib.Path(folder) / "table.vdb"
        result = stf("precompute", volume, "--quality", quality, "--cache", folder, "--out", table, "--threads",
                     threads, "--max-photons", max_photons)
        result["fileBytes"] = table.stat().st_size
    return result


def rank(stf_json):
    """Functions of direction that a table keeps: 0 where the program does not tell."""
    return stf_json.get("rank", 0)


def error_against_time(stf, volumes, budget, max_photons):
    """Tables of each volume from coarse to fine, as long as the next is expected to stay within the budget and the last
    reached what was asked for."""
    print(f"{'volume':<12}{'asked %':>8}{'reached %':>10}{'photons':>12}{'rank':>6}{'MB':>8}{'MB disk':>9}{'s':>8}")
    rows = []
    for name, volume in volumes:
        before = None
        for quality in QUALITIES:
            # Noise falls with the root of the photons.
            expected = before[1] * (before[0] / quality)**2 if before else 0
            if expected > budget:
                rows.append({"volume": name, "quality": quality, "skipped": f"{expected:.0f} s expected"})
                print(f"{name:<12}{100 * quality:>8.0f}   left out: {expected:.0f} s expected")
                break
            r = precompute(stf, volume, quality, max_photons)
            rows.append({"volume": name, **{k: r[k] for k in ("photons", "collisions", "relativeError", "error",
                                                              "bytes", "fileBytes", "seconds", "directions", "size")},
                         "rank": rank(r), "quality": quality})
            # By what was reached: a table at the limit of its photons tells how far away the next is.
            before = max(quality, r["relativeError"]), r["seconds"]
            print(f"{name:<12}{100 * quality:>8.0f}{100 * r['relativeError']:>10.2f}{r['photons']:>12}{rank(r):>6}"
                  f"{r['bytes'] / 1e6:>8.1f}{r['fileBytes'] / 1e6:>9.1f}{r['seconds']:>8.1f}")
    return rows


def collisions_per_second(stf, folder, seconds):
    """Of one core: walks without tallies through a dense and a sparse random volume."""
    print(f"\n{'walks':<12}{'tau':>6}{'collisions/photon':>19}{'million collisions/s':>22}")
    rows = []
    for name, tau in (("dense", 200), ("sparse", 2)):
        volume = stf.make_random(folder / f"{name}.vdb", (64, 64, 32), tau, 0.99)
        words = ["map", volume, "--reflectance", "--threads", 1, "--photons"]
        pilot = stf(*words, 6400)
        photons = int(max(6400, 6400 * seconds / max(pilot["seconds"], 1e-3)))
        r = stf(*words, photons)
        rate = r["collisions"] / r["seconds"]
        rows.append({"volume": name, "tau": tau, "photons": r["photons"], "collisions": r["collisions"],
                     "seconds": r["seconds"], "collisionsPerSecond": rate})
        print(f"{name:<12}{tau:>6}{r['collisions'] / r['photons']:>19.1f}{rate / 1e6:>22.2f}")
    return rows


def threads(stf, name, volume, quality, max_photons):
    """The same table by one and by two threads, in turn; the quickest of two each."""
    best = {1: None, 2: None}
    for _ in range(2):
        for count in best:
            seconds = precompute(stf, volume, quality, max_photons, count)["seconds"]
            best[count] = seconds if best[count] is None else min(best[count], seconds)
    print(f"\n{name} at {100 * quality:.0f} %: {best[1]:.1f} s with one thread, {best[2]:.1f} s with two: "
          f"{best[1] / best[2]:.2f} times as fast")
    return {"volume": name, "quality": quality, "seconds": {str(k): v for k, v in best.items()},
            "speedUp": best[1] / best[2]}
