"""The surface of a body of tetrahedra or triangles, for pictures; needs numpy."""

import numpy as np

# Local nodes of the faces of a tetrahedron, anticlockwise seen from outside where its volume is
# positive: three corners, then (of 10 nodes) the midpoints of the edges that follow them.
FACES = np.array([[1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6], [0, 1, 3, 4, 8, 7], [0, 2, 1, 6, 5, 4]])
# A face of 6 nodes is drawn as four triangles, of whose sides (corner k to k + 1) these are edges.
QUARTERS = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])
QUARTER_EDGES = np.array([[1, 0, 1], [1, 1, 0], [0, 1, 1], [0, 0, 0]], dtype=bool)


class Surface:
    """Triangles (n x 3, numbers of points), anticlockwise seen from outside (of a flat body: from
    above); `cells` (n), whose they are; `is_edge` (n x 3), whether the side from corner k to k + 1 is
    an edge of a cell and not just a line within a face of six nodes."""

    def __init__(self, points, cells, groups=None):
        """`groups`: a number a cell; each group then has a surface of its own, so that one may be
        looked at without the other."""
        if cells.shape[1] in (3, 6):
            nodes, owners = _anticlockwise(points, cells), np.arange(len(cells))
        else:
            nodes, owners = _outer_faces(points, cells, groups)
        quadratic = nodes.shape[1] == 6
        self.triangles = nodes[:, QUARTERS].reshape(-1, 3) if quadratic else nodes
        self.cells = np.repeat(owners, 4) if quadratic else owners
        self.is_edge = (np.tile(QUARTER_EDGES, (len(nodes), 1)) if quadratic
                        else np.ones((len(nodes), 3), dtype=bool))

    @property
    def edges(self):
        """The edges of cells (m x 2), in two parts where they have a node in their middle."""
        ends = np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=2)[self.is_edge]
        return np.unique(np.sort(ends, axis=1), axis=0)


def _anticlockwise(points, cells):
    a, b, c = (points[cells[:, corner], :2] for corner in range(3))
    clockwise = np.cross(b - a, c - a) < 0
    mirrored = [0, 2, 1] if cells.shape[1] == 3 else [0, 2, 1, 5, 4, 3]
    return np.where(clockwise[:, None], cells[:, mirrored], cells)


