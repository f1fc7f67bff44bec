#!/usr/bin/python3
"""The nearly incompressible block under a dead pressure of Reese et al. (deal.II's step-44: a quarter of it,
1 mm an edge, mu = 80.194 N/mm^2, nu = .4999; half of each edge of the top is pressed, the top does not
slide): how far the middle of the top goes down, and how much the pressure scatters within each small cube
of six tetrahedra, relative to its size. A checkerboard would not fade on finer meshes. Run by
hand; coarse meshes in nearly_incompressible_test.py.

    tests/accuracy/block.py [--pressure 100] [--poisson 0.4999] [--cells 4,8]
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

import meshio
import numpy

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("TREFOIL", os.path.join(ROOT, "build", "trefoil"))
MU, P0 = 80.194, 4.0
ELEMENTS = {"P1": ["-order", "1"], "P2": ["-order", "2", "-element_pressure", "pointwise"],
            "P2-P0": ["-order", "2", "-element_pressure", "constant"]}
HELD = ["-constraints", "left,front,bottom,top",
        "-constraint_left_where", "x == xmin", "-constraint_left_move", "0, free, free",
        "-constraint_front_where", "y == ymin", "-constraint_front_move", "free, 0, free",
        "-constraint_bottom_where", "z == zmin", "-constraint_bottom_move", "free, free, 0",
        "-constraint_top_where", "z == zmax", "-constraint_top_move", "0, 0, free"]


def row(elements, cells, poisson, pressure):
    """What a mesh gives: how far the top's middle goes down (of the height), the scatter of the
    pressures, their least and largest over mu, unknowns, iterations, inverted elements."""
    with tempfile.TemporaryDirectory() as folder:
        finished = subprocess.run(
            [PROGRAM, "-mesh_generate", "box", "-mesh_resolution", str(cells), *ELEMENTS[elements],
             "-material_model", "neo_hookean", "-material_young", str(2 * (1 + poisson) * MU),
             "-material_poisson", str(poisson), *HELD, "-loads", "press", "-load_press_where",
             "z == zmax && x <= 0.5 && y <= 0.5", "-load_press_pressure", str(pressure * P0),
             "-probes", "middle", "-probe_middle", "0, 0, 1", "-output_file", "block.xdmf",
             "-output_fields", "cauchy_stress", "-snes_trefoil_record", "record.json"],
            cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
            env=dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1"))
        if finished.returncode not in (0, 3):
            sys.exit(finished.stdout)
        with open(os.path.join(folder, "record.json"), encoding="utf-8") as file:
            record = json.load(file)
        mesh = meshio.read(os.path.join(folder, "block.xdmf"))
    stress = mesh.cell_data["cauchy_stress"][0]  # xx, xy, xz, yy, yz, zz
    p = -(stress[:, 0] + stress[:, 3] + stress[:, 5]) / 3
    places = mesh.points[mesh.cells[0].data[:, :4]].mean(axis=1)
    cube = (numpy.floor(places * cells).astype(int) * [1, cells, cells**2]).sum(axis=1)
    mean = numpy.bincount(cube, p) / numpy.bincount(cube)
    result = record["result"]
    return {"unknowns": record["mesh"]["dofs"], "down": -result["probes"]["middle"][2],
            "scatter": numpy.sqrt(((p - mean[cube])**2).mean() / (p**2).mean()),
            "least": p.min() / MU, "largest": p.max() / MU,
            "iterations": result["iterations"], "inverted": result["inverted"],
            "converged": result["converged"]}


def shown(elements, cells, found):
    return (f"| {elements} | {cells} | {found['unknowns']} | {100 * found['down']:.2f} | "
            f"{found['scatter']:.3f} | {found['least']:.2f} to {found['largest']:.2f} | "
            f"{found['iterations']} | {found['inverted']} | "
            f"{'yes' if found['converged'] else 'no'} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pressure", type=float, default=100, help="in units of p0 = 4 N/mm^2")
    parser.add_argument("--poisson", type=float, default=0.4999)
    parser.add_argument("--cells", default="4,8", help="along an edge")
    arguments = parser.parse_args()
    print("| elements | cells | unknowns | down, % | scatter of p | p / mu | iterations | inverted | "
          "converged |\n" + "|---" * 9 + "|")
    for cells in arguments.cells.split(","):
        for elements in ELEMENTS:
            found = row(elements, int(cells), arguments.poisson, arguments.pressure)
            print(shown(elements, int(cells), found), flush=True)


if __name__ == "__main__":
    main()
