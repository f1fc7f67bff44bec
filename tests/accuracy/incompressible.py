#!/usr/bin/python3
"""A cube stretched by half and twisted by 60 degrees as Poisson's ratio nears 1/2: energies of linear,
quadratic and P2-P0 elements by Trefoil, and of Taylor and Hood's (P2-P1) by FEniCSx, on the same
tetrahedra and the same psi, with unknowns, iterations, CPU seconds and memory, each run in a process of
its own; of FEniCSx's also the part that solves, without Python's imports. The wanted energy is extrapolated
from the three finest Taylor-Hood meshes of a ratio. Run by hand, coarse meshes in
nearly_incompressible_test.py; seconds are of this machine: compare rows of one run.

    tests/accuracy/incompressible.py [--quick] [-o incompressible.png] [--csv incompressible.csv]
"""
import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("TREFOIL", os.path.join(ROOT, "build", "trefoil"))
COLUMNS = ("elements", "nu", "cells", "unknowns", "energy", "error", "iterations", "seconds",
           "its solve", "MB")
POISSONS = (0.3, 0.49, 0.499, 0.4999, 0.49999)
OPTIONS = {"P1": ["-order", "1"],
           "P2": ["-order", "2", "-element_pressure", "pointwise"],
           "P2-P0": ["-order", "2", "-element_pressure", "constant"]}
STRETCH, TURN = 0.5, math.pi / 3


def taylor_hood(cells, poisson, mesh_file):
    """Solves with FEniCSx, prints a JSON record. The energy is W(F) + p log J - p^2 / (2 lambda), whose
    saddle point is the minimum of neo_hookean's W + lambda/2 (log J)^2. Starts from the prescribed
    motion, spread linearly between the ends; Newton's method with MUMPS."""
    import time
    import numpy
    import ufl
    from dolfinx import fem, mesh, nls
    from mpi4py import MPI
    from petsc4py import PETSc

    domain = mesh.create_unit_cube(MPI.COMM_WORLD, cells, cells, cells)
    write_medit(mesh_file, domain.geometry.x, domain.geometry.dofmap.array.reshape(-1, 4))
    mu = fem.Constant(domain, 1 / (2 * (1 + poisson)))
    lame = fem.Constant(domain, poisson / ((1 + poisson) * (1 - 2 * poisson)))
    space = fem.FunctionSpace(domain, ufl.MixedElement(
        ufl.VectorElement("Lagrange", domain.ufl_cell(), 2),
        ufl.FiniteElement("Lagrange", domain.ufl_cell(), 1)))
    state = fem.Function(space)
    u, p = ufl.split(state)
    F = ufl.Identity(3) + ufl.grad(u)
    log_J = ufl.ln(ufl.det(F))
    points = {"quadrature_degree": 4}
    distortion = mu / 2 * (ufl.inner(F, F) - 3) - mu * log_J
    energy = fem.form((distortion + p**2 / (2 * lame)) * ufl.dx(metadata=points))
    lagrangian = (distortion + p * log_J - p**2 / (2 * lame)) * ufl.dx(metadata=points)
    residual = ufl.derivative(lagrangian, state, ufl.TestFunction(space))

    def motion(x):
        """The top's, at height z in proportion."""
        cosine, sine = math.cos(TURN) - 1, math.sin(TURN)
        a, b = x[0] - 0.5, x[1] - 0.5
        return x[2] * numpy.array([a * cosine - b * sine, a * sine + b * cosine,
                                   numpy.full_like(a, STRETCH)])

    displacements, _ = space.sub(0).collapse()
    prescribed = fem.Function(displacements)
    prescribed.interpolate(motion)
    ends = fem.locate_dofs_geometrical(
        (space.sub(0), displacements), lambda x: numpy.isclose(x[2], 0) | numpy.isclose(x[2], 1))
    problem = fem.petsc.NonlinearProblem(
        residual, state, [fem.dirichletbc(prescribed, ends, space.sub(0))])
    solver = nls.petsc.NewtonSolver(MPI.COMM_WORLD, problem)
    solver.convergence_criterion, solver.rtol, solver.atol = "residual", 1e-8, 1e-12
    solver.krylov_solver.setType("preonly")
    solver.krylov_solver.getPC().setType("lu")
    solver.krylov_solver.getPC().setFactorSolverType("mumps")
    state.sub(0).interpolate(motion)
    begin = time.process_time()
    iterations, _ = solver.solve(state)
    print(json.dumps({"unknowns": space.dofmap.index_map.size_global, "iterations": iterations,
                      "energy": fem.assemble_scalar(energy),
                      "seconds": time.process_time() - begin}))


def write_medit(path, vertices, tetrahedra):
    with open(path, "w", encoding="ascii") as file:
        file.write(f"MeshVersionFormatted 2\nDimension 3\nVertices {len(vertices)}\n")
        file.writelines("%.17g %.17g %.17g 0\n" % tuple(place) for place in vertices)
        file.write(f"Tetrahedra {len(tetrahedra)}\n")
        file.writelines("%d %d %d %d 0\n" % tuple(cell + 1) for cell in tetrahedra)
        file.write("End\n")


