"""Hostile variants of a good log: signs, units, clocks, swaps, dead and clipped sensors, and drives that show no soil."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from softsoil.recording.drive import WHEEL_CHANNELS, Array, Recording
from softsoil.recording.noise import low_pass

Channels = dict[str, Array]
GPS = ("x", "y", "u", "v")


@dataclass(frozen=True)
class Variant:
    """One hostile log.

    name; change: channels of a good log -> channels of this one; harmless: whether a right n may come out of it.
    """

    name: str
    change: Callable[[Channels], Mapping[str, Array]]
    harmless: bool = False

    def of(self, recording: Recording) -> Recording:
        """The variant of a good log, without what evaluates it."""
        channels = dict(self.change(dict(recording.channels)))
        return Recording(f"{recording.name}_{self.name.replace(' ', '_')}", channels, meta=recording.meta)


def _scaled(name: str, factor: float) -> Callable[[Channels], Channels]:
    return lambda c: {**c, name: c[name] * factor}


def _swapped(first: str, second: str) -> Callable[[Channels], Channels]:
    return lambda c: {**c, first: c[second], second: c[first]}


def _late(names: tuple[str, ...], seconds: float) -> Callable[[Channels], Channels]:
    def change(c: Channels) -> Channels:
        return {**c, **{name: np.interp(c["t"] - seconds, c["t"], c[name]) for name in names}}

    return change


def _frozen(name: str) -> Callable[[Channels], Channels]:
    def change(c: Channels) -> Channels:
        values = c[name].copy()
        values[len(values) // 3 :] = values[len(values) // 3]
        return {**c, name: values}

    return change


def _clipped(name: str, share: float) -> Callable[[Channels], Channels]:
    def change(c: Channels) -> Channels:
        low, high = np.quantile(c[name], [share, 1.0 - share])
        return {**c, name: np.clip(c[name], low, high)}

    return change


def _offset(name: str, amount: float) -> Callable[[Channels], Channels]:
    return lambda c: {**c, name: c[name] + amount}


def _at_rate(hertz: float) -> Callable[[Channels], Channels]:
    def change(c: Channels) -> Channels:
        t = np.arange(c["t"][0], c["t"][-1], 1.0 / hertz)
        return {name: t if name == "t" else np.interp(t, c["t"], values) for name, values in c.items()}

    return change


def _between(names: tuple[str, ...], hertz: float, line: bool) -> Callable[[Channels], Channels]:
    """Channels of a slower sensor, with its own clock, as a table of one rate holds them: lines between samples, or held."""

    def change(c: Channels) -> Channels:
        t = c["t"]
        rows = np.searchsorted(t, np.arange(t[0], t[-1], 1.0 / hertz))
        last = rows[np.searchsorted(rows, np.arange(len(t)), side="right") - 1]
        return {**c, **{name: np.interp(t, t[rows], c[name][rows]) if line else c[name][last] for name in names}}

    return change


def _filtered(noise: Mapping[str, float], seconds: float, twice: bool = False) -> Callable[[Channels], Channels]:
    """Channels with white noise of so many units through a first-order low-pass; twice: backwards as well, so none is late."""

    def change(c: Channels) -> Channels:
        rng, dt = np.random.default_rng(5), float(np.median(np.diff(c["t"])))
        noisy = {name: c[name] + std * rng.standard_normal(len(c["t"])) for name, std in noise.items()}
        return {**c, **{name: low_pass(values, dt, seconds, twice) for name, values in noisy.items()}}

    return change


def _still(c: Channels) -> Channels:
    rng = np.random.default_rng(1)
    still = {name: 1e-3 * rng.standard_normal(len(c["t"])) for name in c if name != "t"}
    return {"t": c["t"], **still}


def _straight(c: Channels) -> Channels:
    rng = np.random.default_rng(2)
    count = len(c["t"])
    u, none = c["u"], np.zeros(count)
    noise = {name: s * rng.standard_normal(count) for name, s in (("v", 0.01), ("omega_z", 1e-3), ("steer", 1e-3))}
    x = np.cumsum(u) * float(np.median(np.diff(c["t"])))
    return {**c, **noise, "x": x, "y": none + 0.01 * rng.standard_normal(count), "psi": 1e-3 * rng.standard_normal(count),
            "a_y_imu": 0.05 * rng.standard_normal(count), **dict.fromkeys(WHEEL_CHANNELS, u / RADIUS)}  # fmt: skip


def _backwards(c: Channels) -> Channels:
    return {**c, "u": -c["u"], **{name: -c[name] for name in WHEEL_CHANNELS}}


def _hard_ground(c: Channels) -> Channels:
    """A kinematic vehicle: no slip angle at any wheel, so no sinkage exponent in the motion."""
    t, u, steer = c["t"], c["u"], c["steer"]
    dt = float(np.median(np.diff(t)))
    omega = u * np.tan(steer) / (L_F + L_R)
    v = L_R * omega
    psi = np.cumsum(omega) * dt
    aside = v + L_F * omega
    return {**c, "omega_z": omega, "v": v, "psi": psi,
            "x": np.cumsum(u * np.cos(psi) - aside * np.sin(psi)) * dt,
            "y": np.cumsum(u * np.sin(psi) + aside * np.cos(psi)) * dt,
            "a_y_imu": np.gradient(v, dt) + u * omega, "a_x_imu": np.gradient(u, dt) - v * omega,
            **dict.fromkeys(WHEEL_CHANNELS, u / RADIUS)}  # fmt: skip


def _long(c: Channels) -> Channels:
    """A million rows: the drive over and over, positions and heading carried on, in one clock."""
    times = int(np.ceil(1_000_000 / len(c["t"])))
    out: Channels = {name: np.tile(values, times)[:1_000_000] for name, values in c.items()}
    dt = float(np.median(np.diff(c["t"])))
    out["t"] = np.arange(1_000_000, dtype=float) * dt
    return {name: out[name] for name in ("t", "u", "v", "omega_z", "steer", "a_x_imu", "a_y_imu", *WHEEL_CHANNELS)}


RADIUS, L_F, L_R = 0.3313, 1.546, 1.175
"""m: wheels and axles of the vehicle that drove the good log."""


def _odometry(c: Channels) -> Channels:
    """Speed, heading and position as a robot without GPS integrates them from its wheels; no lateral velocity."""
    dt = float(np.median(np.diff(c["t"])))
    u = RADIUS * np.mean([c[name] for name in WHEEL_CHANNELS], axis=0)
    psi = np.cumsum(c["omega_z"]) * dt
    place = {"x": np.cumsum(u * np.cos(psi)) * dt, "y": np.cumsum(u * np.sin(psi)) * dt}
    return {name: values for name, values in {**c, "u": u, "psi": psi, **place}.items() if name != "v"}


def _rear_axle(c: Channels) -> Channels:
    """Position and velocity of the middle of the rear axle, where many robots have their base frame."""
    behind, psi = L_F + L_R, c["psi"]
    place = {"x": c["x"] - behind * np.cos(psi), "y": c["y"] - behind * np.sin(psi)}
    return {**c, **place, "v": c["v"] - L_R * c["omega_z"]}


def _antenna(c: Channels) -> Channels:
    """Position of an antenna over the rear axle, whose place no one gives, and no lateral velocity."""
    behind = L_F + L_R
    place = {"x": c["x"] - behind * np.cos(c["psi"]), "y": c["y"] - behind * np.sin(c["psi"])}
    return {name: values for name, values in {**c, **place}.items() if name != "v"}


def _no_compass(c: Channels) -> Channels:
    """East and north of a receiver beside a gyro: no heading, and the drive begins to the south-west."""
    turn = np.exp(4.0j)
    place = turn * (c["x"] + 1j * c["y"])
    return {name: values for name, values in {**c, "x": place.real, "y": place.imag}.items() if name != "psi"}


def _empty_cell(change: Callable[[Channels], Channels]) -> Callable[[Channels], Channels]:
    """The change, and then no number in the first row, as a table that is filled forwards has none."""
    return lambda c: {k: np.where(np.arange(len(v)) > 0, v, np.nan) if k in GPS else v for k, v in change(c).items()}


def _one_encoder(c: Channels) -> Channels:
    mean: Array = sum((c[name] for name in WHEEL_CHANNELS), np.zeros(len(c["t"]))) / len(WHEEL_CHANNELS)
    return {**c, **dict.fromkeys(WHEEL_CHANNELS, mean)}


def _parked(c: Channels) -> Channels:
    """Five seconds of standing before the drive."""
    dt = float(np.median(np.diff(c["t"])))
    rows = round(5.0 / dt)
    still = {name: np.full(rows, values[0] if name in ("x", "y", "psi", "steer") else 0.0) for name, values in c.items()}
    still["t"] = c["t"][0] - dt * np.arange(rows, 0, -1)
    return {name: np.concatenate([still[name], values]) for name, values in c.items()}


def _outliers(share: float, deviations: float) -> Callable[[Channels], Channels]:
    """A share of the samples of every sensor but the pose's wrong by so many standard deviations of the channel."""

    def change(c: Channels) -> Channels:
        rng, out = np.random.default_rng(6), dict(c)
        for name in ("u", "v", "omega_z", "a_x_imu", "a_y_imu", *WHEEL_CHANNELS):
            wrong = rng.random(len(c["t"])) < share
            out[name] = c[name] + wrong * deviations * c[name].std() * rng.standard_normal(len(c["t"]))
        return out

    return change


