"""What the JSON record says, as parts of the page."""

import html
import json
import re

from history import final_energies, load_steps
from report_page.charts import Series, line_chart, short

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# Keys of `result`: words, quantity. What is not there is not shown.
RESULTS = [("strain_energy", "strain energy", "energy"), ("load_work", "work of the loads", "energy"),
           ("energy", "energy that was minimised", "energy"), ("volume", "volume", "volume"),
           ("mass", "mass", ""), ("least_determinant_F", "least det F", "1"),
           ("least_det_F", "least det F", "1"), ("largest_displacement", "largest displacement", "length"),
           ("largest_von_mises", "largest von Mises stress", "stress"),
           ("inverted", "inverted elements", "1"), ("gradient_norm", "gradient norm", "force"),
           ("newton_decrement", "Newton decrement", "energy")]
PHASES = [("read", "read"), ("setup", "set-up"), ("guess", "starting guess"), ("assembly", "assembly"),
          ("filter", "filter"), ("linear_solve", "linear solve"), ("line_search", "line search"),
          ("output", "output"), ("other", "other")]
SHAPES = {1: ("o", "w = 1"), 0.5: ("v", "w = ½"), 0: ("s", "w = 0")}


def number(value, digits=5):
    """A number for people: 1 254, 0.3, 8.66734 × 10⁵."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return html.escape(value)
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f").replace("-", "−")
    if value != value or value in (float("inf"), -float("inf")):
        return {"inf": "∞", "-inf": "−∞"}.get(str(value), "not a number")
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        return f"{value:.{digits}g}".replace("-", "−")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa.replace('-', '−')} × 10{str(int(exponent)).translate(SUPERSCRIPTS)}"


def with_unit(value, unit):
    return number(value) + (f"\u202f{html.escape(unit)}" if unit else "")


def seconds_of(value):
    return f"{value:.3g} s" if value >= 1e-3 else "< 0.001 s"


def sentence(text):
    """As HTML, in which no option is broken in two."""
    return re.sub(r"-[a-z]\w+", r'<span class="word">\g<0></span>', html.escape(text))


def vector(values):
    return "(" + ", ".join(number(float(value), 4) for value in values) + ")"


def table(rows, head=None, name=""):
    """Rows of cells that are HTML already; the first cell of each is its heading."""
    lines = ['<div class="wide"><table>' if len(rows and rows[0]) > 3 else "<table>"]
    if name:
        lines.append(f"<caption>{html.escape(name)}</caption>")
    if head:
        lines.append("<thead><tr>" + "".join(f'<th scope="col">{each}</th>' for each in head)
                     + "</tr></thead>")
    lines.append("<tbody>")
    for first, *others in rows:
        lines.append(f'<tr><th scope="row">{first}</th>'
                     + "".join(f"<td>{each}</td>" for each in others) + "</tr>")
    lines.append("</tbody></table>" + ("</div>" if len(rows and rows[0]) > 3 else ""))
    return "".join(lines)


def count_of(count, one, many=None):
    return f"{number(count)} {one if count == 1 else many or one + 's'}"


def verdict(record):
    """A class for its colour, and the words."""
    result = record["result"]
    if not result["converged"]:
        return "bad", "Not converged"
    if result.get("inverted"):
        return "doubtful", "Converged, with inverted elements"
    if result.get("minimum") is False:
        return "doubtful", "Converged, not to a minimum"
    return "good", "Converged"


def summary(record):
    """The line below the title."""
    result, mesh, solver = record["result"], record["mesh"], record["solver"]
    parts = [count_of(mesh["elements"], mesh["element"] + " element"),
             count_of(mesh["free_dofs"], "unknown"), count_of(result["iterations"], "iteration"),
             f"{number(record['time']['total'], 3)} s on {count_of(solver['ranks'], 'rank')}"]
    return " · ".join(parts)


def warnings(record, more=()):
    """Sentences that a reader must not miss."""
    result = record["result"]
    said = list(result.get("warnings") or [])
    if not result["converged"]:
        said.insert(0, f"The solver stopped without an equilibrium: {result['reason']}.")
    elif not any("invert" in each for each in said) and result.get("inverted"):
        said.append(f"{count_of(result['inverted'], 'element')} ended inverted.")
    if result.get("minimum") is False:
        said.append("The state is no minimum of the energy: the Hessian has a negative eigenvalue.")
    return said + list(more)


def results_table(record, units):
    result = record["result"]
    rows = [[words, _value(result[key], units.of(quantity))]
            for key, words, quantity in RESULTS if result.get(key) is not None]
    scale = result.get("energy_scale")
    if result.get("error_estimate") is not None and scale:
        rows.append(["solver's relative energy error", number(result["error_estimate"] / scale, 2)])
    if result.get("minimum") is not None:
        rows.append(["at a minimum (H positive definite)", number(result["minimum"])])
    rows.append(["stopped because", sentence(result["reason"])])
    return table(rows)


def _value(value, unit):
    """A number, or an object with a number and where it is."""
    if not isinstance(value, dict):
        return with_unit(value, unit)
    amount = next((each for each in value.values() if isinstance(each, (int, float))), None)
    place = next((each for each in value.values() if isinstance(each, list)), None)
    return with_unit(amount, unit) + (f" at {vector(place)}" if place else "")


def forces_tables(record, units):
    """Reactions of constraints, forces of loads, regions and probes, where the record has them."""
    force, moment, area = (units.of(each) for each in ("force", "moment", "area"))
    titled = lambda words, unit: words + (f" [{html.escape(unit)}]" if unit else "")
    parts = []
    if record.get("constraints"):
        parts.append(table([[html.escape(each["name"]), number(each.get("vertices")),
                             number(each.get("area")), vector(each["reaction"]), vector(each["moment"])]
                            for each in record["constraints"] if "reaction" in each],
                           ["constraint", "vertices", titled("area", area), titled("reaction", force),
                            titled("moment about the origin", moment)], "Reactions"))
    if record.get("loads"):
        parts.append(table([[html.escape(each["name"]), number(each.get("facets")),
                             number(each.get("area")), vector(each["force"])]
                            for each in record["loads"] if "force" in each],
                           ["load", "facets", titled("area", area), titled("force", force)], "Loads"))
    if len(record.get("regions") or []) > 1:
        parts.append(table([[html.escape(str(each["name"])), number(each["cells"]),
                             number(each["volume"]), number(each.get("mass"))]
                            for each in record["regions"]],
                           ["region", "cells", titled("volume", units.of("volume")), "mass"], "Regions"))
    probes = _probes(record)
    if probes:
        parts.append(table([[html.escape(name), vector(value)] for name, value in probes.items()],
                           ["probe", titled("displacement", units.of("length"))], "Probes"))
    return "".join(parts)


def _probes(record):
    """Displacements by name of the probe, at the end."""
    probes = record.get("probes") or (record.get("steps") or [{}])[-1].get("probes") or {}
    if isinstance(probes, list):
        probes = {each["name"]: each.get("displacement") for each in probes}
    return {name: value["displacement"] if isinstance(value, dict) else value
            for name, value in probes.items() if value is not None}


def convergence_charts(record):
    history = [entry for entry in record["history"] if entry.get("decrement") is not None]
    if not history:
        return ""
    count = list(range(len(record["history"])))
    borders = tuple(first for first, _ in load_steps(record)[1:])
    parts = [_decrement_chart(record, count, borders), _energy_chart(record, count, borders)]
    used = {shape: words for shape, words in
            (SHAPES.get(entry["weight"], ("d", "another w")) for entry in record["history"])}
    names = {"o": "disc", "v": "triangle", "s": "square", "d": "diamond"}
    key = ", ".join(f"{names[shape]}: {words}" for shape, words in used.items())
    return "".join(parts) + f'<p class="quiet full">Filter weight of each step: {key}.</p>'


def _hints(record):
    return [f"iteration {entry['k']}: energy {short(entry['energy'])}, decrement "
            f"{short(entry['decrement'] or 0)}, w = {entry['weight']:g}, step {entry['step']:.3g}"
            if entry.get("energy") is not None else f"iteration {entry['k']}"
            for entry in record["history"]]


def _shapes(record):
    return "".join(SHAPES.get(entry["weight"], ("d", ""))[0] for entry in record["history"])


def _decrement_chart(record, count, borders):
    scale = abs(record["result"].get("energy_scale") or 0) or 1
    nan = float("nan")
    values = [(entry["decrement"] if entry["decrement"] is not None else nan) / scale
              for entry in record["history"]]
    options = record["solver"].get("options", {})
    absolute = float(options.get("snes_trefoil_decrement_tolerance") or 0)
    tolerance = float(options.get("snes_trefoil_energy_tolerance") or (0 if absolute else 1e-8))
    level = absolute / scale if absolute else tolerance
    return line_chart("Newton decrement: how far the energy still can fall",
                      [Series("decrement", count, values, _hints(record), _shapes(record), borders)],
                      "iteration", "decrement / energy scale", log=True, whole_x=True,
                      verticals=[border - 0.5 for border in borders],
                      levels=[(level, "tolerance")] if level > 0 else [])


def _energy_chart(record, count, borders):
    scale = abs(record["result"].get("energy_scale") or 0) or 1
    heights = [float("nan")] * len(count)
    for (first, end), final in zip(load_steps(record), final_energies(record)):
        for k in range(first, end):
            energy = record["history"][k]["energy"]
            if energy is not None and final is not None and energy - final > 2.3e-16 * max(abs(final), scale):
                heights[k] = energy - final
    if all(height != height for height in heights):
        return ""
    return line_chart("Energy above where " + ("each load step" if borders else "the run") + " ended",
                      [Series("energy", count, heights, _hints(record), _shapes(record), borders)],
                      "iteration", "energy − final energy", log=True, whole_x=True,
                      verticals=[border - 0.5 for border in borders])


def step_charts(record, units):
    """Reactions and probes over the load or time steps."""
    steps = record.get("steps") or []
    if len(steps) < 2:
        return ""
    t = [step["t"] for step in steps]
    parts = []
    names = list((steps[-1].get("reaction") or {}))
    reactions = [Series(name, t, [_length(step["reaction"][name]) for step in steps]) for name in names]
    force = units.of("force")
    if reactions:
        parts.append(line_chart("Reactions over the steps", reactions, "t",
                                "size of the reaction" + (f" [{force}]" if force else "")))
    if steps[-1].get("kinetic_energy") is not None:
        parts.append(line_chart("Energies over time", [
            Series(words, t, [step.get(key, float("nan")) for step in steps])
            for key, words in (("strain_energy", "strain"), ("kinetic_energy", "kinetic"))],
            "t", "energy" + (f" [{units.of('energy')}]" if units.length else "")))
    elif steps[-1].get("strain_energy") is not None:
        parts.append(line_chart("Strain energy over the steps", [
            Series("strain energy", t, [step["strain_energy"] for step in steps])], "t",
            "energy" + (f" [{units.of('energy')}]" if units.length else "")))
    return "".join(parts)


def _length(values):
    return sum(value * value for value in values) ** 0.5


def steps_table(record):
    steps = record.get("steps") or []
    if len(steps) < 2:
        return ""
    keys = [key for key in ("t", "iterations", "strain_energy", "kinetic_energy", "load_work", "energy")
            if key in steps[-1]]
    rows = [[number(step.get(key)) for key in keys] for step in steps]
    return details("All steps", table(rows, [key.replace("_", " ") for key in keys]))


def history_table(record):
    keys = [("k", "iteration"), ("energy", "energy"), ("gradient_norm", "gradient norm"),
            ("weight", "weight w"), ("decrement", "decrement"), ("rho", "ρ"), ("step", "step"),
            ("trials", "trials"), ("indefinite", "indefinite"), ("seconds", "seconds")]
    keys = [(key, words) for key, words in keys if record["history"] and key in record["history"][0]]
    rows = [[number(entry.get(key), 6 if key == "energy" else 4) for key, _ in keys]
            for entry in record["history"]]
    return details("All iterations", table(rows, [words for _, words in keys]))


def details(name, content):
    return f"<details><summary>{html.escape(name)}</summary>{content}</details>"


def time_bars(record):
    """Seconds by phase, the longest first in length, in the order in which they happen."""
    seconds = record["time"]
    shown = [(words, seconds[key]) for key, words in PHASES if seconds.get(key)]
    longest = max((value for _, value in shown), default=1) or 1
    bars = "".join(f'<li><span>{words}</span><b style="--share:{value / longest:.4f}"></b>'
                   f"<em>{seconds_of(value)}</em></li>" for words, value in shown)
    memory = record.get("memory", {})
    rows = [[words, f"{memory[key] / 2**20:,.1f} MiB"]
            for key, words in (("peak_bytes", "largest use, all ranks"), ("mesh_bytes", "mesh"),
                               ("matrix_bytes", "matrices"), ("factor_bytes", "factors"))
            if memory.get(key)]
    return f'<ul class="bars">{bars}</ul>' + (table(rows, name="Memory") if rows else "")


def what_was_run(record):
    """Mesh, solver and the options as given."""
    mesh, solver = record["mesh"], record["solver"]
    rows = [["mesh", f"{count_of(mesh['vertices'], 'vertex', 'vertices')}, "
             f"{count_of(mesh['elements'], mesh['element'] + ' element')}"
             + (f", {count_of(mesh['parts'], 'part')}" if mesh.get("parts") else "")],
            ["unknowns", f"{number(mesh['free_dofs'])} of {number(mesh['dofs'])}"],
            ["filter", html.escape(str(solver["filter"]))],
            ["linear solver", html.escape(str(solver["linear"])) if solver.get("linear") else None],
            ["ranks", number(solver["ranks"])],
            ["inverted at the start", number(mesh.get("inverted_at_start"))]]
    options = "\n".join(f"-{name} {_quoted(value)}" if value not in (None, "") else f"-{name}"
                        for name, value in sorted(solver.get("options", {}).items()))
    complete = json.dumps(record, indent=1, ensure_ascii=False)
    return ('<div class="columns"><div>' + table([row for row in rows if row[1] is not None])
            + f"</div><pre>{html.escape(options)}</pre></div>"
            + details("The complete record", f"<pre>{html.escape(complete)}</pre>"))


def _quoted(value):
    text = str(value)
    return f'"{text}"' if any(letter in text for letter in " ()*<>&|;") else text
