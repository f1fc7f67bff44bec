"""The curves of a run: convergence, and what load or time steps lead to."""

from history import final_energies, load_steps
from report_page.charts import Series, line_chart, short

SHAPES = {1: ("o", "w = 1"), 0.5: ("v", "w = ½"), 0: ("s", "w = 0")}


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
    keys = ("energy", "decrement", "weight", "step")
    return [f"iteration {entry['k']}: " + ", ".join(f"{key} {short(entry[key])}" for key in keys
                                                    if entry.get(key) is not None)
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
            known = energy is not None and final is not None
            if known and energy - final > 2.3e-16 * max(abs(final), scale):
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
    probes = [Series(name, t, [_length(step["probes"][name]) for step in steps])
              for name in steps[-1].get("probes") or {}]
    if probes:
        parts.append(line_chart("Displacements of the probes over the steps", probes, "t",
                                "size of the displacement" + (f" [{units.length}]" if units.length else "")))
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
