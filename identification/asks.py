"""The manoeuvre, or the tape, that would pin down what logs leave open."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from softsoil.identification.result import Found
from softsoil.recording.drive import Recording
from softsoil.recording.evidence import filled
from softsoil.refinement.excitation import one_wave
from softsoil.refinement.vehicle_numbers import by_name
from softsoil.symbolic.vehicle import Vehicle

FULL = 0.8
"""Share of full lock that counts as full lock."""
HARD = 5.0
"""m/s^2 of lateral acceleration that a manoeuvre to full lock asks for on soft soil, if the vehicle held its course."""
SLOWEST, FASTEST = 0.5, 8.0
"""m/s: least speed to full lock that is asked for, and the largest of any manoeuvre."""


@dataclass(frozen=True)
class Excitation:
    """What the fitted logs have: largest steering angle (rad), whether some log is more than one wave, speeds (m/s), whether the
    steering moves at all; circled: the smaller of the largest angles (rad) that were held for STEADY to either side."""

    largest: float
    many_waves: bool
    speeds: tuple[float, float]
    steers: bool
    circled: float = 0.0


def excitation(recordings: Sequence[Recording], start: float) -> Excitation:
    """The excitation of the logs; start: seconds left out at the beginning of each."""
    parts = [r.between(r.t[0] + start, np.inf) for r in recordings]
    steer = np.concatenate([np.abs(p["steer"] - np.nanmedian(p["steer"])) for p in parts])
    u = np.concatenate([p["u"] for p in parts])
    largest = float(np.nanpercentile(steer, 99.0))
    return Excitation(
        largest=largest,
        many_waves=any(not one_wave(p) for p in parts),
        speeds=(float(np.nanpercentile(u, 5)), float(np.nanpercentile(u, 95))),
        steers=largest > LEAST_STEER,
        circled=min(max(_held(p, side) for p in parts) for side in (1.0, -1.0)),
    )


def _held(recording: Recording, side: float) -> float:
    """The largest steering angle (rad) to a side, 1 left and -1 right, that was held for STEADY, within a fifth; 0 for none."""
    steer = side * filled(recording["steer"])
    rows = round(STEADY / recording.dt)
    if len(steer) <= rows:
        return 0.0
    least, most = (moved(steer, rows, mode="nearest") for moved in (minimum_filter1d, maximum_filter1d))
    whole = slice(rows // 2, len(steer) - rows // 2)
    held = least[whole][least[whole] > 0.8 * most[whole]]
    return max(float(held.max(initial=0.0)), 0.0)


STEADY = 3.0
"""s: an angle held for so long is a circle's, small as the vehicle may be."""
LEAST_STEER = 0.03
"""rad: a largest angle below this is driving straight on."""


@dataclass(frozen=True)
class Manoeuvre:
    """One manoeuvre to ask for.

    name; pins: numbers of the vehicle that it pins down, beside the parameters of effects that name it; words: what to drive, by
    the vehicle and what it has driven; has: whether the logs have it already.
    """

    name: str
    pins: tuple[str, ...]
    words: Callable[[Vehicle, Excitation], str]
    has: Callable[[Vehicle, Excitation], bool]


def _lock_speed(vehicle: Vehicle) -> float:
    tight = math.tan(min(vehicle.max_steer, 1.2))
    return min(max(math.sqrt(HARD * vehicle.wheelbase / tight), SLOWEST), FASTEST)


def _fast(vehicle: Vehicle, had: Excitation) -> float:
    """The largest speed (m/s) that is asked for: what the vehicle has driven, or a little more for lateral acceleration."""
    return min(max(had.speeds[1], _lock_speed(vehicle)), FASTEST)


def _round(vehicle: Vehicle, had: Excitation) -> float:
    """The larger speed (m/s) of steady circles."""
    return min(0.8 * _lock_speed(vehicle) + 1.0, _fast(vehicle, had))


def _once(vehicle: Vehicle, speed: float) -> float:
    """Seconds of a circle at half lock at a speed (m/s), before the vehicle comes into its own ruts."""
    radius = vehicle.wheelbase / math.tan(0.5 * min(vehicle.max_steer, 1.2))
    return min(15.0, 0.85 * 2.0 * math.pi * radius / speed)


