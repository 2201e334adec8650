"""The soil contact model: one rigid cylinder wheel on a grid of nodes that remember (Krenn and Hirzinger's SCM).

Per node under the wheel, each step, with h the sinkage against the undeformed surface (z = 0):

    trial pressure     sigma = K (h - h_plastic), contact where sigma >= 0
    above the yield    sigma = (k_c / b + k_phi) h^n, yield = sigma, h_plastic = h - sigma / K     (paper, eq. (1))
    damping            sigma -= R V_n, V_n the wheel's upward velocity there
    shear              j += |v_t| dt, tau = (c + sigma tan phi)(1 - exp(-j / k)), against v_t      (paper, eqs. (2),
    (3))

v_t is the horizontal velocity of the wheel body at the node, spin and yaw included, so lateral and longitudinal shear
share one Mohr limit. 1/b = perimeter / (2 area) of the convex hull of all nodes within reach of the wheel. h_plastic,
yield and j stay, or each wheel has a j of its own: soil that shears anew in a rut. h is the cylinder's own, or where the
reference simulator's ray cast finds it (`plant.reference`).
"""

from __future__ import annotations

import math

import numpy as np

from softsoil.plant.footprint import hull_area_perimeter
from softsoil.plant.grid import PLASTIC, SHEAR, SINKAGE, TILE, YIELD, add_tile, find_tile, tile_key
from softsoil.plant.kernel import inner, kernel
from softsoil.plant.reference.raycast import EARLY, ray_hit
from softsoil.plant.soil_field import DAMPING, K_C, K_ELASTIC, K_PHI, K_SHEAR, TAN_PHI, C, N, soil_at

REACH = 0.1
"""How far above the soil the search for the footprint looks (m), as in the reference simulator."""

RAY = 0.5
"""Length of the reference's rays (m), which end REACH above the node."""


@inner
def _search(ground, layer, reach, motion, radius, width, i0, j0, bottom, low, high):
    """Fill `bottom` (height of the wheel's underside, +inf elsewhere) and each column's ends; return whether any node
    is in."""
    columns, rows = bottom.shape
    spacing, nodes, centre, axis = ground.spacing, ground.nodes, motion.centre, motion.axis
    curve = 1.0 - axis[2] * axis[2]
    found = False
    tile_row = tile_column = np.int64(-(1 << 40))
    slot = np.int64(-1)
    for a in range(columns):
        low[a], high[a] = rows, -1
        dx = (i0 + a) * spacing - centre[0]
        for b in range(rows):
            bottom[a, b] = np.inf
            dy = (j0 + b) * spacing - centre[1]
            s0 = dx * axis[0] + dy * axis[1]
            # Lower crossing of the vertical line at the node with the cylinder about `axis`.
            half = s0 * axis[2]
            square = half * half - curve * (dx * dx + dy * dy - s0 * s0 - radius * radius)
            if square < 0.0:
                continue
            dz = (half - math.sqrt(square)) / curve
            if abs(s0 + dz * axis[2]) > 0.5 * width:
                continue
            z = centre[2] + dz
            if z > reach:
                continue
            i, j = i0 + a, j0 + b
            row, column = i // TILE, j // TILE
            if row != tile_row or column != tile_column:
                tile_row, tile_column = row, column
                slot = find_tile(ground.keys, ground.slots, tile_key(layer, row, column))
            if slot >= 0 and z > reach - nodes[slot, (i - row * TILE) * TILE + j - column * TILE, SINKAGE]:
                continue
            bottom[a, b] = z
            low[a] = min(low[a], b)
            high[a] = max(high[a], b)
            found = True
    return found


@inner
def _cast_depth(dx, dy, top, centre_z, axis, radius, width, simplex, share):
    """Depth (m) at which a ray up to the height `top` (m), dx and dy from the wheel's centre, meets it; 0 without a hit."""
    across = math.sqrt(axis[0] * axis[0] + axis[1] * axis[1])
    x, y = axis[1] / across, -axis[0] / across  # forward; the third axis is forward x leftward
    up_x, up_y, up_z = y * axis[2], -x * axis[2], across
    low = top - RAY - centre_z
    met = ray_hit(
        dx * x + dy * y, dx * axis[0] + dy * axis[1] + low * axis[2], dx * up_x + dy * up_y + low * up_z,
        RAY * axis[2], RAY * up_z, radius, 0.5 * width, simplex, share,
    )  # fmt: skip
    return RAY - top - met * RAY if met >= 0.0 else 0.0


