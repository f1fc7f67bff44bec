"""The obstacles of a scene, as surfaces in a picture of its bodies; needs numpy."""

import numpy as np

import surface
import trefoil

GREY = np.array([0.62, 0.66, 0.70])
THICKNESS = 0.012  # of a segment's strip, in sizes of the obstacle
ROOM = 0.25  # to each side of the bodies, in their sizes, that obstacles may have in a picture


class Obstacles:
    """All obstacles beside a file of bodies: `triangles` and `smooth` (n x 3), empty
    where there is none. Segments become strips, a little below the bodies."""

    def __init__(self, path):
        self._all = list(trefoil.read_obstacles(path).values())
        triangles, count = [np.zeros((0, 3), dtype=int)], 0
        for steps in self._all:
            cells = steps[0].cells
            if cells.shape[1] == 2:
                cells = _strip_triangles(cells, len(steps[0].points))
            triangles.append(count + cells)
            count += len(self._moved(steps, 0, 1))
        self.triangles = np.concatenate(triangles)
        rest = self.at(0)
        self.smooth = (surface.smoothing_groups(rest, self.triangles) if len(self.triangles)
                       else self.triangles)

    def __bool__(self):
        return bool(self._all)

    @staticmethod
    def _moved(steps, number, scale):
        step = steps[number]
        points = step.points + scale * step.fields["displacement"]
        return points if step.cells.shape[1] == 3 else _strip_points(points, step.cells)

    def at(self, number, scale=1):
        """Points (n x 3) at a step of the file, by its number."""
        return np.concatenate([np.zeros((0, 3)), *(self._moved(steps, number, scale)
                                                   for steps in self._all)])

    def facing(self, points, view):
        """Whether each triangle shows its front: what lies behind its back is not hidden."""
        return surface.face_normals(points, self.triangles) @ view[2] > 0


def with_room(low, high, seen):
    """The rectangle of the bodies, made larger for what is seen of obstacles, but not by much."""
    if not len(seen):
        return low, high
    room = ROOM * (high - low).max()
    return (np.maximum(np.minimum(low, seen[:, :2].min(axis=0)), low - room),
            np.minimum(np.maximum(high, seen[:, :2].max(axis=0)), high + room))


def _strip_triangles(segments, count):
    """Of each segment two triangles; its corners once more lie to its right."""
    a, b = segments.T
    return np.concatenate([np.stack([a, a + count, b], axis=1),
                           np.stack([b, a + count, b + count], axis=1)])


def _strip_points(points, segments):
    across = np.zeros_like(points)
    along = points[segments[:, 1]] - points[segments[:, 0]]
    right = surface.unit(np.stack([along[:, 1], -along[:, 0], 0 * along[:, 2]], axis=1))
    for end in segments.T:
        np.add.at(across, end, right)
    thickness = THICKNESS * np.ptp(points, axis=0).max()
    below = np.array([0, 0, -thickness])
    return np.concatenate([points, points + thickness * surface.unit(across)]) + below
