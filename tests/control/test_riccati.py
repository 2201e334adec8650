"""The interior point on a Riccati recursion against a general solver of quadratic programmes."""

from dataclasses import replace

import numpy as np
import pytest

from riccati_c import NOT_CONVEX, SOLVED, Problem, random_problem, solve

pytestmark = pytest.mark.compiler


def by_piqp(p: Problem) -> tuple[np.ndarray, np.ndarray]:
    """(v (N + 1, nv), multipliers of the dynamics (N + 1, nz)) of the same programme in one dense matrix, slacks as variables."""
    import piqp

    n, nz, nv = p.AB.shape
    nb, rows = len(p.box), p.c.shape[1]
    slack = {(k, i): (n + 1) * nv + j for j, (k, i) in enumerate(np.argwhere((p.on > 0) & (p.soft > 0)))}
    size = (n + 1) * nv + len(slack)
    P, cost = np.zeros((size, size)), np.zeros(size)
    A, right = [], []
    G, least = [], []
    for k in range(n + 1):
        at = slice(k * nv, (k + 1) * nv)
        P[at, at], cost[at] = p.H[k], p.g[k]
        for i in range(nz):
            row = np.zeros(size)
            row[k * nv + i] = 1.0
            if k:
                row[(k - 1) * nv : k * nv] = -p.AB[k - 1, i]
            A.append(row)
            right.append(p.b[k - 1, i] if k else p.z0[i])
        for i in range(rows):
            if not p.on[k, i]:
                continue
            row = np.zeros(size)
            if i < 2 * nb:
                row[k * nv + p.box[i // 2]] = 1.0 if i % 2 == 0 else -1.0
            else:
                row[at] = p.general[k, i - 2 * nb]
            if (k, i) in slack:
                row[slack[k, i]] = 1.0
            G.append(row)
            least.append(-p.c[k, i])
    for j in range(nz, nv):
        row = np.zeros(size)
        row[n * nv + j] = 1.0
        A.append(row)
        right.append(0.0)
    for place in slack.values():
        P[place, place], cost[place] = p.rho[1], p.rho[0]
        row = np.zeros(size)
        row[place] = 1.0
        G.append(row)
        least.append(0.0)
    solver = piqp.DenseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-12
    upper = np.full(len(G), np.inf)
    solver.setup(P, cost, np.array(A), np.array(right), np.array(G), np.array(least), upper)
    assert solver.solve() == piqp.PIQP_SOLVED
    return solver.result.x[: (n + 1) * nv].reshape(n + 1, nv), solver.result.y[: (n + 1) * nz].reshape(n + 1, nz)


@pytest.mark.parametrize("nw", (1, 2, 3, 5))
@pytest.mark.parametrize("seed", range(4))
def test_any_number_of_inputs_has_piqps_solution(seed, nw):
    problem = random_problem(seed, nw)
    outcome, v, pi = solve(problem)
    assert outcome == SOLVED
    theirs, multipliers = by_piqp(problem)
    np.testing.assert_allclose(v, theirs, atol=1e-6)
    np.testing.assert_allclose(pi[1:], -multipliers[1:], atol=1e-5)


def test_a_concave_subproblem_is_said_and_a_convex_one_of_it_is_solved():
    problem = random_problem(3)
    concave = problem.H - 30.0 * np.eye(5)
    values, vectors = np.linalg.eigh(concave)
    convex = (vectors * np.maximum(values, 1e-4)[:, None, :]) @ vectors.transpose(0, 2, 1)
    outcomes = [solve(replace(problem, H=h), 1e-8)[0] for h in (concave, convex)]
    assert outcomes == [NOT_CONVEX, SOLVED]


def test_numbers_that_are_not_finite_are_said():
    problem = random_problem(1)
    g = problem.g.copy()
    g[2, 1] = np.nan
    assert solve(replace(problem, g=g))[0] != SOLVED