@kernel
def wheel_contact(ground, layer, side, rules, motion, radius, width, dt, force, moment):
    """Force (N) and moment about the wheel centre (N m) of the soil on one wheel, in world axes; moves the soil on by
    dt.

    ground, rules, motion: Ground, Rules and Motion; layer: which memory of the ground; side: which half of its soil map;
    radius, width: m; dt: s; force, moment (3,): written. Returns the greatest sinkage (m).
    """
    keys, slots, nodes, spacing, field, meta = (
        ground.keys, ground.slots, ground.nodes, ground.spacing, ground.field, ground.meta,
    )  # fmt: skip
    centre, axis, velocity, rate, reach = motion.centre, motion.axis, motion.velocity, motion.rate, rules.reach
    force[:] = 0.0
    moment[:] = 0.0
    if centre[2] - radius > reach:
        return 0.0
    lift = max(centre[2] - reach, 0.0)
    half_length = math.sqrt(max(radius * radius - lift * lift, 0.0))
    across = math.sqrt(axis[0] * axis[0] + axis[1] * axis[1])
    fx, fy = axis[1] / across, -axis[0] / across
    half_width = 0.5 * width + radius * abs(axis[2])
    ex = half_length * abs(fx) + half_width * abs(fy)
    ey = half_length * abs(fy) + half_width * abs(fx)
    i0 = math.ceil((centre[0] - ex) / spacing)
    j0 = math.ceil((centre[1] - ey) / spacing)
    columns = math.floor((centre[0] + ex) / spacing) - i0 + 1
    rows = math.floor((centre[1] + ey) / spacing) - j0 + 1
    if columns <= 0 or rows <= 0:
        return 0.0
    bottom = np.empty((columns, rows))
    low = np.empty(columns, dtype=np.int64)
    high = np.empty(columns, dtype=np.int64)
    if not _search(ground, layer, reach, motion, radius, width, i0, j0, bottom, low, high):
        return 0.0
    area, perimeter = hull_area_perimeter(low, high, spacing)
    over_b = perimeter / (2.0 * area) if area > 1e-6 else 0.0

    uniform = field.shape[1] == 1 and field.shape[2] == 1
    soil = np.empty(8)
    soil_at(field, side, meta, centre[0], centre[1], soil)
    cell = spacing * spacing
    slack = EARLY if rules.cast else 0.0
    simplex, share = np.empty((4, 3)), np.empty(4)
    deepest = 0.0
    for a in range(columns):
        for b in range(low[a], high[a] + 1):
            h = -bottom[a, b]
            if h + slack <= 0.0:
                continue
            i, j = i0 + a, j0 + b
            row, column = i // TILE, j // TILE
            key = tile_key(layer, row, column)
            slot = find_tile(keys, slots, key)
            x, y = i * spacing, j * spacing
            if rules.cast:
                level = 0.0
                if slot >= 0:
                    at = (i - row * TILE) * TILE + j - column * TILE
                    if h + slack < nodes[slot, at, PLASTIC]:
                        continue
                    level = -nodes[slot, at, SINKAGE]
                h = _cast_depth(
                    x - centre[0], y - centre[1], level + reach, centre[2], axis, radius, width, simplex, share
                )
                if h <= 0.0:
                    continue
            if slot < 0:
                slot = add_tile(keys, slots, ground.count, key)
            node = nodes[slot, (i - row * TILE) * TILE + j - column * TILE]
            if not uniform:
                soil_at(field, side, meta, x, y, soil)
            sigma = soil[K_ELASTIC] * (h - node[PLASTIC])
            if sigma < 0.0:
                continue
            rx, ry, rz = x - centre[0], y - centre[1], -node[SINKAGE] - centre[2]
            vx = velocity[0] + rate[1] * rz - rate[2] * ry
            vy = velocity[1] + rate[2] * rx - rate[0] * rz
            vz = velocity[2] + rate[0] * ry - rate[1] * rx
            speed = math.sqrt(vx * vx + vy * vy)
            node[SINKAGE] = h
            sheared = node
            if rules.own > 0:
                mine = tile_key(rules.own, row, column)
                place = find_tile(keys, slots, mine)
                if place < 0:
                    place = add_tile(keys, slots, ground.count, mine)
                sheared = nodes[place, (i - row * TILE) * TILE + j - column * TILE]
            sheared[SHEAR] += speed * dt
            if sigma > node[YIELD]:
                sigma = (soil[K_C] * over_b + soil[K_PHI]) * h ** soil[N]
                node[YIELD] = sigma
                node[PLASTIC] = h - sigma / soil[K_ELASTIC]
            if rules.damped:
                sigma -= soil[DAMPING] * vz
            tau = (soil[C] + sigma * soil[TAN_PHI]) * (1.0 - math.exp(-sheared[SHEAR] / soil[K_SHEAR]))
            slide = math.sqrt(speed * speed + rules.creep * rules.creep)
            grip = -tau * cell / slide if slide > 0.0 else 0.0
            px, py, pz = grip * vx, grip * vy, sigma * cell
            force[0] += px
            force[1] += py
            force[2] += pz
            moment[0] += ry * pz - rz * py
            moment[1] += rz * px - rx * pz
            moment[2] += rx * py - ry * px
            deepest = max(deepest, h)
    return deepest


def tiles_within_reach(radius: float, width: float, spacing: float) -> int:
    """Most tiles that one wheel can touch in one step: the room to keep in the grid."""
    across = 2.0 * math.hypot(radius, width) / (TILE * spacing) + 2.0
    return math.ceil(across * across)
