#!/usr/bin/env python3
"""Writes meshes/soft_toy.obj: a sitting toy bear as one closed triangle mesh.

Body, head, snout, ears, arms and legs are ellipsoids whose distances are blended smoothly; the surface between inside
and outside is meshed by naive surface nets: one vertex for each cell of a grid that the surface passes through, one
quadrilateral for each edge of the grid that it crosses. Vertices are then moved onto the surface by Newton's method.

z points up, the bear looks along +x and sits on z = 0. Lengths in m. The result depends on nothing but this file.

usage: make_soft_toy.py [OUTPUT.obj]
"""
import os
import sys

import numpy as np

SPACING = 0.006         # of the grid, about the length of an edge
BLEND = 0.008           # width over which parts run into each other

# Centre and half axes of each part.
PARTS = [
    ([0.000, 0.000, 0.062], [0.045, 0.050, 0.060]),     # body
    ([0.008, 0.000, 0.142], [0.040, 0.044, 0.038]),     # head
    ([0.045, 0.000, 0.132], [0.020, 0.020, 0.016]),     # snout
    ([0.000, 0.034, 0.176], [0.010, 0.017, 0.017]),     # ears
    ([0.000, -0.034, 0.176], [0.010, 0.017, 0.017]),
    ([0.022, 0.058, 0.078], [0.040, 0.018, 0.018]),     # arms
    ([0.022, -0.058, 0.078], [0.040, 0.018, 0.018]),
    ([0.055, 0.040, 0.022], [0.045, 0.021, 0.021]),     # legs
    ([0.055, -0.040, 0.022], [0.045, 0.021, 0.021]),
]


def field(points):
    """Smooth distance-like function of points (n x 3), m: negative inside."""
    values = []
    for centre, half in PARTS:
        q = (points - np.array(centre)) / np.array(half)
        length = np.linalg.norm(q, axis=1)
        # Of first order exact at the surface: (|q| - 1) / |gradient of |q||.
        slope = np.linalg.norm(q / np.array(half), axis=1) / np.maximum(length, 1e-9)
        values.append((length - 1.0) / np.maximum(slope, 1e-9))
    values = np.array(values)
    lowest = values.min(axis=0)
    return lowest - BLEND * np.log(np.exp(-(values - lowest) / BLEND).sum(axis=0))


def gradient(points, step=1e-6):
    columns = []
    for axis in range(3):
        shift = np.zeros(3)
        shift[axis] = step
        columns.append((field(points + shift) - field(points - shift)) / (2 * step))
    return np.array(columns).T


def surface_net():
    low = np.array([-0.075, -0.105, -0.03])
    count = np.ceil((np.array([0.125, 0.105, 0.22]) - low) / SPACING).astype(int)
    axes = [low[k] + SPACING * np.arange(count[k] + 1) for k in range(3)]
    grid = np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1)
    inside = field(grid.reshape(-1, 3)).reshape(grid.shape[:3]) < 0

    corners = sum(inside[i:i + count[0], j:j + count[1], k:k + count[2]].astype(int)
                  for i in (0, 1) for j in (0, 1) for k in (0, 1))
    cells = np.argwhere((corners > 0) & (corners < 8))
    index = {tuple(cell): n for n, cell in enumerate(cells)}
    vertices = low + SPACING * (cells + 0.5)

    quads = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        here = [slice(None)] * 3
        there = [slice(None)] * 3
        here[axis], there[axis] = slice(None, -1), slice(1, None)
        first = inside[tuple(here)]
        for node in np.argwhere(first != inside[tuple(there)]):
            around = []
            for du, dv in ((0, 0), (-1, 0), (-1, -1), (0, -1)):
                cell = node.copy()
                cell[u] += du
                cell[v] += dv
                around.append(index[tuple(cell)])
            # Counter-clockwise seen from outside: along +axis when the first node is inside.
            quads.append(around if first[tuple(node)] else around[::-1])
    return vertices, quads


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    path = sys.argv[1] if len(sys.argv) > 1 else os.path.join(here, '..', 'meshes', 'soft_toy.obj')
    vertices, quads = surface_net()
    for _ in range(8):
        slope = gradient(vertices)
        vertices -= (field(vertices) / (slope ** 2).sum(axis=1))[:, None] * slope
        # Evens out the net along the surface before the next step back onto it.
        neighbours = [[] for _ in vertices]
        for quad in quads:
            for k in range(4):
                neighbours[quad[k]].append(quad[(k + 1) % 4])
        mean = np.array([vertices[near].mean(axis=0) for near in neighbours])
        normal = slope / np.linalg.norm(slope, axis=1)[:, None]
        move = mean - vertices
        vertices += 0.5 * (move - (move * normal).sum(axis=1)[:, None] * normal)
    slope = gradient(vertices)
    vertices -= (field(vertices) / (slope ** 2).sum(axis=1))[:, None] * slope
    vertices[:, 2] -= vertices[:, 2].min()

    faces = []
    for a, b, c, d in quads:
        if np.linalg.norm(vertices[a] - vertices[c]) <= np.linalg.norm(vertices[b] - vertices[d]):
            faces += [(a, b, c), (a, c, d)]
        else:
            faces += [(a, b, d), (b, c, d)]
    edges = {tuple(sorted((f[k], f[(k + 1) % 3]))) for f in faces for k in range(3)}
    assert len(vertices) - len(edges) + len(faces) == 2, 'the surface is not a sphere'
    with open(path, 'w') as out:
        out.write('# Toy bear, m. Generated by scripts/make_soft_toy.py\no soft_toy\n')
        for p in vertices:
            out.write('v %.5f %.5f %.5f\n' % tuple(p))
        for f in faces:
            out.write('f %d %d %d\n' % tuple(k + 1 for k in f))
    print('%s: %d vertices, %d faces' % (os.path.normpath(path), len(vertices), len(faces)))


if __name__ == '__main__':
    main()