def _circles(vehicle: Vehicle, had: Excitation) -> str:
    angle = math.degrees(0.5 * vehicle.max_steer)
    slow, fast = (f"{_once(vehicle, u):.0f} s at {_said(u)} m/s" for u in (0.6 * _round(vehicle, had), _round(vehicle, had)))
    return (
        f"steady circles, one each way with {angle:.0f} deg of steering, {slow} and {fast}, each on fresh soil: they pin down "
        "the tracks and what follows the body's roll"
    )


def _said(speed: float) -> str:
    return f"{speed:.0f}" if speed >= 2.95 else f"{speed:.1f}"


MANOEUVRES = (
    Manoeuvre(
        "lock",
        ("yaw_inertia", "scrub", "ackermann", "toe"),
        lambda v, _: (
            f"20 s of sine steering to full lock ({math.degrees(v.max_steer):.0f} deg) with a period of 3 s at "
            f"{_said(_lock_speed(v))} m/s: it pins down the yaw inertia and the steering's geometry"
        ),
        lambda v, e: e.largest >= FULL * v.max_steer,
    ),
    Manoeuvre(
        "multi-sine",
        ("toe_rear", "roll_gain", "roll_time", "roll_stiffness_front", "roll_damping_front"),
        lambda v, e: (
            f"45 s of steering by several sines together (periods of 1 to 8 s, up to {math.degrees(0.6 * v.max_steer):.0f} deg) "
            f"at speeds from {_said(0.4 * _fast(v, e))} to {_said(_fast(v, e))} m/s and back: it separates n from the vehicle's "
            "numbers"
        ),
        lambda v, e: e.many_waves and e.speeds[1] > 1.2 * e.speeds[0],
    ),
    Manoeuvre(
        "circles",
        ("track", "track_rear", "radius"),
        _circles,
        lambda v, e: e.circled >= 0.8 * 0.5 * v.max_steer,
    ),
)  # fmt: skip


def _pins(manoeuvre: Manoeuvre, name: str) -> bool:
    """Whether a manoeuvre pins down the number called `name`."""
    return name in manoeuvre.pins or by_name()[name].pinned_by == manoeuvre.name


def asks(vehicle: Vehicle, numbers: Mapping[str, Found], had: Excitation, least: float) -> tuple[str, ...]:
    """What would take most off n's error: to measure a number that no log shows, and manoeuvres that the logs lack, or once more
    the one that would pin down most.

    least: change of n (%) by a number's error below which it is no matter.
    """
    gains = []
    for manoeuvre in MANOEUVRES:
        open_ = [f for name, f in numbers.items() if _pins(manoeuvre, name) and f.state != "given"]
        gain = math.sqrt(sum(f.n_percent_per_std**2 for f in open_ if math.isfinite(f.n_percent_per_std)))
        lacking = not manoeuvre.has(vehicle, had)
        gains.append((lacking, gain, manoeuvre))
    gains.sort(key=lambda entry: (entry[0], entry[2].name != "circles", entry[1]), reverse=True)
    wanted = [m for lacking, gain, m in gains if lacking and (gain >= least or m.name != "circles")]
    more = [m.words(vehicle, had) for m in wanted[:2]] or [f"once more, on fresh soil: {gains[0][2].words(vehicle, had)}"]
    return (*_to_measure(numbers, least), *more)


def _to_measure(numbers: Mapping[str, Found], least: float) -> list[str]:
    """Numbers that nobody gave and no log shows, where they may move n by `least` (%) or more."""
    said = []
    for name, number in by_name().items():
        one = numbers.get(name)
        if not number.free and one is not None and one.given is None and abs(one.n_percent_per_std) >= least:
            said.append(
                f"measure {name} ({number.how}) and give it with the known numbers: {number.doc}, {number.why}; no log shows it, "
                f"and without it n may be {abs(one.n_percent_per_std):.0f} % off"
            )
    return said
