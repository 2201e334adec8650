"""Suspension kinematics from hardpoints: the position of a wheel over travel and steering, as smooth polynomials.

A carrier has one degree of freedom left by its links. Its pose follows from solving the link lengths (and the tie
rod's, whose inner end the steering link moves) at a grid of travels q and pitman angles theta; polynomials through the
results give the wheel centre, its axle, the carrier's turning per travel and per steering, and the strut's length, all
in the chassis frame.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

DEGREE = 5
"""Total degree of the polynomials in (q, theta)."""
TRAVEL = 0.09
"""Travel covered to each side of the design position (m)."""
QUANTITIES = ("x", "y", "z", "a_x", "a_z", "e_x", "e_y", "e_z", "k_x", "k_y", "k_z", "strut", "link", "rod")
"""Wheel centre; x and z of the axle's unit vector; turning of the carrier per travel (rad/m) and per pitman angle
(rad/rad);
length of the strut and height of the roll bar's drop link (m); upward force of the tie rod on the steering link per
moment about the pitman arm with which the wheel turns it (1/m)."""


def _pose(points: Array, equations: Callable[[Array], Array], start: Array) -> Array:
    """Pose (3 translations, 3 rotation vector) of a carrier that meets six equations on its moved points."""

    def residual(pose: Array) -> Array:
        moved = Rotation.from_rotvec(pose[3:]).apply(points - points[0]) + points[0] + pose[:3]
        return equations(moved)

    found, _, success, message = fsolve(residual, start, full_output=True)
    if success != 1:
        raise ValueError(f"suspension: expected hardpoints that reach the whole travel, found: {message}")
    return found


def _distance(a: Array, b: Array) -> float:
    return float(np.linalg.norm(np.asarray(a) - np.asarray(b)))


def _double_wishbone(axle: Mapping[str, Any]) -> tuple[Array, Callable[..., Array]]:
    """Carrier points (spindle, upper and lower ball, tie rod end) and their six equations."""
    upper, lower = np.array(axle["upper_chassis"]), np.array(axle["lower_chassis"])
    tie = np.array(axle["tie_rod_chassis"])
    points = np.array([axle["spindle"], axle["upper_carrier"], axle["lower_carrier"], axle["tie_rod_carrier"]])
    lengths = [_distance(p, points[1]) for p in upper] + [_distance(p, points[2]) for p in lower]
    rod = _distance(tie, points[3])

    def equations(moved: Array, q: float, shift: Array) -> Array:
        ends = [(upper[0], 1), (upper[1], 1), (lower[0], 2), (lower[1], 2)]
        found = [_distance(p, moved[k]) - length for (p, k), length in zip(ends, lengths, strict=True)]
        return np.array([*found, _distance(tie + shift, moved[3]) - rod, moved[2][2] - points[2][2] - q])

    return points, equations


def _trailing_arm(axle: Mapping[str, Any]) -> tuple[Array, Callable[..., Array]]:
    """Carrier points (spindle, pivot, two link ends) and their six equations."""
    pivot, inner = np.array(axle["arm_chassis"]), np.array(axle["links_chassis"])
    points = np.array([axle["spindle"], axle["arm_chassis"], *axle["links_carrier"]])
    lengths = [_distance(inner[k], points[2 + k]) for k in range(2)]

    def equations(moved: Array, q: float, shift: Array) -> Array:
        links = [_distance(inner[k], moved[2 + k]) - lengths[k] for k in range(2)]
        return np.array([*(moved[1] - pivot), *links, moved[0][2] - points[0][2] - q])

    return points, equations


def _arm_point(point: Array, fixed: Array, lengths: Array, start: Array) -> Array:
    """A point at given distances from three others, near `start`."""
    found = fsolve(lambda p: np.linalg.norm(fixed - p, axis=1) - lengths, start)
    return np.asarray(found)


def solve_axle(axle: Mapping[str, Any], link_arm: float, max_angle: float, side: int) -> tuple[Array, Array, Array]:
    """Grids q (A,), theta (B,) and the QUANTITIES on them (A, B, 14), of the left (side = 1) or right (-1) wheel.

    max_angle: of the pitman arm (rad), 0 for an axle that is not steered; axle: hardpoints, and `toe` (rad), to the left, of the
    wheel on its carrier as designed. A right wheel is a left wheel seen in the mirror: its steering link moves the other way.
    """
    wishbone = axle["layout"] == "double_wishbone"
    points, equations = (_double_wishbone if wishbone else _trailing_arm)(axle)
    mount, top = np.array(axle["strut_arm"]), np.array(axle["strut_chassis"])
    hinge = np.array([*axle["lower_chassis"], axle["lower_carrier"]]) if wishbone else np.zeros((3, 3))
    reach = np.linalg.norm(hinge - mount, axis=1)
    travels = np.linspace(-TRAVEL, TRAVEL, 13)
    angles = np.linspace(-max_angle, max_angle, 11) if wishbone and max_angle > 0 else np.array([0.0])
    poses = np.zeros((len(travels), len(angles), 6))
    strut, link, rod = np.zeros((3, *poses.shape[:2]))
    order = np.argsort(np.abs(travels), kind="stable")
    middle = len(angles) // 2
    for b in sorted(range(len(angles)), key=lambda b: abs(b - middle)):
        theta = angles[b]
        shift = link_arm * np.array([np.cos(theta) - 1.0, -side * np.sin(theta), 0.0])
        moved = link_arm * np.array([-np.sin(theta), -side * np.cos(theta), 0.0])
        near = dict.fromkeys((1, -1), poses[order[0], b + (b < middle) - (b > middle)])
        seat = {1: mount, -1: mount}
        for a in order:
            sign = 1 if travels[a] >= 0 else -1
            pose = _pose(points, partial(equations, q=float(travels[a]), shift=shift), near[sign])
            near[sign] = poses[a, b] = pose
            turn = Rotation.from_rotvec(pose[3:])
            if wishbone:
                ball = turn.apply(points[2] - points[0]) + points[0] + pose[:3]
                seat[sign] = _arm_point(mount, np.array([*axle["lower_chassis"], ball]), reach, seat[sign])
                along = turn.apply(points[3] - points[0]) + points[0] + pose[:3] - axle["tie_rod_chassis"] - shift
                rod[a, b] = along[2] / (along @ moved)
            else:
                seat[sign] = turn.apply(mount - points[0]) + points[0] + pose[:3]
            strut[a, b] = _distance(top, seat[sign])
            if "bar_link" in axle:
                link[a, b] = (turn.apply(np.array(axle["bar_link"]) - points[0]) + points[0] + pose[:3])[2]
    lengths = np.stack([strut, link, rod], axis=-1)
    toe = float(axle.get("toe", 0.0))
    spin = np.array([-np.sin(toe), np.cos(toe), 0.0])
    return travels, angles, _quantities((points[0], spin), travels, angles, poses, lengths, side)


def _quantities(
    wheel: tuple[Array, Array], travels: Array, angles: Array, poses: Array, lengths: Array, side: int
) -> Array:
    """wheel: its centre and its axle's unit vector on the carrier as designed."""
    turns = Rotation.from_rotvec(poses[..., 3:].reshape(-1, 3)).as_matrix().reshape(*poses.shape[:2], 3, 3)
    turning = []
    for axis, grid in ((0, travels), (1, angles)):
        if len(grid) == 1:
            turning.append(np.zeros((*poses.shape[:2], 3)))
            continue
        rate = np.gradient(turns, grid, axis=axis, edge_order=2) @ np.swapaxes(turns, -1, -2)
        turning.append(np.stack([rate[..., 2, 1], rate[..., 0, 2], rate[..., 1, 0]], axis=-1))
    axle = turns @ wheel[1]
    centre = wheel[0] + poses[..., :3]
    out = np.concatenate(
        [centre, axle[..., [0]], axle[..., [2]], turning[0], turning[1], lengths], axis=-1
    )
    # The mirror y -> -y turns the axle's x and z (kept leftward) and the turning about x and z.
    flip = np.array([1, side, 1, side, side, side, 1, side, side, 1, side, 1, 1, 1], dtype=float)
    return out * flip


def fit_polynomials(travels: Array, angles: Array, values: Array) -> Array:
    """(14, 6, 6) coefficients c[m, i, j] of q^i theta^j with i + j <= 5, least squares on the grid."""
    q, theta = np.meshgrid(travels, angles, indexing="ij")
    powers = [(i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i) if j == 0 or len(angles) > 1]
    scale = np.array([TRAVEL**i * (max(abs(angles).max(), 1e-9)) ** j for i, j in powers])
    design = np.stack([(q**i * theta**j).ravel() for i, j in powers], axis=1) / scale
    solution = np.linalg.lstsq(design, values.reshape(-1, values.shape[-1]), rcond=None)[0] / scale[:, None]
    coefficients = np.zeros((values.shape[-1], DEGREE + 1, DEGREE + 1))
    for (i, j), row in zip(powers, solution, strict=True):
        coefficients[:, i, j] = row
    return coefficients
