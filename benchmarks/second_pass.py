"""A wheel that follows in a rut, as a rear wheel does: the force law against the plant's soil.

`python -m benchmarks.second_pass`: two wheels of the rig's size pass one after the other over the same soil in a straight line,
each under its own constant load, slip angle and slip; nothing is fitted. Lateral and longitudinal force and sinkage of the second
are printed three ways: the soil contact model; the law as the model has it, with the first wheel's sinkage and exit path; the
same equations integrated finely: contact from the rut's floor on, which the elastic soil has raised by sigma/K, a path that the
first wheel left by the same fine integration, and a slip floor of 0.001 instead of 0.003. A second table has the second wheel
pass partly beside the rut, of the rig's size and a large one: side force and sinkage of the law over those of the contact model.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq

from softsoil.plant.bed import SoilBed
from softsoil.recording.rig import RIG_PATCH
from softsoil.symbolic.contact_line import bulk_modulus
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.soil import CLAY, SANDY_LOAM, Soil
from softsoil.symbolic.vehicle import GRAVITY
from softsoil.symbolic.wheel import Contact, Wheel

Array = NDArray[np.float64]

WHEEL = Wheel(0.330229, 0.2121)
SPEED, SLIP, FIRST_LOAD = 5.0, 0.03, 2950.0
LARGE, LARGE_LOADS = Wheel(0.42, 0.38), (10500.0, 9000.0)
BESIDE, BESIDE_ANGLES, BESIDE_LOADS = (0.0, 0.15, 0.3, 0.5, 0.75), (0.02, 0.05), (FIRST_LOAD, 3900.0)
"""Shares of the width by which the second wheel runs beside the rut, its slip angles (rad), loads of the first and second (N)."""
SOILS = (CLAY.with_(n=0.62), SANDY_LOAM.with_(n=0.75))
FIRST_ANGLES, LOADS, ANGLES = (0.02, 0.1), (3000.0, 3900.0, 5100.0), (0.01, 0.03, 0.06)
STEP, SPACING = 1e-3, 0.02
SECONDS, SETTLED = 1.2, 0.5
POINTS = 400
LEAST_SLIP = 1e-3


@dataclass(frozen=True)
class Pass:
    """Settings of a wheel: load (N), slip angle (rad), how far it passes beside the first one (m)."""

    load: float
    angle: float
    beside: float = 0.0
    wheel: Wheel = WHEEL

    @property
    def spin(self) -> float:
        """rad/s."""
        return SPEED / (self.wheel.radius * (1.0 - SLIP))


@dataclass(frozen=True)
class Felt:
    """Forces in the wheel frame (N), sinkage (m), and the shear path that stays in the soil (m)."""

    f_x: float
    f_y: float
    sinkage: float
    path: float = float("nan")


def by_plant(soil: Soil, passes: tuple[Pass, ...]) -> list[Felt]:
    """What each wheel feels on the soil contact model, mean over the settled part."""
    bed, felt = SoilBed(soil, SPACING), []
    for told in passes:
        cos, sin = np.cos(told.angle), np.sin(told.angle)
        axis, x, z, rise, rows = np.array([-sin, cos, 0.0]), 0.0, told.wheel.radius, 0.0, []
        size = {"radius": told.wheel.radius, "width": told.wheel.width}
        for _ in range(round(SECONDS / STEP)):
            centre, velocity = (x, told.beside, z), (SPEED, 0.0, rise)
            touch = bed.touch(centre, axis=axis, velocity=velocity, rate=told.spin * axis, dt=STEP, **size)
            force = touch.force
            rise = 0.98 * (rise + STEP * (force[2] * GRAVITY / told.load - GRAVITY))  # its bounce dies out
            x, z = x + STEP * SPEED, z + STEP * rise
            rows.append([force[0] * cos + force[1] * sin, -force[0] * sin + force[1] * cos, told.wheel.radius - z])
        f_x, f_y, sinkage = np.array(rows)[round(SETTLED / STEP) :].mean(axis=0)
        felt.append(Felt(f_x, f_y, sinkage))
    return felt


def by_law(soil: Soil, told: Pass, path: float, rut: float) -> Felt:
    """What the law says, in a rut of depth `rut` (m; 0: fresh soil) that another wheel of the size has sheared by `path` (m)."""
    v_x, v_y = SPEED * np.cos(told.angle), -SPEED * np.sin(told.angle)
    share = max(1.0 - told.beside / told.wheel.width, 0.0) if rut > 0.0 else 0.0
    contact = Contact(v_x, v_y, told.spin, told.load, entry_path=path, overlap=share, rut_depth=rut)
    force = TurnSlip(contact_step=STEP, patch_length=RIG_PATCH)(soil, told.wheel, contact)
    return Felt(*(float(ca.DM(value)) for value in (force.f_x, force.f_y, force.sinkage, force.exit_path)))


def by_hand(soil: Soil, told: Pass, path: float, rut: float) -> Felt:
    """The law's equations in a rut of depth `rut` (m; 0: fresh soil) sheared by `path`, integrated finely; no side entry."""
    r = WHEEL.radius
    stiffness = float(bulk_modulus(soil, WHEEL)) + soil.k_c / (RIG_PATCH * r)
    floor = rut - stiffness * rut**soil.n / soil.K

    def pressed(h: float) -> tuple[Array, Array]:
        """Places from front to rear (m) and pressure there (Pa)."""
        e = h - floor
        ahead = np.linspace(np.sqrt(e * (2 * r - e)), 0.0, POINTS)
        depth = np.sqrt(r * r - ahead**2) - (r - h)
        front = np.minimum(stiffness * np.maximum(depth, 0.0) ** soil.n, soil.K * np.maximum(depth - floor, 0.0))
        peak = front[-1]
        behind = np.linspace(0.0, -np.sqrt(2 * r * peak / soil.K), POINTS)
        rear = peak * (1.0 - (behind / behind[-1]) ** 2)
        x = np.concatenate([ahead, behind[1:]])
        return x, np.maximum(np.concatenate([front, rear[1:]]) + soil.R * told.spin * x, 0.0)

    def missing(h: float) -> float:
        x, sigma = pressed(h)
        return -WHEEL.width * float(np.trapezoid(sigma, x)) - told.load

    h = float(brentq(missing, max(floor, 0.0) + 1e-6, 0.8 * r))
    x, sigma = pressed(h)
    u_x = SPEED * np.cos(told.angle) - told.spin * np.sqrt(r * r - x * x)
    u_y = -SPEED * np.sin(told.angle)
    size = np.sqrt(u_x**2 + u_y**2 + (LEAST_SLIP * SPEED) ** 2)
    spent = -cumulative_trapezoid(size, x, initial=0.0) / SPEED + 0.5 * STEP * size
    tau = np.where(sigma > 0.0, soil.c + sigma * np.tan(soil.phi), 0.0) * (1.0 - np.exp(-(path + spent) / soil.k))
    f_x, f_y = (WHEEL.width * float(np.trapezoid(tau * u / size, x)) for u in (u_x, u_y))
    return Felt(f_x, f_y, h, float(spent[-1]))


