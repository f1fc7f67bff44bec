"""What the scripts of this folder run: bodies in poses, by the paper's method and by the defaults.

A body is a mesh file, or what the program generates. It is held at one end of its longest axis and
moved at the other, in zones of a tenth of its length; its box has norm 1 as in the paper.
"""
import math
import os
import re
import subprocess
import sys
from dataclasses import dataclass

FOLDER = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(FOLDER))

from speed_error import judgement, runs  # noqa: E402  (of the folder above)

PROGRAM = os.environ.get("TREFOIL",
                         os.path.join(os.path.dirname(runs.EXAMPLES), "build", "trefoil"))
YOUNG = 1e8
LARGE = ("stretched by 3 lengths", "compressed to half", "turned by 180 degrees",
         "bent by 90 degrees")
SMALL = ("stretched by a fifth", "compressed by a tenth", "turned by 45 degrees",
         "bent by 30 degrees")


@dataclass(frozen=True)
class Body:
    name: str
    options: tuple
    axis: int  # the longest
    cells: int


@dataclass(frozen=True)
class PaperScene(runs.Scene):
    """A scene with what the paper's method is told of it."""
    poisson: float = 0.495
    rho_tolerance: float = 0.01


@dataclass(frozen=True)
class Strategy:
    """The paper's method with one of its filters, or, without a filter, the program's defaults."""
    name: str
    filter: str = ""
    more: tuple = ()
    tolerance = None  # as the scene says

    def options_of(self, scene):
        if not self.filter:  # said, for scenes whose files are the paper's
            return ["-initial", "auto", "-snes_trefoil_search", "subspace",
                    "-snes_trefoil_rho_tolerance", "0.01", "-snes_trefoil_energy_tolerance", "1e-8",
                    "-snes_trefoil_decrement_tolerance", "0", *self.more]
        return ["-initial", "rest", "-snes_trefoil_search", "armijo",
                "-snes_trefoil_filter", self.filter,
                "-snes_trefoil_rho_tolerance", repr(scene.rho_tolerance),
                "-snes_trefoil_decrement_tolerance", repr(paper_tolerance(scene.poisson)),
                "-snes_trefoil_energy_tolerance", "0", "-snes_max_it", "200", *self.more]


ADAPTIVE, ABSOLUTE, CLAMP = (Strategy(name, name) for name in ("adaptive", "absolute", "clamp"))
DEFAULTS = Strategy("defaults")


class Runner(runs.Runner):
    """Runs scenes by strategies; what a strategy asks for depends on the scene."""

    def __init__(self, program, folder, reuse, timeout=600):
        super().__init__(program, 1, [], os.path.join(folder, "records"), reuse, timeout)

    def command(self, scene, method):
        return [*scene.options, *method.options_of(scene), *self.options]


def paper_tolerance(poisson):
    """1e-5 lambda of the paper's raw constants; its energies are three times ours."""
    return 1e-5 * YOUNG * poisson / ((1 + poisson) * (1 - 2 * poisson)) / 3


def body_of(word, program, more=()):
    """From a mesh file, or from the name of what the program generates, with more options."""
    source = "-mesh_file" if os.path.exists(word) else "-mesh_generate"
    options = (source, word, "-order", "1", "-mesh_normalize", "true", "-mesh_repair", "drop", *more)
    told = subprocess.run([program, *options, "-constraints", "any", "-constraint_any_where",
                           "x < (xmin + xmax)/2", "-check"], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, env=runs.environment(),
                          check=False).stdout
    box = re.search(r"^box: (.*);", told, re.MULTILINE)
    cells = re.search(r"(\d+) tetrahedra$", told, re.MULTILINE)
    if not box or not cells:
        sys.exit(f"{word} is no body of tetrahedra:\n{told}")
    ends = [[float(end) for end in side.strip("[]").split(",")] for side in box[1].split(" x ")]
    lengths = [high - low for low, high in ends]
    name = " ".join([os.path.splitext(os.path.basename(word))[0], *more[1::2]])
    return Body(name, options, lengths.index(max(lengths)), int(cells[1]))


def rotation(first, second, degrees):
    """Displacements of two coordinates, pairs (name, centre), that turn in their plane."""
    cosine, sine = (round(f(math.radians(degrees)), 15) for f in (math.cos, math.sin))
    p, q = (f"({name} - {centre})" for name, centre in (first, second))
    return {first[0]: f"({cosine - 1!r})*{p} - ({sine!r})*{q}",
            second[0]: f"({sine!r})*{p} + ({cosine - 1!r})*{q}"}


def moves(axis):
    """By pose, the displacements of a body's end, by coordinate."""
    along = "xyz"[axis]
    across, third = (name for name in "xyz" if name != along)
    length = f"({along}max - {along}min)"
    middle = {name: (name, f"({name}min + {name}max)/2") for name in (across, third)}

    def turned(degrees):
        return rotation(middle[across], middle[third], degrees)

    def bent(degrees, offset):
        bend = rotation((along, f"{along}max"), middle[across], degrees)
        return {**bend, across: f"{bend[across]} + {offset}*{length}"}

    large = ({along: f"3*{length}"}, {along: f"(-0.5)*{length}"}, turned(180), bent(90, 0.5))
    small = ({along: f"0.2*{length}"}, {along: f"(-0.1)*{length}"}, turned(45), bent(30, 0.1))
    return dict(zip((*LARGE, *SMALL), (*large, *small)))


def scene_of(body, pose, poisson):
    """The paper takes the wider trust for compression."""
    a = "xyz"[body.axis]
    zone, move = f"0.1*({a}max - {a}min)", moves(body.axis)[pose]
    options = (*body.options, "-material_model", "stable_neo_hookean", "-material_lame", "raw",
               "-material_young", repr(YOUNG), "-material_poisson", repr(poisson),
               "-constraints", "held,moved", "-constraint_held_where", f"{a} < {a}min + {zone}",
               "-constraint_held_move", "0, 0, 0", "-constraint_moved_where",
               f"{a} > {a}max - {zone}", "-constraint_moved_move",
               ", ".join(move.get(name, "0") for name in "xyz"))
    return PaperScene(f"{body.name} {pose} {poisson}", options, None, poisson,
                      0.1 if pose.startswith("compressed") else 0.01)


def iterations_to(record, energy):
    """Until a state under the whole load is as low; None where none is. Those of a path before it,
    and of one that was given up, are counted."""
    bound = energy + 1e-6 * record["result"]["energy_scale"]
    for entry in record["history"]:
        if judgement.is_of_last_loads(record, entry) and entry["energy"] <= bound:
            return max(1, entry["k"])
    return record["result"]["iterations"] if record["result"]["energy"] <= bound else None
