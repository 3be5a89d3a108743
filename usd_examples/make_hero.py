#!/usr/bin/env python3
"""Writes hero.usda: a turned tulip vase of marble, lit from behind so that the rim glows.

The vase is a Catmull-Clark cage: a profile curve sampled by arc length and curvature, turned about the y axis. The
cage is solved for, so that the limit surface, not the cage, passes through the samples. Units are centimetres.
"""

import pathlib
import sys

import numpy as np

import usda_text as usda

COLUMNS = 32
WALL = 0.42  # cm, at the rim
SHELL = 0.16  # cm; two shells fit into the wall, so that none has to be clamped


def spline(points, step=0.01):
    """Dense polyline, about `step` apart, through `points` (centripetal Catmull-Rom)."""
    points = np.asarray(points, float)
    padded = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    pieces = []
    for p0, p1, p2, p3 in zip(padded, padded[1:], padded[2:], padded[3:]):
        knots = np.cumsum([0] + [np.sqrt(np.linalg.norm(b - a)) for a, b in ((p0, p1), (p1, p2), (p2, p3))])
        count = max(2, int(np.linalg.norm(p2 - p1) / step))
        t = np.linspace(knots[1], knots[2], count, endpoint=False)[:, None]

        def mix(a, b, i, j):
            return ((knots[j] - t) * a + (t - knots[i]) * b) / (knots[j] - knots[i])

        a1, a2, a3 = mix(p0, p1, 0, 1), mix(p1, p2, 1, 2), mix(p2, p3, 2, 3)
        pieces.append(mix(mix(a1, a2, 0, 2), mix(a2, a3, 1, 3), 1, 2))
    return np.vstack(pieces + [points[-1:]])


def profile():
    """The profile (radius, height) from the centre of the underside, up the outside, over the lip, down the inside."""
    underside = [(0, 0.32), (0.9, 0.3), (1.55, 0.15), (1.95, 0.0), (2.25, 0.03)]
    foot = [(2.45, 0.22), (2.43, 0.48), (2.2, 0.72), (1.82, 1.08)]
    body = [(1.48, 1.7), (1.55, 2.5), (2.1, 3.8), (2.95, 5.4), (3.42, 7.1), (3.4, 8.9), (3.14, 10.7), (3.14, 12.1)]
    rim = np.array((3.4, 12.95))
    outside = spline(underside + foot + body + [tuple(rim)])

    # The lip: half a circle that continues the outside's direction and turns inward.
    along = outside[-1] - outside[-5]
    along /= np.linalg.norm(along)
    inward = np.array((-along[1], along[0]))
    centre = rim + inward * WALL / 2
    turn = np.linspace(0, np.pi, 60)[1:, None]
    lip = centre + WALL / 2 * (np.sin(turn) * along - np.cos(turn) * inward)

    # The inside follows the outside at a wall that grows towards the base, then closes to a round bottom.
    body_part = outside[outside[:, 1] > 3.0]
    tangent = np.gradient(body_part, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    wall = WALL + 0.025 * (rim[1] - body_part[:, 1])[:, None]
    inner = (body_part + normal * wall)[::-1]
    picks = [inner[np.argmin(np.abs(inner[:, 1] - height))] for height in (12.85, 12.5, 11.9, 10.7, 9.3, 7.7, 6.3, 5.2)]
    inside = spline([lip[-1], *picks, (1.75, 4.3), (1.1, 3.66), (0.5, 3.42), (0, 3.36)])
    return np.vstack([outside, lip, inside[1:]])


def sample(curve, longest=0.72, turn=np.radians(22)):
    """Rows of the surface: points of `curve` at most `longest` apart that turn by at most about `turn` from one to the
    next, their spacing changing smoothly; with their arc lengths."""
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    even = np.linspace(0, length[-1], 4000)
    curve = np.stack([np.interp(even, length, curve[:, i]) for i in (0, 1)], axis=1)
    tangent = np.gradient(curve, even, axis=0)
    curvature = np.abs(np.gradient(np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0])), even))
    density = np.maximum(1 / longest, curvature / turn)
    # Dense also a little before and after a bend, and smoothly so: a spline through uneven steps wiggles.
    width = int(0.5 / (even[1] - even[0]))
    windows = np.lib.stride_tricks.sliding_window_view
    density = windows(np.pad(density, width // 2, mode="edge"), width // 2 * 2 + 1).max(axis=1)
    kernel = np.hanning(2 * width + 1)
    density = np.convolve(np.pad(density, width, mode="edge"), kernel / kernel.sum(), mode="valid")
    count = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2 * np.diff(even))])
    at = np.interp(np.linspace(0, count[-1], int(np.ceil(count[-1])) + 1), count, even)
    return np.stack([np.interp(at, even, curve[:, i]) for i in (0, 1)], axis=1), at


def cage(rows):
    """Control rows whose limit curve (a uniform cubic B-spline) passes through `rows`, and wider by what turning them
    in `COLUMNS` steps takes away."""
    matrix = np.eye(len(rows))
    for i in range(1, len(rows) - 1):
        matrix[i, i - 1 : i + 2] = np.array((1, 4, 1)) / 6
    control = np.linalg.solve(matrix, rows)
    control[:, 0] *= 6 / (4 + 2 * np.cos(2 * np.pi / COLUMNS))
    return control


