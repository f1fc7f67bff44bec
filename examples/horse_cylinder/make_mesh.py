#!/usr/bin/env python3
"""A stand-in for the paper's horse and cylinder: a saddle and, above it, a cylinder across.

    python3 make_mesh.py [saddle_cylinder.mesh]

Both are blocks of a regular grid, bent, six tetrahedra a cell; a Medit file."""
import math
import sys

CORNERS = [(i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
SPLIT = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]


def block(counts, place):
    """Points and tetrahedra of a grid of cells; `place` takes coordinates from 0 to 1."""
    nx, ny, nz = counts
    number = lambda i, j, k: i + (nx + 1) * (j + (ny + 1) * k)
    points = [place(i / nx, j / ny, k / nz)
              for k in range(nz + 1) for j in range(ny + 1) for i in range(nx + 1)]
    cells = [[number(i + di, j + dj, k + dk) for di, dj, dk in (CORNERS[c] for c in cell)]
             for k in range(nz) for j in range(ny) for i in range(nx) for cell in SPLIT]
    return points, cells


def saddle(x, y, z):
    """A back of length 2 and width 0.8, hollow along it and round across."""
    X, Y = 2 * x - 1, 0.8 * (y - 0.5)
    return X, Y, -0.6 * (1 - z) + z * (0.35 * X * X - 0.5 * Y * Y)


def cylinder(x, y, z):
    """Radius 0.25 about the y axis, length 1.6, its lowest line 0.05 above the saddle."""
    a, b = 2 * x - 1, 2 * z - 1
    a, b = a * math.sqrt(1 - b * b / 2), b * math.sqrt(1 - a * a / 2)  # a square to a disc
    return 0.25 * a, 1.6 * (y - 0.5), 0.3 + 0.25 * b


def write(path):
    points, cells = [], []
    for counts, place in (((20, 8, 5), saddle), ((6, 20, 6), cylinder)):
        new_points, new_cells = block(counts, place)
        cells += [[corner + len(points) for corner in cell] for cell in new_cells]
        points += new_points
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        file.writelines("%.17g %.17g %.17g 0\n" % point for point in points)
        file.write(f"Tetrahedra\n{len(cells)}\n")
        file.writelines("%d %d %d %d 0\n" % tuple(c + 1 for c in cell) for cell in cells)
        file.write("End\n")


if __name__ == "__main__":
    write(sys.argv[1] if len(sys.argv) > 1 else "saddle_cylinder.mesh")
