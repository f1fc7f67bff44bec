#!/usr/bin/env python3
"""A rope with a loose overhand knot, for knot_tight.yaml.

    python3 overhand_knot.py [overhand_knot.mesh]

A round rope about a trefoil that is open below, whose ends turn to the left and to the right; six
tetrahedra a cell, a Medit file. Debian: python3-numpy"""
import sys

import numpy as np

RADIUS = 0.4
OPENING = 0.6  # of the trefoil's parameter, to either side of where it is open
BEND, STRAIGHT = 1, 3  # of the ends: the radius of their quarter turn, what follows it
CORNERS = [(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
SPLIT = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]


def end(point, tangent, outwards):
    """From a point on: a quarter turn, and straight on outwards."""
    normal = outwards - np.dot(outwards, tangent) * tangent
    normal /= np.linalg.norm(normal)
    angle = np.linspace(0, np.pi / 2, 200)[1:, None]
    turn = point + BEND * (np.sin(angle) * tangent + (1 - np.cos(angle)) * normal)
    return np.concatenate([turn, turn[-1] + np.linspace(0, STRAIGHT, 200)[1:, None] * normal])


def axis(cells):
    """Points at equal distances along the curve, and two normals at each that do not twist."""
    t = np.linspace(OPENING - np.pi, np.pi - OPENING, 4001)
    curve = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)],
                     axis=1)
    tangents = [(curve[0] - curve[1]), (curve[-1] - curve[-2])]
    first, last = (end(point, tangent / np.linalg.norm(tangent), np.array([side, 0, 0]))
                   for point, tangent, side in zip(curve[[0, -1]], tangents, (1, -1)))
    curve = np.concatenate([first[::-1], curve, last])
    length = np.append(0, np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1)))
    at = np.linspace(0, length[-1], cells + 1)
    points = np.stack([np.interp(at, length, component) for component in curve.T], axis=1)
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    normal, frames = np.array([1.0, 0, 0]), []
    for tangent in tangents:  # what is left of the normal before, across the curve
        normal = normal - np.dot(normal, tangent) * tangent
        normal /= np.linalg.norm(normal)
        frames.append((normal, np.cross(tangent, normal)))
    return points, frames


def disc(i, j, cells):
    """A square's grid on the unit disc."""
    a, b = 2 * i / cells - 1, 2 * j / cells - 1
    return a * np.sqrt(1 - b * b / 2), b * np.sqrt(1 - a * a / 2)


def write(path, across=4, along=120):
    """So many cells."""
    side = across + 1
    points = [centre + RADIUS * (a * first + b * second)
              for centre, (first, second) in zip(*axis(along))
              for a, b in (disc(i, j, across) for j in range(side) for i in range(side))]
    number = lambda i, j, k: 1 + i + side * (j + side * k)
    cells = [[number(i + di, j + dj, k + dk) for di, dj, dk in (CORNERS[c] for c in cell)]
             for k in range(along) for j in range(across) for i in range(across) for cell in SPLIT]
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        file.writelines("%.16g %.16g %.16g 0\n" % tuple(point) for point in points)
        file.write(f"Tetrahedra\n{len(cells)}\n")
        file.writelines(" ".join(map(str, cell)) + " 0\n" for cell in cells)
        file.write("End\n")


if __name__ == "__main__":
    write(sys.argv[1] if len(sys.argv) > 1 else "overhand_knot.mesh")