def _outer_faces(points, cells, groups):
    """Faces (n x 3 or 6 nodes) of one cell only, or between cells of two groups, and their cells."""
    used = FACES if cells.shape[1] == 10 else FACES[:, :3]
    corners = np.sort(cells[:, FACES[:, :3]].reshape(-1, 3), axis=1)
    order = np.lexsort(corners.T[::-1])
    corners = corners[order]
    twin = (corners[1:] == corners[:-1]).all(axis=1)
    if groups is not None:
        owner_groups = np.asarray(groups)[order // 4]
        twin &= owner_groups[1:] == owner_groups[:-1]
    inner = np.append(twin, False) | np.append(False, twin)
    outer = np.sort(order[~inner])
    owners, face = outer // 4, outer % 4
    nodes = cells[owners[:, None], used[face]]
    # At rest no cell is inverted: the fourth corner lies inside, whatever the mesher's orientation.
    a, b, c, inside = (points[node] for node in (*nodes.T[:3], cells[owners, face]))
    wrong = np.einsum("ij,ij->i", np.cross(b - a, c - a), inside - a) > 0
    mirrored = [0, 2, 1, 5, 4, 3][:nodes.shape[1]]
    nodes[wrong] = nodes[wrong][:, mirrored]
    return nodes, owners


def face_normals(points, triangles):
    """Normals (n x 3), each as long as twice the area of its triangle."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def smoothing_groups(points, triangles, groups=None, angle=30):
    """A number for each corner of each triangle (n x 3): corners at one vertex have the same number
    where no edge of the body, sharper than `angle` degrees, is between their triangles. Normals are
    averaged over corners of one number, and nowhere across an edge. `groups`: as of `Surface`, here
    a number a triangle."""
    sides, mates = _neighbours(triangles, groups)
    flat = unit(face_normals(points, triangles))
    smooth = np.einsum("ij,ij->i", flat[sides[:, 0]], flat[mates[:, 0]]) > np.cos(np.radians(angle))
    sides, mates = sides[smooth], mates[smooth]
    # The side from corner k to k + 1 meets its mate's in the other direction.
    pairs = np.concatenate([
        np.stack([3 * sides[:, 0] + sides[:, 1], 3 * mates[:, 0] + (mates[:, 1] + 1) % 3]),
        np.stack([3 * sides[:, 0] + (sides[:, 1] + 1) % 3, 3 * mates[:, 0] + mates[:, 1]])], axis=1)
    least = np.arange(triangles.size)
    while True:  # corners round a vertex: as many rounds as half of them
        before = least.copy()
        np.minimum.at(least, pairs[0], before[pairs[1]])
        np.minimum.at(least, pairs[1], before[pairs[0]])
        least = least[least]
        if (least == before).all():
            return np.unique(least, return_inverse=True)[1].reshape(triangles.shape)


def _neighbours(triangles, groups):
    """Pairs of sides where exactly two triangles (of one group) meet with one orientation: triangle
    and first corner of the one (m x 2), and of the other."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    group = np.zeros(len(triangles)) if groups is None else groups
    keys = np.column_stack([np.repeat(group, 3), np.sort(ends, axis=1)])
    order = np.lexsort(keys.T[::-1])
    keys = keys[order]
    same = (keys[1:] == keys[:-1]).all(axis=1)
    alone = ~np.append(False, same[:-1]) & ~np.append(same[1:], False)
    first = np.flatnonzero(same & alone)
    one, other = order[first], order[first + 1]
    opposite = ends[one, 0] == ends[other, 1]
    one, other = one[opposite], other[opposite]
    return np.stack([one // 3, one % 3], axis=1), np.stack([other // 3, other % 3], axis=1)


def feature_edges(points, triangles, groups=None, angle=30):
    """Edges of the body (m x 2): where its surface ends, or bends by more than `angle` degrees."""
    sides, mates = _neighbours(triangles, groups)
    flat = unit(face_normals(points, triangles))
    smooth = np.einsum("ij,ij->i", flat[sides[:, 0]], flat[mates[:, 0]]) > np.cos(np.radians(angle))
    plain = np.zeros(triangles.size, dtype=bool)
    for side in (sides[smooth], mates[smooth]):
        plain[3 * side[:, 0] + side[:, 1]] = True
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    return np.unique(np.sort(ends[~plain], axis=1), axis=0)


def unit(vectors):
    """The vectors in the last axis, scaled to length one."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def inverted_cells(step):
    """Numbers of the cells of a `trefoil.Step` that are turned inside out: det F <= 0. None where
    that cannot be said: quadratic cells without the field determinant_F."""
    if "determinant_F" in step.cell_fields:
        return np.flatnonzero(step.cell_fields["determinant_F"] <= 0)
    cells, rest = step.cells, step.points
    if cells.shape[1] > 4 or "displacement" not in step.fields:
        return None
    before, after = (_signed_sizes(at, cells) for at in (rest, rest + step.fields["displacement"]))
    return np.flatnonzero(before * after <= 0)


def _signed_sizes(points, cells):
    a, *others = (points[cells[:, corner]] for corner in range(cells.shape[1]))
    spans = np.stack([corner - a for corner in others], axis=1)
    return np.linalg.det(spans if cells.shape[1] == 4 else spans[:, :, :2])


def thinned(points, triangles, most):
    """At most about `most` triangles that look like the surface: points that fall into one box of a
    grid become the one nearest to their middle. Returns numbers of the triangles that stay, and their
    new corners (n x 3)."""
    low, high = points[triangles].min(axis=(0, 1)), points[triangles].max(axis=(0, 1))
    area = np.linalg.norm(face_normals(points, triangles), axis=1).sum() / 2
    size = np.sqrt(2.2 * area / most)
    while True:
        stay, corners = _clustered(points, triangles, low, high, size)
        if len(stay) <= most:
            return stay, corners
        size *= 1.2


def _clustered(points, triangles, low, high, size):
    used = np.unique(triangles)
    boxes = np.floor((points[used] - low) / size).astype(np.int64)
    counts = np.floor((high - low) / size).astype(np.int64) + 1
    key = (boxes[:, 0] * counts[1] + boxes[:, 1]) * counts[2] + boxes[:, 2]
    _, cluster = np.unique(key, return_inverse=True)
    clusters = cluster.max() + 1
    weight = np.bincount(cluster, minlength=clusters)
    middle = np.stack([np.bincount(cluster, points[used, axis], clusters) / weight
                       for axis in range(3)], axis=1)
    off = np.linalg.norm(points[used] - middle[cluster], axis=1)
    order = np.lexsort((off, cluster))
    nearest = used[order[np.append(True, cluster[order][1:] != cluster[order][:-1])]]
    place = np.zeros(len(points), dtype=np.int64)
    place[used] = nearest[cluster]
    corners = place[triangles]
    kept = np.flatnonzero((corners[:, 0] != corners[:, 1]) & (corners[:, 1] != corners[:, 2])
                          & (corners[:, 2] != corners[:, 0]))
    _, first = np.unique(np.sort(corners[kept], axis=1), axis=0, return_index=True)
    stay = kept[np.sort(first)]
    return stay, corners[stay]
