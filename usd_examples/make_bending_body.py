#!/usr/bin/env python3
"""Writes bending_body.usda: a horn of marble that nods to either side over 24 frames.

The mesh says where its points are at rest, and which way the sample lies: it is laid out and gridded once, and stays on
the body in every frame. Units are centimetres.
"""

import pathlib
import sys

import numpy as np

import usda_text as usda

FRAMES = 24
HEIGHT = 8.0
COLUMNS = 10
BEND = 1.3  # radians from base to tip, at most


def body():
    """Face counts, vertex indices and points of the upright horn, a Catmull-Clark cage."""
    rows = [(1.5, 0.0), (2.2, 0.3), (2.3, 0.9), (2.05, 2.0), (1.75, 3.2), (1.45, 4.4), (1.15, 5.6), (0.95, 6.8), (0.7, 7.6)]
    turn = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    points = [(r * np.cos(a), y, -r * np.sin(a)) for r, y in rows for a in turn]
    bottom, top = len(points), len(points) + 1
    points += [(0, 0, 0), (0, HEIGHT, 0)]
    counts, indices = [], []
    for i in range(COLUMNS):
        j = (i + 1) % COLUMNS
        for row in range(len(rows) - 1):
            below, above = row * COLUMNS, (row + 1) * COLUMNS
            counts.append(4)
            indices += [below + i, below + j, above + j, above + i]
        last = (len(rows) - 1) * COLUMNS
        counts += [3, 3]
        indices += [j, i, bottom, last + i, last + j, top]
    return np.array(counts), np.array(indices), np.array(points)


def bent(points, angle):
    """The points with the y axis bent to an arc of `angle` radians towards +x; lengths along the axis stay."""
    if abs(angle) < 1e-9:
        return points
    radius = HEIGHT / angle
    turn, across = points[:, 1] / radius, radius - points[:, 0]
    return np.stack([radius - across * np.cos(turn), across * np.sin(turn), points[:, 2]], axis=1)


def poses(points):
    """The points of each frame, from 1 on; the first is the rest pose."""
    return [bent(points, BEND * np.sin(2 * np.pi * frame / FRAMES)) for frame in range(FRAMES)]


def samples(values):
    return "{\n" + "".join(f"            {i + 1}: {v},\n" for i, v in enumerate(values)) + "        }"


def scene():
    counts, indices, rest = body()
    frames = poses(rest)
    extents = samples(usda.numbers([p.min(0), p.max(0)]) for p in frames)
    return f"""#usda 1.0
(
    doc = "A horn of marble that nods. Written by make_bending_body.py. Centimetres."
    defaultPrim = "World"
    metersPerUnit = 0.01
    upAxis = "Y"
    startTimeCode = 1
    endTimeCode = {FRAMES}
    timeCodesPerSecond = 24
)

def Xform "World"
{{
    def Mesh "Body" (
        prepend apiSchemas = ["StfShellAPI"]
    )
    {{
        float3[] extent = {usda.numbers([rest.min(0), rest.max(0)])}
        float3[] extent.timeSamples = {extents}
        int[] faceVertexCounts = {usda.numbers(counts)}
        int[] faceVertexIndices = {usda.numbers(indices)}
        point3f[] points = {usda.numbers(rest)}
        point3f[] points.timeSamples = {samples(usda.numbers(p) for p in frames)}
        color3f[] primvars:displayColor = [(0.85, 0.82, 0.78)]
        uniform token subdivisionScheme = "catmullClark"

        asset primvars:stf:baseVolume = @./volumes/marble.vdb@ (
            interpolation = "constant"
        )
        token primvars:stf:mapping = "synthesize" (
            interpolation = "constant"
        )
        float primvars:stf:thickness = 0.24 (
            interpolation = "constant"
        )
        float primvars:stf:quality = 0.1 (
            doc = "Coarser than the default of 0.02, for a quick first picture."
            interpolation = "constant"
        )
        point3f[] primvars:stf:rest = {usda.numbers(rest)} (
            interpolation = "vertex"
        )
        vector3f[] primvars:stf:orientation = {usda.numbers(np.tile((0, 1, 0), (len(rest), 1)))} (
            interpolation = "vertex"
        )
    }}

{usda.ground(300, "(0.25, 0.22, 0.2)")}{usda.distant_light("Key", (-0.9, 0.8, 0.6), 2.4, "(1, 0.94, 0.85)", 3)}{usda.dome_light("Sky", 0.3,
        "(0.85, 0.92, 1)")}{usda.camera((0, 7, 28), (0, 3.9, 0), 60, (24, 20), "(1, 1000)")}}}
"""


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).with_name("bending_body.usda")
    target.write_text(scene())
