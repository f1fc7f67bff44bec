"""Line charts as SVG, in the colours of the page."""

import dataclasses
import html
import math

WIDTH, HEIGHT = 560, 300
LEFT, RIGHT, TOP, BOTTOM = 70, 16, 16, 44


@dataclasses.dataclass
class Series:
    """One line: points that are not finite leave a gap, and no line leads to the points `breaks`.
    `hints`: a text a point, shown on hovering; `shapes`: a letter a point, o (disc), v (triangle),
    s (square) or d (diamond)."""
    label: str
    x: list
    y: list
    hints: list = None
    shapes: str = ""
    breaks: tuple = ()


def short(value):
    """A number as it stands at an axis."""
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e5:
        return f"{value:.6g}"
    mantissa, exponent = f"{value:.3e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".")
    power = "10" + str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return {"1": power, "-1": "−" + power}.get(mantissa, f"{mantissa}·{power}")


def _round_ticks(low, high, about=5):
    """Multiples of 1, 2 or 5 times a power of ten, from low to high."""
    raw = (high - low) / about
    power = 10 ** math.floor(math.log10(raw))
    step = next(step * power for step in (1, 2, 5, 10) if step * power >= raw * 0.999)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


class Axis:
    """From values to pixels; `low` and `high` are widened to what is round."""

    def __init__(self, values, pixels, log=False, whole=False):
        self.log, self._pixels = log, pixels
        values = [value for value in values if math.isfinite(value) and (value > 0 or not log)]
        low, high = (min(values), max(values)) if values else ((1, 10) if log else (0, 1))
        if log:
            self._low, self._high = math.floor(math.log10(low)), math.ceil(math.log10(high))
            if self._low == self._high:
                self._high += 1
            every = max(1, -(-(self._high - self._low) // 8))
            self.ticks = [10.0 ** k for k in range(self._low, self._high + 1, every)]
        else:
            if high - low <= 1e-12 * max(abs(low), abs(high)):
                low, high = (low - 0.5, high + 0.5) if whole or low == 0 else sorted((0, 2 * low))
            room = 0 if whole else 0.04 * (high - low)
            self._low, self._high = low - room, high + room
            self.ticks = _round_ticks(self._low, self._high)
            if whole:
                self.ticks = [tick for tick in self.ticks if tick == round(tick)]

    def __call__(self, value):
        if not math.isfinite(value) or (self.log and value <= 0):
            return None
        share = ((math.log10(value) if self.log else value) - self._low) / (self._high - self._low)
        return self._pixels[0] + share * (self._pixels[1] - self._pixels[0])


def _mark(shape, x, y):
    """The path of a marker."""
    return {"v": f"M{x - 4.5:.1f} {y - 3.6:.1f}h9l-4.5 8z",
            "s": f"M{x - 3.6:.1f} {y - 3.6:.1f}h7.2v7.2h-7.2z",
            "d": f"M{x:.1f} {y - 4.8:.1f}l4.8 4.8l-4.8 4.8l-4.8 -4.8z"}.get(
        shape, f"M{x - 3.6:.1f} {y:.1f}a3.6 3.6 0 1 0 7.2 0a3.6 3.6 0 1 0 -7.2 0z")


def _curve(series, number, x_axis, y_axis):
    places = [(x_axis(x), y_axis(y)) for x, y in zip(series.x, series.y)]
    path, pen_down = [], False
    for k, (x, y) in enumerate(places):
        seen = x is not None and y is not None
        if seen:
            path.append(f"{'L' if pen_down and k not in series.breaks else 'M'}{x:.1f} {y:.1f}")
        pen_down = seen
    drawn = [f'<path class="line c{number % 8}" d="{"".join(path)}"/>']
    for k, (x, y) in enumerate(places):
        if x is None or y is None or len(places) > 400:
            continue
        hint = series.hints[k] if series.hints else f"{series.label} {short(series.y[k])}"
        shape = series.shapes[k] if series.shapes else "o"
        drawn.append(f'<path class="mark c{number % 8}" d="{_mark(shape, x, y)}">'
                     f"<title>{html.escape(hint)}</title></path>")
    return drawn


def line_chart(title, series, x_title, y_title, log=False, whole_x=False, verticals=(), levels=()):
    """The chart; `verticals`: places on the x axis with a thin line, `levels`: (value, words) on the
    y axis."""
    x_axis = Axis([x for each in series for x in each.x], (LEFT, WIDTH - RIGHT), whole=whole_x)
    y_axis = Axis([y for each in series for y in each.y] + [value for value, _ in levels],
                  (HEIGHT - BOTTOM, TOP), log)
    drawn = [f'<svg class="chart" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
             f'aria-label="{html.escape(title, quote=True)}">']
    for tick in y_axis.ticks:
        y = y_axis(tick)
        drawn.append(f'<path class="grid" d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}"/>'
                     f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{short(tick)}</text>')
    for tick in x_axis.ticks:
        drawn.append(f'<text x="{x_axis(tick):.1f}" y="{HEIGHT - BOTTOM + 18}" '
                     f'text-anchor="middle">{short(tick)}</text>')
    for place in verticals:
        drawn.append(f'<path class="vertical" d="M{x_axis(place):.1f} {TOP}V{HEIGHT - BOTTOM}"/>')
    for value, words in levels:
        y = y_axis(value)
        drawn.append(f'<path class="level" d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}"/>'
                     f'<text class="quiet" x="{LEFT + 6}" y="{y - 5:.1f}">'
                     f"{html.escape(words)}</text>")
    drawn.append(f'<path class="axis" d="M{LEFT} {HEIGHT - BOTTOM}H{WIDTH - RIGHT}"/>')
    for number, each in enumerate(series):
        drawn += _curve(each, number, x_axis, y_axis)
    drawn.append(f'<text class="name" x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 6}" '
                 f'text-anchor="middle">{html.escape(x_title)}</text>'
                 f'<text class="name" transform="translate(14 {(TOP + HEIGHT - BOTTOM) / 2}) rotate(-90)" '
                 f'text-anchor="middle">{html.escape(y_title)}</text></svg>')
    key = "".join(f'<li><i class="c{number % 8}"></i>{html.escape(each.label)}</li>'
                  for number, each in enumerate(series)) if len(series) > 1 else ""
    return (f'<figure><figcaption>{html.escape(title)}</figcaption>{"".join(drawn)}'
            + (f'<ul class="key">{key}</ul>' if key else "") + "</figure>")