def main() -> None:
    """Read the command line and run."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    print(" " * 44 + "f_y true   law    fine     f_x true    law   fine     h true    law   fine")
    for soil in SOILS:
        for first_angle in FIRST_ANGLES:
            before = Pass(FIRST_LOAD, first_angle)
            law_before, fine_before = by_law(soil, before, 0.0, 0.0), by_hand(soil, before, 0.0, 0.0)
            for load in LOADS:
                for angle in ANGLES:
                    told = Pass(load, angle)
                    true = by_plant(soil, (before, told))[1]
                    law = by_law(soil, told, law_before.path, law_before.sinkage)
                    fine = by_hand(soil, told, fine_before.path, fine_before.sinkage)
                    print(
                        f"{soil.name:11s}{soil.n:5.2f} after {first_angle:.2f} rad: {load:5.0f} N {angle:.2f} rad  "
                        f"{true.f_y:7.0f}{law.f_y / true.f_y:8.3f}{fine.f_y / true.f_y:8.3f}   "
                        f"{true.f_x:8.0f}{law.f_x:7.0f}{fine.f_x:7.0f}   "
                        f"{true.sinkage:8.4f}{law.sinkage:8.4f}{fine.sinkage:8.4f}",
                        flush=True,
                    )
    print("\npartly in the rut: side force/sinkage, law over contact model, by the share of the width beside it")
    for wheel, (first, second) in ((WHEEL, BESIDE_LOADS), (LARGE, LARGE_LOADS)):
        for soil in SOILS:
            for angle in BESIDE_ANGLES:
                _print_beside(soil, Pass(first, BESIDE_ANGLES[0], wheel=wheel), Pass(second, angle, wheel=wheel))


def _print_beside(soil: Soil, before: Pass, told: Pass) -> None:
    """A row of the second table."""
    left, cells = by_law(soil, before, 0.0, 0.0), []
    for share in BESIDE:
        mine = replace(told, beside=share * told.wheel.width)
        true, law = by_plant(soil, (before, mine))[1], by_law(soil, mine, left.path, left.sinkage)
        cells.append(f"{share:.2f}: {law.f_y / true.f_y:.3f}/{law.sinkage / true.sinkage:.3f}")
    of = f"{soil.name:11s}{soil.n:5.2f} wheel {told.wheel.radius:.2f} m {told.load:5.0f} N {told.angle:.2f} rad"
    print(of, *cells, sep="  ", flush=True)


if __name__ == "__main__":
    main()
