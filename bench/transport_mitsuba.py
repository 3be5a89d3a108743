"""Against Mitsuba 3: variance x time of a reflectance, and the map of a tile, pixel by pixel."""

import math

# tau, albedo, g
SLABS = ((1, 1, 0), (10, 0.99, 0), (10, 0.99, 0.9), (100, 0.999999, 0.9))
RANDOM_TILE = {"size": (64, 64, 32), "tau": 10, "albedo": 0.95, "g": 0.0, "ratio": 100.0}
CHECK_TILE = {"size": (32, 32, 16), "tau": 4, "albedo": 0.9, "g": 0.5, "ratio": 30.0}
CHECK_LIGHT = (0.5, 0.3, 0.8124038)


def reading(value, stderr, seconds, cpu):
    return {"R": value, "stderr": stderr, "seconds": seconds, "cpu_seconds": cpu,
            "variance_seconds": stderr**2 * seconds, "variance_cpu_seconds": stderr**2 * cpu}


class Ours:
    """R of a slab or of a tile by walks, in about the time that is asked for."""

    def __init__(self, stf, words, seconds, threads):
        self.stf, self.words, self.threads = stf, words, threads
        pilot = self.run(20000, 0)
        self.photons = int(max(20000, 20000 * seconds / max(pilot["seconds"], 1e-3)))

    def run(self, photons, seed):
        r = self.stf(*self.words, "--photons", photons, "--seed", seed, "--threads", self.threads)
        total, stderr = r["R"]["total"], r["R"]["stderr"]
        if isinstance(total, list):
            total, stderr = total[0], stderr[0]
        return reading(total, stderr, r["seconds"], r["cpu_seconds"])

    def __call__(self, round_):
        return self.run(self.photons, 1 + round_)


class Theirs:
    """The same by Mitsuba; roulette is chosen once."""

    def __init__(self, mitsuba, words, seconds, threads):
        self.mitsuba, self.words, self.threads = mitsuba, words, threads
        self.roulette, samples = "auto", 1 << 16
        pilot = self.run(samples, 0)
        self.roulette = pilot["rr_depth"]
        self.samples = int(min(max(samples, samples * seconds / max(pilot["seconds"], 1e-3)), 1 << 24))

    def run(self, samples, seed):
        r = self.mitsuba("mitsuba_slab.py", *self.words, "--samples", samples, "--repeats", 1, "--seed", seed,
                         "--threads", self.threads, "--rr-depth", self.roulette)
        return {**reading(r["R"], r["stderr"], r["seconds"], r["cpu_seconds"]), "rr_depth": r["rr_depth"]}

    def __call__(self, round_):
        return self.run(self.samples, 1 + round_)


