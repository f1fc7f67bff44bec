"""What records say: errors against the best minimiser known, who found another minimum, profiles.

A relative energy error is (f - f*) / energy_scale(x*), with x* the minimiser of lowest energy that
any run of a scene found.
"""
import math
from dataclasses import dataclass, field

LEVELS = tuple(10.0 ** -digits for digits in range(1, 9))
SAME_MINIMUM = 1e-6
MINIMUM, ANOTHER, UNFINISHED, FAILED = ("minimum", "another minimum", "not converged", "failed")


@dataclass(frozen=True)
class Reference:
    """The lowest energy that was found for a scene. `support`: how far it may be from its
    minimum's, relative to `scale`, going by its last Newton decrement and rounding."""
    energy: float
    scale: float
    method: object
    support: float


@dataclass
class Judged:
    """One run: outcome, its own final error, and for each error level what it took to get there,
    (iterations, linear solves, seconds), or None."""
    outcome: str
    final_error: float = math.nan
    levels: dict = field(default_factory=dict)
    record: dict = None


def reference_of(records):
    """Of {method: record} the lowest final energy; None where no run left a finite one."""
    finite = [(record["result"]["energy"], method) for method, record in records.items()
              if record and record["result"]["energy"] is not None]
    if not finite:
        return None
    energy, method = min(finite, key=lambda pair: pair[0])
    result = records[method]["result"]
    scale = result["energy_scale"]
    decrement = result["newton_decrement"]
    if decrement is None:
        decrement = math.inf
    return Reference(energy, scale, method,
                     max(decrement, math.ulp(1.0) * abs(energy)) / scale if scale else math.inf)


def relative_error(energy, reference):
    if energy is None or not reference.scale:
        return math.nan
    return (energy - reference.energy) / reference.scale


def is_of_last_loads(record, entry):
    """Whether a state is one of the last load step, and on the way to the end: only their energies
    are those of the scene."""
    return (not entry.get("rejected")
            and entry.get("load_step") == record["history"][-1].get("load_step"))


def errors_of(record, reference):
    """The relative energy error before every step, and at last; infinite in all load steps but the
    last."""
    return [relative_error(entry["energy"], reference) if is_of_last_loads(record, entry)
            else math.inf for entry in record["history"]]


def cost_at(record, k):
    """(iterations, linear solves, seconds) of a run that ends at state k: the direction that a stop
    test needs is included, and so is the starting guess. A path that was walked in vain after a leap
    stands before it in the history; what came later is no cost of a state."""
    history, result = record["history"], record["result"]
    entry = history[k]
    later = [other for other in history[:k] if other["seconds"] > entry["seconds"]]
    solves_of_later = later[-1]["linear_solves"] if later else 0
    return (min(entry["k"] + 1 - len(later), result["iterations"]),
            result.get("guess_linear_solves", 0) + entry["linear_solves"] - solves_of_later,
            entry["seconds"])


def first_at_or_below(values, bound):
    return next((k for k, value in enumerate(values) if value <= bound), None)


def outcome_of(record, reference):
    """A run that says `converged` and ended above the reference found another minimum, or stopped
    too early: either way it is not what it claims to be."""
    if record is None or reference is None:
        return FAILED
    if not record["result"]["converged"]:
        return UNFINISHED
    error = relative_error(record["result"]["energy"], reference)
    return MINIMUM if error <= SAME_MINIMUM else ANOTHER


def judge(record, reference, levels=LEVELS):
    outcome = outcome_of(record, reference)
    if outcome == FAILED:
        return Judged(outcome)
    errors = errors_of(record, reference)
    reached = {}
    for level in levels:
        k = first_at_or_below(errors, level)
        reached[level] = None if k is None else cost_at(record, k)
    return Judged(outcome, relative_error(record["result"]["energy"], reference), reached, record)


def judge_all(records, levels=LEVELS):
    """Of {(scene, method): record}: {scene: Reference} and {(scene, method): Judged}."""
    references, judged = {}, {}
    for scene in dict.fromkeys(scene for scene, _ in records):
        of_scene = {method: record for (other, method), record in records.items()
                    if other == scene}
        references[scene] = reference_of(of_scene)
        for method, record in of_scene.items():
            judged[scene, method] = judge(record, references[scene], levels)
    return references, judged


def geometric_mean(values):
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values)) if values else math.nan


def ratios_to(judged, method, base, level, quantity):
    """method / base, scene by scene, where both reached the level; quantity as in `Judged`."""
    ratios = {}
    for (scene, other), run in judged.items():
        if other != method or (scene, base) not in judged:
            continue
        mine, theirs = run.levels.get(level), judged[scene, base].levels.get(level)
        if mine and theirs:
            ratios[scene] = mine[quantity] / theirs[quantity]
    return ratios


def profile(judged, level):
    """{method: sorted multiples of the fastest run's seconds to the level, one a scene, inf where
    it is not reached}: a share of scenes is solved within each multiple."""
    fastest, multiples = {}, {}
    for (scene, _), run in judged.items():
        if run.levels.get(level):
            fastest[scene] = min(fastest.get(scene, math.inf), run.levels[level][2])
    for (scene, method), run in judged.items():
        if scene not in fastest:
            continue
        reached = run.levels.get(level)
        # A clock may say zero on the smallest scenes.
        ratio = max(reached[2], 1e-9) / max(fastest[scene], 1e-9) if reached else math.inf
        multiples.setdefault(method, []).append(ratio)
    return {method: sorted(ratios) for method, ratios in multiples.items()}


def stop_at(record, reference, tolerance):
    """Where a run with this energy tolerance would have ended: (iterations, relative error), or
    None where it never would. The energy scale is that of the run's end."""
    scale = record["result"]["energy_scale"]
    for k, entry in enumerate(record["history"]):
        decrement = entry["decrement"]
        if (decrement is not None and decrement <= tolerance * scale
                and is_of_last_loads(record, entry)):
            return cost_at(record, k)[0], relative_error(entry["energy"], reference)
    return None


def against_paper(record, paper_record, row):
    """(iterations, their ratio, time ratio) to the energy of the paper's run at its stop: our
    energies are a third of theirs. Iterations are relative to the paper's count, seconds to its
    method's own run here. None where the energy is not reached."""
    target = float(row["final_energy"]) / 3
    target += 1e-9 * abs(target)
    energies = [math.inf if entry["energy"] is None or not is_of_last_loads(record, entry)
                else entry["energy"] for entry in record["history"]]
    k = first_at_or_below(energies, target)
    if k is None:
        return None
    iterations, _, seconds = cost_at(record, k)
    return (iterations, iterations / int(row["iterations"]),
            seconds / paper_record["history"][-1]["seconds"])