def vase():
    """Face counts, vertex indices, points, texture coordinates and their indices."""
    rows, arc = sample(profile())
    control = cage(rows)
    inner_rows = control[1:-1]
    turn = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    points = [(r * c, y, -r * s) for r, y in inner_rows for c, s in ring]
    bottom, top = len(points), len(points) + 1
    points += [(0, control[0, 1], 0), (0, control[-1, 1], 0)]

    # u runs once around, in a column more than there are points; v is arc length in units of the mean circumference,
    # weighted by area as the renderer weighs it, so that u and v are about equally long.
    weights = rows[:, 0] * np.gradient(arc)
    circumference = 2 * np.pi * np.sum(rows[:, 0] * weights) / np.sum(weights)
    u = np.arange(COLUMNS + 1) / COLUMNS
    v = arc / circumference
    uvs = [(x, y) for y in v[1:-1] for x in u]
    bottom_uv = len(uvs)
    uvs += [((x0 + x1) / 2, y) for y in (v[0], v[-1]) for x0, x1 in zip(u, u[1:])]
    top_uv = bottom_uv + COLUMNS

    counts, indices, uv_indices = [], [], []

    def face(corners, uv_corners):
        counts.append(len(corners))
        indices.extend(corners)
        uv_indices.extend(uv_corners)

    width, last = COLUMNS + 1, len(inner_rows) - 1
    for j in range(COLUMNS):
        k = (j + 1) % COLUMNS
        face((bottom, k, j), (bottom_uv + j, j + 1, j))
        for i in range(last):
            face(
                (i * COLUMNS + j, i * COLUMNS + k, (i + 1) * COLUMNS + k, (i + 1) * COLUMNS + j),
                (i * width + j, i * width + j + 1, (i + 1) * width + j + 1, (i + 1) * width + j),
            )
        face(
            (last * COLUMNS + j, last * COLUMNS + k, top),
            (last * width + j, last * width + j + 1, top_uv + j),
        )
    return np.array(counts), np.array(indices), np.array(points), np.array(uvs), np.array(uv_indices)


def backdrop(half_width=90.0, front=45.0, back=-14.0, radius=75.0, rise=np.radians(42), slope=50.0, steps=28):
    """A floor that bends up smoothly and never as steep as the key light, so that the light fades along it and nothing
    throws a shadow: counts, indices, points and smooth normals."""
    bend = np.linspace(0, rise, steps + 1)
    section = [(front, 0.0, 0.0)]
    section += [(back - radius * np.sin(a), radius * (1 - np.cos(a)), a) for a in bend]
    section += [(section[-1][0] - slope * np.cos(rise), section[-1][1] + slope * np.sin(rise), rise)]
    points = [(x, y, z) for z, y, _ in section for x in (-half_width, half_width)]
    normals = [(0, np.cos(a), np.sin(a)) for _, _, a in section for _ in range(2)]
    faces = [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(section) - 1)]
    return np.full(len(faces), 4), np.array(faces).ravel(), np.array(points), np.array(normals)


def scene():
    counts, indices, points, uvs, uv_indices = vase()
    floor_counts, floor_indices, floor_points, floor_normals = backdrop()
    return f"""#usda 1.0
(
    doc = "A turned vase of marble, lit from behind. Written by make_hero.py. Centimetres."
    defaultPrim = "World"
    metersPerUnit = 0.01
    upAxis = "Y"
)

def Xform "World"
{{
    def Mesh "Vase" (
        prepend apiSchemas = ["StfShellAPI"]
    )
    {{
        float3[] extent = {usda.numbers([points.min(0), points.max(0)])}
        int[] faceVertexCounts = {usda.numbers(counts)}
        int[] faceVertexIndices = {usda.numbers(indices)}
        point3f[] points = {usda.numbers(points)}
        texCoord2f[] primvars:st = {usda.numbers(uvs)} (
            interpolation = "faceVarying"
        )
        int[] primvars:st:indices = {usda.numbers(uv_indices)}
        color3f[] primvars:displayColor = [(0.8, 0.78, 0.74)]
        uniform token subdivisionScheme = "catmullClark"

        asset primvars:stf:baseVolume = @./volumes/marble.vdb@ (
            interpolation = "constant"
        )
        token primvars:stf:mapping = "uv" (
            interpolation = "constant"
        )
        float primvars:stf:quality = 0.08 (
            doc = "Coarser than the default of 0.02, for a quick first picture."
            interpolation = "constant"
        )
        float primvars:stf:thickness = {SHELL} (
            doc = "The wall is {WALL} cm thick: a shell from either side fits, the sample is cropped to it."
            interpolation = "constant"
        )
        token primvars:stf:transport = "dE1" (
            interpolation = "constant"
        )
    }}

    def Mesh "Backdrop"
    {{
        float3[] extent = {usda.numbers([floor_points.min(0), floor_points.max(0)])}
        int[] faceVertexCounts = {usda.numbers(floor_counts)}
        int[] faceVertexIndices = {usda.numbers(floor_indices)}
        point3f[] points = {usda.numbers(floor_points)}
        normal3f[] normals = {usda.numbers(floor_normals)} (
            interpolation = "vertex"
        )
        color3f[] primvars:displayColor = [(0.2, 0.215, 0.24)]
        uniform token subdivisionScheme = "none"
    }}
{usda.distant_light("Key", (-0.92, 0.62, -0.22), 3.9, "(1, 0.82, 0.62)", 3)}{usda.dome_light("Sky", 0.5,
        "(0.78, 0.88, 1)")}{usda.camera((7, 20.5, 42), (0, 6.3, 0), 70, (24, 30), "(1, 1000)")}}}
"""


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).with_name("hero.usda")
    target.write_text(scene())
