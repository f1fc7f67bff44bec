#!/usr/bin/python3
"""Draws a result of Trefoil: the body at rest, and deformed.

    python3 examples/picture.py out/knot.xdmf -o knot.png
    python3 examples/picture.py out/knot.xdmf -o knot.png --field energy_density --azimuth 30

The field may live on vertices or on cells; a vector is drawn by its length.
Debian: python3-numpy python3-h5py python3-matplotlib
"""

import argparse
import os
import sys
import xml.etree.ElementTree

try:
    import h5py
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.collections import PolyCollection
except ImportError as missing:
    sys.exit(f"picture.py: {missing.name} is missing: "
             "apt install python3-numpy python3-h5py python3-matplotlib, then use /usr/bin/python3")

CLAY = np.array([0.80, 0.79, 0.77])  # the body at rest


class Result:
    """Points, cells and fields of a file that Trefoil wrote."""

    def __init__(self, path):
        grid = xml.etree.ElementTree.parse(path).getroot().find("./Domain/Grid")
        if grid is None:
            raise ValueError("it holds no Domain with a Grid")
        self.directory = os.path.dirname(path)
        self.points = self._read(grid.find("Geometry"))
        self.cells = self._read(grid.find("Topology"))
        self.fields = {item.get("Name"): (item.get("Center") == "Node", self._read(item))
                       for item in grid.findall("Attribute")}

    def _read(self, element):
        file, _, dataset = element.find("DataItem").text.strip().partition(":")
        with h5py.File(os.path.join(self.directory, file), "r") as data:
            return data[dataset][()]


def linear_cells(cells):
    """Quadratic cells (n x 6 or n x 10) cut at the midpoints of their edges into linear ones, and the
    cell that each comes from; linear ones as they are."""
    parts = {6: [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
             10: [[0, 4, 6, 7], [4, 1, 5, 8], [6, 5, 2, 9], [7, 8, 9, 3],
                  [4, 9, 5, 6], [4, 9, 6, 7], [4, 9, 7, 8], [4, 9, 8, 5]]}.get(cells.shape[1])
    if parts is None:
        return cells, np.arange(len(cells))
    cut = cells[:, np.array(parts)]
    return cut.reshape(-1, cut.shape[2]), np.repeat(np.arange(len(cells)), len(parts))


def outer_surface(points, cells):
    """Triangles (n x 3) that belong to one cell only, anticlockwise seen from outside (of a flat
    body: from above), and those cells (n)."""
    if cells.shape[1] == 3:
        a, b, c = (points[cells[:, corner]] for corner in range(3))
        clockwise = np.cross(b - a, c - a)[:, 2] < 0
        return np.where(clockwise[:, None], cells[:, ::-1], cells), np.arange(len(cells))
    corners = np.array([[1, 2, 3, 0], [0, 3, 2, 1], [0, 1, 3, 2], [0, 2, 1, 3]])  # face, opposite
    faces = cells[:, corners].reshape(-1, 4)
    _, first, times = np.unique(np.sort(faces[:, :3], axis=1), axis=0,
                                return_index=True, return_counts=True)
    outer = first[times == 1]
    triangles = faces[outer, :3]
    # At rest no cell is inverted: the fourth vertex lies inside, whatever the mesher's orientation.
    a, b, c, inside = (points[faces[outer, corner]] for corner in range(4))
    wrong = np.einsum("ij,ij->i", np.cross(b - a, c - a), inside - a) > 0
    triangles[wrong] = triangles[wrong][:, ::-1]
    return triangles, outer // 4


def normals(points, triangles):
    """Normals of the triangles (n x 3), and those of their vertices (n x 3 corners x 3)."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    flat = np.cross(b - a, c - a)  # as long as twice the area: large triangles count more
    at_vertices = np.zeros_like(points)
    for corner in range(3):
        np.add.at(at_vertices, triangles[:, corner], flat)
    return unit(flat), unit(at_vertices)[triangles]


def sharp_corners(rest, triangles):
    """Corners of triangles (n x 3) at an edge of the body, where no smoothing should be."""
    flat, at_corners = normals(rest, triangles)
    return np.einsum("ikj,ij->ik", at_corners, flat) < 0.9  # more than 26 degrees off


def unit(vectors):
    """The vectors in the last axis, scaled to length one."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300)


def camera(azimuth, elevation):
    """Rows: to the right, up, towards the eye; z is up in the picture. In degrees."""
    azimuth, elevation = np.radians([azimuth, elevation])
    eye = np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                    np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0])
    return np.array([right, np.cross(eye, right), eye])


def draw(axes, points, triangles, sharp, colours, view, edges):
    """Paints the triangles that face the eye, the farthest first."""
    seen = points @ view.T
    flat, smooth = normals(seen, triangles)
    smooth = unit(np.where(sharp[:, :, None], flat[:, None], smooth).mean(axis=1))
    facing = flat[:, 2] > 0
    facing = np.flatnonzero(facing)[np.argsort(seen[triangles[facing], 2].mean(axis=1))]
    normal = smooth[facing]
    key, fill = unit(np.array([[-0.45, 0.65, 0.75], [0.8, -0.1, 0.45]]))
    light = 0.56 + 0.44 * np.maximum(normal @ key, 0) + 0.12 * np.maximum(normal @ fill, 0)
    halfway = unit(key + np.array([0, 0, 1]))
    shine = 0.16 * np.maximum(normal @ halfway, 0)[:, None] ** 16
    shaded = np.clip(colours[facing, :3] * light[:, None] + shine, 0, 1)
    # A line in the triangle's own colour closes the hairline gaps between neighbours.
    axes.add_collection(PolyCollection(
        seen[triangles[facing], :2], facecolors=shaded,
        edgecolors=shaded * 0.85 if edges else shaded, linewidths=0.25 if edges else 0.35))
    axes.set_aspect("equal")
    axes.axis("off")
    return seen[triangles.ravel(), :2]


