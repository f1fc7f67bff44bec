"""Writes small XDMF files as the program does, with every kind of field, for tests of what reads
them."""
import os

import h5py
import numpy as np

CUBE_TETRAHEDRA = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]
EDGES = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]]  # midpoints 4 ... 9, in VTK's order
TYPES = {3: "Triangle", 4: "Tetrahedron", 6: "Triangle_6", 10: "Tetrahedron_10"}
KINDS = {1: "Scalar", 3: "Vector", 6: "Tensor6", 9: "Tensor"}


def box(nx, ny, nz):
    """Points and tetrahedra of a bar nx x ny x nz."""
    axes = np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), np.arange(nz + 1), indexing="ij")
    points = np.stack([each.ravel() for each in axes], axis=1).astype(float)
    number = np.arange(len(points)).reshape(nx + 1, ny + 1, nz + 1)
    corners = np.stack([number[x:x + nx, y:y + ny, z:z + nz].ravel()
                        for x in (0, 1) for y in (0, 1) for z in (0, 1)], axis=1)
    return points, corners[:, np.array(CUBE_TETRAHEDRA)].reshape(-1, 4)


def square(n):
    """Points (z = 0) and triangles of a square of n x n cells."""
    axes = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
    points = np.stack([axes[0].ravel(), axes[1].ravel(), np.zeros((n + 1) ** 2)], axis=1).astype(float)
    number = np.arange(len(points)).reshape(n + 1, n + 1)
    a, b, c, d = (number[x:x + n, y:y + n].ravel() for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)))
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def quadratic(points, cells):
    """The same body with a node at the middle of every edge."""
    edges = np.array(EDGES[:3] if cells.shape[1] == 3 else EDGES)
    ends = np.sort(cells[:, edges].reshape(-1, 2), axis=1)
    unique, which = np.unique(ends, axis=0, return_inverse=True)
    middles = len(points) + which.reshape(len(cells), len(edges))
    return np.concatenate([points, points[unique].mean(axis=1)]), np.concatenate([cells, middles], 1)


def write(path, points, cells, steps):
    """`steps`: pairs of t and fields by name, each (whether on vertices, values); what follows a | in
    a name only tells two of the name apart. One step without t makes a file without a series."""
    name = os.path.splitext(os.path.basename(path))[0] + ".h5"
    with h5py.File(os.path.join(os.path.dirname(path), name), "w") as data:
        data["points"], data["cells"] = points, cells
        grids = [_grid(data, name, number, *step) for number, step in enumerate(steps)]
    series = len(steps) > 1 or steps[0][0] is not None
    with open(path, "w", encoding="utf-8") as file:
        file.write('<?xml version="1.0" encoding="UTF-8"?>\n<Xdmf Version="3.0"><Domain>\n'
                   + ('<Grid Name="steps" GridType="Collection" CollectionType="Temporal">\n' * series)
                   + "\n".join(grids) + "</Grid>" * series + "</Domain></Xdmf>\n")


def _grid(data, file, number, t, fields):
    points, cells = data["points"], data["cells"]
    time = "" if t is None else f'<Time Value="{t!r}"/>'
    text = (f'<Grid Name="body" GridType="Uniform">{time}'
            f'<Topology TopologyType="{TYPES[cells.shape[1]]}" NumberOfElements="{len(cells)}">'
            f"{_item(file, '/cells', cells)}</Topology>"
            f'<Geometry GeometryType="XYZ">{_item(file, "/points", points)}</Geometry>')
    for key, (on_vertices, values) in fields.items():
        name = key.split("|")[0]
        values = np.asarray(values, dtype=float)
        dataset = f"/step{number}/{'vertex' if on_vertices else 'cell'}_fields/{name}"
        data[dataset] = values
        kind = KINDS[1 if values.ndim == 1 else values.shape[1]]
        text += (f'<Attribute Name="{name}" AttributeType="{kind}" '
                 f'Center="{"Node" if on_vertices else "Cell"}">'
                 f"{_item(file, dataset, values)}</Attribute>")
    return text + "</Grid>"


def _item(file, dataset, values):
    kind = "Int" if np.issubdtype(values.dtype, np.integer) else "Float"
    return (f'<DataItem Format="HDF" NumberType="{kind}" Precision="8" '
            f'Dimensions="{" ".join(map(str, values.shape))}">{file}:{dataset}</DataItem>')


def bent_bar(path, count=5, order=2, n=(12, 3, 3)):
    """A bar of two regions that bends in `count` steps, with every kind of field; some cells are
    inverted in the last step. Returns the number of these."""
    points, cells = box(*n)
    if order == 2:
        points, cells = quadratic(points, cells)
    middle = points[cells[:, :4]].mean(axis=1)
    steps = []
    for number in range(1, count + 1):
        t = number / count
        x, y, z = points.T
        angle = 1.2 * t * x / n[0]
        radius = n[0] / (1.2 * t)
        moved = np.stack([(radius - z) * np.sin(angle), y, radius - (radius - z) * np.cos(angle)], axis=1)
        determinant = 1 + 0.3 * t * (middle[:, 2] / n[2] - 0.5)
        if number == count:
            determinant[(abs(middle[:, 0] - 4) < 0.4) & (middle[:, 2] > 2.2)] = -0.1
        stress = np.stack([middle[:, k % 3] * (k + 1) * t for k in range(6)], axis=1)
        steps.append((t, {
            "displacement": (True, moved - points), "reaction": (True, points * t),
            "von_mises": (False, np.abs(middle[:, 2] - n[2] / 2) * 1e6 * t),
            "von_mises|": (True, np.abs(points[:, 2] - n[2] / 2) * 1e6 * t),
            "cauchy_stress": (False, stress), "first_piola": (False, np.tile(stress, 2)[:, :9]),
            "principal_stretches": (True, 1 + 0.1 * t * points),
            "determinant_F": (False, determinant), "region": (False, (middle[:, 0] > 6) + 1)}))
    write(path, points, cells, steps)
    return int((determinant <= 0).sum())
