"""What the JSON record says, as parts of the page."""

import html
import json
import re

SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# Keys of `result`: words, quantity. What is not there is not shown.
RESULTS = [("strain_energy", "strain energy", "energy"), ("load_work", "work of the loads", "energy"),
           ("energy", "energy that was minimised", "energy"), ("volume", "volume", "volume"),
           ("least_det_F", "least det F", "1"),
           ("largest_displacement", "largest displacement", "length"),
           ("largest_von_mises", "largest von Mises stress", "stress"),
           ("inverted", "inverted elements", "1"), ("gradient_norm", "gradient norm", "force"),
           ("newton_decrement", "Newton decrement", "energy")]
PHASES = [("read", "read"), ("setup", "set-up"), ("guess", "starting guess"), ("assembly", "assembly"),
          ("filter", "filter"), ("linear_solve", "linear solve"), ("line_search", "line search"),
          ("output", "output"), ("other", "other")]


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
        short = f"{value:.{digits}g}"
        return (f"{value:.0f}" if "e" in short else short).replace("-", "−")
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
    """Components for people: what is below 1e-9 of the largest is 0."""
    floor = 1e-9 * max(map(abs, values), default=0)
    shown = (number(float(value) if abs(value) > floor else 0, 4) for value in values)
    return "(" + ", ".join(shown) + ")"


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
    return with_unit(value["value"], unit) + f" at {vector(value['at'])}"


def forces_tables(record, units):
    """Reactions of constraints, forces of loads, regions and probes, as far as the record has them."""
    def named(key, name, columns):
        return _table_of(record.get(key) or [], name, [
            (column, words + (f" [{html.escape(units.of(quantity))}]" if units.of(quantity) else ""))
            for column, words, quantity in columns])

    regions = "" if len(record.get("regions") or []) < 2 else named("regions", "Regions", [
        ("cells", "cells", ""), ("volume", "volume", "volume"), ("mass", "mass", "")])
    probes = [{"name": name, "displacement": value}
              for name, value in (record.get("result", {}).get("probes") or {}).items()]
    return (named("constraints", "Constraints", [
        ("vertices", "vertices", ""), ("area", "area", "area"), ("reaction", "reaction", "force"),
        ("moment", "moment about the origin", "moment")])
            + named("loads", "Loads", [("facets", "facets", ""), ("area", "area", "area"),
                                       ("force", "force", "force")])
            + regions
            + _table_of(probes, "Probes", [("displacement", "displacement"
                                            + (f" [{html.escape(units.length)}]" if units.length else ""))]))


def _table_of(rows, name, columns):
    """Objects with a name, and those of the columns (key, words) that any of them has."""
    columns = [(key, words) for key, words in columns if any(row.get(key) is not None for row in rows)]
    if not columns:
        return ""
    shown = [[html.escape(str(row["name"]))]
             + [vector(row[key]) if isinstance(row.get(key), list) else number(row.get(key))
                for key, _ in columns] for row in rows]
    return table(shown, [name[:-1].lower()] + [words for _, words in columns], name)


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
