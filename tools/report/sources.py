"""Where the error of the STF comes from: one setting at a time is brought back from its limit to what the scene or the
renderer says, the others stay at their limits, seeds and tables stay the same.

Only settings that exist are varied, and only to limits that were really run."""

import dataclasses
import math

LIMIT_BOUNCES = 32
TABLE_SHARE = 0.1  # of the time limit, for one table of the limit
LEAST_GAIN = 2  # a table is a limit where its error is smaller by that factor
SAMPLES = 16  # of an image

# What has no run without it, and why: said on the page instead of a number.
LEFT_OUT = [
    ("synthesis", "the reference shows the same layout of the sample; another seed is another object, not an error"),
    ("visibility averaging", "visibility at the point where a ray enters is no limit of it, but another approximation"),
    ("hierarchy of lights", "they are chosen at random with the right chances: noise, no error of its own"),
]
# Of the time of a usual table, that of one with more directions, or for halved voxels: about what was seen.
FINE_DIRECTIONS, FINE_VOXELS = 8, 12


@dataclasses.dataclass
class Source:
    """One row: runs [seed] with the setting changed, and those they are compared with."""
    name: str
    change: str
    changed: list
    limit: list
    scale: float = 1.0  # of the difference


@dataclasses.dataclass
class Sources:
    limits: dict
    limit: list = None  # runs [seed] with everything at its limit
    rows: list = dataclasses.field(default_factory=list)
    left_out: list = dataclasses.field(default_factory=list)


def limit_quality(scene_quality, cold_seconds, share_seconds):
    """The quality of a table that takes `share_seconds`, where one of `scene_quality` takes `cold_seconds`: walks grow
    with the inverse square. No finer than an eighth of the scene's."""
    ratio = math.sqrt(max(share_seconds, 1e-9) / max(cold_seconds, 1e-9))
    return float(f"{scene_quality / min(ratio, 8):.2g}")


class _Rows:
    def __init__(self, measurement, limits):
        self.measurement, self.limits = measurement, limits
        self.folder = measurement.recorder.folder.parent / "scenes"

    def images(self, name, seeds=((0, 0), (0, 1)), **changes):
        """Runs for (table seed, seed) pairs with the limits but for `changes`."""
        values = {**self.limits, **changes}
        shell = {k: v for k, v in values.items() if ":" not in k}
        scene = self.measurement.shells.write(self.folder / f"{name}.usda", **shell)
        runs = []
        for table, seed in seeds:
            self.measurement.say(f"{name.replace('_', ' ')}, seed {seed + 1}")
            runs.append(self.measurement.recorder.run(
                f"source_{name}_{table}{seed}", scene, SAMPLES, seed, table,
                settings=[(k, v) for k, v in values.items() if ":" in k]))
        return runs


def measure(measurement, until):
    """All rows that the time allows, into `measurement.found`."""
    shells, found = measurement.shells, measurement.found
    if not shells.shells:
        found.sources = Sources({}, left_out=[("all", "the scene has no shell")] + LEFT_OUT)
        return
    quality = max(shells.values("quality"))
    made = found.cold[0].seconds["precompute"] - found.stf[1][0].seconds["precompute"]
    # A report that goes on keeps its limit: another one would make all of its runs again.
    finest = measurement.earlier_limits.get("quality") or limit_quality(
        quality, made, TABLE_SHARE * measurement.options.time_limit)
    limits = {"quality": min(finest, quality), "transport": "dE1", "stf:regularize": 0, "stf:irradianceCache": 0,
              "stf:maxDepth": LIMIT_BOUNCES}
    cores = [m for m in shells.values("coreModel") if m != "none"]
    if cores and len(shells.values("coreModel")) == 1:
        limits["coreModel"] = "walk"
    exact = ["levels", "step"] + (["coreTree"] if cores else [])
    limits["stf:exact"] = ",".join(exact)
    result = found.sources = Sources(limits, left_out=list(LEFT_OUT))
    rows = _Rows(measurement, limits)
    result.limit = rows.images("limit")

    def add(name, change, key, value):
        # The first run of the limit made its table, as that of another form will.
        need = 2.2 * result.limit[1].wall + (1.2 * result.limit[0].wall if key == "transport" else 0)
        if need > measurement.left(until):
            result.left_out.append((name, "the time did not suffice"))
        else:
            result.rows.append(Source(name, change, rows.images(name.replace(" ", "_"), **{key: value}), result.limit))

    def without(name):
        return ",".join(e for e in exact if e != name)

    if finest * LEAST_GAIN <= quality:
        # Runs of table a and seed b. Of different tables on different seeds, the noise of neither is in the product.
        t00, t01, t10, t11 = tables = rows.images("tables", ((0, 0), (0, 1), (1, 0), (1, 1)), quality=quality)
        result.rows.append(Source("resolution of tables", f"quality {limits['quality']:g} to {quality:g}", [t00, t11],
                                  result.limit))
        result.rows.append(Source("noise of tables", f"two tables of quality {quality:g}", [t00, t01], [t10, t11],
                                  0.5**0.5))
    else:
        result.left_out.append(("tables", f"a table {LEAST_GAIN} times better takes longer than the time allows"))
        tables = None
    if "coreModel" in limits:
        add("core model", "walk to dipole", "coreModel", "dipole")
    else:
        result.left_out.append(("core model", "no core, or some shells have one and others none"))
    add("step of the march", "a quarter to whole", "stf:exact", without("step"))
    add("coarser levels of shell and sample", "none to those that pixels ask for", "stf:exact", without("levels"))
    if cores:
        add("sums over the core", "error bound of trees a tenth to whole", "stf:exact", without("coreTree"))
    add("irradiance cache", "off to on", "stf:irradianceCache", 1)
    add("bounces off surfaces", f"{LIMIT_BOUNCES} to 4", "stf:maxDepth", 4)
    add("regularization", "off to on", "stf:regularize", 1)
    add("form of anisotropy", "dE1 to classic", "transport", "classic")

    def compare_tables(name, change, flag, times):
        # Tables of the usual quality on either side, two of each: their noise is in neither product.
        nonlocal tables
        pairs = ((0, 0), (1, 1))
        need = 2 * (times * max(made, 0) + 2 * result.limit[1].wall)
        if need > measurement.left(until):
            result.left_out.append((name, "the time did not suffice"))
            return
        if tables is None:
            tables = rows.images("usual", pairs, quality=quality)
        fine = rows.images(name.replace(" ", "_"), pairs, quality=quality, **{"stf:exact": ",".join(exact + [flag])})
        result.rows.append(Source(name, change, [tables[0], tables[-1]], fine))

    compare_tables("direction resolution", "four times finer to usual", "directions", FINE_DIRECTIONS)
    compare_tables("voxel resolution of tables", "voxels halved to whole", "voxels", FINE_VOXELS)
