#!/usr/bin/python3
"""Does a surface pass through itself? An exact answer, independent of the program.

    tests/contact/exact.py FILE.xdmf ... [--between-bodies]

Reads every state of the files (see mesh_files.py), finds their surfaces, and tests all edges
against all triangles (in the plane, edges against edges) that have no vertex in common and whose
boxes overlap. Signs of volumes are taken from floating-point numbers only where an error bound
allows it, else from fractions. Touching counts. Exit status 0: nothing found; 1: intersections,
each state's number and first one are printed; 2: a file that cannot be read."""
import argparse
import sys
from fractions import Fraction

import numpy as np

import mesh_files


# --- the surface ---

def facets_of(cells):
    """Facets that belong to one cell only, sorted corners: triangles, of flat meshes edges."""
    corners = cells.shape[1]
    every = np.concatenate([np.delete(cells, k, axis=1) for k in range(corners)])
    facets, count = np.unique(np.sort(every, axis=1), axis=0, return_counts=True)
    return facets[count == 1]


def edges_of(facets):
    if facets.shape[1] == 2:
        return facets
    every = np.concatenate([facets[:, pair] for pair in ([0, 1], [0, 2], [1, 2])])
    return np.unique(every, axis=0)


def bodies_of(cells, count):
    """The number of the connected body of each vertex: the least vertex that it hangs together
    with."""
    body = np.arange(count)
    while True:
        least = body[cells].min(axis=1)
        before = body.copy()
        for corner in range(cells.shape[1]):
            np.minimum.at(body, cells[:, corner], least)
        body = body[body]
        if np.array_equal(body, before):
            return body


# --- pairs with overlapping boxes, by a grid ---

def _boxes(points, primitives):
    corners = points[primitives]
    return corners.min(axis=1), corners.max(axis=1)


def _cells_of(low, high):
    """Numbers of boxes and the integer cells that they cover."""
    size = high - low + 1
    count = size.prod(axis=1)
    box = np.repeat(np.arange(len(low)), count)
    place = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    size, cell = size[box], np.empty((len(box), 3), dtype=np.int64)
    for axis in range(3):
        cell[:, axis] = low[box, axis] + place % size[:, axis]
        place = place // size[:, axis]
    return box, cell


