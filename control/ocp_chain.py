"""Kernels between the generated C's packed results and the arrays of the subproblem: the chain rule through one step."""

from __future__ import annotations

import numpy as np
from numba import njit

_FAST = {"contract", "reassoc", "nsz", "arcp"}


@njit(cache=True, fastmath=_FAST)
def absorb(
    number, h, z, into, out, rows, columns, s, total, total_t, middle_s, middle_z, middle_j, end, AB
):  # fmt: skip
    """Take in Runge-Kutta point `number` (0 to 3) of all intervals and place the next one in `into`."""
    count, nz, nv = AB.shape
    t = np.empty((nz, nv))
    weight = h / 6.0 if number in (0, 3) else h / 3.0
    ahead = h if number == 2 else 0.5 * h
    for k in range(count):
        t[:] = 0.0
        for i in range(len(rows)):
            row, column, entry = rows[i], columns[i], out[k, nz + i]
            if number == 0 or column >= nz:
                t[row, column] += entry
            else:
                for j in range(nv):
                    t[row, j] += entry * s[k, column, j]
        for i in range(nz):
            # Not 0 * total at the first point: what was once not finite would stay so.
            total[k, i] = weight * out[k, i] + (total[k, i] if number > 0 else 0.0)
            for j in range(nv):
                total_t[k, i, j] = weight * t[i, j] + (total_t[k, i, j] if number > 0 else 0.0)
                s[k, i, j] = ahead * t[i, j]
            s[k, i, i] += 1.0
        if number < 3:
            for i in range(nz):
                into[k, i] = z[k, i] + ahead * out[k, i]
        else:
            for i in range(nz):
                end[k, i] = z[k, i] + total[k, i]
                for j in range(nv):
                    AB[k, i, j] = total_t[k, i, j]
                AB[k, i, i] += 1.0
        if number == 0:
            for i in range(nz):
                middle_z[k, i] = into[k, i]
                for j in range(nv):
                    middle_s[k, i, j] = s[k, i, j]
        if number == 1:
            for i in range(len(rows)):
                middle_j[k, i] = out[k, nz + i]


@njit(cache=True)
def reserve_rows(out, rows, columns, reserve, use, general, value):
    """The last two general rows: 1 - reserve - |use| >= 0 of front and rear, |.| smooth."""
    first = general.shape[1] - 2
    for k in range(out.shape[0]):
        for a in range(2):
            use[k, a] = out[k, a]
            value[k, first + a] = 1.0 - reserve - np.sqrt(out[k, a] ** 2 + 1e-4)
            general[k, first + a, :] = 0.0
        for i in range(len(rows)):
            a = rows[i]
            slope = out[k, a] / np.sqrt(out[k, a] ** 2 + 1e-4)
            general[k, first + a, columns[i]] = -slope * out[k, 2 + i]


@njit(cache=True)
def spread(out, nv, cost_cells, gap_cells, gaps, cost, g, hessian, general, value):
    """Stage terms from their packed form."""
    for k in range(out.shape[0]):
        cost[k] = out[k, 0]
        for j in range(nv):
            g[k, j] = out[k, 1 + j]
        at = 1 + nv
        for i in range(cost_cells.shape[1]):
            a, b = cost_cells[0, i], cost_cells[1, i]
            hessian[k, a, b] = out[k, at + i]
            hessian[k, b, a] = out[k, at + i]
        at += cost_cells.shape[1]
        for i in range(gaps):
            value[k, i] = out[k, at + i]
        at += gaps
        for i in range(gap_cells.shape[1]):
            general[k, gap_cells[0, i], gap_cells[1, i]] = out[k, at + i]


@njit(cache=True)
def perturb(into, plain, z, w, pi, directions, eps, n_r):
    """Points of the gradient: each direction of each interval moved by eps; `plain`: unmoved; pi of the interval's end."""
    nz, nw = z.shape[1], w.shape[1]
    count = len(directions)
    for k in range(z.shape[0]):
        for i in range(nz):
            plain[k, i] = z[k, i]
            plain[k, nz + nw + n_r + i] = pi[k + 1, i]
        for i in range(nw):
            plain[k, nz + i] = w[k, i]
        for d in range(count):
            row = k * count + d
            for i in range(nz + nw):
                into[row, i] = plain[k, i]
            for i in range(nz):
                into[row, nz + nw + n_r + i] = pi[k + 1, i]
            into[row, directions[d]] += eps


@njit(cache=True, fastmath=_FAST)
def contract(
    out, rest, middle_j, rows, columns, costly, wanted, directions, cells, s, pi, h, eps, cost, hessian
):  # fmt: skip
    """Hessian = cost + h T' C T, C the curvature at the middle of the interval, T the variables there over the start's."""
    count, nz, nv = s.shape
    curve, half, base = np.empty((nv, nv)), np.empty((nv, nv)), np.empty(nv)
    is_costly, is_direction = np.zeros(nz, dtype=np.bool_), np.zeros(nv, dtype=np.bool_)
    for i in costly:
        is_costly[i] = True
    for i in directions:
        is_direction[i] = True
    touched = np.zeros(nv, dtype=np.bool_)
    for i in wanted:
        touched[i] = True
    for i in range(cells.shape[1]):
        touched[cells[0, i]] = True
        touched[cells[1, i]] = True
    used = np.flatnonzero(touched)
    for k in range(count):
        base[:] = 0.0
        curve[:] = 0.0
        for i in range(len(rows)):
            if is_costly[rows[i]]:
                base[columns[i]] += pi[k + 1, rows[i]] * middle_j[k, i]
        for a in range(len(directions)):
            i = directions[a]
            for b in range(len(wanted)):
                j = wanted[b]
                value = h * (out[k * len(directions) + a, b] - base[j]) / eps
                if is_direction[j]:
                    curve[i, j] += 0.5 * value
                    curve[j, i] += 0.5 * value
                else:
                    curve[i, j] += value
                    curve[j, i] += value
        for i in range(cells.shape[1]):
            a, b = cells[0, i], cells[1, i]
            curve[a, b] += h * rest[k, i]
            if a != b:
                curve[b, a] += h * rest[k, i]
        for one in used:  # half = C T with T = (s; 0 I)
            for j in range(nv):
                half[one, j] = curve[one, j] if j >= nz else 0.0
            for two in used:
                if two < nz and curve[one, two] != 0.0:
                    for j in range(nv):
                        half[one, j] += curve[one, two] * s[k, two, j]
        for i in range(nv):
            for j in range(i + 1):
                hessian[k, i, j] = cost[k, i, j] + (half[i, j] if i >= nz and touched[i] else 0.0)
        for one in used:
            if one < nz:
                for i in range(nv):
                    scaled = s[k, one, i]
                    if scaled != 0.0:
                        for j in range(i + 1):
                            hessian[k, i, j] += scaled * half[one, j]
        for i in range(nv):
            for j in range(i):
                hessian[k, j, i] = hessian[k, i, j]
    hessian[count] = cost[count]
