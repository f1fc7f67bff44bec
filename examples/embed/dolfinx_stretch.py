#!/usr/bin/python3
"""A cube of rubber stretched to four times its height with FEniCSx (dolfinx and petsc4py's SNES). It knows
nothing of Trefoil: PETSc's options come from the command line.

  mpirun -n 2 python3 dolfinx_stretch.py
  mpirun -n 2 python3 dolfinx_stretch.py -dll_append ../../build/libtrefoil.so -snes_type trefoil
"""
import sys

import petsc4py

petsc4py.init(sys.argv)

import numpy
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc

options = PETSc.Options()
cells = options.getInt("cells", 6)  # along an edge
stretch, poisson = options.getReal("stretch", 4), options.getReal("poisson", 0.3)
mu = 1 / (2 * (1 + poisson))
lame = poisson / ((1 + poisson) * (1 - 2 * poisson)) + mu

domain = mesh.create_unit_cube(MPI.COMM_WORLD, cells, cells, cells)
space = fem.VectorFunctionSpace(domain, ("Lagrange", 1))
u, v, du = fem.Function(space), ufl.TestFunction(space), ufl.TrialFunction(space)
F = ufl.variable(ufl.Identity(3) + ufl.grad(u))
psi = mu / 2 * (ufl.inner(F, F) - 3) + lame / 2 * (ufl.det(F) - 1 - mu / lame) ** 2
energy = fem.form(psi * ufl.dx)
residual = ufl.inner(ufl.diff(psi, F), ufl.grad(v)) * ufl.dx
jacobian = ufl.derivative(residual, u, du)
residual, jacobian = fem.form(residual), fem.form(jacobian)


def held(where, displacement):
    dofs = fem.locate_dofs_geometrical(space, where)
    return fem.dirichletbc(numpy.array(displacement, dtype=PETSc.ScalarType), dofs, space)


conditions = [held(lambda x: numpy.isclose(x[2], 0), (0, 0, 0)),
              held(lambda x: numpy.isclose(x[2], 1), (0, 0, stretch - 1))]


def update(x):
    x.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
    x.copy(u.vector)
    u.vector.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)


def form_residual(_, x, f):
    update(x)
    with f.localForm() as local:
        local.set(0)
    fem.petsc.assemble_vector(f, residual)
    fem.petsc.apply_lifting(f, [jacobian], [conditions], [x], -1.0)
    f.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    fem.petsc.set_bc(f, conditions, x, -1.0)


def form_jacobian(_, x, __, matrix):
    update(x)
    matrix.zeroEntries()
    fem.petsc.assemble_matrix(matrix, jacobian, conditions)
    matrix.assemble()


snes = PETSc.SNES().create(MPI.COMM_WORLD)
matrix = fem.petsc.create_matrix(jacobian)
snes.setFunction(form_residual, fem.petsc.create_vector(residual))
snes.setJacobian(form_jacobian, matrix)
snes.getKSP().setType("preonly")
snes.getKSP().getPC().setType("lu")
snes.getKSP().getPC().setFactorSolverType("mumps")
snes.setFromOptions()
x = u.vector.copy()
snes.solve(None, x)
update(x)
total = MPI.COMM_WORLD.allreduce(fem.assemble_scalar(energy), MPI.SUM)
if MPI.COMM_WORLD.rank == 0:
    outcome = "CONVERGED" if snes.getConvergedReason() > 0 else "DIVERGED"
    print(f"{outcome} iterations {snes.getIterationNumber()} energy {total:.12e}")
