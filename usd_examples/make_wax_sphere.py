#!/usr/bin/env python3
"""Writes wax_sphere.usda: a sphere of carved wax as a subdivided cube.

Each face of the cube is a chart of texture coordinates from 0 to 1. A relief with the symmetry of a square, repeated a
whole number of times along a chart, meets itself along every edge of the cube, whichever way the charts are turned.
Units are centimetres.
"""

import pathlib
import sys

import numpy as np

import usda_text as usda

RADIUS = 2.5  # cm
CELLS = 4  # along an edge of the cube


def sphere(radius=RADIUS, cells=CELLS):
    """Quad vertex indices, points, texture coordinates and their indices. The points are scaled until the limit
    surface, not the cage, lies on the sphere. `cells` quads along an edge of the cube."""
    angles = np.tan(np.linspace(-np.pi / 4, np.pi / 4, cells + 1))
    axes = np.eye(3)
    index_of, points, quads, uv_quads, uvs = {}, [], [], [], []
    for axis in range(3):
        for sign in (1, -1):
            across, up = axes[(axis + 1) % 3], sign * axes[(axis + 2) % 3]
            names = np.empty((cells + 1, cells + 1), int)
            for i, a in enumerate(angles):
                for j, b in enumerate(angles):
                    point = sign * axes[axis] + a * across + b * up
                    key = tuple(np.round(point, 9) + 0.0)
                    if key not in index_of:
                        index_of[key] = len(points)
                        points.append(point / np.linalg.norm(point))
                    names[i, j] = index_of[key]
            first = len(uvs)
            uvs += [(i / cells, j / cells) for i in range(cells + 1) for j in range(cells + 1)]
            for i in range(cells):
                for j in range(cells):
                    corners = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
                    quads.append([names[c] for c in corners])
                    uv_quads.append([first + c[0] * (cells + 1) + c[1] for c in corners])
    quads, points = np.array(quads), np.array(points) * radius
    for _ in range(40):
        points *= (radius / np.linalg.norm(limit_points(quads, points), axis=1))[:, None]
    return quads, points, np.array(uvs), np.array(uv_quads)


def limit_points(quads, points):
    """Where Catmull-Clark subdivision takes the vertices of a closed quad mesh."""
    valence = np.bincount(quads.ravel())[:, None]
    edges, diagonals = np.zeros_like(points), np.zeros_like(points)
    for corner in range(4):
        np.add.at(edges, quads[:, corner], points[quads[:, (corner + 1) % 4]])
        np.add.at(diagonals, quads[:, corner], points[quads[:, (corner + 2) % 4]])
    return (valence**2 * points + 4 * edges + diagonals) / (valence * (valence + 5))


def scene():
    quads, points, uvs, uv_quads = sphere()
    return f"""#usda 1.0
(
    doc = "A sphere of carved wax. Written by make_wax_sphere.py. Centimetres."
    defaultPrim = "World"
    metersPerUnit = 0.01
    upAxis = "Y"
)

def Xform "World"
{{
    def Mesh "Sphere" (
        prepend apiSchemas = ["StfShellAPI"]
    )
    {{
        float3[] extent = {usda.numbers([points.min(0), points.max(0)])}
        int[] faceVertexCounts = {usda.numbers(np.full(len(quads), 4))}
        int[] faceVertexIndices = {usda.numbers(quads.ravel())}
        point3f[] points = {usda.numbers(points, 6)}
        texCoord2f[] primvars:st = {usda.numbers(uvs)} (
            interpolation = "faceVarying"
        )
        int[] primvars:st:indices = {usda.numbers(uv_quads.ravel())}
        color3f[] primvars:displayColor = [(0.85, 0.7, 0.45)]
        uniform token subdivisionScheme = "catmullClark"
        double3 xformOp:translate = (0, {RADIUS}, 0)
        float3 xformOp:rotateXYZ = (28, 33, 0)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]

        asset primvars:stf:baseVolume = @./volumes/wax.vdb@ (
            interpolation = "constant"
        )
        token primvars:stf:mapping = "uv" (
            interpolation = "constant"
        )
        float primvars:stf:quality = 0.08 (
            doc = "Coarser than the default of 0.02, for a quick first picture."
            interpolation = "constant"
        )
        token primvars:stf:transport = "dE1" (
            interpolation = "constant"
        )
    }}

{usda.ground(300, "(0.25, 0.22, 0.2)")}{usda.distant_light("Key", (-0.9, 0.75, 0.15), 2.6, "(1, 0.93, 0.82)", 2)}{usda.dome_light("Sky", 0.25,
        "(0.85, 0.92, 1)")}{usda.camera((0, 8.5, 21), (0, 2.4, 0), 70, (24, 24), "(1, 1000)")}}}
"""


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).with_name("wax_sphere.usda")
    target.write_text(scene())
