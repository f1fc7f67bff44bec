"""The results as pictures, each as PNG and SVG."""
import os
import re

import numpy as np

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.lines import Line2D
except ImportError as missing:
    raise SystemExit(f"speed_against_error: {missing.name} is missing: apt install python3-numpy "
                     "python3-matplotlib, then use /usr/bin/python3; or --no-plots") from missing

from . import judgement

PROFILE_LEVELS = (1e-2, 1e-4, 1e-6, 1e-8)
LINES = ("-", "--", ":", "-.")
WIDTHS = (2.0, 0.9, 1.4, 0.5)


class Look:
    """Rules are colours, guesses are line styles, searches are widths; the best come last so that
    they lie on top."""

    def __init__(self, methods):
        self.rules = list(dict.fromkeys(method.rule for method in methods))
        self.guesses = list(dict.fromkeys(method.guess for method in methods))[::-1]
        self.searches = list(dict.fromkeys(method.search for method in methods))[::-1]

    def of(self, method):
        return {"color": plt.get_cmap("tab10")(self.rules.index(method.rule) % 10),
                "linestyle": LINES[self.guesses.index(method.guess) % len(LINES)],
                "linewidth": WIDTHS[self.searches.index(method.search) % len(WIDTHS)]}

    def legend(self):
        entries = [Line2D([], [], color=plt.get_cmap("tab10")(i % 10), linewidth=2, label=rule)
                   for i, rule in enumerate(self.rules)]
        entries += [Line2D([], [], color="0.3", linestyle=LINES[i % len(LINES)], label=guess)
                    for i, guess in enumerate(self.guesses)]
        entries += [Line2D([], [], color="0.3", linewidth=WIDTHS[i % len(WIDTHS)], label=search)
                    for i, search in enumerate(self.searches)]
        return entries


def tidy(axes):
    axes.grid(True, color="0.92")
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def save(figure, look, folder, name):
    entries, columns = look.legend(), 8
    rows = -(-len(entries) // columns)
    figure.tight_layout(rect=(0, 0.02 + 0.05 * rows, 1, 1))
    figure.legend(handles=entries, loc="lower center", ncol=columns, frameon=False, fontsize=9)
    for ending in ("png", "svg"):
        figure.savefig(os.path.join(folder, f"{name}.{ending}"), dpi=110)
    plt.close(figure)


def draw_scene(folder, scene, reference, judged, look):
    """Energy error over seconds and over iterations; flat ends are other minima."""
    figure, (by_time, by_iteration) = plt.subplots(1, 2, figsize=(11, 4.6), sharey=True)
    lowest, unknown = 1e-12, 1e-8  # of an error that is drawn; where the reference has no decrement
    floor = max(reference.support, lowest) if np.isfinite(reference.support) else unknown
    for (other, method), run in judged.items():
        if other != scene or run.record is None:
            continue
        errors = np.maximum(judgement.errors_of(run.record, reference), floor)
        costs = [judgement.cost_at(run.record, k) for k in range(len(errors))]
        by_time.plot([cost[2] for cost in costs], errors, **look.of(method))
        by_iteration.plot([cost[0] for cost in costs], errors, **look.of(method))
    by_time.set_xscale("log")
    by_time.set_xlabel("seconds, starting guess included")
    by_time.set_ylabel("relative energy error [-]")
    by_iteration.set_xlabel("iterations [-]")
    by_time.set_yscale("log")
    highest = 10
    by_time.set_ylim(floor / 2, highest)
    for axes in (by_time, by_iteration):
        tidy(axes)
    figure.suptitle(scene.name)
    save(figure, look, folder, "scene_" + re.sub(r"[^\w.-]+", "_", scene.name))


def draw_profiles(folder, judged, references, look):
    """Share of the scenes solved to an error within a multiple of the fastest method's time."""
    figure, panels = plt.subplots(1, len(PROFILE_LEVELS), figsize=(13, 4.4), sharey=True)
    scenes, largest = len(references), 100
    for axes, level in zip(panels, PROFILE_LEVELS):
        for method, multiples in judgement.profile(judged, level).items():
            reached = [multiple for multiple in multiples if multiple <= largest]
            shares = np.arange(len(reached) + 1) / scenes
            axes.step([1, *reached, largest], [*shares, shares[-1]], where="post",
                      **look.of(method))
        axes.set_xscale("log")
        axes.set_xlim(1, largest)
        axes.set_title(f"to relative energy error {level:.0e}", fontsize=10)
        axes.set_xlabel("multiple of the fastest's time [-]")
        tidy(axes)
    panels[0].set_ylim(0, 1.02)
    panels[0].set_ylabel(f"share of {scenes} scenes [-]")
    save(figure, look, folder, "profiles")


def draw_all(folder, judged, references, methods):
    look = Look(methods)
    for scene, reference in references.items():
        if reference is not None:
            draw_scene(folder, scene, reference, judged, look)
    draw_profiles(folder, judged, references, look)
