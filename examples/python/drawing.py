"""What examples/picture.py and examples/animate.py share: a body, a field on it, and their options."""

import argparse
import os
import sys

import matplotlib
import numpy as np

import fields
import render
import surface
from obstacles import GREY


def fail(sentence):
    """Ends the program with one sentence."""
    sys.exit(f"{os.path.basename(sys.argv[0])}: {sentence}")


def add_view_options(parser):
    parser.add_argument("--field", default="displacement", help="what the colours show")
    parser.add_argument("--component",
                        help="of a vector or tensor, such as x or yz (default: its magnitude)")
    parser.add_argument("--cells", action="store_true",
                        help="values of cells also where they are averaged to vertices")
    parser.add_argument("--range",
                        help="the colours' ends, such as 0,2e6 (default: all but extreme cells)")
    parser.add_argument("--scale", type=float, default=1,
                        help="displacements are drawn so many times as large")
    parser.add_argument("--azimuth", type=float,
                        help="of the eye, degrees from x (default -60; a flat body -90)")
    parser.add_argument("--elevation", type=float,
                        help="of the eye, degrees (default 25; a flat body 90)")
    parser.add_argument("--colours", default="viridis", help="a colour map of matplotlib")
    parser.add_argument("--units", help="of length and force, such as 'mm, N'")
    parser.add_argument("--edges", action=argparse.BooleanOptionalAction,
                        help="draw the edges of the mesh (default: where there are few)")


def view_of(arguments, flat):
    azimuth, elevation = (-90, 90) if flat else (-60, 25)
    return render.camera(azimuth if arguments.azimuth is None else arguments.azimuth,
                         elevation if arguments.elevation is None else arguments.elevation)


class Body:
    """The surface of a step's body at rest; `triangles` and `used`, the points on it."""

    def __init__(self, step):
        self.rest, cells = step.points, step.cells
        skin = surface.Surface(self.rest, cells)
        self.triangles, self.cells, self.is_edge = skin.triangles, skin.cells, skin.is_edge
        self.used = np.unique(self.triangles)
        self.is_flat = cells.shape[1] in (3, 6) and bool(np.ptp(self.rest[:, 2]) == 0)
        self._smooth = surface.smoothing_groups(self.rest, self.triangles)

    def moved(self, step, scale=1):
        """The points, displaced."""
        if "displacement" not in step.fields:
            return self.rest
        return self.rest + scale * step.fields["displacement"]

    def draw(self, points, view, low, high, pixels, colours, edges, others=None):
        """A picture of the rectangle from low to high, see render.draw. `others`: obstacles, and
        their points."""
        window = render.Window(low, high, *pixels, margin=0)
        triangles, smooth = self.triangles, self._smooth
        is_edge = self.is_edge if edges else None
        if others and others[0]:
            obstacles, places = others
            front = obstacles.facing(places, view)
            triangles = np.concatenate([triangles, len(points) + obstacles.triangles[front]])
            smooth = np.concatenate([smooth, smooth.max() + 1 + obstacles.smooth[front]])
            points = np.concatenate([points, places])
            colours = self._beside_grey(colours)
            if edges:
                is_edge = np.concatenate([is_edge, np.zeros((front.sum(), 3), dtype=bool)])
        return render.draw(points, triangles, smooth, view, window, colours, is_edge)

    def _beside_grey(self, colours):
        """The colours, of triangles that are not the body's grey."""
        def both(owner, weights):
            mine = owner < len(self.triangles)
            shades = np.tile(GREY, (len(owner), 1))
            if mine.any():
                shades[mine] = colours(owner[mine], weights[mine])
            return shades
        return both


class FieldOfBody:
    """A column of a field, its scale of colours over some steps, and its title."""

    def __init__(self, body, steps, arguments):
        self._body, self._name, self._column = body, arguments.field, arguments.component
        self._on_vertices = not arguments.cells and steps[0].fields.on_vertices(self._name)
        if arguments.cells and any(self._name not in step.cell_fields for step in steps):
            raise ValueError(f"{self._name} has no values of cells")
        self._rows = body.used if self._on_vertices else np.unique(body.cells)
        column = self._column or self._columns(steps[-1])[0]
        self.title = (fields.title(self._name) + (f", {column}" if column else ""))
        unit = fields.unit(self._name, fields.Units(arguments.units))
        self.title += f" [{unit}]" if unit else ""
        self._normalize, self.extend = self._scale(steps, arguments.range)
        self.map = matplotlib.cm.ScalarMappable(self._normalize, arguments.colours)

    def _columns(self, step):
        return list(fields.columns(self._name, self._found(step)[:1]))

    def _found(self, step):
        return (step.vertex_fields if self._on_vertices else step.cell_fields)[self._name]

    def values(self, step):
        """A number a vertex or a cell."""
        chosen = fields.columns(self._name, self._found(step))
        if self._column is None:
            return next(iter(chosen.values()))
        if self._column not in chosen:
            raise ValueError(f"{self._name} has no component '{self._column}', but " + ", ".join(chosen))
        return chosen[self._column]

    def _scale(self, steps, given):
        ends, most = [], []
        for step in steps:
            values = self.values(step)[self._rows]
            values = values[np.isfinite(values)]
            if len(values):
                ends += [values.min(), values.max()]
                # A few extreme cells do not decide the scale.
                most += ([values.min(), values.max()] if self._on_vertices
                         else np.percentile(values, [1, 99]).tolist())
        if not ends:
            raise ValueError(f"{self._name} has no finite value")
        if given:
            low, high = (float(word) for word in given.split(","))
        else:
            low, high = min(most), max(most)
            low = 0 if self.title.split(" [")[0].endswith("magnitude") else low
        if high <= low:
            high = low + max(abs(low), 1) * 1e-3
        extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[
            bool(min(ends) < low), bool(max(ends) > high)]
        return matplotlib.colors.Normalize(low, high), extend

    def colours(self, step):
        """For render.draw: colours of samples."""
        return self.colours_of(self.values(step))

    def colours_of(self, values):
        def colours(owner, weights):
            if self._on_vertices:
                at = np.einsum("ij,ij->i", weights, values[self._body.triangles[owner]])
            else:
                at = values[self._body.cells[owner]]
            return self.map.to_rgba(at)[:, :3]
        return colours


def bar_of(figure, field, place):
    """The scale of a field's colours, at a place (left, bottom, width, height) of the figure."""
    bar = figure.colorbar(field.map, cax=figure.add_axes(place), extend=field.extend)
    bar.set_label(field.title, color="0.25")
    bar.ax.ticklabel_format(scilimits=(-3, 4), useMathText=True)
    bar.ax.tick_params(labelsize=9, color="0.5", labelcolor="0.25")
    bar.outline.set_visible(False)
