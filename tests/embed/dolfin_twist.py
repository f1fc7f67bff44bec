#!/usr/bin/python3
"""A cube of rubber twisted and pulled with legacy DOLFIN and its PETSc SNES, whose objective is the norm
of the residual and which ends PETSc from a static destructor: the problem of DOLFIN's own demo of
hyperelasticity.

  python3 dolfin_twist.py [cells of the axis, 6; the demo's are 24]
"""
import sys

from dolfin import (Constant, DirichletBC, Expression, Function, Identity, NonlinearVariationalProblem,
                    NonlinearVariationalSolver, TestFunction, TrialFunction, UnitCubeMesh,
                    VectorFunctionSpace, assemble, derivative, det, dot, ds, dx, grad, inner, ln, near,
                    set_log_level)

set_log_level(40)
cells = int(sys.argv[1]) if len(sys.argv) > 1 else 6
space = VectorFunctionSpace(UnitCubeMesh(cells, 2 * cells // 3, 2 * cells // 3), "Lagrange", 1)
turned = Expression(("0", "(c * (x[1] - 0.5) - s * (x[2] - 0.5) + 0.5 - x[1]) / 2",
                     "(s * (x[1] - 0.5) + c * (x[2] - 0.5) + 0.5 - x[2]) / 2"),
                    c=0.5, s=0.8660254037844386, degree=1)
conditions = [DirichletBC(space, Constant((0, 0, 0)), lambda x, on: on and near(x[0], 0)),
              DirichletBC(space, turned, lambda x, on: on and near(x[0], 1))]
u, v, du = Function(space), TestFunction(space), TrialFunction(space)
F = Identity(3) + grad(u)
mu, lame, J = 10 / 2.6, 3 / (1.3 * 0.4), det(F)
energy = (mu / 2 * (inner(F, F) - 3) - mu * ln(J) + lame / 2 * ln(J) ** 2) * dx
energy -= dot(Constant((0, -0.5, 0)), u) * dx + dot(Constant((0.1, 0, 0)), u) * ds
residual = derivative(energy, u, v)
solver = NonlinearVariationalSolver(
    NonlinearVariationalProblem(residual, u, conditions, derivative(residual, u, du)))
solver.parameters.update({"nonlinear_solver": "snes", "snes_solver": {
    "linear_solver": "lu", "report": False, "error_on_nonconvergence": False}})
iterations, converged = solver.solve()
print(f"{'CONVERGED' if converged else 'DIVERGED'} iterations {iterations} energy {assemble(energy):.12e}")
