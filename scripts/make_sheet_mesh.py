#!/usr/bin/env python3
"""Writes a square sheet of 1 m x 1 m as a triangle mesh that is no grid: what a garment's mesh is like, for studies.

SIDE x SIDE nodes, those inside moved by up to JITTER of a cell, joined by the Delaunay triangulation of the points, and
numbered at random, as files from other programs are. The sheet lies in the x-y plane, its middle at the origin. The
result depends on nothing but the arguments; the corners (-0.5, 0.5) and (0.5, 0.5) are printed by their numbers.

usage: make_sheet_mesh.py SIDE OUTPUT.obj [JITTER]
"""
import random
import sys


def points_of(side, jitter, rng):
    cell = 1.0 / (side - 1)
    points = []
    for row in range(side):
        for column in range(side):
            inside_x, inside_y = 0 < column < side - 1, 0 < row < side - 1
            x = -0.5 + cell * (column + (jitter * rng.uniform(-1, 1) if inside_x else 0.0))
            y = -0.5 + cell * (row + (jitter * rng.uniform(-1, 1) if inside_y else 0.0))
            points.append((x, y))
    return points


def in_circle(a, b, c, d):
    """> 0 where d lies inside the circle through a, b, c, which run counterclockwise."""
    rows = [(p[0] - d[0], p[1] - d[1]) for p in (a, b, c)]
    squares = [x * x + y * y for x, y in rows]
    return (squares[0] * (rows[1][0] * rows[2][1] - rows[2][0] * rows[1][1])
            - squares[1] * (rows[0][0] * rows[2][1] - rows[2][0] * rows[0][1])
            + squares[2] * (rows[0][0] * rows[1][1] - rows[1][0] * rows[0][1]))


def turns_left(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0


def delaunay(side, points):
    """Cells cut in two, then edges flipped until no circle holds a neighbour's point [Lawson 1977]."""
    across = {}  # directed edge -> the third corner of the triangle that it runs along

    def add(a, b, c):
        across[a, b], across[b, c], across[c, a] = c, a, b

    for row in range(side - 1):
        for column in range(side - 1):
            a = row * side + column
            b, c, d = a + 1, a + side + 1, a + side
            if turns_left(points[a], points[b], points[c]) and turns_left(points[a], points[c], points[d]):
                add(a, b, c)
                add(a, c, d)
            else:
                add(a, b, d)
                add(b, c, d)
    waiting = sorted(across)
    while waiting:
        a, b = waiting.pop()
        c, d = across.get((a, b)), across.get((b, a))
        if c is None or d is None:
            continue
        if in_circle(points[a], points[b], points[c], points[d]) <= 1e-14:
            continue
        del across[a, b], across[b, a]
        add(a, d, c)
        add(d, b, c)
        waiting += [(a, d), (d, b), (b, c), (c, a)]
    return sorted({min((a, b, c), (b, c, a), (c, a, b)) for (a, b), c in across.items()})


def main():
    side, path = int(sys.argv[1]), sys.argv[2]
    jitter = float(sys.argv[3]) if len(sys.argv) > 3 else 0.3
    rng = random.Random(side)
    points = points_of(side, jitter, rng)
    triangles = delaunay(side, points)
    order = list(range(len(points)))
    rng.shuffle(order)
    number = {old: new for new, old in enumerate(order)}
    # Nodes are numbered as faces first name them.
    rng.shuffle(triangles)
    loaded = {}
    for triangle in triangles:
        for node in triangle:
            loaded.setdefault(node, len(loaded))
    with open(path, "w", encoding="utf-8") as file:
        for old in order:
            file.write("v %.9g %.9g 0\n" % points[old])
        for triangle in triangles:
            file.write("f %d %d %d\n" % tuple(number[node] + 1 for node in triangle))
    print(loaded[side * (side - 1)], loaded[side * side - 1])


if __name__ == "__main__":
    main()
