#!/usr/bin/python3
"""The bracket in CalculiX, on the same mesh: where the reference figures of examples/bracket.yaml come
from. Writes the deck, runs ccx on it, and prints the displacement at the tip and the reaction.

    python3 examples/bracket/calculix.py gravity [folder for the deck]
    python3 examples/bracket/calculix.py pressure    # on the shelf, so much that it bends

A C3D10 has Trefoil's four points of quadrature; *ELASTIC with NLGEOM is Green's strain with the second
Piola-Kirchhoff stress, the material `st_venant_kirchhoff`; a pressure in such a step acts on the
deformed face, as with `follower: true`.
Debian: calculix-ccx (2.20) python3-meshio python3-numpy
"""

import os
import subprocess
import sys
import tempfile

import meshio
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
TIP = (80, 25, 70)  # the shelf's front corner
YOUNG, POISSON = 210e3, 0.3  # steel, in MPa
DENSITY, GRAVITY = 7.85e-9, 9810  # tonnes / mm3, mm / s2
PRESSURE, STEPS = 100, 10  # MPa, in so many equal increments
FACES = ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0))  # P1 ... P4 of a C3D10


def lines_of(numbers, width=10):
    return "\n".join(", ".join(map(str, numbers[k:k + width])) for k in range(0, len(numbers), width))


def facets(mesh, name):
    """Nodes of the six-node triangles of a physical surface."""
    return np.concatenate([block.data[mesh.cell_sets[name][k]] for k, block in enumerate(mesh.cells)
                           if block.type == "triangle6"])


def loads(mesh, case):
    """The cards of a case."""
    if case == "gravity":
        return f"*DLOAD\nBODY, GRAV, {GRAVITY}, 0, 0, -1"
    pressed = {frozenset(facet[:3]) for facet in facets(mesh, "shelf").tolist()}
    cells = enumerate(mesh.cells_dict["tetra10"].tolist())
    cards = [f"{k + 1}, P{face + 1}, {PRESSURE}" for k, cell in cells
             for face, corners in enumerate(FACES) if frozenset(cell[c] for c in corners) in pressed]
    return "*DLOAD\n" + "\n".join(cards)


def deck(mesh, case):
    """The text of the deck; nodes and elements are numbered from 1."""
    cells = mesh.cells_dict["tetra10"] + 1
    wall = np.unique(facets(mesh, "wall")) + 1
    steps = STEPS if case == "pressure" else 1
    tip = int(np.argmin(np.linalg.norm(mesh.points - TIP, axis=1))) + 1
    nodes = "\n".join(f"{k + 1}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in enumerate(mesh.points))
    elements = "\n".join(f"{k + 1}, {lines_of(cell.tolist())}" for k, cell in enumerate(cells))
    return f"""*NODE, NSET=ALL
{nodes}
*ELEMENT, TYPE=C3D10, ELSET=BODY
{elements}
*NSET, NSET=WALL
{lines_of(wall.tolist())}
*NSET, NSET=TIP
{tip}
*MATERIAL, NAME=STEEL
*ELASTIC
{YOUNG}, {POISSON}
*DENSITY
{DENSITY}
*SOLID SECTION, ELSET=BODY, MATERIAL=STEEL
*BOUNDARY
WALL, 1, 3, 0
*STEP, NLGEOM
*STATIC, DIRECT
{1 / steps}, 1
*CONTROLS, PARAMETERS=FIELD
1e-10, 1e-10
{loads(mesh, case)}
*NODE PRINT, NSET=TIP, FREQUENCY={steps}
U
*NODE PRINT, NSET=WALL, FREQUENCY={steps}, TOTALS=ONLY
RF
*EL PRINT, ELSET=BODY, FREQUENCY={steps}, TOTALS=ONLY
EVOL
*END STEP
"""


def run(case, folder):
    """What ccx prints to its .dat file."""
    mesh = meshio.read(os.path.join(HERE, "bracket.msh"))
    with open(os.path.join(folder, "bracket.inp"), "w", encoding="ascii") as file:
        file.write(deck(mesh, case))
    log = subprocess.run(["ccx", "-i", "bracket"], cwd=folder, capture_output=True, text=True, check=False)
    with open(os.path.join(folder, "bracket.dat"), encoding="ascii") as file:
        return file.read() or sys.exit(log.stdout + log.stderr)


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[1] not in ("gravity", "pressure"):
        sys.exit(__doc__)
    if len(sys.argv) == 3:
        os.makedirs(sys.argv[2], exist_ok=True)
        print(run(sys.argv[1], sys.argv[2]))
    else:
        with tempfile.TemporaryDirectory() as folder:
            print(run(sys.argv[1], folder))


if __name__ == "__main__":
    main()
