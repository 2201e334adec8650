"""Case study on measured data: a race car's log without pose, wheel speeds or soil, through the project's own loop.

On a hard road there is no sinkage exponent: friction and tread of `hard_ground` are fitted, with whatever is traced beside them,
and n appears nowhere. What rests on a pose or on wheel speeds is not tried.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from softsoil.cases.dart import candidates_of, hard_road
from softsoil.checking.cross_check import check_channels, refuse_contradictions
from softsoil.checking.usable import mark_checked
from softsoil.checking.words import Check
from softsoil.recording.columns import Source
from softsoil.recording.derive import completed
from softsoil.recording.drive import Recording
from softsoil.recording.read import read_drive
from softsoil.refinement.refine import refine
from softsoil.refinement.result import Refinement
from softsoil.refinement.windowing import Windowing
from softsoil.symbolic.vehicle import Vehicle

MASS, LENGTH, WIDTH = 982.0, 4.09, 1.7
CAR = Vehicle(
    "250lm", mass=MASS, l_f=1.33, l_r=1.07, yaw_inertia=MASS / 12 * (WIDTH**2 + LENGTH**2), track=1.35, h_cg=0.45,
    radius=0.32, width=0.2, max_steer=0.4, max_steer_rate=2.0,
)  # fmt: skip
"""The publishing repository's figures; height and wheel are nominal: the single track on hard ground hardly looks at them."""
COLUMNS = {"u": Source("vx"), "v": Source("vy"), "omega_z": Source("yawRate"), "steer": Source("delta"),
           "a_x_imu": Source("axCG"), "a_y_imu": Source("ayCG")}  # fmt: skip
KINDS = ("steering", "tyre", "slope", "sensor")
"""Kinds of effects that are tried; those that rest on a channel that the log lacks are not."""
WINDOWING = Windowing(horizon=1.0, horizons=(0.5, 1.0))
"""A tyre on a hard road answers faster than a wheel in soil: shorter windows see it."""
START = 0.3
"""s that are left out at the beginning."""
SECONDS = 120.0
"""s of the log that are used: the fit sees its first two thirds."""
CANNOT = (
    "Not said: a sinkage exponent; the road does not give way.",
    "Not named, for want of a pose: slopes, which have a compass direction.",
    "Not tried, for want of a pose: places and scales of pose and speed sensors.",
    "Not tried, for want of wheel speeds: differentials and the scale of those sensors; slip takes no share of the grip here.",
)


def read_stanford(folder: Path) -> tuple[Recording, tuple[Check, ...]]:
    """The first SECONDS of the log in `folder` with what is absent derived, and the checks of its channels.

    Raises ValueError for a folder without the log, or channels that contradict each other.
    """
    paths = sorted(Path(folder).glob("*250lm*.csv*"))
    if not paths:
        raise ValueError(f"{folder}: expected the race car's log (*250lm*.csv.gz), found none")
    whole = read_drive(paths[0], COLUMNS)
    checks = check_channels(whole, CAR)
    refuse_contradictions(str(paths[0]), checks)
    part = whole.between(float(whole.t[0]), float(whole.t[0]) + SECONDS)
    drive = completed(part, CAR)
    return mark_checked(replace(drive, name="stanford_250lm")), checks


def run_stanford(drive: Recording, progress: Callable[[float], None] = lambda share: None) -> Refinement:
    """Friction and tread of the road under the car, and what is traced beside them; progress: called with the share done."""
    declared, tried = hard_road(CAR, "road"), candidates_of(CAR, KINDS)
    return refine([drive], declared, start=START, candidates=tried, windowing=WINDOWING, progress=progress)