def measured(command):
    """What a process prints, its CPU seconds, and the megabytes it had at most."""
    environment = dict(os.environ, OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, text=True) as process:
        printed = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {process.returncode}:\n{printed}")
    return printed, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def fenicsx_row(cells, poisson, mesh_file):
    command = [sys.executable, os.path.abspath(__file__), "--taylor-hood", str(cells),
               str(poisson), mesh_file]
    printed, seconds, megabytes = measured(command)
    found = json.loads(printed.splitlines()[-1])
    return {"unknowns": found["unknowns"], "energy": found["energy"],
            "iterations": found["iterations"], "seconds": seconds,
            "its solve": found["seconds"], "MB": megabytes}


def trefoil_row(elements, poisson, mesh, record_file):
    """@param mesh the options that say which"""
    top = (f"(x-0.5)*{math.cos(TURN) - 1}-(y-0.5)*{math.sin(TURN)}, "
           f"(x-0.5)*{math.sin(TURN)}+(y-0.5)*{math.cos(TURN) - 1}, {STRETCH}")
    _, seconds, megabytes = measured(
        [PROGRAM, *mesh, "-material_model", "neo_hookean", "-material_young", "1",
         "-material_poisson", str(poisson), "-constraints", "low,high", "-constraint_low_where",
         "z == zmin", "-constraint_high_where", "z == zmax", "-constraint_high_move", top,
         "-snes_trefoil_record", record_file, *OPTIONS[elements]])
    with open(record_file, encoding="utf-8") as file:
        record = json.load(file)
    result = record["result"]
    return {"unknowns": record["mesh"]["dofs"], "energy": result["strain_energy"],
            "iterations": result["iterations"], "seconds": seconds,
            "its solve": math.nan, "MB": megabytes}


def extrapolated(rows):
    """The limit E of E_n = E + C n^-r through the energies of three meshes."""
    (n1, e1), (n2, e2), (n3, e3) = sorted((row["cells"], row["energy"]) for row in rows)[-3:]
    share, low, high = (e1 - e2) / (e2 - e3), 0.1, 8.0

    def ratio(rate):
        return (n1**-rate - n2**-rate) / (n2**-rate - n3**-rate)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if ratio(middle) > share else (middle, high)
    return e3 - (e2 - e3) * n3**-low / (n2**-low - n3**-low)


def rows_of(poisson, sizes, folder):
    """Taylor-Hood first: it makes the meshes."""
    rows = []
    files = {cells: os.path.join(folder, f"cube_{cells}.mesh") for cells in sizes}
    for cells, mesh_file in files.items():
        row = fenicsx_row(cells, poisson, mesh_file)
        rows.append(dict(row, elements="P2-P1", nu=poisson, cells=cells))
    wanted = extrapolated(rows)
    for elements in OPTIONS:
        for cells, mesh_file in files.items():
            row = trefoil_row(elements, poisson, ["-mesh_file", mesh_file], mesh_file + ".json")
            rows.append(dict(row, elements=elements, nu=poisson, cells=cells))
    for row in rows:
        row["error"] = row["energy"] / wanted - 1
    return rows


def shown(row):
    formats = {"energy": "{:.6f}", "error": "{:.2e}", "seconds": "{:.2f}", "its solve": "{:.2f}",
               "MB": "{:.0f}"}
    return "| " + " | ".join(formats.get(name, "{}").format(row[name]) for name in COLUMNS) + " |"


def draw(rows, path):
    try:
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    except ImportError:
        sys.exit("incompressible.py: apt install python3-matplotlib, then use /usr/bin/python3")
    poissons = sorted({row["nu"] for row in rows})
    quantities = (("unknowns", "unknowns"), ("seconds", "CPU time of the run, s"),
                  ("MB", "memory, MB"))
    figure, panels = plt.subplots(len(quantities), len(poissons), sharey=True, squeeze=False,
                                  figsize=(3 * len(poissons), 8), constrained_layout=True)
    for line, (quantity, label) in zip(panels, quantities):
        for panel, nu in zip(line, poissons):
            for elements, style in (("P1", "o--"), ("P2", "s-"), ("P2-P0", "D-"), ("P2-P1", "^:")):
                chosen = [row for row in rows if row["elements"] == elements and row["nu"] == nu]
                panel.loglog([row[quantity] for row in chosen],
                             [abs(row["error"]) for row in chosen], style, markersize=4,
                             label=elements if elements != "P2-P1" else "P2-P1 (FEniCSx)")
            panel.set_xlabel(label)
            panel.grid(True, which="both", alpha=0.25)
        line[0].set_ylabel("relative error of the energy")
    for panel, nu in zip(panels[0], poissons):
        panel.set_title(f"nu {nu}")
    panels[0][0].legend(fontsize=8)
    figure.savefig(path, dpi=80)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="coarse meshes, nu 0.4999 only")
    parser.add_argument("-o", "--output", help="picture, for example incompressible.png")
    parser.add_argument("--csv", help="the rows as comma-separated values")
    parser.add_argument("--taylor-hood", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.taylor_hood:
        cells, poisson, mesh_file = arguments.taylor_hood
        taylor_hood(int(cells), float(poisson), mesh_file)
        return
    sizes = (2, 3, 4) if arguments.quick else (3, 4, 6, 8)
    print("| " + " | ".join(COLUMNS) + " |\n" + "|---" * len(COLUMNS) + "|")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for poisson in (0.4999,) if arguments.quick else POISSONS:
            found = rows_of(poisson, sizes, folder)
            print("\n".join(map(shown, found)), flush=True)
            rows += found
    if arguments.csv:
        with open(arguments.csv, "w", encoding="ascii", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
    if arguments.output:
        draw(rows, arguments.output)


if __name__ == "__main__":
    main()
