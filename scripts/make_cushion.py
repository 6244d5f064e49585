#!/usr/bin/env python3
"""Writes meshes/cushion.obj: a square cushion, two panels of cloth welded along their borders, almost flat.

The surface is closed, counter-clockwise seen from outside; panels bulge by GAP, so that they do not coincide. Lengths in m.

usage: make_cushion.py [OUTPUT.obj]
"""
import os
import sys

SIZE = 0.4
CELLS = 20
GAP = 0.004


def main():
    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    path = sys.argv[1] if len(sys.argv) > 1 else os.path.join(root, 'meshes/cushion.obj')
    nodes, number, faces = [], {}, []
    for side in (1, -1):
        for row in range(CELLS + 1):
            for column in range(CELLS + 1):
                border = row in (0, CELLS) or column in (0, CELLS)
                if border and side < 0:
                    number[side, row, column] = number[1, row, column]
                    continue
                number[side, row, column] = len(nodes) + 1
                x, y = (SIZE * (k / CELLS - 0.5) for k in (column, row))
                bulge = 4 * row * (CELLS - row) / CELLS**2 * 4 * column * (CELLS - column) / CELLS**2
                nodes.append((x, y, 0.5 * side * GAP * bulge))
        for row in range(CELLS):
            for column in range(CELLS):
                a, b = number[side, row, column], number[side, row, column + 1]
                d, e = number[side, row + 1, column], number[side, row + 1, column + 1]
                # Diagonals alternate; at corners no triangle lies on two borders.
                for face in ((a, b, e), (a, e, d)) if (row + column) % 2 == 0 else ((a, b, d), (b, e, d)):
                    faces.append(face if side > 0 else face[::-1])
    with open(path, 'w', encoding='utf-8') as stream:
        stream.write('# A square cushion, two panels welded along their borders (scripts/make_cushion.py). Metres.\n')
        stream.writelines('v %.6f %.6f %.6f\n' % node for node in nodes)
        stream.writelines('f %d %d %d\n' % face for face in faces)


if __name__ == '__main__':
    main()