def _silent(names: tuple[str, ...], seconds: float) -> Callable[[Channels], Channels]:
    """Channels without a number for so long in the middle of the drive."""

    def change(c: Channels) -> Channels:
        gap = np.abs(c["t"] - 0.5 * (c["t"][0] + c["t"][-1])) < 0.5 * seconds
        return {**c, **{name: np.where(gap, np.nan, c[name]) for name in names}}

    return change


def _no_side_slip(c: Channels) -> Channels:
    """A lateral velocity that a filter holds at zero."""
    return {**c, "v": 0.01 * np.random.default_rng(3).standard_normal(len(c["t"]))}


ALL = ("x", "y", "psi", "u", "v", "omega_z", "a_x_imu", "a_y_imu", "steer", *WHEEL_CHANNELS)
_SIGNS = tuple(Variant(f"{name} flipped", _scaled(name, -1.0)) for name in ALL)
_UNITS = (
    Variant("psi in deg", _scaled("psi", 180 / np.pi)), Variant("omega_z in deg/s", _scaled("omega_z", 180 / np.pi)),
    Variant("steer in deg", _scaled("steer", 180 / np.pi)), Variant("steering-wheel angle", _scaled("steer", 16.0)),
    Variant("steer in deg, declared deg twice", _scaled("steer", np.pi / 180)),
    Variant("u in km/h", _scaled("u", 3.6)), Variant("v in km/h", _scaled("v", 3.6)), Variant("u in mph", _scaled("u", 2.23694)),
    Variant("a_y in g", _scaled("a_y_imu", 1 / 9.80665)), Variant("a_x in g", _scaled("a_x_imu", 1 / 9.80665)),
    Variant("x, y in cm", lambda c: {**c, "x": 100 * c["x"], "y": 100 * c["y"]}),
    Variant("wheels in rpm", lambda c: {**c, **{n: c[n] * 30 / np.pi for n in WHEEL_CHANNELS}}),
    Variant("wheels in m/s", lambda c: {**c, **{n: c[n] * RADIUS for n in WHEEL_CHANNELS}}),
    Variant("one wheel in rpm", _scaled("omega_rl", 30 / np.pi)), Variant("one wheel 15 % off", _scaled("omega_fl", 1.15)),
    Variant("t in ms", _scaled("t", 1000.0)),
)  # fmt: skip
_CLOCKS = (
    Variant("steer 0.8 s late", _late(("steer",), 0.8)), Variant("steer 0.3 s late", _late(("steer",), 0.3)),
    Variant("steer 0.6 s early", _late(("steer",), -0.6)), Variant("omega_z 0.3 s late", _late(("omega_z",), 0.3)),
    Variant("omega_z 0.05 s late", _late(("omega_z",), 0.05)),
    Variant("pose 0.5 s late", _late(("x", "y", "psi"), 0.5)), Variant("u 0.5 s late", _late(("u",), 0.5)),
    Variant("wheels 1 s late", _late(WHEEL_CHANNELS, 1.0)),
)  # fmt: skip
_SWAPS = (
    Variant("x and y swapped", _swapped("x", "y")), Variant("a_x and a_y swapped", _swapped("a_x_imu", "a_y_imu")),
    Variant("u and v swapped", _swapped("u", "v")), Variant("steer and omega_z swapped", _swapped("steer", "omega_z")),
    Variant("psi and steer swapped", _swapped("psi", "steer")), Variant("left and right wheels swapped", lambda c: {
        **c, "omega_fl": c["omega_fr"], "omega_fr": c["omega_fl"], "omega_rl": c["omega_rr"], "omega_rr": c["omega_rl"]}),
    Variant("compass heading", lambda c: {**c, "psi": np.pi / 2 - c["psi"]}),
    Variant("z down", lambda c: {**c, **{n: -c[n] for n in ("y", "psi", "v", "omega_z", "a_y_imu")}}),
)  # fmt: skip
_SENSORS = (
    *(Variant(f"{name} frozen", _frozen(name)) for name in ("psi", "u", "v", "omega_z", "steer", "omega_fl", "x")),
    Variant("omega_z clipped", _clipped("omega_z", 0.15)), Variant("steer clipped", _clipped("steer", 0.15)),
    Variant("u clipped", _clipped("u", 0.15)), Variant("gyro bias 0.05 rad/s", _offset("omega_z", 0.05)),
    Variant("a_x bias 0.5 m/s^2", _offset("a_x_imu", 0.5)), Variant("heading 0.08 rad off", _offset("psi", 0.08)),
    Variant("u 12 % fast", _scaled("u", 1.12)), Variant("omega_z 4 % large", _scaled("omega_z", 1.04)),
)  # fmt: skip
_ROBOTS = (
    Variant("wheel odometry", _odometry), Variant("base frame at the rear axle", _rear_axle),
    Variant("antenna over the rear axle, no v", _antenna), Variant("no heading", _no_compass, harmless=True),
    Variant("no heading, x and y swapped", lambda c: _swapped("x", "y")(_no_compass(c))),
    Variant("v of the front axle", lambda c: {**c, "v": c["v"] + L_F * c["omega_z"]}),
    Variant("states 0.15 s late", _late(("x", "y", "psi", "u", "v", "omega_z"), 0.15)),
    Variant("no side slip in v", _no_side_slip), Variant("one encoder for all wheels", _one_encoder),
    Variant("wheels 3 % fast", lambda c: {**c, **{n: 1.03 * c[n] for n in WHEEL_CHANNELS}}),
    Variant("steering ratio 10 % off", _scaled("steer", 1.1)), Variant("steer 0.15 s early", _late(("steer",), -0.15)),
)  # fmt: skip
_DRIVES = (
    Variant("standing", _still), Variant("straight", _straight), Variant("reversing", _backwards),
    Variant("hard ground", _hard_ground),
    Variant("x, y, u, v held at 10 Hz", _between(GPS, 10.0, False), harmless=True),
    Variant("x, y, u, v held at 10 Hz, no first value", _empty_cell(_between(GPS, 10.0, False)), harmless=True),
    Variant("x, y, u, v at 10 Hz, lines between", _between(GPS, 10.0, True), harmless=True),
    Variant("steer held at 20 Hz", _between(("steer",), 20.0, False), harmless=True),
    Variant("v through a low-pass of 0.05 s", _filtered({"v": 0.25}, 0.05), harmless=True),
    Variant("u, v, omega_z smoothed both ways", _filtered({"u": 0.25, "v": 0.25, "omega_z": 0.0175}, 0.02, True), harmless=True),
    Variant("omega_z through a low-pass of 0.05 s", _filtered({"omega_z": 0.0175}, 0.05)),
    Variant("2 % of samples wrong", _outliers(0.02, 8.0), harmless=True),
    Variant("no steering and wheels for 2 s", _silent(("steer", *WHEEL_CHANNELS), 2.0), harmless=True),
    Variant("parked for 5 s", _parked, harmless=True),
    Variant("5 Hz", _at_rate(5.0), harmless=True), Variant("50 Hz", _at_rate(50.0), harmless=True),
    Variant("1 kHz", _at_rate(1000.0), harmless=True), Variant("a million rows", _long, harmless=True),
)  # fmt: skip
VARIANTS = (*_SIGNS, *_UNITS, *_CLOCKS, *_SWAPS, *_SENSORS, *_ROBOTS, *_DRIVES)
"""All variants, in the order of the table in docs/reference/any-log.md."""


def variant(name: str) -> Variant:
    """The variant called `name`; KeyError where there is none."""
    return {v.name: v for v in VARIANTS}[name]