def middle(values):
    return sorted(values)[len(values) // 2]


def compare(name, ours, theirs, rounds):
    """Both in turn: what disturbs one disturbs the other."""
    runs = [(ours(i), theirs(i)) for i in range(rounds)]
    ratio = {key: middle([t[key] / o[key] for o, t in runs]) for key in ("variance_seconds", "variance_cpu_seconds")}
    weights = [sum(1 / r[i]["stderr"]**2 for r in runs) for i in (0, 1)]
    means = [sum(r[i]["R"] / r[i]["stderr"]**2 for r in runs) / weights[i] for i in (0, 1)]
    sigmas = (means[0] - means[1]) / math.sqrt(1 / weights[0] + 1 / weights[1])
    print(f"{name:<32}{means[0]:>10.6f}{means[1]:>10.6f}{sigmas:>8.1f}{ratio['variance_seconds']:>10.2f}"
          f"{ratio['variance_cpu_seconds']:>10.2f}")
    return {"case": name, "R": means[0], "mitsubaR": means[1], "sigmas": sigmas,
            "secondsToSameError": ratio["variance_seconds"], "cpuToSameError": ratio["variance_cpu_seconds"],
            "runs": [{"ours": o, "mitsuba": t} for o, t in runs]}


def slabs(stf, mitsuba, folder, seconds, rounds, threads):
    """Time of Mitsuba over ours to the same standard error of R."""
    print(f"\n{'Mitsuba / ours, time to one error':<32}{'R':>10}{'Mitsuba':>10}{'sigmas':>8}{'clock':>10}{'cpu':>10}")
    rows = []
    for tau, albedo, g in SLABS:
        words = ["--tau", tau, "--albedo", albedo, "--g", g]
        rows.append(compare(f"tau {tau}, albedo {albedo}, g {g}", Ours(stf, ["slab", *words], seconds, threads),
                            Theirs(mitsuba, words, seconds, threads), rounds))
    volume = stf.make_random(folder / "random.vdb", **RANDOM_TILE)
    raw = stf.dump(volume, folder / "random")
    rows.append(compare("random {}x{}x{}".format(*RANDOM_TILE["size"]),
                        Ours(stf, ["map", volume, "--reflectance"], seconds, threads),
                        Theirs(mitsuba, ["--volume", raw], seconds, threads), rounds))
    return rows


def read_map(path):
    """The first channel of a map's layers; the tile is grey."""
    import numpy as np
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as image:
        channels = image.parts[0].channels
        return [np.asarray(channels[name].pixels, float) for name in ("radiance.R", "stderr.R")]


def tile_check(stf, mitsuba, folder, target, photons, samples, threads):
    """Walks against Mitsuba on one tile and light; the dE1 map beside them. Maps go to `target` (.npz)."""
    try:
        import numpy as np
        import OpenEXR  # noqa: F401, read_map needs it
    except ImportError as error:
        print(f"the tile check is left out: this Python has no {error.name}")
        return None

    volume = stf.make_random(folder / "check.vdb", **CHECK_TILE)
    raw = stf.dump(volume, folder / "check")
    light = ",".join(map(str, CHECK_LIGHT))
    maps, told = {}, {}
    words = ["map", volume, f"--light={light}", "--threads", threads, "--out"]
    told["walk"] = stf(*words, folder / "walk.exr", "--photons", photons)
    for form in ("dE1", "classic"):
        told[form] = stf(*words, folder / f"{form}.exr", "--method", "stf", "--form", form, "--quality", 0.02)
    told["mitsuba"] = mitsuba("mitsuba_tile.py", raw, folder / "mitsuba.npz", f"--light={light}", "--samples", samples,
                              "--renders", 64, "--threads", threads)
    for name in ("walk", "dE1", "classic"):
        maps[name], maps[f"{name}_stderr"] = read_map(folder / f"{name}.exr")
    with np.load(folder / "mitsuba.npz") as theirs:
        maps["mitsuba"], maps["mitsuba_stderr"] = theirs["radiance"], theirs["stderr"]
    np.savez_compressed(target, **maps)

    scale = maps["walk"].mean()
    sigma = np.hypot(maps["walk_stderr"], maps["mitsuba_stderr"])
    deviations = (maps["walk"] - maps["mitsuba"]) / sigma
    result = {
        "tile": CHECK_TILE, "light": CHECK_LIGHT, "pixels": deviations.size,
        "chiSquarePerPixel": float(np.mean(deviations**2)), "largestSigmas": float(np.abs(deviations).max()),
        "noise": float(np.sqrt(np.mean(sigma**2)) / scale),
        "meanDifference": float((maps["walk"] - maps["mitsuba"]).mean() / scale),
        "meanDifferenceStderr": float(np.sqrt(np.sum(sigma**2)) / sigma.size / scale),
        "seconds": {name: told[name]["seconds"] for name in told},
    }
    for form in ("dE1", "classic"):
        difference = maps[form] - maps["walk"]
        noise = np.mean(maps["walk_stderr"]**2 + maps[f"{form}_stderr"]**2)
        result[form] = {"meanDifference": float(difference.mean() / scale),
                        "rms": float(math.sqrt(max(np.mean(difference**2) - noise, 0)) / scale),
                        "tableError": told[form]["tableError"]}
    print(f"\ntile {CHECK_TILE['size']}: chi-square {result['chiSquarePerPixel']:.3f} a pixel, mean "
          f"{100 * result['meanDifference']:+.3f} % +- {100 * result['meanDifferenceStderr']:.3f} % against Mitsuba; "
          f"dE1 {100 * result['dE1']['meanDifference']:+.2f} % (rms {100 * result['dE1']['rms']:.2f} %), classic "
          f"{100 * result['classic']['meanDifference']:+.2f} % (rms {100 * result['classic']['rms']:.2f} %)")
    return result
