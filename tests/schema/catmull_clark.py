"""Catmull-Clark subdivision of closed meshes (numpy), enough to check what surface an example's cage stands for."""

import numpy as np


def subdivide(counts, indices, points):
    """One step on a closed mesh. Returns (counts, indices, points) of quads."""
    counts, indices, points = np.asarray(counts), np.asarray(indices), np.asarray(points, float)
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    face_of = np.repeat(np.arange(len(counts)), counts)
    local = np.arange(len(indices)) - starts[face_of]
    following = indices[starts[face_of] + (local + 1) % counts[face_of]]

    face_points = np.add.reduceat(points[indices], starts) / counts[:, None]
    pairs = np.sort(np.stack([indices, following], axis=1), axis=1)
    edges, edge_of = np.unique(pairs, axis=0, return_inverse=True)
    edge_of = edge_of.ravel()
    adjacent = np.zeros((len(edges), 3))
    np.add.at(adjacent, edge_of, face_points[face_of])
    uses = np.bincount(edge_of)
    if np.any(uses != 2):
        raise ValueError("the mesh is not closed")
    ends = points[edges].sum(axis=1)
    edge_points = (ends + adjacent) / 4

    valence = np.bincount(indices, minlength=len(points))[:, None]
    faces_sum, middles_sum = np.zeros_like(points), np.zeros_like(points)
    np.add.at(faces_sum, indices, face_points[face_of])
    for side in (0, 1):
        np.add.at(middles_sum, edges[:, side], ends / 2)
    vertex_points = (faces_sum / valence + 2 * middles_sum / valence + (valence - 3) * points) / valence

    first_face, first_edge = len(points), len(points) + len(face_points)
    previous_edge = edge_of[starts[face_of] + (local - 1) % counts[face_of]]
    quads = np.stack([indices, first_edge + edge_of, first_face + face_of, first_edge + previous_edge], axis=1)
    return np.full(len(quads), 4), quads.ravel(), np.vstack([vertex_points, face_points, edge_points])


def limit(counts, indices, points):
    """Limit positions of the vertices of a closed quad mesh."""
    if np.any(np.asarray(counts) != 4):
        raise ValueError("subdivide once first")
    quads = np.asarray(indices).reshape(-1, 4)
    valence = np.bincount(quads.ravel(), minlength=len(points))[:, None]
    edges, diagonals = np.zeros_like(points), np.zeros_like(points)
    for corner in range(4):
        np.add.at(edges, quads[:, corner], points[quads[:, (corner + 1) % 4]])
        np.add.at(diagonals, quads[:, corner], points[quads[:, (corner + 2) % 4]])
    return (valence**2 * points + 4 * edges + diagonals) / (valence * (valence + 5))


def volume(counts, indices, points):
    """Signed volume: positive where faces turn counter-clockwise seen from outside."""
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    total = 0.0
    for start, count in zip(starts, counts):
        corners = points[np.asarray(indices[start : start + count])]
        for b, c in zip(corners[1:], corners[2:]):
            total += np.dot(corners[0], np.cross(b, c)) / 6
    return total
