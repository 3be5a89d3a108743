"""Pieces of .usda text that the example generators share. Nothing here needs OpenUSD."""

import numpy as np


def numbers(values, digits=5):
    """`values` as a usda array; rows of a 2-D array become tuples. A dozen entries to a line."""
    values = np.asarray(values)

    def one(x):
        return f"{int(x)}" if values.dtype.kind == "i" else f"{round(float(x), digits) + 0.0:.{digits}g}"

    if values.ndim == 1:
        entries, per_line = [one(x) for x in values], 24
    else:
        entries, per_line = ["(" + ", ".join(map(one, row)) + ")" for row in values], 6
    lines = [", ".join(entries[i : i + per_line]) for i in range(0, len(entries), per_line)]
    return "[" + ",\n            ".join(lines) + "]"


def look_at(eye, target):
    """Camera-to-world matrix (row vectors, as OpenUSD stores it) as usda text; y is up."""
    eye, target = np.asarray(eye, float), np.asarray(target, float)
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    up = np.cross(back, right)
    rows = [(*right, 0), (*up, 0), (*back, 0), (*eye, 1)]
    return "( " + ", ".join("(" + ", ".join(f"{x:.7g}" for x in row) + ")" for row in rows) + " )"


def shine_from(position):
    """Transform of a distant light that shines from `position` towards the origin."""
    return look_at(position, (0, 0, 0))


def inputs(indent, *attributes):
    """Light attributes in both spellings: OpenUSD before 21.02 reads `intensity`, later versions `inputs:intensity`."""
    lines = []
    for kind, name, value in attributes:
        lines += [f"{kind} {name} = {value}", f"{kind} inputs:{name} = {value}"]
    return ("\n" + " " * indent).join(lines)


def distant_light(name, position, irradiance, color, angle):
    """A distant light that gives a perpendicular irradiance of `irradiance` * `color` whatever its angle."""
    return f"""
    def DistantLight "{name}"
    {{
        {inputs(8, ("float", "angle", angle), ("color3f", "color", color), ("float", "intensity", irradiance),
                ("bool", "normalize", 1))}
        matrix4d xformOp:transform = {shine_from(position)}
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }}
"""


def dome_light(name, radiance, color):
    """A uniform dome: no texture, so that the scene needs no file beside it."""
    return f"""
    def DomeLight "{name}"
    {{
        {inputs(8, ("color3f", "color", color), ("float", "intensity", radiance))}
    }}
"""


def ground(half, color):
    """A square of 2 * `half` in the plane y = 0."""
    h = f"{half:g}"
    return f"""    def Mesh "Ground"
    {{
        float3[] extent = [(-{h}, 0, -{h}), ({h}, 0, {h})]
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-{h}, 0, {h}), ({h}, 0, {h}), ({h}, 0, -{h}), (-{h}, 0, -{h})]
        normal3f[] normals = [(0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0)] (
            interpolation = "vertex"
        )
        color3f[] primvars:displayColor = [{color}]
        uniform token subdivisionScheme = "none"
    }}
"""


def camera(eye, target, focal_length, aperture, clipping):
    """Aperture and focal length in mm as printed on a lens; USD reads them as tenths of a unit, only the ratio counts."""
    return f"""
    def Camera "Camera"
    {{
        float2 clippingRange = {clipping}
        float focalLength = {focal_length}
        float horizontalAperture = {aperture[0]}
        float verticalAperture = {aperture[1]}
        matrix4d xformOp:transform = {look_at(eye, target)}
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }}
"""
