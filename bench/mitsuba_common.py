"""What the Mitsuba 3 benchmarks share: start-up, tiles from files, the periodic medium, timed renders."""

import json
import pathlib
import sys
import time

SKIP = 77  # exit code of a benchmark whose program is not installed, as test runners know it

try:
    import numpy as np
except ImportError as missing:
    print(f"skipped: {missing}; try: pip install mitsuba numpy", file=sys.stderr)
    sys.exit(SKIP)

NEVER = 1 << 30  # a Russian roulette depth no walk reaches
ROULETTE = (5, 20, 50, 100, NEVER)


def start(variant, threads):
    """Mitsuba with a variant set and its threads limited, or the end of the program where it cannot run."""
    try:
        import drjit
        import mitsuba
    except ImportError as error:
        print(f"skipped: Mitsuba 3 is not installed ({error}); try: pip install mitsuba numpy", file=sys.stderr)
        sys.exit(SKIP)
    if variant not in mitsuba.variants():
        print(f"skipped: this Mitsuba has no variant {variant}, only {' '.join(mitsuba.variants())}", file=sys.stderr)
        sys.exit(SKIP)
    try:
        mitsuba.set_variant(variant)
        if threads:
            drjit.set_thread_count(threads)
        drjit.eval(mitsuba.Float(1) + 1)  # LLVM is only looked for now
    except (ImportError, RuntimeError) as error:
        print(f"skipped: {variant} does not start ({error}); LLVM variants need a shared libLLVM (Debian: libllvm19), "
              "found by itself or through DRJIT_LIBLLVM_PATH", file=sys.stderr)
        sys.exit(SKIP)
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return mitsuba


class Tile:
    """A periodic block of voxels: extinction (1/mm) and albedo [nz,ny,nx] or [nz,ny,nx,3], one g, voxel_mm [3].

    z = 0 is the top layer, z grows inward.
    """

    def __init__(self, extinction, albedo, g=0.0, voxel_mm=(1.0, 1.0, 1.0)):
        self.extinction = np.ascontiguousarray(extinction, np.float32)
        albedo = np.asarray(albedo, np.float32)
        if albedo.ndim == 0:
            albedo = np.full(self.extinction.shape[:3], albedo, np.float32)
        self.albedo = np.ascontiguousarray(albedo)
        self.g = float(g)
        self.voxel_mm = np.broadcast_to(np.asarray(voxel_mm, float), 3)
        for name, grid in (("extinction", self.extinction), ("albedo", self.albedo)):
            if grid.ndim not in (3, 4) or grid.ndim == 4 and grid.shape[3] != 3:
                raise SystemExit(f"{name} must be [nz,ny,nx] or [nz,ny,nx,3], not {list(grid.shape)}")
            if not np.isfinite(grid).all() or grid.min() < 0:
                raise SystemExit(f"{name} must be finite and not negative")
        if self.extinction.shape[:3] != self.albedo.shape[:3]:
            raise SystemExit("extinction and albedo must have the same number of voxels")

    @property
    def size(self):
        """Voxels along x, y, z."""
        return self.extinction.shape[2::-1]

    @property
    def steps(self):
        """Steps of a walk, null collisions with them, to a real collision."""
        return float(self.extinction.max() / max(self.extinction.mean(), 1e-30))

    @property
    def extent(self):
        """Lengths along x, y, z in mm."""
        return np.array(self.size) * self.voxel_mm

    def channel(self, c):
        """The grey tile of one colour."""
        return Tile(self.extinction[..., c] if self.extinction.ndim == 4 else self.extinction,
                    self.albedo[..., c] if self.albedo.ndim == 4 else self.albedo, self.g, self.voxel_mm)

    def save(self, path):
        np.savez(path, extinction=self.extinction, albedo=self.albedo, g=self.g, voxel_mm=self.voxel_mm)


def load_raw(folder):
    """What `stf inspect VOLUME.vdb --raw FOLDER` wrote; grids that are grey become so."""
    header = json.loads((folder / "volume.json").read_text())
    nx, ny, nz = header["size"]

    def grid(name):
        entry = header["grids"][name]
        values = np.fromfile(folder / entry["file"], np.float32).reshape(nz, ny, nx, entry["channels"])
        return values[..., 0] if np.all(values == values[..., :1]) else values

    if "surface" in header["grids"] or "ior" in header["grids"] and np.any(grid("ior") != 1):
        raise SystemExit(f"{folder}: only flat tiles of index 1 are compared")
    g = grid("g") if "g" in header["grids"] else np.zeros(1)
    if g.min() != g.max():
        raise SystemExit(f"{folder}: only one g for all voxels is compared")
    return {"extinction": grid("extinction"), "albedo": grid("albedo"), "g": g.flat[0], "voxel_mm": header["voxelMm"]}


def load_tile(path, albedo=None, g=None):
    """A tile from .npz or .json (extinction, albedo, g, voxel_mm), .npy (extinction for voxels of 1 mm) or a folder
    that `stf inspect --raw` wrote."""
    path = pathlib.Path(path)
    if path.is_dir():
        data = load_raw(path)
    elif path.suffix == ".npy":
        data = {"extinction": np.load(path)}
    elif path.suffix == ".json":
        data = json.loads(path.read_text())
    else:
        data = dict(np.load(path))
    if "albedo" not in data and albedo is None:
        raise SystemExit(f"{path} holds no albedo: give --albedo")
    return Tile(data["extinction"], data.get("albedo", albedo), data.get("g", g or 0), data.get("voxel_mm", 1.0))


