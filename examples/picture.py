#!/usr/bin/python3
"""Draws a result of Trefoil: the body at rest, and deformed; obstacles in grey.

    python3 examples/picture.py out/knot.xdmf -o knot.png
    python3 examples/picture.py out/knot.xdmf -o knot.png --field energy_density --azimuth 30
    python3 examples/picture.py bracket.xdmf --scale 5000 --field von_mises

The field may live on vertices or on cells; of a vector or a tensor the magnitude is drawn, or a
--component. Of a series of steps the last one is drawn.
Debian: python3-numpy python3-h5py python3-matplotlib
"""

import argparse
import os
import sys
import xml.etree.ElementTree

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "python"))

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    import trefoil
    from drawing import Body, FieldOfBody, add_view_options, bar_of, fail, view_of
    from obstacles import Obstacles, with_room
except ImportError as missing:
    sys.exit(f"picture.py: {missing.name} is missing: "
             "apt install python3-numpy python3-h5py python3-matplotlib, then use /usr/bin/python3")

CLAY = np.array([0.80, 0.79, 0.77])  # the body at rest
MARGIN, BAR, ROOM_ABOVE, ROOM_BELOW = 0.35, 1.3, 0.55, 0.1  # inches


def picture(step, obstacles, arguments):
    body = Body(step)
    field = FieldOfBody(body, [step], arguments)
    view = view_of(arguments, body.is_flat)
    edges = len(body.triangles) < 8000 if arguments.edges is None else arguments.edges
    shapes = (body.rest, body.moved(step, arguments.scale))

    # One scale for both; each panel is as wide as its body, and both are as tall as the taller.
    seen = [points[body.used] @ view.T for points in shapes]
    around = [obstacles.at(number, arguments.scale * (number != 0)) for number in (0, -1)]
    low, high = np.swapaxes([with_room(each[:, :2].min(axis=0), each[:, :2].max(axis=0),
                                       places @ view.T) for each, places in zip(seen, around)], 0, 1)
    size = high - low
    tall = size[:, 1].max() * 1.04
    wide = np.maximum(size[:, 0] * 1.08, 0.35 * tall)
    height = np.clip(9.5 * tall / wide.sum(), 3.2, 6.5)  # inches, without title and margin
    widths = wide * height / tall
    total = np.array([widths.sum() + BAR + 2 * MARGIN, height + ROOM_ABOVE + ROOM_BELOW])
    figure = plt.figure(figsize=total)
    left = MARGIN
    titles = "at rest", deformed_by(arguments.scale)
    for k, (points, width, title) in enumerate(zip(shapes, widths, titles)):
        middle = (low[k] + high[k]) / 2
        half = np.array([wide[k], tall]) / 2
        pixels = (int(round(width * arguments.dpi)), int(round(height * arguments.dpi)))
        colours = field.colours(step) if k else lambda owner, weights: np.tile(CLAY, (len(owner), 1))
        image = body.draw(points, view, middle - half, middle + half, pixels, colours, edges,
                          (obstacles, around[k]))
        panel = figure.add_axes([left / total[0], ROOM_BELOW / total[1],
                                 width / total[0], height / total[1]])
        panel.imshow(image, aspect="auto", interpolation="none")
        panel.axis("off")
        figure.text((left + width / 2) / total[0], 1 - 0.33 / total[1], title, ha="center",
                    fontsize=13, color="0.25")
        left += width
    bar_height = min(0.75 * height, 3.2)
    bar_of(figure, field, [(left + 0.15) / total[0], (ROOM_BELOW + (height - bar_height) / 2) / total[1],
                           0.16 / total[0], bar_height / total[1]])
    figure.savefig(arguments.output, dpi=arguments.dpi, facecolor="white")


def deformed_by(scale):
    return "deformed" if scale == 1 else f"displacements × {scale:g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("xdmf", help="the file that trefoil wrote")
    parser.add_argument("-o", "--output", help="the picture (default: beside the file, .png)")
    add_view_options(parser)
    parser.add_argument("--dpi", type=float, default=160)
    arguments = parser.parse_args()
    arguments.output = arguments.output or os.path.splitext(arguments.xdmf)[0] + ".png"
    try:
        step = trefoil.read_steps(arguments.xdmf)[-1]
        obstacles = Obstacles(arguments.xdmf)
        if arguments.field not in step.fields:
            fail(f"{arguments.xdmf} has no field '{arguments.field}', but "
                 + ", ".join(step.fields))
    except (OSError, KeyError, ValueError, AttributeError,
            xml.etree.ElementTree.ParseError) as error:
        fail(f"cannot read {arguments.xdmf}: {error}")
    try:
        picture(step, obstacles, arguments)
    except (OSError, ValueError) as error:
        fail(f"cannot draw {arguments.output}: {error}")


if __name__ == "__main__":
    main()
