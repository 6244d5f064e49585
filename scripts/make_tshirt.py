#!/usr/bin/env python3
"""Writes meshes/tshirt.obj: a T-shirt as one welded triangle mesh.

Two panels, front and back, each a torso and two short sleeves. They share the nodes of their seams: sides, undersides
and tops of the sleeves, shoulders. What is left open are the four holes of a shirt: neck, hem and two cuffs. The
surface is a sphere with four holes, so vertices - edges + faces = 2 - 4 = -2.

The shirt lies flat in the x-y plane, hem towards -y, front towards +z. The panels bulge up to GAP apart, so that the
layers do not coincide. Lengths in m. The result depends on nothing but this file.

usage: make_tshirt.py [OUTPUT.obj]
"""
import os
import sys

import numpy as np

LENGTH = 0.68           # hem to shoulder at the neck
HALF_HEM = 0.26         # half width at the hem
HALF_CHEST = 0.25       # half width at the underarm
HALF_SHOULDER = 0.215   # x of the shoulder point
HALF_NECK = 0.085       # half width of the neck opening
UNDERARM = 0.43         # y of the underarm
SHOULDER = 0.64         # y of the shoulder point
FRONT_NECK_DEPTH = 0.080
BACK_NECK_DEPTH = 0.02
CUFF_BOTTOM = np.array([0.365, 0.385])
CUFF_TOP = np.array([0.415, 0.545])
GAP = 0.010             # between the panels, away from the seams
SEAM_FALLOFF = 0.04     # distance from a seam at which the gap is nearly reached

COLUMNS = 26            # cells across the torso
NECK_COLUMNS = 10       # of them under the neck opening
LOWER_ROWS = 21         # cells from hem to underarm
UPPER_ROWS = 11         # cells from underarm to shoulder
SLEEVE_COLUMNS = 8      # cells along a sleeve


def torso_sections():
    """Fractions -1..1 across the torso, so that a line of nodes runs to each side of the neck."""
    side = (COLUMNS - NECK_COLUMNS) // 2
    neck = HALF_NECK / HALF_SHOULDER
    left = np.linspace(-1.0, -neck, side + 1)
    middle = np.linspace(-neck, neck, NECK_COLUMNS + 1)
    return np.concatenate([left, middle[1:-1], -left[::-1]])


def top_edge(section, neck_depth):
    """y of the upper edge of a panel: the shoulder seams, or the neck line between them."""
    x = abs(section) * HALF_SHOULDER
    if x > HALF_NECK - 1e-12:
        along = (x - HALF_NECK) / (HALF_SHOULDER - HALF_NECK)
        return LENGTH + along * (SHOULDER - LENGTH)
    return LENGTH - neck_depth * np.cos(0.5 * np.pi * x / HALF_NECK) ** 2


def half_width(y):
    if y <= UNDERARM:
        return HALF_HEM + (HALF_CHEST - HALF_HEM) * y / UNDERARM
    return HALF_CHEST + (HALF_SHOULDER - HALF_CHEST) * (y - UNDERARM) / (SHOULDER - UNDERARM)


def torso_grid(neck_depth):
    """Rows x columns x 2. Rows meet the sleeves at the sides at the same heights, whatever the neck line."""
    sections = torso_sections()
    side_y = np.concatenate([np.linspace(0.0, UNDERARM, LOWER_ROWS + 1),
                             np.linspace(UNDERARM, SHOULDER, UPPER_ROWS + 1)[1:]])
    grid = np.zeros((side_y.size, sections.size, 2))
    for j, section in enumerate(sections):
        stretch = top_edge(section, neck_depth) / SHOULDER
        for i, y in enumerate(side_y):
            # The hem half of a panel is the same on both sides; only the upper half bends to the shoulder or neck line.
            blend = (y / SHOULDER) ** 2
            grid[i, j] = section * half_width(y), y * (1.0 - blend + blend * stretch)
    return grid