def phase_function(g):
    # Isotropic is its own plugin: cheaper than Henyey-Greenstein at g = 0.
    return {"type": "hg", "g": float(g)} if g else {"type": "isotropic"}


def periodic_medium(mi, tile, sample_emitters):
    """A medium that repeats a grey tile for ever in x and y, between z = 0 (top) and minus its depth.

    Mitsuba's own heterogeneous medium ends at its grid's bounding box, also where the grid wraps, so there a repeated
    tile must be stored many times over; this one is traced into the same kernel and reads one tile, which fits a cache.
    As there, distances are sampled against the tile's largest extinction.
    """
    import drjit as dr

    if not dr.is_array_v(mi.Float):
        raise SystemExit("a voxel tile needs a compiled variant: a scalar one would call Python at every collision")

    class PeriodicMedium(mi.Medium):
        def __init__(self, props):
            super().__init__(props)
            self.m_is_homogeneous = False
            self.m_has_spectral_extinction = False  # grey extinction: no choice of channel, no spectral weights

        def configure(self, tile):
            self.counts = [int(n) for n in tile.size]
            self.scale = [float(1 / v) for v in tile.voxel_mm]
            self.depth = float(tile.extent[2])
            self.majorant = dr.opaque(mi.Float, float(tile.extinction.max()))
            self.coloured = tile.albedo.ndim == 4
            grids = [tile.extinction[..., None], tile.albedo if self.coloured else tile.albedo[..., None]]
            # Extinction beside albedo: one look-up, one cache line.
            self.voxels = mi.Float(np.ascontiguousarray(np.concatenate(grids, axis=3)).ravel())

        def intersect_aabb(self, ray):
            # Two planes only: no side to leave through.
            a, b = -ray.o.z / ray.d.z, (-self.depth - ray.o.z) / ray.d.z
            near, far = dr.minimum(a, b), dr.maximum(a, b)
            return (far > 0) & (near <= far), near, far

        def get_majorant(self, mei, active=True):
            return mi.UnpolarizedSpectrum(self.majorant)

        def get_scattering_coefficients(self, mei, active=True):
            nx, ny, nz = self.counts

            def wrapped(x, n):
                i = mi.Int32(dr.floor(x))
                if n & (n - 1) == 0:
                    return i & (n - 1)
                i = i % n
                return dr.select(i < 0, i + n, i)

            i = wrapped(mei.p.x * self.scale[0], nx)
            j = wrapped(mei.p.y * self.scale[1], ny)
            k = dr.clip(mi.Int32(dr.floor(mei.p.z * -self.scale[2])), 0, nz - 1)
            cell = mi.UInt32((k * ny + j) * nx + i)
            if self.coloured:
                v = dr.gather(mi.Vector4f, self.voxels, cell, active)
                albedo = mi.UnpolarizedSpectrum(v.y, v.z, v.w)
            else:
                v = dr.gather(mi.Vector2f, self.voxels, cell, active)
                albedo = mi.UnpolarizedSpectrum(v.y)
            extinction = mi.UnpolarizedSpectrum(v.x)
            return extinction * albedo, self.majorant - extinction, extinction

        def to_string(self):
            return "PeriodicMedium[]"

    name = f"periodic_{'lit' if sample_emitters else 'unlit'}"
    mi.register_medium(name, PeriodicMedium)
    medium = mi.load_dict({"type": name, "phase": phase_function(tile.g), "sample_emitters": bool(sample_emitters)})
    medium.configure(tile)
    return medium


def timed_render(mi, scene, spp, seed):
    """The image of one render as numpy, its seconds and its seconds of CPU in all threads."""
    import drjit as dr

    cpu, wall = time.process_time(), time.perf_counter()
    image = mi.render(scene, spp=spp, seed=seed)
    dr.eval(image)
    dr.sync_thread()
    seconds = time.perf_counter() - wall, time.process_time() - cpu
    return np.array(image, dtype=np.float64), *seconds


def roulette_by_trial(mi, build, spp, albedo, steps):
    """The start of Russian roulette with the least variance x time of CPU, which other programs disturb less.

    `build(rr_depth)` gives the scene, `albedo` is the largest in it, `steps` the steps (null collisions too) to a real
    collision. Mitsuba ends at least one walk in twenty at every step, also where nothing is absorbed: in long walks of
    high albedo the survivors' weights then grow without bound, which a short trial would not see, so there it is off.
    """
    if albedo > 0.98**steps:
        return NEVER
    best = None
    for rr_depth in ROULETTE:
        scene = build(rr_depth)
        first, _, _ = timed_render(mi, scene, spp, 1)  # compiles
        second, _, cpu = timed_render(mi, scene, spp, 2)
        cost = np.mean((first - second)**2) * cpu
        if best is None or cost < best[0]:
            best = cost, rr_depth
    return best[1]


def roulette(mi, text, build, spp, albedo, steps):
    """What --rr-depth says: a depth, 'never' or 'auto'."""
    if text == "auto":
        return roulette_by_trial(mi, build, spp, albedo, steps)
    return NEVER if text == "never" else max(int(text), 1)


def roulette_name(rr_depth):
    return "never" if rr_depth == NEVER else rr_depth
