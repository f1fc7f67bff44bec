#!/usr/bin/python3
"""Nearly incompressible quadratic tetrahedra with one pressure each: conjugate gradients on displacements beside
Krylov methods on displacements and pressures, iterations by Poisson's ratio and mesh. Debian: python3-scipy.

    python3 tests/benchmarks/pressure_blocks.py [n ...]        (4 6 8)

A unit cube of 6 n^3 tetrahedra, held at x = 0 and 1, at rest; mu = 1. The stiffness H of
-element_pressure constant is A + B C^-1 B': A has 2 mu |eps|^2 and `KEPT` mu tr(eps)^2 at the points (none where
lambda is less), B the gradients of the elements' volumes, C = V / (lambda - KEPT mu). The block system is
[A B; B' -C], its preconditioner p-multigrid of A (as of H: one Chebyshev step of SSOR each way, linear elements
solved exactly) with C + diag(B' diag(A)^-1 B) for the Schur complement: on the diagonal with MINRES, as a triangle
with GMRES.

Two loads: a `force` on all of the body, and `volumes`, B times random pressures, as the gradient is where Newton's
method has left elements of a wrong volume. Iterations until the displacements' error in the energy norm of H is
.1 / 1e-4 / 1e-8 of their size; `own` until MINRES' preconditioned residual is.
"""
import itertools
import sys

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, cg, minres, splu

KEPT = 6
RATIOS = (.3, .45, .49, .499, .4999, .49999)
TOLERANCES = (1e-1, 1e-4, 1e-8)
EDGES = list(itertools.combinations(range(4), 2))


def cube(n):
    """Vertices, tetrahedra, and the edges of all: pairs of vertices, and for each tetrahedron its six."""
    points = np.array(list(itertools.product(range(n + 1), repeat=3)))
    number = points @ [(n + 1) ** 2, n + 1, 1]
    steps = np.eye(3, dtype=int)
    cells = []
    for order in itertools.permutations(range(3)):
        corner = np.vstack([np.zeros(3, int), np.cumsum(steps[list(order)], axis=0)])
        inside = points[(points < n).all(axis=1)]
        cells.append(np.searchsorted(number, (inside[:, None] + corner) @ [(n + 1) ** 2, n + 1, 1]))
    cells = np.concatenate(cells)
    edges, of_cell = np.unique(np.sort(np.concatenate([cells[:, e] for e in EDGES]), axis=1), axis=0,
                               return_inverse=True)
    return points / n, cells, edges, of_cell.reshape(6, -1).T


class Body:
    """Matrices of the free displacements."""

    def __init__(self, n):
        points, cells, self.edges, of_cell = cube(n)
        self.vertices = len(points)
        nodes = np.hstack([cells, self.vertices + of_cell])
        places = np.vstack([points, points[self.edges].mean(axis=1)])
        frame = points[cells[:, 1:]] - points[cells[:, :1]]
        self.volumes = np.abs(np.linalg.det(frame)) / 6
        inverse = np.linalg.inv(frame).transpose(0, 2, 1)
        slopes = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
        self.shear, self.divergence, self.volume_slopes = self.element_matrices(slopes)
        self.dofs = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(cells), 30)
        self.free = np.flatnonzero(np.repeat((places[:, 0] > 1e-9) & (places[:, 0] < 1 - 1e-9), 3))
        self.size = 3 * len(places)

    def element_matrices(self, slopes):
        """2 |eps|^2 and tr(eps)^2, integrated, and the gradient of the volume."""
        shear = divergence = volume = 0
        for point in (5 - np.sqrt(5)) / 20 + np.eye(4) / np.sqrt(5):
            D = np.concatenate([(4 * point[:, None] - 1) * slopes] + [
                4 * (point[i] * slopes[:, j:j + 1] + point[j] * slopes[:, i:i + 1]) for i, j in EDGES], axis=1)
            w = self.volumes[:, None, None, None, None] / 4
            same = np.einsum("eaj,ebj,ik->eaibk", D, D, np.eye(3)) + np.einsum("eak,ebi->eaibk", D, D)
            shear = shear + w * same
            divergence = divergence + w * np.einsum("eai,ebk->eaibk", D, D)
            volume = volume + self.volumes[:, None] / 4 * D.reshape(-1, 30)
        return shear.reshape(-1, 30, 30), divergence.reshape(-1, 30, 30), volume

    def assemble(self, matrices):
        rows, columns = np.repeat(self.dofs, 30, axis=1), np.tile(self.dofs, (1, 30))
        whole = sp.csr_matrix((matrices.ravel(), (rows.ravel(), columns.ravel())), (self.size, self.size))
        return whole[self.free][:, self.free]

    def coupling(self):
        columns = np.repeat(np.arange(len(self.volumes)), 30)
        return sp.csr_matrix((self.volume_slopes.ravel(), (self.dofs.ravel(), columns)))[self.free]

    def interpolation(self):
        """From the linear elements' displacements."""
        ends = np.repeat(np.arange(len(self.edges)), 2)
        middle = sp.csr_matrix((np.full(ends.size, .5), (ends, self.edges.ravel())),
                               (len(self.edges), self.vertices))
        both = sp.kron(sp.vstack([sp.identity(self.vertices), middle]), sp.identity(3)).tocsr()
        return both[self.free][:, self.free[self.free < 3 * self.vertices]]


