#!/usr/bin/env python3
"""Writes backlit_dish.usda: a dish of marble on edge, lit from behind: thick in its middle, with a rim so thin that the
light of the other side comes through.

Units are centimetres.
"""

import pathlib
import sys

import numpy as np

import usda_text as usda

COLUMNS = 24
RADIUS = 4.0
THICK, THIN = 1.4, 0.35  # in the middle, at the rim


def dish():
    """Face counts, vertex indices and points of a Catmull-Clark cage: front, rim and back of a bowl around the z axis."""
    share = np.array([0.12, 0.35, 0.6, 0.82, 0.97])
    depth = 0.9 * share**2  # the bowl opens to the front
    half = 0.5 * (THIN + (THICK - THIN) * (1 - share) ** 1.5)
    front = list(zip(RADIUS * share, depth + half))
    back = list(zip(RADIUS * share, depth - half))
    rows = front + [(RADIUS, 0.9)] + back[::-1]
    turn = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    points = [(r * np.cos(a), r * np.sin(a) + RADIUS, z) for r, z in rows for a in turn]
    first, last = len(points), len(points) + 1
    points += [(0, RADIUS, front[0][1]), (0, RADIUS, back[0][1])]
    counts, indices = [], []
    for i in range(COLUMNS):
        j = (i + 1) % COLUMNS
        for row in range(len(rows) - 1):
            here, there = row * COLUMNS, (row + 1) * COLUMNS
            counts.append(4)
            indices += [here + i, there + i, there + j, here + j]
        end = (len(rows) - 1) * COLUMNS
        counts += [3, 3]
        indices += [first, i, j, last, end + j, end + i]
    return np.array(counts), np.array(indices), np.array(points)


def scene():
    counts, indices, points = dish()
    return f"""#usda 1.0
(
    doc = "A dish of marble on edge, lit from behind. Written by make_backlit_dish.py. Centimetres."
    defaultPrim = "World"
    metersPerUnit = 0.01
    upAxis = "Y"
)

def Xform "World"
{{
    def Mesh "Dish" (
        prepend apiSchemas = ["StfShellAPI"]
    )
    {{
        float3[] extent = {usda.numbers([points.min(0), points.max(0)])}
        int[] faceVertexCounts = {usda.numbers(counts)}
        int[] faceVertexIndices = {usda.numbers(indices)}
        point3f[] points = {usda.numbers(points)}
        color3f[] primvars:displayColor = [(0.85, 0.82, 0.78)]
        uniform token subdivisionScheme = "catmullClark"

        asset primvars:stf:baseVolume = @./volumes/marble.vdb@ (
            interpolation = "constant"
        )
        token primvars:stf:mapping = "synthesize" (
            interpolation = "constant"
        )
        float primvars:stf:thickness = 0.08 (
            interpolation = "constant"
        )
        float primvars:stf:quality = 0.1 (
            doc = "Coarser than the default of 0.02, for a quick first picture."
            interpolation = "constant"
        )
    }}
{usda.distant_light("Behind", (0.5, 0.7, -1), 5, "(1, 0.94, 0.85)", 3)}{usda.dome_light("Sky", 0.08,
        "(0.85, 0.92, 1)")}{usda.camera((0, 5, 24), (0, RADIUS, 0), 50, (20, 20), "(1, 1000)")}}}
"""


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).with_name("backlit_dish.usda")
    target.write_text(scene())
