"""Draws surfaces into arrays of pixels, near before far also where they fold; needs numpy.

The camera looks from infinity: parallel lines stay parallel. Shades are those of the page that
report.py makes."""

import numpy as np

from surface import face_normals, unit

KEY, FILL = unit(np.array([[-0.45, 0.65, 0.75], [0.8, -0.1, 0.45]]))  # lights: right, up, to the eye
HALFWAY = unit(KEY + np.array([0, 0, 1]))
FINE = 2  # a pixel is FINE x FINE samples


def camera(azimuth, elevation):
    """Rows: to the right, up, towards the eye; z is up in the picture. In degrees."""
    azimuth, elevation = np.radians([azimuth, elevation])
    eye = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                    np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0])
    return np.array([right, np.cross(eye, right), eye])


class Window:
    """The part of the picture plane that is drawn: a middle, and pixels a unit of length."""

    def __init__(self, low, high, width, height, margin=0.06):
        """Fits the rectangle from low to high (of the plane) into width x height pixels."""
        self.width, self.height = width, height
        self.middle = (np.asarray(low) + high) / 2
        size = np.maximum(np.asarray(high) - low, 1e-300)
        self.scale = (1 - margin) * min(width / size[0], height / size[1])

    def samples(self, seen):
        """Places in samples: to the right, downwards, and nearness."""
        right, up = ((seen[:, :2] - self.middle) * self.scale).T
        return np.stack([(right + self.width / 2) * FINE, (self.height / 2 - up) * FINE,
                         seen[:, 2] * self.scale * FINE], axis=1)


def draw(points, triangles, smooth, view, window, colours, edges=None):
    """A picture (height x width x 4, in 0 ... 1, not covered: transparent).

    points     n x 3, deformed
    triangles  m x 3, anticlockwise from outside; the others' backs are dark
    smooth     m x 3, a number for each corner, see surface.smoothing_groups
    view       see camera
    colours    takes triangles (k) and weights of their corners (k x 3), returns k x 3 colours
    edges      m x 3, whether the side from corner k to k + 1 is drawn
    """
    seen = points @ view.T
    places = window.samples(seen)
    height, width = window.height * FINE, window.width * FINE
    which, weights = _nearest(places[triangles], width, height)
    covered = np.flatnonzero(which >= 0)
    shades = np.zeros((height * width, 4))
    owner, corners = which[covered], weights[covered]
    flat = face_normals(seen, triangles)
    colour = colours(owner, corners)
    if edges is not None:
        colour = _with_edges(colour, places[triangles], edges, owner, corners)
    shades[covered, :3] = _shaded(colour, flat, smooth, owner, corners)
    shades[covered, 3] = 1
    shades = shades.reshape(window.height, FINE, window.width, FINE, 4).mean(axis=(1, 3))
    shades[..., :3] /= np.maximum(shades[..., 3:], 1e-12)
    return shades


def _nearest(places, width, height):
    """For every sample the triangle in front (-1: none) and the weights of its corners."""
    which = np.full(width * height, -1)
    nearness = np.full(width * height, -np.inf)
    weights = np.zeros((width * height, 3))
    (ax, ay, _), (bx, by, _), (cx, cy, _) = np.moveaxis(places, 0, 2)
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    size = np.array([width, height])
    low = np.clip(np.floor(places[:, :, :2].min(axis=1)), 0, size).astype(int)
    high = np.clip(np.ceil(places[:, :, :2].max(axis=1)), 0, size).astype(int)
    extent = (high - low).max(axis=1)
    inside = (area != 0) & (high > low).all(axis=1)
    for span in 2 ** np.arange(1, 2 + int(np.log2(size.max()))):  # those of about one size together
        chosen = np.flatnonzero(inside & (extent <= span) & (extent > span // 2 * (span > 2)))
        for part in np.array_split(chosen, max(1, len(chosen) * span * span // 2_000_000)):
            if len(part):
                _paint(places[part], area[part], part, low[part], span, width, height,
                       which, nearness, weights)
    return which, weights


def _paint(places, area, numbers, low, span, width, height, which, nearness, weights):
    """Puts some triangles, each within `span` samples from `low`, before what is behind them."""
    x = low[:, 0, None, None] + np.arange(span)[None, None, :]
    y = low[:, 1, None, None] + np.arange(span)[None, :, None]
    corners = places[:, :, :, None, None]
    parts = []
    for k in range(3):  # shares of the corners at the middle of a sample, by the areas opposite to them
        p, q = corners[:, (k + 1) % 3], corners[:, (k + 2) % 3]
        parts.append(((p[:, 0] - x - 0.5) * (q[:, 1] - y - 0.5)
                      - (q[:, 0] - x - 0.5) * (p[:, 1] - y - 0.5)) / area[:, None, None])
    hit = (parts[0] >= 0) & (parts[1] >= 0) & (parts[2] >= 0) & (x < width) & (y < height)
    triangle, row, column = np.nonzero(hit)
    share = np.stack([part[hit] for part in parts], axis=1)
    depth = np.einsum("ij,ij->i", share, places[triangle, :, 2])
    sample = (low[triangle, 1] + row) * width + low[triangle, 0] + column
    order = np.argsort(depth, kind="stable")  # of several at one sample the last one stays
    order = order[depth[order] > nearness[sample[order]]]
    sample = sample[order]
    nearness[sample], which[sample], weights[sample] = depth[order], numbers[triangle[order]], share[order]


def _with_edges(colour, places, edges, owner, weights):
    """The colours, darker within half a pixel of the edges."""
    span = np.roll(places, -1, axis=1)[:, :, :2] - places[:, :, :2]  # side k to k + 1
    area = abs(span[:, 0, 0] * span[:, 1, 1] - span[:, 0, 1] * span[:, 1, 0])
    heights = area[:, None] / np.maximum(np.linalg.norm(span, axis=2), 1e-12)  # of the corner k + 2
    away = np.roll(weights, 1, axis=1) * heights[owner]  # weight of corner k + 2 at column k
    near = (edges[owner] & (away < 0.35 * FINE)).any(axis=1)
    return np.where(near[:, None], 0.55 * colour, colour)


def _shaded(colour, flat, smooth, owner, weights):
    """Colours in the light: normals are averaged over corners of one number in `smooth`."""
    sums = np.zeros((smooth.max() + 1, 3))
    for corner in range(3):
        np.add.at(sums, smooth[:, corner], flat)
    normal = unit(np.einsum("ij,ijk->ik", weights, unit(sums)[smooth[owner]]))
    back = flat[owner, 2] < 0
    normal[back] *= -1
    colour = np.where(back[:, None], 0.35 * colour + 0.65 * np.array([0.35, 0.31, 0.30]), colour)
    light = 0.70 + 0.32 * np.maximum(normal @ KEY, 0) + 0.10 * np.maximum(normal @ FILL, 0)
    shine = 0.06 * np.maximum(normal @ HALFWAY, 0) ** 24
    return np.clip(colour * light[:, None] + shine[:, None], 0, 1)
