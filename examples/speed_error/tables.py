"""The results as CSV and Markdown."""
import csv
import math

from . import judgement
from .judgement import ANOTHER, FAILED, MINIMUM, UNFINISHED, geometric_mean

OVERVIEW_LEVELS = (1e-2, 1e-4, 1e-6, 1e-8)
STOP_TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9)


def power(level):
    return f"1e{round(math.log10(level)):d}"


def number(value, digits=2):
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}f}"


def markdown(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|---" * len(header) + "|"]
    return "\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]) + "\n"


def how_exact(reference):
    if math.isfinite(reference.support):
        return f"exact to about {reference.support:.0e}"
    return "which had not converged: nobody knows how exact"


def write_csv(path, judged, ranks):
    """One row a run and error level; empty cells where the level is not reached."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["scene", "rule", "guess", "search", "ranks", "outcome", "final_error",
                         "relative_error", "iterations", "linear_solves", "seconds"])
        for (scene, method), run in judged.items():
            for level in judgement.LEVELS:
                writer.writerow([scene.name, method.rule, method.guess, method.search, ranks,
                                 run.outcome, f"{run.final_error:.3e}", power(level),
                                 *(run.levels.get(level) or ("", "", ""))])


def overview(judged, references, methods, base):
    """A row a method: outcomes, and the geometric means of its ratios to the base method over the
    scenes in which both came to the error."""
    rows = []
    for method in methods:
        outcomes = [run.outcome for (_, other), run in judged.items() if other == method]
        row = [method.name] + [outcomes.count(outcome) or ""
                               for outcome in (MINIMUM, ANOTHER, UNFINISHED, FAILED)]
        for level in OVERVIEW_LEVELS:
            iterations = judgement.ratios_to(judged, method, base, level, 0)
            times = judgement.ratios_to(judged, method, base, level, 2)
            reached = sum(1 for (_, other), run in judged.items()
                          if other == method and run.levels.get(level))
            row.append(f"{number(geometric_mean(iterations.values()))} / "
                       f"{number(geometric_mean(times.values()))} ({reached})")
        rows.append(row)
    header = ["method", "minimum", "another", "unfinished", "failed",
              *(f"to {power(level)}" for level in OVERVIEW_LEVELS)]
    loose = [scene.name for scene, reference in references.items()
             if reference is None or not reference.support <= min(judgement.LEVELS)]
    warning = (f"The lowest energy is not known to {power(min(judgement.LEVELS))}, and errors are "
               f"too small, in: {', '.join(loose)}.\n\n" if loose else "")
    return (f"## Overview: {len(references)} scenes\n\n{warning}"
            f"Runs by outcome; iterations / seconds relative to `{base.name}`, geometric means over "
            "the scenes in which\nboth came to the relative energy error (in how many the method "
            "did).\n\n" + markdown(header, rows) + "\n")


def by_scene(judged, references):
    """For each scene: iterations and seconds of every run to every other error."""
    text = "## Every scene\n\nIterations (linear solves) seconds to a relative energy error.\n\n"
    for scene, reference in references.items():
        text += f"### {scene.name}\n\n"
        if reference is None:
            text += "No run left an energy.\n\n"
            continue
        text += (f"Lowest energy {reference.energy:.14g}, scale {reference.scale:.4g}, found by "
                 f"`{reference.method.name}`, {how_exact(reference)}.\n\n")
        rows = []
        for (other, method), run in judged.items():
            if other != scene:
                continue
            cells = [f"{cost[0]} ({cost[1]}) {cost[2]:.3g}" if cost else "-"
                     for cost in map(run.levels.get, OVERVIEW_LEVELS)]
            outcome = run.outcome if run.outcome == MINIMUM else f"**{run.outcome}**"
            rows.append([method.name, outcome, f"{run.final_error:.0e}", *cells])
        text += markdown(["method", "outcome", "final error",
                          *(power(level) for level in OVERVIEW_LEVELS)], rows) + "\n"
    return text


def stop_tests(judged, references, methods):
    """Where the default stop test with several tolerances would have ended each run."""
    rows = []
    for method in methods:
        for scene, reference in references.items():
            run = judged.get((scene, method))
            if run is None or run.record is None:
                continue
            cells = []
            for tolerance in STOP_TOLERANCES:
                stop = judgement.stop_at(run.record, reference, tolerance)
                cells.append(f"{stop[0]}: {stop[1]:.0e}" if stop else "-")
            rows.append([method.name, scene.name, *cells])
    return ("## Stop tests\n\nIterations and relative energy error with which a run would end at "
            "these energy tolerances (decrement\nover energy scale); `-` where it never "
            "would.\n\n"
            + markdown(["method", "scene", *map(power, STOP_TOLERANCES)], rows) + "\n")


def compare_with_paper(records, paper_records, methods):
    """{method: {scene: what against_paper() says, or None}}"""
    return {method: {scene: judgement.against_paper(records[scene, method], theirs, scene.paper)
                     if theirs and records.get((scene, method)) else None
                     for scene, theirs in paper_records.items()} for method in methods}


def paper_overview(comparison):
    """To the energy at which the paper's method stops: a row a method, means and worst."""
    header = ["method", "scenes", "iterations: mean", "worst", "seconds: mean", "worst"]
    rows = []
    for method, scenes in comparison.items():
        reached = {scene: here for scene, here in scenes.items() if here}
        row = [method.name, f"{len(reached)} of {len(scenes)}"]
        for quantity in (1, 2):
            values = [(here[quantity], scene.name) for scene, here in reached.items()]
            worst = max(values, default=(math.nan, ""))
            row += [number(geometric_mean(value for value, _ in values), 3),
                    f"{number(worst[0])} {worst[1]}"]
        rows.append(row)
    return ("## Against the paper\n\nTo the energy at which the paper's method stops: iterations "
            "relative to the paper's count, seconds (guess\nincluded) relative to its method run "
            "here. Geometric means and worst over the scenes in which it is\nreached.\n\n"
            + markdown(header, rows) + "\n")


def paper_by_scene(comparison):
    rows = [[method.name, scene.name, scene.paper["iterations"],
             *((here[0], number(here[1]), number(here[2])) if here else ("not reached", "-", "-"))]
            for method, scenes in comparison.items() for scene, here in scenes.items()]
    return markdown(["method", "scene", "paper's iterations", "iterations", "ratio",
                     "seconds ratio"], rows) + "\n"
