"""A scene that shows one sample: a ball of it between soft boxes in a dark room (studio.py). Millimetres.

Texture coordinates are those of a map that keeps distances from the point that faces the camera, so that no seam and
little stretch is in sight; they meet at the far side.
"""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "usd_examples"))
import make_wax_sphere  # noqa: E402
import usda_text as usda  # noqa: E402

EYE = np.array((0.0, 0.42, 1.0)) / np.linalg.norm((0.0, 0.42, 1.0))


def facing_coordinates(points, offset):
    """Azimuthal equidistant coordinates of the points of a ball, about the point nearest to the camera, in radii; that
    point has the coordinates `offset`."""
    # Not quite at the camera: no point of the mesh may lie opposite, where the coordinates have no direction.
    pole = EYE + np.array((0.013, 0.007, 0.0))
    pole /= np.linalg.norm(pole)
    right = np.cross((0.0, 1.0, 0.0), pole)
    right /= np.linalg.norm(right)
    up = np.cross(pole, right)
    unit = points / np.linalg.norm(points, axis=1)[:, None]
    angle = np.arccos(np.clip(unit @ pole, -1, 1))
    along = np.stack([unit @ right, unit @ up], axis=1)
    return along / np.maximum(np.linalg.norm(along, axis=1), 1e-9)[:, None] * angle[:, None] + offset


def studio_of(picture):
    """Name of the light's image for a picture, beside the scene."""
    return "studio_soft.exr" if picture.get("soft") else "studio.exr"


def text(name, picture):
    """The scene of the sample NAME, whose volume lies beside it as NAME.vdb. `picture` is that of its recipe."""
    radius = float(picture["radiusMm"])
    quads, points, _, _ = make_wax_sphere.sphere(radius, 8)
    light = float(picture.get("light", 1))
    offset = np.array(picture.get("offsetMm", (0, 0))) / radius
    return f"""#usda 1.0
(
    doc = "A ball of {name}, radius {radius:g} mm. Written by tools/samples. Millimetres."
    defaultPrim = "World"
    metersPerUnit = 0.001
    upAxis = "Y"
)

def Xform "World"
{{
    def Mesh "Ball" (
        prepend apiSchemas = ["StfShellAPI"]
    )
    {{
        float3[] extent = {usda.numbers([points.min(0), points.max(0)])}
        int[] faceVertexCounts = {usda.numbers(np.full(len(quads), 4))}
        int[] faceVertexIndices = {usda.numbers(quads.ravel())}
        point3f[] points = {usda.numbers(points, 6)}
        texCoord2f[] primvars:st = {usda.numbers(facing_coordinates(points, offset), 6)} (
            interpolation = "vertex"
        )
        uniform token subdivisionScheme = "catmullClark"

        asset primvars:stf:baseVolume = @./{name}.vdb@ (
            interpolation = "constant"
        )
    }}

    def DomeLight "Studio"
    {{
        {usda.inputs(8, ("float", "intensity", light), ("asset", "texture:file", f"@./{studio_of(picture)}@"),
                     ("token", "texture:format", '"latlong"'))}
    }}
{usda.camera(EYE * 8.2 * radius, (0, 0, 0), 70, (20, 20), f"({0.1 * radius:g}, {1000 * radius:g})")}}}
"""
