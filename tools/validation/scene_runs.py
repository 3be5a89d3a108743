"""Rendered scenes of flat homogeneous shells beside `stf slab`: what the renderer makes of a table and of exact
transport, seen from five sides."""

import numpy as np

import flat_scene as flat

VIEWS = (1.0, 0.8, 0.6, 0.4, 0.2)
INDICES = (1, 1.3, 1.5)
TAU, ALBEDO = 4, 0.99
LAYERS_PER_MM = 20  # of extinction 1/mm
TABLES = 4  # independent: their noise is part of the error
PIXELS, VIEW_MM = 16, 0.4


class Slabs:
    def __init__(self, slab, recorder, quality, samples, log):
        self.slab, self.record, self.quality, self.samples, self.log = slab, recorder, quality, samples, log
        self.stf = slab.program

    def volume(self, index, albedo, tau=TAU):
        path = self.record.folder / f"slab_{index}_{albedo}_{tau}.vdb"
        self.slab.make("uniform", path, "--size", f"1,1,{tau * LAYERS_PER_MM}", "--voxel", 1 / LAYERS_PER_MM,
                       "--extinction", 1, "--albedo", albedo, "--g", 0, "--ior", index)
        return path

    def seen(self, name, volume, lights, views, core=None):
        """Mean and standard error of the radiance towards each view; over independent tables."""
        rows = []
        for seed in range(TABLES):
            shell = flat.FlatShell(volume, (1 / LAYERS_PER_MM, 1 / LAYERS_PER_MM), core, self.quality, seed=seed,
                                   tiles=20 * 80)
            row = []
            for towards in views:
                camera = flat.parallel_camera(towards, (0, 0, 0), VIEW_MM, VIEW_MM)
                layers, _ = self.record(f"{name}_{seed}", shell.text(lights, camera), PIXELS,
                                        max(1, self.samples // TABLES))
                row.append(flat.mean_and_error(layers["color"]))
            rows.append(row)
        told = np.array(rows)  # [table, view, (mean, error)]
        scatter = told[..., 0].std(axis=0, ddof=1) / TABLES**0.5
        noise = np.sqrt((told[..., 1]**2).sum(axis=0)) / TABLES
        return [{"mean": float(m), "stderr": float(max(a, b))} for m, a, b in
                zip(told[..., 0].mean(axis=0), scatter, noise)]

    def against_tables(self):
        """Parallel light along the normal: radiance times pi, beside `stf slab --method stf --view`."""
        rows = []
        for index in INDICES:
            seen = self.seen(f"parallel_{index}", self.volume(index, ALBEDO), flat.distant((0, 0, 1)),
                             [flat.direction(mu, 90) for mu in VIEWS])
            told = self.slab.table("dE1", "--tau", TAU, "--albedo", ALBEDO, "--ior", index, "--core-albedo", 0,
                                   "--view", ",".join(map(str, VIEWS)), quality=self.quality,
                                   photons=1_000_000)["view"]
            for mu, s, t in zip(VIEWS, seen, told):
                rows.append(_row(index, mu, np.pi * s["mean"], np.pi * s["stderr"], t["factor"], t["stderr"]))
            self.log(f"scene index {index} against tables")
        return rows

    def against_walks(self):
        """A white dome: radiance at a cosine is the reflectance of parallel light from there, by walks."""
        rows = []
        for index in INDICES:
            seen = self.seen(f"dome_{index}", self.volume(index, ALBEDO), flat.dome(),
                             [flat.direction(mu, 90) for mu in VIEWS])
            for mu, s in zip(VIEWS, seen):
                exact = self.slab.walk("--tau", TAU, "--albedo", ALBEDO, "--ior", index, "--core-albedo", 0,
                                       "--incidence", mu)["R"]
                rows.append(_row(index, mu, s["mean"], s["stderr"], exact["total"], exact["stderr"]))
            self.log(f"scene index {index} against walks")
        return rows

    def furnaces(self):
        """Nothing absorbs, all around is white: so is the image."""
        rows = []
        for index in INDICES:
            seen = self.seen(f"furnace_{index}", self.volume(index, 1, 1), flat.dome(),
                             [flat.direction(mu, 90) for mu in VIEWS], core=(0, 1))
            rows += [_row(index, mu, s["mean"], s["stderr"], 1, 0) for mu, s in zip(VIEWS, seen)]
            self.log(f"furnace index {index}")
        return rows

    def reciprocity(self):
        """Light and view exchanged: the radiance per irradiance of the surface is the same (Helmholtz)."""
        rows = []
        for index in INDICES:
            volume = self.volume(index, ALBEDO)
            for a, b in ((1, 0.5), (0.8, 0.3)):
                da, db = flat.direction(a, 20), flat.direction(b, 130)
                there = self.seen(f"there_{index}", volume, flat.distant(da), [db])[0]
                back = self.seen(f"back_{index}", volume, flat.distant(db), [da])[0]
                rows.append({**_row(index, b, there["mean"] / a, there["stderr"] / a, back["mean"] / b,
                                    back["stderr"] / b), "other": a})
            self.log(f"reciprocity index {index}")
        return rows


def _row(index, mu, value, error, exact, exact_error):
    difference = value - exact
    sigma = max((error**2 + exact_error**2)**0.5, 1e-9)
    return {"n": index, "mu": mu, "value": value, "stderr": error, "exact": exact, "exactStderr": exact_error,
            "percent": 100 * difference / exact, "percentStderr": 100 * sigma / exact, "sigmas": difference / sigma}


def measure(slab, recorder, quality, samples, log):
    runs = Slabs(slab, recorder, quality, samples, log)
    return {"quality": quality, "tables": runs.against_tables(), "walks": runs.against_walks(),
            "furnaces": runs.furnaces(), "reciprocity": runs.reciprocity()}
