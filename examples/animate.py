#!/usr/bin/python3
"""Makes a film of a series of load or time steps of Trefoil, by the name's ending .mp4 or .gif.

    python3 examples/animate.py beam.xdmf -o beam.mp4
    python3 examples/animate.py beam.xdmf -o beam.gif --field von_mises --scale 10 --seconds 3 --turn 90

Steps are shown at their times t; what lies between two of them is drawn on a straight line, unless
--exact. A file of one step goes from rest to its state and back.
Debian: python3-numpy python3-h5py python3-matplotlib, for .mp4 ffmpeg
"""

import argparse
import math
import os
import shutil
import sys
import xml.etree.ElementTree

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "python"))

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.animation
    import matplotlib.pyplot as plt
    import numpy as np

    import trefoil
    from drawing import Body, FieldOfBody, add_view_options, bar_of, fail, view_of
    from obstacles import Obstacles, with_room
except ImportError as missing:
    sys.exit(f"animate.py: {missing.name} is missing: "
             "apt install python3-numpy python3-h5py python3-matplotlib, then use /usr/bin/python3")

DPI = 100


class Film:
    """Frames of a series: positions and values of the field, at times between those of the steps."""

    def __init__(self, steps, obstacles, arguments):
        self.steps, self.obstacles, self._arguments = steps, obstacles, arguments
        self.body = Body(steps[0])
        self.field = FieldOfBody(self.body, steps, arguments)
        self.count = max(2, round(arguments.seconds * arguments.fps))
        self._times = [step.t for step in steps]
        if any(later <= earlier for earlier, later in zip(self._times, self._times[1:])):
            self._times = list(range(len(steps)))

    def frame(self, number):
        """Points, values, points of obstacles and the words for a frame."""
        share = number / (self.count - 1)
        if len(self.steps) == 1:
            amount = (1 - math.cos(2 * math.pi * share)) / 2
            step = self.steps[0]
            scale = amount * self._arguments.scale
            return (self.body.moved(step, scale), self.field.values(step),
                    self.obstacles.at(0, scale), "")
        t = self._times[0] + share * (self._times[-1] - self._times[0])
        after = min(int(np.searchsorted(self._times, t * (1 - 1e-12))), len(self.steps) - 1)
        before = max(after - 1, 0)
        gap = self._times[after] - self._times[before]
        part = (t - self._times[before]) / gap if gap else 1.0
        if self._arguments.exact:
            part = round(part)
            t = self._times[after if part else before]
        scale = self._arguments.scale
        points, values, places = (self._between(take, before, after, part) for take in (
            lambda number: self.body.moved(self.steps[number], scale),
            lambda number: self.field.values(self.steps[number]),
            lambda number: self.obstacles.at(number, scale)))
        return points, values, places, f"t = {t:.4g}"

    def _between(self, take, before, after, part):
        if part == 0:
            return take(before)
        if part == 1:
            return take(after)
        return (1 - part) * take(before) + part * take(after)

    def extent(self, views):
        """Low and high corner of what any step covers in the picture plane."""
        shapes = [self.body.moved(step, self._arguments.scale) for step in self.steps]
        shapes += [self.body.rest] * (len(self.steps) == 1)
        seen = [(shape[self.body.used] @ view.T)[:, :2] for shape in shapes for view in views]
        places = self.obstacles.at(0)
        return with_room(np.min([each.min(axis=0) for each in seen], axis=0),
                         np.max([each.max(axis=0) for each in seen], axis=0),
                         np.concatenate([places @ view.T for view in views]))


def writer_for(path, fps):
    """Matplotlib's writer for the name's ending."""
    ending = os.path.splitext(path)[1]
    if ending == ".gif":
        return matplotlib.animation.PillowWriter(fps=fps)
    if ending != ".mp4":
        fail(f"cannot write {path}: its name must end in .mp4 or .gif")
    if not shutil.which("ffmpeg"):
        fail(f"cannot write {path}: apt install ffmpeg, or name a .gif")
    return matplotlib.animation.FFMpegWriter(fps=fps, codec="libx264",
                                             extra_args=["-pix_fmt", "yuv420p", "-crf", "18"])


def views_of(film, arguments):
    """The view of every frame."""
    start = arguments.azimuth if arguments.azimuth is not None else (-90 if film.body.is_flat else -60)
    views = []
    for number in range(film.count):
        arguments.azimuth = start + arguments.turn * number / (film.count - 1)
        views.append(view_of(arguments, film.body.is_flat))
    return views


def animate(steps, obstacles, arguments):
    film = Film(steps, obstacles, arguments)
    width, height = (2 * (int(word) // 2) for word in arguments.size.split("x"))  # as films want it: even
    writer = writer_for(arguments.output, arguments.fps)
    views = views_of(film, arguments)
    edges = len(film.body.triangles) < 8000 if arguments.edges is None else arguments.edges
    panel_width = width - 120  # the rest is the scale's
    low, high = film.extent(views[::max(1, film.count // 12)])
    middle, size = (low + high) / 2, np.maximum(high - low, 1e-300)
    half = np.array([panel_width, height]) / 2 / min(0.92 * panel_width / size[0], 0.88 * height / size[1])

    figure = plt.figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="white")
    panel = figure.add_axes([0, 0, panel_width / width, 1])
    panel.axis("off")
    image = panel.imshow(np.ones((height, panel_width, 4)), aspect="auto", interpolation="none")
    words = figure.text(0.02, 0.03, "", fontsize=12, color="0.25")
    bar_of(figure, film.field, [1 - 96 / width, 0.2, 14 / width, 0.6])
    name, ending = os.path.splitext(arguments.output)
    part = f"{name}.{os.getpid()}.part{ending}"
    with open(part, "wb"):  # a folder that is not there is said before the work
        pass
    try:
        with writer.saving(figure, part, DPI):
            for number, view in enumerate(views):
                points, values, places, said = film.frame(number)
                image.set_data(film.body.draw(points, view, middle - half, middle + half,
                                              (panel_width, height), film.field.colours_of(values), edges,
                                              (film.obstacles, places)))
                words.set_text(said)
                writer.grab_frame(facecolor="white")
        os.replace(part, arguments.output)
    finally:
        if os.path.exists(part):
            os.remove(part)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("xdmf", help="the file that trefoil wrote")
    parser.add_argument("-o", "--output", help="the film (default: beside the file; without ffmpeg a .gif)")
    add_view_options(parser)
    parser.add_argument("--seconds", type=float, default=4)
    parser.add_argument("--fps", type=int, default=25, help="frames a second")
    parser.add_argument("--turn", type=float, default=0, help="degrees by which the eye goes round")
    parser.add_argument("--exact", action="store_true", help="show the steps only, nothing between them")
    parser.add_argument("--size", default="960x720", help="in pixels")
    arguments = parser.parse_args()
    ending = ".mp4" if shutil.which("ffmpeg") else ".gif"
    arguments.output = arguments.output or os.path.splitext(arguments.xdmf)[0] + ending
    try:
        steps, obstacles = trefoil.read_steps(arguments.xdmf), Obstacles(arguments.xdmf)
        if arguments.field not in steps[-1].fields:
            fail(f"{arguments.xdmf} has no field '{arguments.field}', but "
                 + ", ".join(steps[-1].fields))
    except (OSError, KeyError, ValueError, AttributeError,
            xml.etree.ElementTree.ParseError) as error:
        fail(f"cannot read {arguments.xdmf}: {error}")
    try:
        animate(steps, obstacles, arguments)
    except (OSError, ValueError) as error:
        fail(f"cannot draw {arguments.output}: {error}")


if __name__ == "__main__":
    main()
