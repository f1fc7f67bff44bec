"""Meshes that are hard to compute on, as Medit files."""
import numpy

# A cube's corners, numbered x + 2 y + 4 z, cut into five tetrahedra: one with no edge of the cube,
# and four corners. Cubes of the other parity take its mirror image, so that faces agree; with an
# even number of cubes along an axis the mesh is its own mirror image.
EVEN = ((0, 3, 5, 6), (1, 0, 3, 5), (2, 0, 6, 3), (4, 0, 5, 6), (7, 3, 6, 5))
ODD = tuple(tuple(corner ^ 1 for corner in tetrahedron) for tetrahedron in EVEN)


def grid(path, x, y, z):
    """Writes the tetrahedra of a grid with these coordinates along its axes; returns its volume."""
    x, y, z = (numpy.asarray(axis, float) for axis in (x, y, z))
    points = numpy.stack(numpy.meshgrid(x, y, z, indexing="ij"), -1).reshape(-1, 3)
    number = numpy.arange(len(points)).reshape(len(x), len(y), len(z))
    tetrahedra = []
    for i in range(len(x) - 1):
        for j in range(len(y) - 1):
            for k in range(len(z) - 1):
                cube = [number[i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)] for c in range(8)]
                for tetrahedron in ODD if (i + j + k) % 2 else EVEN:
                    tetrahedra.append([cube[c] for c in tetrahedron])
    tetrahedra = numpy.array(tetrahedra)
    corner = points[tetrahedra]
    edges = corner[:, 1:] - corner[:, :1]
    turned = numpy.linalg.det(edges) < 0
    tetrahedra[turned] = tetrahedra[turned][:, [1, 0, 2, 3]]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(points)}\n")
        file.writelines(f"{p[0]!r} {p[1]!r} {p[2]!r} 0\n" for p in points.tolist())
        file.write(f"Tetrahedra\n{len(tetrahedra)}\n")
        file.writelines(" ".join(str(v + 1) for v in t) + " 0\n" for t in tetrahedra.tolist())
        file.write("End\n")
    return float(abs(numpy.linalg.det(edges)).sum() / 6)


def steps(length, count):
    return numpy.linspace(0, length, count + 1)


def cube(path, size=1.0):
    return grid(path, *(steps(size, 4),) * 3)


def bar(path):
    """2 x 1 x 1."""
    return grid(path, steps(2, 16), steps(1, 8), steps(1, 8))


def beam(path):
    """100 x 1 x 1 along z."""
    return grid(path, steps(1, 2), steps(1, 2), steps(100, 100))


def column(path):
    """1 x 1 x 16 along z, its own mirror image in x and in y."""
    return grid(path, steps(1, 4), steps(1, 4), steps(16, 64))


def slivers(path):
    """A unit cube with a layer of height 1e-4, in which every fifth tetrahedron is a sliver."""
    return grid(path, steps(1, 5), steps(1, 5), [0, 0.25, 0.5, 0.5 + 1e-4, 0.75, 1])


def graded(path):
    """A unit cube with edges from 1e-5 to 0.7 towards one corner."""
    axis = numpy.concatenate([[0], numpy.geomspace(1e-5, 1, 10)])
    return grid(path, axis, axis, axis)
