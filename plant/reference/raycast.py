"""How the reference simulator finds a wheel's underside: a ray cast that stops within a tolerance.

At each node the reference casts a ray upward against a convex body and advances it conservatively (van den Bergen, Ray
casting against general convex objects with application to continuous collision detection, 2004): up to the plane through
the wheel's support point, whose normal is the shortest way from the ray to a simplex of such points. Its library works in
single precision and stops where that way is 1 cm, or where the simplex has no volume: the hit lies below the wheel, by 0
to 9 mm, in a pattern that moves with the wheel over the nodes. Its cylinder has rounded edges.
"""

from __future__ import annotations

import math

from softsoil.plant.kernel import geometry

EDGE = 0.01
"""Radius of the rounded edges (m): the reference's margin."""

NEAR = 1e-4
"""Squared distance (m^2) at which the ray stops, and below which two vertices are one."""

FLAT = 1e-4
"""Six times the volume (m^3) below which a simplex is flat."""

MOST = 32
"""Most steps of one ray."""

FAR = 1e30
"""A squared distance beyond all (m^2)."""

EARLY = 0.0125
"""How far below the wheel a hit can lie (m)."""


@geometry
def _triangle(s, i, j, k, share):
    """Shares of vertices i, j, k in their triangle's point closest to the origin (Ericson, Real-Time Collision Detection,
    5.1.5); its squared distance."""
    ax, ay, az = s[i, 0], s[i, 1], s[i, 2]
    bx, by, bz = s[j, 0], s[j, 1], s[j, 2]
    cx, cy, cz = s[k, 0], s[k, 1], s[k, 2]
    ux, uy, uz = bx - ax, by - ay, bz - az
    wx, wy, wz = cx - ax, cy - ay, cz - az
    d1 = -(ux * ax + uy * ay + uz * az)
    d2 = -(wx * ax + wy * ay + wz * az)
    d3 = -(ux * bx + uy * by + uz * bz)
    d4 = -(wx * bx + wy * by + wz * bz)
    d5 = -(ux * cx + uy * cy + uz * cz)
    d6 = -(wx * cx + wy * cy + wz * cz)
    vc = d1 * d4 - d3 * d2
    vb = d5 * d2 - d1 * d6
    va = d3 * d6 - d5 * d4
    a = b = c = 0.0
    if d1 <= 0.0 and d2 <= 0.0:
        a = 1.0
    elif d3 >= 0.0 and d4 <= d3:
        b = 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        b = d1 / (d1 - d3)
        a = 1.0 - b
    elif d6 >= 0.0 and d5 <= d6:
        c = 1.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        c = d2 / (d2 - d6)
        a = 1.0 - c
    elif va <= 0.0 and d4 >= d3 and d5 >= d6:
        c = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        b = 1.0 - c
    else:
        b = vb / (va + vb + vc)
        c = vc / (va + vb + vc)
        a = 1.0 - b - c
    share[i], share[j], share[k] = a, b, c
    x, y, z = a * ax + b * bx + c * cx, a * ay + b * by + c * cy, a * az + b * bz + c * cz
    return x * x + y * y + z * z


@geometry
def _beyond(s, i, j, k, m):
    """1 where the origin and vertex m lie on opposite sides of the plane through i, j, k; 0 if not; -1 without volume."""
    ux, uy, uz = s[j, 0] - s[i, 0], s[j, 1] - s[i, 1], s[j, 2] - s[i, 2]
    wx, wy, wz = s[k, 0] - s[i, 0], s[k, 1] - s[i, 1], s[k, 2] - s[i, 2]
    nx, ny, nz = uy * wz - uz * wy, uz * wx - ux * wz, ux * wy - uy * wx
    fourth = (s[m, 0] - s[i, 0]) * nx + (s[m, 1] - s[i, 1]) * ny + (s[m, 2] - s[i, 2]) * nz
    if abs(fourth) < FLAT:
        return -1
    return 1 if (s[i, 0] * nx + s[i, 1] * ny + s[i, 2] * nz) * fourth > 0.0 else 0