def sleeve_grid(armhole):
    """Rows x columns x 2 from an armhole (rows x 2, right side) to the cuff."""
    rows = armhole.shape[0]
    cuff = CUFF_BOTTOM + np.linspace(0.0, 1.0, rows)[:, None] * (CUFF_TOP - CUFF_BOTTOM)
    along = np.linspace(0.0, 1.0, SLEEVE_COLUMNS + 1)[None, :, None]
    return armhole[:, None, :] * (1.0 - along) + cuff[:, None, :] * along


class Shirt:
    """Collects nodes and faces; a node on a seam belongs to both panels."""

    def __init__(self):
        self.points = []
        self.side = []       # +1 front, -1 back, 0 seam
        self.faces = []

    def node(self, xy, side):
        self.points.append((xy[0], xy[1]))
        self.side.append(side)
        return len(self.points) - 1

    def add_cells(self, ids, side):
        for i in range(ids.shape[0] - 1):
            for j in range(ids.shape[1] - 1):
                a, b, c, d = ids[i, j], ids[i, j + 1], ids[i + 1, j + 1], ids[i + 1, j]
                cut = [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
                # Outward: counter-clockwise seen from the panel's own side.
                self.faces += cut if side > 0 else [(p, r, q) for p, q, r in cut]


def torso_seam(i, j):
    """Whether node (i, j) of the torso lies on a seam between the panels."""
    side_seam = j in (0, COLUMNS) and i <= LOWER_ROWS
    neck_columns = (COLUMNS - NECK_COLUMNS) // 2
    shoulder_seam = i == LOWER_ROWS + UPPER_ROWS and not neck_columns < j < COLUMNS - neck_columns
    return side_seam or shoulder_seam


def build():
    shirt = Shirt()
    seams = {}

    def placed(key, seam, xy, side):
        if not seam:
            return shirt.node(xy, side)
        if key not in seams:
            seams[key] = shirt.node(xy, 0)
        return seams[key]

    for side, depth in ((1, FRONT_NECK_DEPTH), (-1, BACK_NECK_DEPTH)):
        torso = torso_grid(depth)
        rows, columns = torso.shape[:2]
        ids = np.array([[placed(("torso", i, j), torso_seam(i, j), torso[i, j], side) for j in range(columns)]
                        for i in range(rows)])
        shirt.add_cells(ids, side)
        for hand in (1, -1):
            j_side = columns - 1 if hand > 0 else 0
            sleeve = sleeve_grid(torso[LOWER_ROWS:, columns - 1])
            sleeve_ids = np.zeros(sleeve.shape[:2], dtype=int)
            sleeve_ids[:, 0] = ids[LOWER_ROWS:, j_side]
            for i in range(sleeve.shape[0]):
                seam = i in (0, sleeve.shape[0] - 1)
                for j in range(1, sleeve.shape[1]):
                    sleeve_ids[i, j] = placed(("sleeve", hand, i, j), seam, sleeve[i, j] * (hand, 1.0), side)
            shirt.add_cells(sleeve_ids if hand > 0 else sleeve_ids[:, ::-1], side)
    return shirt


def heights(shirt):
    """z of every node: zero on the seams, rising to half the gap away from them."""
    points = np.array(shirt.points)
    side = np.array(shirt.side)
    on_seam = points[side == 0]
    distance = np.sqrt(((points[:, None, :] - on_seam[None, :, :]) ** 2).sum(axis=2)).min(axis=1)
    return side * 0.5 * GAP * (1.0 - np.exp(-((distance / SEAM_FALLOFF) ** 2)))


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    path = sys.argv[1] if len(sys.argv) > 1 else os.path.join(here, "..", "meshes", "tshirt.obj")
    shirt = build()
    z = heights(shirt)
    points = np.array(shirt.points)
    middle = 0.5 * LENGTH
    with open(path, "w", encoding="ascii") as out:
        out.write("# T-shirt, m. Generated by scripts/make_tshirt.py\no tshirt\n")
        for (x, y), height in zip(points, z):
            # Rounded to 1 um: more would show the last bit of the machine's mathematics.
            line = "v {:.6f} {:.6f} {:.6f}\n".format(x, y - middle, height)
            out.write(line.replace("-0.000000", "0.000000"))
        for a, b, c in shirt.faces:
            out.write("f {} {} {}\n".format(a + 1, b + 1, c + 1))


if __name__ == "__main__":
    main()