def p_multigrid(matrix, interpolation):
    exact = {"permc_spec": "NATURAL", "diag_pivot_thresh": 0, "options": {"SymmetricMode": True}}
    lower, upper = splu(sp.tril(matrix).tocsc(), **exact), splu(sp.triu(matrix).tocsc(), **exact)
    coarse = splu((interpolation.T @ matrix @ interpolation).tocsc())
    diagonal = matrix.diagonal()

    def smooth(r):
        return upper.solve(diagonal * lower.solve(r)) * 2 / (1.05 + .1)

    def cycle(r):
        x = smooth(r)
        x = x + interpolation @ coarse.solve(interpolation.T @ (r - matrix @ x))
        return x + smooth(r - matrix @ x)
    return cycle


def gmres(multiply, right, precondition, watch, most=150):
    """Preconditioned from the right, without restarts."""
    basis, directions, heights = [right / np.linalg.norm(right)], [], np.zeros((most + 1, most))
    for k in range(most):
        directions.append(precondition(basis[k]))
        w = multiply(directions[k])
        for j in range(k + 1):
            heights[j, k] = basis[j] @ w
            w = w - heights[j, k] * basis[j]
        heights[k + 1, k] = np.linalg.norm(w)
        basis.append(w / heights[k + 1, k])
        start = np.linalg.norm(right) * np.eye(1, k + 2)[0]
        weights = np.linalg.lstsq(heights[:k + 2, :k + 1], start, rcond=None)[0]
        if watch(np.array(directions).T @ weights):
            return


class Count:
    """Iterations until what `measure` says is below the tolerances."""

    def __init__(self, measure):
        self.measure, self.iterations, self.reached = measure, 0, []

    def __call__(self, x):
        self.iterations += 1
        value = self.measure(x)
        while len(self.reached) < len(TOLERANCES) and value < TOLERANCES[len(self.reached)]:
            self.reached.append(self.iterations)
        return len(self.reached) == len(TOLERANCES)

    def __str__(self):
        return "/".join(map(str, self.reached + ["-"] * (len(TOLERANCES) - len(self.reached))))


def compare(body, ratio):
    lame = 2 * ratio / (1 - 2 * ratio)
    kept = KEPT if lame > KEPT else 0
    A, B = body.assemble(body.shear + kept * body.divergence), body.coupling()
    C = body.volumes / (lame - kept)
    H = (A + B @ sp.diags(1 / C) @ B.T).tocsr()
    split, pressures = B.shape
    schur = C + B.multiply(B).T @ (1 / A.diagonal())
    of_H, of_A = (p_multigrid(matrix, body.interpolation()) for matrix in (H, A))
    exact, reference = splu(A.tocsc()).solve, splu(H.tocsc()).solve

    def multiply(x):
        return np.concatenate([A @ x[:split] + B @ x[split:], B.T @ x[:split] - C * x[split:]])

    def diagonal(r):
        return np.concatenate([of_A(r[:split]), r[split:] / schur])

    def triangle(inverse):
        def apply(r):
            p = -r[split:] / schur
            return np.concatenate([inverse(r[:split] - B @ p), p])
        return apply

    def operator(size, apply):
        return LinearOperator((size, size), matvec=apply, dtype=float)

    force = np.tile([0, 0, 1.], body.size // 3)[body.free]
    volumes = B @ np.random.default_rng(0).standard_normal(pressures)
    for name, load in (("force", force), ("volumes", volumes)):
        right = np.concatenate([load, np.zeros(pressures)])
        solution = reference(load)
        energy = np.sqrt(solution @ load)
        first = np.sqrt(right @ diagonal(right))

        def error(x):
            e = x[:split] - solution
            return np.sqrt(max(0, e @ (H @ e))) / energy

        def own(x):
            r = right - multiply(x)
            return np.sqrt(max(0, r @ diagonal(r))) / first

        counts = [Count(error) for _ in range(4)] + [Count(own)]
        cg(H, load, M=operator(split, of_H), tol=1e-15, maxiter=600, callback=counts[0])
        minres(operator(right.size, multiply), right, M=operator(right.size, diagonal), tol=1e-15, maxiter=250,
               callback=lambda x: [counts[k](x) for k in (1, 4)])
        gmres(multiply, right, triangle(of_A), counts[2])
        gmres(multiply, right, triangle(exact), counts[3])
        yield name, counts


def main():
    print("| n | unknowns | load | nu | CG, p-multigrid of H | MINRES | GMRES | GMRES, A exactly | MINRES, own |")
    print("|---|---|---|---|---|---|---|---|---|")
    for n in [int(word) for word in sys.argv[1:]] or [4, 6, 8]:
        body = Body(n)
        for ratio in RATIOS:
            for name, counts in compare(body, ratio):
                print("|", " | ".join(map(str, [n, body.free.size, name, ratio, *counts])), "|", flush=True)


if __name__ == "__main__":
    main()
