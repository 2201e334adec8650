"""A quadratic programme with the structure of optimal control, solved by an interior-point method on a Riccati recursion.

min sum_k 1/2 v_k' H_k v_k + g_k' v_k + sum_i rho_1 s + rho_2/2 s^2,  v_k = (z_k, w_k), two inputs w
s.t. z_{k+1} = AB_k v_k + b_k, z_0 given, and rows y_i = a_i' v_k + c_i >= -s_i (s = 0 where the row is hard).
Mehrotra's predictor and corrector; slacks are eliminated row by row, so that a soft limit costs what a hard one costs
(Rao, Wright, Rawlings 1998, for the recursion). Rows are limits of one variable first, then general ones.
"""

from __future__ import annotations

import numpy as np
from numba import njit

SOLVED, SHORT, NOT_CONVEX, BROKEN = 0, 1, 2, 3
"""Outcomes: solved; out of iterations (the iterate is usable); a reduced Hessian that is not positive; not finite."""
HARD = 1e12
"""Stands for the stiffness of a slack that does not exist."""
_FAST = {"contract", "reassoc", "nsz", "arcp"}


@njit(cache=True, fastmath=_FAST)
def rows_of(v, box, general, y):
    """y_i = a_i' v for all rows: each limited variable up and down, then the general rows."""
    for k in range(v.shape[0]):
        for j in range(box.shape[0]):
            y[k, 2 * j] = v[k, box[j]]
            y[k, 2 * j + 1] = -v[k, box[j]]
        for i in range(general.shape[1]):
            total = 0.0
            for j in range(v.shape[1]):
                total += general[k, i, j] * v[k, j]
            y[k, 2 * box.shape[0] + i] = total


@njit(cache=True, fastmath=_FAST)
def _factor(H, AB, b, box, general, stiff, last, P, K, R, Pb, M, PAB):
    """Riccati recursion with the rows' stiffness added to H; False where a reduced Hessian is not positive definite."""
    n_stage, nz, nv = AB.shape
    nb = box.shape[0]
    for k in range(n_stage, -1, -1):
        nk = nz if k == n_stage else nv
        for i in range(nk):
            for j in range(i + 1):
                M[i, j] = H[k, i, j]
        for j in range(nb):
            if box[j] < nk:
                M[box[j], box[j]] += stiff[k, 2 * j] + stiff[k, 2 * j + 1]
        for row in range(general.shape[1]):
            weight = stiff[k, 2 * nb + row]
            if weight > 0.0:
                for i in range(nk):
                    scaled = weight * general[k, row, i]
                    if scaled != 0.0:
                        for j in range(i + 1):
                            M[i, j] += scaled * general[k, row, j]
        if k < n_stage:
            for i in range(nz):
                total = 0.0
                for m in range(nz):
                    total += P[k + 1, i, m] * b[k, m]
                Pb[k, i] = total
                for j in range(nv):
                    PAB[i, j] = 0.0
                for m in range(nz):
                    p = P[k + 1, i, m]
                    for j in range(nv):
                        PAB[i, j] += p * AB[k, m, j]
            for m in range(nz):
                for i in range(nv):
                    a = AB[k, m, i]
                    if a != 0.0:
                        for j in range(i + 1):
                            M[i, j] += a * PAB[m, j]
            r11, r21, r22 = M[nz, nz], M[nz + 1, nz], M[nz + 1, nz + 1]
            if not r11 > last:
                return False
            l11 = np.sqrt(r11)
            l21 = r21 / l11
            rest = r22 - l21 * l21
            if not rest > last:
                return False
            l22 = np.sqrt(rest)
            R[k, 0], R[k, 1], R[k, 2] = 1.0 / l11, l21, 1.0 / l22
            for j in range(nz):
                y0 = M[nz, j] / l11
                y1 = (M[nz + 1, j] - l21 * y0) / l22
                K[k, 0, j], K[k, 1, j] = y0, y1
        for i in range(nz):
            for j in range(i + 1):
                value = M[i, j]
                if k < n_stage:
                    value -= K[k, 0, i] * K[k, 0, j] + K[k, 1, i] * K[k, 1, j]
                P[k, i, j] = value
                P[k, j, i] = value
    return True


