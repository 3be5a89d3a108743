"""Scenes of one large flat shell, rendered by stfrecord: the whole chain from USD to EXR, where transport is known."""

import json
import pathlib
import subprocess
import sys

import numpy as np
import OpenEXR

TOP = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(TOP / "usd_examples"))
import usda_text as usda  # noqa: E402


def direction(cosine, azimuth=0.0):
    """Unit vector at an angle to the normal, z; azimuth in degrees from x."""
    sine, phi = (1 - cosine * cosine)**0.5, np.radians(azimuth)
    return np.array((sine * np.cos(phi), sine * np.sin(phi), cosine))


def distant(towards, irradiance=1.0):
    """A light of this perpendicular irradiance, without a disc."""
    return usda.distant_light("Light", towards, irradiance, "(1, 1, 1)", 0)


def dome(radiance=1.0):
    return usda.dome_light("Light", radiance, "(1, 1, 1)")


def parallel_camera(towards, target, width, height):
    """A parallel camera that sees width x height mm about `target` from the unit direction `towards`; y is up where the
    view is along the normal."""
    right = np.cross((0.0, 1.0, 0.0) if abs(towards[1]) < 0.9 else (-1.0, 0.0, 0.0), towards)
    right /= np.linalg.norm(right)
    up, eye = np.cross(towards, right), np.asarray(target) + 100 * towards
    rows = [(*right, 0), (*up, 0), (*towards, 0), (*eye, 1)]
    matrix = ", ".join("(" + ", ".join(f"{x:.9g}" for x in row) + ")" for row in rows)
    # Apertures are tenths of a scene unit.
    return f"""
    def Camera "Camera"
    {{
        float2 clippingRange = (1, 1000)
        token projection = "orthographic"
        float horizontalAperture = {10 * width:.9g}
        float verticalAperture = {10 * height:.9g}
        matrix4d xformOp:transform = ( {matrix} )
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }}
"""


class FlatShell:
    """A square of `tiles` x `tiles` repeats of a volume in the plane z = 0, outward +z; one corner of a tile lies in
    the origin. `core`: (sigma_a, sigma_s') in 1/mm, or None for black."""

    def __init__(self, volume, tile_mm, core=None, quality=0.003, transport="dE1", tiles=64, seed=0):
        self.volume, self.tile_mm, self.core = pathlib.Path(volume).resolve(), tile_mm, core
        self.quality, self.transport, self.tiles, self.seed = quality, transport, tiles, seed

    def _mesh(self):
        n = self.tiles // 2
        x, y = n * self.tile_mm[0], n * self.tile_mm[1]
        model, (absorption, scattering) = ("none", (0, 0)) if self.core is None else ("auto", self.core)
        return f"""
    def Mesh "Shell" (
        prepend apiSchemas = ["StfShellAPI"]
    )
    {{
        float3[] extent = [({-x:.9g}, {-y:.9g}, 0), ({x:.9g}, {y:.9g}, 0)]
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [({-x:.9g}, {-y:.9g}, 0), ({x:.9g}, {-y:.9g}, 0), ({x:.9g}, {y:.9g}, 0), ({-x:.9g}, {y:.9g}, 0)]
        texCoord2f[] primvars:st = [({-x:.9g}, {-y:.9g}), ({x:.9g}, {-y:.9g}), ({x:.9g}, {y:.9g}), ({-x:.9g}, {y:.9g})] (
            interpolation = "vertex"
        )
        uniform token subdivisionScheme = "none"
        asset primvars:stf:baseVolume = @{self.volume}@
        token primvars:stf:mapping = "uv"
        float primvars:stf:quality = {self.quality:.9g}
        token primvars:stf:transport = "{self.transport}"
        token primvars:stf:coreModel = "{model}"
        color3f primvars:stf:coreSigmaA = ({absorption:.9g}, {absorption:.9g}, {absorption:.9g})
        color3f primvars:stf:coreSigmaSPrime = ({scattering:.9g}, {scattering:.9g}, {scattering:.9g})
        int primvars:stf:seed = {self.seed}
    }}
"""

    def text(self, lights, camera):
        return f"""#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 0.001
    upAxis = "Z"
)

def Xform "World"
{{{self._mesh()}{lights}{camera}}}
"""


class Recorder:
    """stfrecord of a build folder; images are kept in `folder`."""

    def __init__(self, build, folder):
        self.program, self.folder = pathlib.Path(build) / "bin" / "stfrecord", pathlib.Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)

    def __call__(self, name, scene, width, samples, aovs=("color",), settings=()):
        """Layers [height, width, 3] by AOV, and the statistics of the run."""
        usd, exr, stats = (self.folder / f"{name}.{kind}" for kind in ("usda", "exr", "json"))
        usd.write_text(scene)
        command = [self.program, usd, exr, "--imageWidth", width, "--samples", samples, "--aov", ",".join(aovs),
                   "--stats", stats, "--quiet", "--set", "stf:pixelFilter=box", "--set", "stf:pixelFilterWidth=1"]
        for setting in settings:
            command += ["--set", setting]
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{' '.join(map(str, command))}\n{done.stderr}")
        with OpenEXR.File(str(exr), separate_channels=True) as image:
            channels = image.parts[0].channels

            def layer(aov):
                names = [p + c for p in ("", f"{aov}.") for c in "RGB" if p or aov == "color"]
                found = [n for n in names if n in channels][:3]
                return np.stack([np.asarray(channels[n].pixels, float) for n in found], axis=2)

            return {aov: layer(aov) for aov in aovs}, json.loads(stats.read_text())


def mean_and_error(image):
    """Mean of the first channel and its standard error, from the scatter of pixels."""
    values = image[..., 0].ravel()
    return float(values.mean()), float(values.std(ddof=1) / len(values)**0.5)