def colours_of(values, name, map_name):
    """Colours, and the scale they stand for; a few extreme cells do not decide the scale."""
    low, high = np.percentile(values[np.isfinite(values)], [1, 99])
    if name == "displacement":
        low, high = 0.0, values.max()
    if high <= low:
        high = low + max(abs(low), 1.0) * 1e-3
    scale = plt.cm.ScalarMappable(matplotlib.colors.Normalize(low, high), map_name)
    below, above = values.min() < low, values.max() > high
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[(below, above)]
    return scale.to_rgba(values), scale, extend


def picture(result, arguments):
    on_vertices, field = result.fields[arguments.field]
    values = np.linalg.norm(field, axis=1) if field.ndim == 2 else field
    moved = result.points
    if "displacement" in result.fields:
        moved = result.points + result.fields["displacement"][1]
    cells, whole = linear_cells(result.cells)
    triangles, owners = outer_surface(result.points, cells)
    owners = whole[owners]
    values = values[triangles].mean(axis=1) if on_vertices else values[owners]
    colours, scale, extend = colours_of(values, arguments.field, arguments.colours)
    edges = len(triangles) < 8000 if arguments.edges is None else arguments.edges
    flat = cells.shape[1] == 3
    azimuth, elevation = (-90, 90) if flat else (-60, 25)
    view = camera(azimuth if arguments.azimuth is None else arguments.azimuth,
                  elevation if arguments.elevation is None else arguments.elevation)

    figure, panels = plt.subplots(1, 2)
    sharp = sharp_corners(result.points, triangles)
    clay = np.broadcast_to(CLAY, (len(triangles), 3))
    drawn = [draw(panels[0], result.points, triangles, sharp, clay, view, edges),
             draw(panels[1], moved, triangles, sharp, colours, view, edges)]

    # One scale for both; each panel is as wide as its body, and both are as tall as the taller.
    low, high = (np.array([getattr(body, side)(axis=0) for body in drawn]) for side in ("min", "max"))
    size = high - low
    tall = size[:, 1].max() * 1.04
    wide = np.maximum(size[:, 0] * 1.08, 0.35 * tall)
    picture_height = np.clip(9.5 * tall / wide.sum(), 3.2, 6.5)  # inches, without title and margin
    unit_length = picture_height / tall
    widths, bar, margin = wide * unit_length, 1.15, 0.35
    total = np.array([widths.sum() + bar + 2 * margin, picture_height + 0.65])
    figure.set_size_inches(total)
    left = margin
    for panel, body_low, body_high, width, title in zip(panels, low, high, widths,
                                                        ("at rest", "deformed")):
        panel.set_position([left / total[0], 0.1 / total[1], width / total[0],
                            picture_height / total[1]])
        middle = (body_low + body_high) / 2
        panel.set_xlim(middle[0] - width / unit_length / 2, middle[0] + width / unit_length / 2)
        panel.set_ylim(middle[1] - tall / 2, middle[1] + tall / 2)
        figure.text((left + width / 2) / total[0], 1 - 0.33 / total[1], title, ha="center",
                    fontsize=13, color="0.25")
        left += width
    height = min(0.75 * picture_height, 3.2)
    bar_axes = figure.add_axes([(left + 0.15) / total[0],
                                (0.1 + (picture_height - height) / 2) / total[1],
                                0.16 / total[0], height / total[1]])
    label = arguments.field.replace("_", " ") + (" (length)" if field.ndim == 2 else "")
    bar = figure.colorbar(scale, cax=bar_axes, extend=extend)
    bar.set_label(label, color="0.25")
    bar.ax.ticklabel_format(scilimits=(-3, 4), useMathText=True)
    bar.ax.tick_params(labelsize=9, color="0.5", labelcolor="0.25")
    bar.outline.set_visible(False)
    figure.savefig(arguments.output, dpi=arguments.dpi, facecolor="white")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("xdmf", help="the file that trefoil wrote")
    parser.add_argument("-o", "--output", help="the picture (default: beside the file, .png)")
    parser.add_argument("--field", default="displacement", help="what the colours show")
    parser.add_argument("--azimuth", type=float, help="of the eye, degrees from x (default -60; a flat body -90)")
    parser.add_argument("--elevation", type=float, help="of the eye, degrees (default 25; a flat body 90)")
    parser.add_argument("--colours", default="viridis", help="a colour map of matplotlib")
    parser.add_argument("--edges", action=argparse.BooleanOptionalAction,
                        help="draw the edges of the mesh (default: where there are few)")
    parser.add_argument("--dpi", type=float, default=160)
    arguments = parser.parse_args()
    arguments.output = arguments.output or os.path.splitext(arguments.xdmf)[0] + ".png"
    try:
        result = Result(arguments.xdmf)
    except (OSError, KeyError, ValueError, AttributeError,
            xml.etree.ElementTree.ParseError) as error:
        sys.exit(f"picture.py: cannot read {arguments.xdmf}: {error}")
    if arguments.field not in result.fields:
        sys.exit(f"picture.py: {arguments.xdmf} has no field '{arguments.field}', but "
                 + ", ".join(result.fields))
    try:
        picture(result, arguments)
    except (OSError, ValueError) as error:
        sys.exit(f"picture.py: cannot draw {arguments.output}: {error}")


if __name__ == "__main__":
    main()