@njit(cache=True, fastmath=_FAST)
def _sweep(AB, b, z0, P, K, R, Pb, grad, v, pi, q, f):
    """Backward sweep for the gradients grad (N + 1, nv), then forward: v and the multipliers pi of the dynamics."""
    n_stage, nz, nv = AB.shape
    for i in range(nz):
        q[n_stage, i] = grad[n_stage, i]
    m = np.empty(nv)
    for k in range(n_stage - 1, -1, -1):
        for i in range(nv):
            m[i] = grad[k, i]
        for j in range(nz):
            h = Pb[k, j] + q[k + 1, j]
            for i in range(nv):
                m[i] += AB[k, j, i] * h
        f0 = m[nz] * R[k, 0]
        f1 = (m[nz + 1] - R[k, 1] * f0) * R[k, 2]
        f[k, 0], f[k, 1] = f0, f1
        for i in range(nz):
            q[k, i] = m[i] - K[k, 0, i] * f0 - K[k, 1, i] * f1
    for i in range(nz):
        v[0, i] = z0[i]
    for k in range(n_stage):
        y0, y1 = f[k, 0], f[k, 1]
        for i in range(nz):
            y0 += K[k, 0, i] * v[k, i]
            y1 += K[k, 1, i] * v[k, i]
        w1 = -y1 * R[k, 2]
        w0 = (-y0 - R[k, 1] * w1) * R[k, 0]
        v[k, nz], v[k, nz + 1] = w0, w1
        for i in range(nz):
            total = b[k, i]
            for j in range(nv):
                total += AB[k, i, j] * v[k, j]
            v[k + 1, i] = total
    for j in range(nz, nv):
        v[n_stage, j] = 0.0
    for k in range(1, n_stage + 1):
        for i in range(nz):
            total = q[k, i]
            for j in range(nz):
                total += P[k, i, j] * v[k, j]
            pi[k, i] = total


