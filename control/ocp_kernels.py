"""The functions of an Ocp that the solver evaluates at every stage, as CasADi functions with packed results.

Each maps [point, s] to one vector: the values and the entries of their derivatives that are not zero. Where the entries
belong is kept beside the function. The controller in C is written from them (`c_controller`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.discretize import advance_memory, read_memory
from softsoil.control.ocp import OBSTACLE, REFERENCE, Ocp

Whole = NDArray[np.int64]

COSTLY = 300
"""Operations from which on a row of the rates counts as costly: those with soil forces in them."""


@dataclass(frozen=True)
class Packed:
    """A function [point, s] -> [values, entries]; cells (2, K): row and column of each entry."""

    function: ca.Function
    cells: Whole


@dataclass(frozen=True)
class Curvature:
    """Parts of the Hessian of pi' rates.

    gradient: [(z, w, r, pi), s] -> gradient of the costly rows' share in the `wanted` variables, to be differenced along
    `directions`, which are the first of them (the states; the inputs' own block is small beside their weights and left out);
    rest: the same point -> lower cells of the cheap rows' exact Hessian; costly: rows with soil forces in them.
    """

    gradient: ca.Function
    costly: Whole
    wanted: Whole
    directions: Whole
    rest: Packed


def rates(ocp: Ocp) -> Packed:
    """[(z, w, r), s] -> rates (n_z,) and the entries of their Jacobian in (z, w)."""
    return _with_jacobian("rates", ocp, 0)


def force_use(ocp: Ocp) -> Packed:
    """[(z, w, r), s] -> use of the soil's lateral force (2,), front and rear, and its Jacobian in (z, w)."""
    return _with_jacobian("use", ocp, 1)


def _with_jacobian(name: str, ocp: Ocp, result: int) -> Packed:
    z, w, r, s = ocp.symbols()
    v = ca.vertcat(z, w)
    values = ocp.dynamics()(z, w, r, s)[result]
    entries, places = [], []
    for i in range(values.numel()):
        # Row by row in reverse mode: few rows are costly, and they share their sweep.
        row = ca.jacobian(values[i], v)
        places += [(i, column) for column in row.sparsity().get_triplet()[1]]
        entries += [row.nz[j] for j in range(row.nnz())]
    function = ca.Function(name, [ca.vertcat(v, r), s], [ca.densify(ca.vertcat(values, *entries))])
    return Packed(function, np.array(places, dtype=np.int64).reshape(-1, 2).T)


def curvature(ocp: Ocp) -> Curvature:
    """The parts of the Hessian of the dynamics under multipliers pi."""
    z, w, r, s = ocp.symbols()
    v, pi = ca.vertcat(z, w), ca.SX.sym("pi", len(ocp.z))
    rows = ocp.dynamics()(z, w, r, s)[0]
    sizes = [ca.Function("row", [v, r, s], [rows[i]]).n_instructions() for i in range(rows.numel())]
    costly = np.array([i for i, size in enumerate(sizes) if size > COSTLY], dtype=np.int64)
    cheap = [i for i in range(rows.numel()) if i not in costly]
    share: Any = sum((pi[int(i)] * rows[int(i)] for i in costly), ca.SX(0))
    gradient = ca.gradient(share, v)
    wanted = np.array([i for i in range(v.numel()) if ca.which_depends(gradient[i], v, 1, True)[0]], dtype=np.int64)
    point = ca.vertcat(v, r, pi)
    slopes = ca.vertcat(*[gradient[int(i)] for i in wanted]) if len(wanted) else ca.SX(1, 1)
    rest = ca.tril(ca.hessian(sum((pi[i] * rows[i] for i in cheap), ca.SX(0)), v)[0])
    cells = np.array(rest.sparsity().get_triplet(), dtype=np.int64).reshape(2, -1)
    entries = ca.vertcat(*[rest.nz[i] for i in range(rest.nnz())]) if rest.nnz() else ca.SX(1, 1)
    return Curvature(
        ca.Function("gradient", [point, s], [ca.densify(slopes)]), costly, wanted,
        wanted[wanted < len(ocp.z)], Packed(ca.Function("rest", [point, s], [ca.densify(entries)]), cells),
    )  # fmt: skip


@dataclass(frozen=True)
class StageTerms:
    """[(z, w, ref, scale, obstacles), s] -> (l, gradient, Hessian cells, gaps, entries of the gaps' Jacobian).

    hessian, gaps: rows and columns of the cells (lower triangle) and of the entries.
    """

    function: ca.Function
    hessian: Whole
    gaps: Whole


def stage_terms(ocp: Ocp) -> StageTerms:
    """Cost and clearances of one stage with their derivatives in (z, w)."""
    z, w, _, s = ocp.symbols()
    ref, scale = ca.SX.sym("ref", len(REFERENCE)), ca.SX.sym("scale")
    places = ca.SX.sym("obstacles", len(OBSTACLE), ocp.settings.obstacles)
    v = ca.vertcat(z, w)
    hessian, gradient = ca.hessian(scale * ocp.cost()(z, w, ref), v)
    hessian = ca.tril(hessian)
    cells = np.array(hessian.sparsity().get_triplet(), dtype=np.int64).reshape(2, -1)
    parts = [scale * ocp.cost()(z, w, ref), ca.densify(gradient), *[hessian.nz[i] for i in range(hessian.nnz())]]
    clear = ocp.clearance()
    gap_cells = np.zeros((2, 0), dtype=np.int64)
    if ocp.settings.obstacles:
        gaps = ca.vertcat(*[clear(z, places[:, i]) for i in range(ocp.settings.obstacles)])
        jacobian = ca.jacobian(gaps, v)
        gap_cells = np.array(jacobian.sparsity().get_triplet(), dtype=np.int64).reshape(2, -1)
        parts += [gaps, *[jacobian.nz[i] for i in range(jacobian.nnz())]]
    point = ca.vertcat(v, ref, scale, ca.vec(places))
    return StageTerms(ca.Function("stage", [point, s], [ca.densify(ca.vertcat(*parts))]), cells, gap_cells)


def roll(ocp: Ocp) -> ca.Function:
    """[m, z, w, s] -> [m one interval later, r in it]: the model's histories along a plan."""
    z, w, _, s = ocp.symbols()
    m = ca.SX.sym("m", len(ocp.model.cells))
    x, p = z[: len(ocp.model.x)], s[: len(ocp.model.p)]
    full = read_memory(ocp.model)(x, ocp.external(z, w, s), p, m)
    after = advance_memory(ocp.model, ocp.settings.dt)(x, full, p, m)
    results = ca.cse([ca.densify(after), ca.densify(full[len(ocp.model.external) :])])
    return ca.Function("roll", [m, z, w, s], results)


def model_inputs(ocp: Ocp) -> ca.Function:
    """[z, w, s] -> [inputs of the model (n_external,)]: steering, acceleration, and wheel speeds that follow from the motion."""
    z, w, _, s = ocp.symbols()
    return ca.Function("inputs", [z, w, s], [ca.densify(ocp.external(z, w, s))])