@geometry
def _closest(s, count, share):
    """Shares (4,) of the vertices in the simplex' point closest to the origin; False where it is flat or holds it."""
    share[0] = share[1] = share[2] = share[3] = 0.0
    if count == 1:
        share[0] = 1.0
    elif count == 2:
        ux, uy, uz = s[1, 0] - s[0, 0], s[1, 1] - s[0, 1], s[1, 2] - s[0, 2]
        along = -(ux * s[0, 0] + uy * s[0, 1] + uz * s[0, 2])
        square = ux * ux + uy * uy + uz * uz
        share[1] = 0.0 if along <= 0.0 else (along / square if along < square else 1.0)
        share[0] = 1.0 - share[1]
    elif count == 3:
        _triangle(s, 0, 1, 2, share)
    else:
        abc, acd = _beyond(s, 0, 1, 2, 3), _beyond(s, 0, 2, 3, 1)
        adb, bdc = _beyond(s, 0, 3, 1, 2), _beyond(s, 1, 3, 2, 0)
        if min(abc, acd, adb, bdc) < 0 or max(abc, acd, adb, bdc) == 0:
            return False
        nearest = FAR
        p = q = r = t = 0.0
        if abc > 0:
            nearest = _triangle(s, 0, 1, 2, share)
            p, q, r = share[0], share[1], share[2]
        if acd > 0:
            square = _triangle(s, 0, 2, 3, share)
            if square < nearest:
                nearest = square
                p, q, r, t = share[0], 0.0, share[2], share[3]
        if adb > 0:
            square = _triangle(s, 0, 3, 1, share)
            if square < nearest:
                nearest = square
                p, q, r, t = share[0], share[1], 0.0, share[3]
        if bdc > 0:
            square = _triangle(s, 1, 3, 2, share)
            if square < nearest:
                p, q, r, t = 0.0, share[1], share[2], share[3]
        share[0], share[1], share[2], share[3] = p, q, r, t
    return True


@geometry
def _from_wheel(x, y, z, vx, vy, vz, rim, side):
    """From the wheel's farthest point in direction v to (x, y, z); rim, side: radius and half width less the rounding."""
    across = math.sqrt(vx * vx + vz * vz)
    length = math.sqrt(across * across + vy * vy)
    out = rim / across + EDGE / length if across > 0.0 else 0.0
    return x - vx * out, y - EDGE * vy / length + (side if vy < 0.0 else -side), z - vz * out


@geometry
def ray_hit(x, y, z, ry, rz, radius, half_width, s, share):
    """Share of the ray from (x, y, z) along (0, ry, rz) at which it meets the wheel, or -1 (m, in the wheel's frame: centre
    0, axle along y).

    s (4, 3), share (4,): room to work in.
    """
    rim, side = radius - EDGE, half_width - EDGE
    vx, vy, vz = _from_wheel(x, y, z, 0.0, ry, rz, rim, side)
    ny = nz = 0.0
    lam, count = 0.0, 0
    for _ in range(MOST):
        if lam > 1.0 or vx * vx + vy * vy + vz * vz <= NEAR:
            break
        wx, wy, wz = _from_wheel(x, y + lam * ry, z + lam * rz, vx, vy, vz, rim, side)
        ahead = vx * wx + vy * wy + vz * wz
        if ahead > 0.0:
            along = vy * ry + vz * rz
            if along >= 0.0:
                return -1.0
            lam -= ahead / along
            ny, nz = vy, vz
        known = False
        for k in range(count):
            ax, ay, az = s[k, 0] - wx, s[k, 1] - wy, s[k, 2] - wz
            known = known or ax * ax + ay * ay + az * az <= NEAR
        if not known:
            s[count, 0], s[count, 1], s[count, 2] = wx, wy, wz
            count += 1
        if not _closest(s, count, share):
            break
        vx = vy = vz = 0.0
        for k in range(count):
            vx += share[k] * s[k, 0]
            vy += share[k] * s[k, 1]
            vz += share[k] * s[k, 2]
        for k in range(count - 1, -1, -1):
            if share[k] == 0.0:
                count -= 1
                s[k, 0], s[k, 1], s[k, 2] = s[count, 0], s[count, 1], s[count, 2]
    return lam if lam < 1.0 and ny * ry + nz * rz < 0.0 else -1.0