@njit(cache=True, fastmath=_FAST)
def _targets(grad, g, box, general, lam, t, s, mu, stiff, e, y, c, on, aim, cross, rho, base, a_over_e):
    """Gradient of the barrier's quadratic model at the present iterate, and the row terms dlam = base - stiff (a' dv)."""
    nb = box.shape[0]
    for k in range(g.shape[0]):
        for j in range(g.shape[1]):
            grad[k, j] = g[k, j]
        for i in range(lam.shape[1]):
            if not on[k, i]:
                continue
            w = lam[k, i] / t[k, i]
            primal = y[k, i] + c[k, i] + s[k, i] - t[k, i]
            soft = e[k, i] < HARD
            a = 0.0
            if soft:
                dual = rho[0] + rho[1] * s[k, i] - lam[k, i] - mu[k, i]
                a = (-dual + (aim - cross[k, i, 1]) / s[k, i] - mu[k, i]) / e[k, i]
            a_over_e[k, i] = a
            value = ((aim - cross[k, i, 0]) / t[k, i] - lam[k, i] - w * (a + primal)) * (stiff[k, i] / w)
            base[k, i] = value
            push = lam[k, i] + value + stiff[k, i] * y[k, i]
            if i < 2 * nb:
                grad[k, box[i // 2]] -= push if i % 2 == 0 else -push
            else:
                for j in range(g.shape[1]):
                    grad[k, j] -= push * general[k, i - 2 * nb, j]


@njit(cache=True, fastmath=_FAST)
def _directions(y_new, y, c, base, stiff, a_over_e, e, lam, t, s, mu, on, aim, cross, dlam, dt, ds, dmu):
    """Steps of multipliers and slacks that belong to the new rows y_new; the largest steps that keep all positive."""
    primal_step, dual_step = 1.0, 1.0
    for k in range(y.shape[0]):
        for i in range(y.shape[1]):
            if not on[k, i]:
                continue
            dy = y_new[k, i] - y[k, i]
            dl = base[k, i] - stiff[k, i] * dy
            soft = e[k, i] < HARD
            d_s = dl / e[k, i] + a_over_e[k, i] if soft else 0.0
            d_t = dy + d_s + y[k, i] + c[k, i] + s[k, i] - t[k, i]
            dlam[k, i], dt[k, i], ds[k, i] = dl, d_t, d_s
            if d_t < 0.0:
                primal_step = min(primal_step, -t[k, i] / d_t)
            if dl < 0.0:
                dual_step = min(dual_step, -lam[k, i] / dl)
            if soft:
                dm = (aim - cross[k, i, 1] - mu[k, i] * s[k, i] - mu[k, i] * d_s) / s[k, i]
                dmu[k, i] = dm
                if d_s < 0.0:
                    primal_step = min(primal_step, -s[k, i] / d_s)
                if dm < 0.0:
                    dual_step = min(dual_step, -mu[k, i] / dm)
    return primal_step, dual_step


@njit(cache=True, fastmath=_FAST)
def _gap(lam, t, s, mu, e, on, dlam, dt, ds, dmu, step_p, step_d):
    """Mean complementarity after the given steps, and the number of pairs."""
    total, count = 0.0, 0
    for k in range(lam.shape[0]):
        for i in range(lam.shape[1]):
            if on[k, i]:
                total += (lam[k, i] + step_d * dlam[k, i]) * (t[k, i] + step_p * dt[k, i])
                count += 1
                if e[k, i] < HARD:
                    total += (mu[k, i] + step_d * dmu[k, i]) * (s[k, i] + step_p * ds[k, i])
                    count += 1
    return total / max(count, 1)


@njit(cache=True, fastmath=_FAST)
def solve_qp(H, g, AB, b, z0, box, general, c, on, soft, rho, v, pi, lam, t, s, mu, start, tolerance, most):
    """Solve; v, pi, lam, t, s, mu hold the solution. Returns (outcome, iterations).

    H (N + 1, nv, nv), g (N + 1, nv), AB (N, nz, nv), b (N, nz), z0 (nz,), box (nb,) variables with limits,
    general (N + 1, ng, nv), c, on, lam, t, s, mu (N + 1, 2 nb + ng), soft (2 nb + ng,), rho (2,): see the module;
    start: complementarity to start from, tolerance: to end at; most: iterations.
    """
    n_stage, nz, nv = AB.shape
    rows = c.shape[1]
    shape = (n_stage + 1, rows)
    P, K, R = np.empty((n_stage + 1, nz, nz)), np.empty((n_stage, 2, nz)), np.empty((n_stage, 3))
    Pb, M, PAB = np.empty((n_stage, nz)), np.empty((nv, nv)), np.empty((nz, nv))
    q, f = np.empty((n_stage + 1, nz)), np.empty((n_stage, 2))
    grad, v_new, pi_new = np.empty_like(g), np.zeros_like(g), np.zeros_like(pi)
    y, y_new, stiff, e = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.empty(shape)
    base, a_over_e, cross = np.zeros(shape), np.zeros(shape), np.zeros((n_stage + 1, rows, 2))
    dlam, dt, ds, dmu = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape)
    rows_of(v, box, general, y)
    for k in range(n_stage + 1):
        for i in range(rows):
            if not on[k, i]:
                lam[k, i] = 0.0
                s[k, i] = 0.0
                continue
            value = y[k, i] + c[k, i]
            if not soft[i]:
                t[k, i] = max(value, 0.1 * np.sqrt(start))
                lam[k, i] = max(min(lam[k, i], 10.0 * start / t[k, i]), start / t[k, i])
                s[k, i], mu[k, i] = 0.0, 0.0
            else:
                lam[k, i] = min(max(lam[k, i], start / max(value, np.sqrt(start))), 0.95 * rho[0])
                t[k, i] = max(value, start / lam[k, i])
                mu[k, i] = rho[0] - lam[k, i]
                s[k, i] = max(t[k, i] - value, start / mu[k, i])
                mu[k, i] = max(mu[k, i] + rho[1] * s[k, i], 1e-8)
    for iteration in range(most):
        for k in range(n_stage + 1):
            for i in range(rows):
                if on[k, i]:
                    w = lam[k, i] / t[k, i]
                    e[k, i] = rho[1] + mu[k, i] / s[k, i] if soft[i] else HARD
                    stiff[k, i] = w / (1.0 + w / e[k, i]) if soft[i] else w
        gap = _gap(lam, t, s, mu, e, on, dlam, dt, ds, dmu, 0.0, 0.0)
        if not _factor(H, AB, b, box, general, stiff, 1e-10, P, K, R, Pb, M, PAB):
            return NOT_CONVEX, iteration
        cross[:] = 0.0
        _targets(grad, g, box, general, lam, t, s, mu, stiff, e, y, c, on, 0.0, cross, rho, base, a_over_e)
        _sweep(AB, b, z0, P, K, R, Pb, grad, v_new, pi_new, q, f)
        rows_of(v_new, box, general, y_new)
        a_p, a_d = _directions(
            y_new, y, c, base, stiff, a_over_e, e, lam, t, s, mu, on, 0.0, cross, dlam, dt, ds, dmu
        )  # fmt: skip
        after = _gap(lam, t, s, mu, e, on, dlam, dt, ds, dmu, a_p, a_d)
        aim = max(gap * (after / gap) ** 3, 0.1 * tolerance) if gap > 0 else tolerance
        for k in range(n_stage + 1):
            for i in range(rows):
                if on[k, i]:
                    cross[k, i, 0] = dlam[k, i] * dt[k, i]
                    cross[k, i, 1] = dmu[k, i] * ds[k, i]
        _targets(grad, g, box, general, lam, t, s, mu, stiff, e, y, c, on, aim, cross, rho, base, a_over_e)
        _sweep(AB, b, z0, P, K, R, Pb, grad, v_new, pi_new, q, f)
        rows_of(v_new, box, general, y_new)
        a_p, a_d = _directions(
            y_new, y, c, base, stiff, a_over_e, e, lam, t, s, mu, on, aim, cross, dlam, dt, ds, dmu
        )  # fmt: skip
        step = min(1.0, 0.995 * min(a_p, a_d))
        change = 0.0
        for k in range(n_stage + 1):
            for j in range(nv):
                move = step * (v_new[k, j] - v[k, j])
                v[k, j] += move
                change = max(change, abs(move))
            for j in range(nz):
                pi[k, j] += step * (pi_new[k, j] - pi[k, j])
            for i in range(rows):
                if on[k, i]:
                    y[k, i] += step * (y_new[k, i] - y[k, i])
                    lam[k, i] += step * dlam[k, i]
                    t[k, i] += step * dt[k, i]
                    s[k, i] += step * ds[k, i]
                    if soft[i]:
                        mu[k, i] += step * dmu[k, i]
        if not np.isfinite(change):
            return BROKEN, iteration + 1
        after = _gap(lam, t, s, mu, e, on, dlam, dt, ds, dmu, 0.0, 0.0)
        if after < tolerance and step > 0.9:
            return SOLVED, iteration + 1
    return SHORT, most


@njit(cache=True)
def penalised(z, w, box, limits, value, on, rho, cost):
    """Cost with what soft limits cost: sum of cost (N + 1,), and rho_1 s + rho_2/2 s^2 of each row that is violated."""
    total, n, nz, nb = 0.0, w.shape[0], z.shape[1], len(box)
    for k in range(n + 1):
        total += cost[k]
        for j in range(nb):
            if k == n and box[j] >= nz:
                continue
            now = z[k, box[j]] if box[j] < nz else w[k, box[j] - nz]
            for side in range(2):
                short = limits[j, 0] - now if side == 0 else now - limits[j, 1]
                if on[k, 2 * j + side] and short > 0.0:
                    total += short * (rho[0] + 0.5 * rho[1] * short)
        for i in range(value.shape[1]):
            if on[k, 2 * nb + i] and value[k, i] < 0.0:
                total -= value[k, i] * (rho[0] - 0.5 * rho[1] * value[k, i])
    return total


@njit(cache=True)
def margins(z, w, box, limits, value, c):
    """c (N + 1, rows): how far every row is from its limit at z, w."""
    n, nz, nb = w.shape[0], z.shape[1], len(box)
    for k in range(n + 1):
        for j in range(nb):
            if k < n or box[j] < nz:
                now = z[k, box[j]] if box[j] < nz else w[k, box[j] - nz]
                c[k, 2 * j], c[k, 2 * j + 1] = now - limits[j, 0], limits[j, 1] - now
        for i in range(value.shape[1]):
            c[k, 2 * nb + i] = value[k, i]