def _ranges(starts, counts):
    """starts[0], starts[0] + 1, ... counts[0] numbers, then those of the next."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) + np.repeat(starts - ends + counts, counts)


def close_pairs(points, edges, facets):
    """All pairs edge, facet whose boxes overlap, without those that share a vertex."""
    (low_e, high_e), (low_f, high_f) = _boxes(points, edges), _boxes(points, facets)
    origin = points.min(axis=0)
    extents = np.concatenate([high_e - low_e, high_f - low_f]).max(axis=1)
    side = max(extents.mean(), extents.max() / 8, 1e-300)  # no box in more than 9^3 cells
    to_cells = lambda x: np.floor((x - origin) / side).astype(np.int64)
    edge, cell_e = _cells_of(to_cells(low_e), to_cells(high_e))
    facet, cell_f = _cells_of(to_cells(low_f), to_cells(high_f))
    _, key = np.unique(np.concatenate([cell_e, cell_f]), axis=0, return_inverse=True)
    key_e, key_f = key[:len(cell_e)], key[len(cell_e):]
    order = np.argsort(key_f, kind="stable")
    facet, key_f = facet[order], key_f[order]
    start, end = np.searchsorted(key_f, key_e), np.searchsorted(key_f, key_e, side="right")
    pairs = np.stack([np.repeat(edge, end - start), facet[_ranges(start, end - start)]], axis=1)
    pairs = np.unique(pairs, axis=0)
    e, f = pairs.T
    overlap = ((low_e[e] <= high_f[f]) & (low_f[f] <= high_e[e])).all(axis=1)
    shared = (edges[e][:, :, None] == facets[f][:, None, :]).any(axis=(1, 2))
    return pairs[overlap & ~shared]


# --- exact tests of one pair ---

def _sign(x):
    return (x > 0) - (x < 0)


def _exactly(point):
    return [Fraction(float(x)) for x in point]


def volume_sign(a, b, c, d):
    p, q, r = ([x - y for x, y in zip(point, a)] for point in (b, c, d))
    return _sign(p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2])
                 + p[2] * (q[0] * r[1] - q[1] * r[0]))


def area_sign(a, b, c, i, j):
    return _sign((b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]))


def segments_meet(a, b, c, d, i, j):
    """Closed segments, seen in coordinates i and j."""
    of_a, of_b = area_sign(c, d, a, i, j), area_sign(c, d, b, i, j)
    of_c, of_d = area_sign(a, b, c, i, j), area_sign(a, b, d, i, j)
    if of_a * of_b > 0 or of_c * of_d > 0:
        return False
    if of_a or of_b or of_c or of_d:
        return True
    return all(max(a[k], b[k]) >= min(c[k], d[k]) and max(c[k], d[k]) >= min(a[k], b[k])
               for k in (i, j))


def _inside(p, triangle, i, j):
    c, d, e = triangle
    signs = {area_sign(c, d, p, i, j), area_sign(d, e, p, i, j), area_sign(e, c, p, i, j)}
    return area_sign(c, d, e, i, j) != 0 and not {1, -1} <= signs


def segment_meets_triangle(a, b, c, d, e):
    """Whether closed segment and triangle have a point in common; of fractions."""
    sides = [volume_sign(a, b, c, d), volume_sign(a, b, d, e), volume_sign(a, b, e, c)]
    of_a, of_b = volume_sign(a, c, d, e), volume_sign(b, c, d, e)
    if of_a * of_b > 0 or {1, -1} <= set(sides):
        return False
    if of_a or of_b:
        return True
    # In one plane: seen along each axis, of which one at least loses nothing.
    return all(segments_meet(a, b, c, d, i, j) or segments_meet(a, b, d, e, i, j)
               or segments_meet(a, b, e, c, i, j) or _inside(a, (c, d, e), i, j)
               for i, j in ((0, 1), (1, 2), (2, 0)))


# --- all pairs: most are settled by floating-point numbers ---

def _certain_signs(a, b, c, d):
    """Signs of volumes; 0 where rounding may decide."""
    p, q, r = b - a, c - a, d - a
    terms = np.stack([p[:, 0] * q[:, 1] * r[:, 2], -p[:, 0] * q[:, 2] * r[:, 1],
                      p[:, 1] * q[:, 2] * r[:, 0], -p[:, 1] * q[:, 0] * r[:, 2],
                      p[:, 2] * q[:, 0] * r[:, 1], -p[:, 2] * q[:, 1] * r[:, 0]])
    total, bound = terms.sum(axis=0), 1e-14 * np.abs(terms).sum(axis=0)
    return np.where(np.abs(total) > bound, np.sign(total), 0).astype(int)


def intersections(points, edges, facets):
    """The pairs edge, facet that meet, sorted."""
    points = np.asarray(points, dtype=float)
    pairs = close_pairs(points, edges, facets)
    if facets.shape[1] == 2:
        return [(e, f) for e, f in pairs if e < f and segments_meet(
            *(_exactly(points[v]) for v in (*edges[e], *facets[f])), 0, 1)]
    corner = [points[edges[pairs[:, 0], k]] for k in (0, 1)]
    corner += [points[facets[pairs[:, 1], k]] for k in (0, 1, 2)]
    a, b, c, d, e = corner
    apart = _certain_signs(a, c, d, e) * _certain_signs(b, c, d, e) > 0
    sides = np.stack([_certain_signs(a, b, c, d), _certain_signs(a, b, d, e),
                      _certain_signs(a, b, e, c)])
    apart |= (sides == 1).any(axis=0) & (sides == -1).any(axis=0)
    return [(edge, facet) for edge, facet in pairs[~apart] if segment_meets_triangle(
        *(_exactly(points[v]) for v in (*edges[edge], *facets[facet])))]


def intersections_of(step, between_bodies=False):
    """Pairs of an edge and a facet of the surface of a state that meet, by their vertices."""
    facets = facets_of(step.cells)
    edges = edges_of(facets)
    found = [(tuple(edges[e]), tuple(facets[f]))
             for e, f in intersections(step.points, edges, facets)]
    if between_bodies:
        body = bodies_of(step.cells, len(step.points))
        found = [(e, f) for e, f in found if body[e[0]] != body[f[0]]]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="+", metavar="FILE", help=".xdmf or .vtu")
    parser.add_argument("--between-bodies", action="store_true",
                        help="leave out what a body does to itself")
    arguments = parser.parse_args()
    states = bad = 0
    for path in arguments.files:
        try:
            for step in mesh_files.steps_of(path):
                states += 1
                found = intersections_of(step, arguments.between_bodies)
                if not found:
                    continue
                bad += 1
                edge, facet = found[0]
                place = step.points[list(edge)].mean(axis=0)
                print(f"{path}, {step.name}: {len(found)} pairs intersect, the first edge "
                      f"{tuple(map(int, edge))} and facet {tuple(map(int, facet))}, near "
                      f"({', '.join(f'{x:g}' for x in place)})")
        except (OSError, KeyError, ValueError, SyntaxError) as error:
            print(f"{path}: cannot be read: {error}", file=sys.stderr)
            return 2
    print(f"{states} states, {bad} with intersections")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
