"""Measurements of a motion that contradict each other while driving: what is seen, when, and what is none of it."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from softsoil.control.motion_watch import KINDS, MotionWatch

TICK, L_F, L_R = 0.0125, 1.3, 1.5


def motion(seconds, speed=6.0, bend=0.25, start=0.6, drift=0.0):
    """Samples by name of a vehicle that weaves, at a mean speed (m/s), its yaw rate up to bend (rad/s), from a heading (rad);
    drift: m/s to the left beside what the rear axle does."""
    t = np.arange(0.0, seconds, TICK)
    omega = bend * np.sin(0.9 * t) + 0.1 * bend
    psi = start + np.cumsum(omega) * TICK - omega * TICK
    u, v = speed * (1.0 + 0.2 * np.sin(0.5 * t)), L_R * omega + drift
    side = v + L_F * omega
    x = np.cumsum(TICK * (u * np.cos(psi) - side * np.sin(psi)))
    y = np.cumsum(TICK * (u * np.sin(psi) + side * np.cos(psi)))
    steer = np.arctan(1.3 * (L_F + L_R) * omega / u)
    return SimpleNamespace(t=t, x=x, y=y, psi=psi, u=u, v=v, omega_z=omega, steer=steer)


def watched(m, std=0.02, change=lambda _k, sample: sample):
    """A watch that took every sample, and the time at which it first disagreed."""
    watch, first = MotionWatch(L_F, L_R, std, 0.0175), math.nan
    for k, t in enumerate(m.t):
        sample = {name: getattr(m, name)[k] for name in ("x", "y", "psi", "u", "v", "omega_z", "steer")}
        sample = change(k, sample)
        watch.take(float(t), sample, sample["steer"])
        if watch.disagree and math.isnan(first):
            first = float(t)
    return watch, first


def scaled(**factors):
    return lambda _k, sample: sample | {name: factor * sample[name] for name, factor in factors.items()}


@pytest.mark.parametrize(
    ("fault", "kind"),
    (
        (scaled(u=3.6), "course"),
        (scaled(psi=180.0 / math.pi), "course"),
        (scaled(psi=-1.0), "course"),
        (scaled(psi=-1.0), "heading"),
        (scaled(omega_z=180.0 / math.pi), "heading"),
        (scaled(omega_z=-1.0), "heading"),
        (scaled(y=-1.0), "course"),
        (lambda _k, s: s | {"x": s["y"], "y": -s["x"]}, "course"),
        (lambda _k, s: s | {"psi": math.pi / 2 - s["psi"]}, "heading"),
        (scaled(steer=-1.0), "steering"),
        (lambda _k, s: s | {"x": 5.0, "y": 7.0}, "course"),
    ),
)  # fmt: skip
def test_a_unit_sign_or_axis_that_is_wrong_is_seen(fault, kind):
    watch, first = watched(motion(20.0, bend=0.5), change=fault)
    assert kind in watch.disagree
    assert first < 13.0


@pytest.mark.parametrize("speed", (6.0, 0.8, -2.0))
@pytest.mark.parametrize("drift", (0.0, 0.15))
def test_noise_a_drift_and_slow_channels_are_none(speed, drift):
    """With the noise of the paper's Table 5, a heading wrapped anywhere, positions at every tick, at 5 Hz or held at 1 Hz; drift:
    that share of the speed, of a v that is not measured."""
    m, rng = motion(150.0, speed, drift=drift * speed), np.random.default_rng(5)
    stds = {"x": 1.2, "y": 1.2, "psi": 0.0175, "u": 0.25, "v": 0.25, "omega_z": 0.0175, "steer": 0.01}
    noise = {name: rng.normal(0.0, std, len(m.t)) for name, std in stds.items()}

    def seen(k, sample, rate, holds):
        out = {name: value + noise[name][k] for name, value in sample.items()}
        out["psi"] = math.remainder(out["psi"], math.tau)
        at = k - k % rate
        if at != k:
            held = {name: getattr(m, name)[at] + noise[name][at] for name in ("x", "y")}
            out |= held if holds else dict.fromkeys(held, math.nan)
        return out if not drift else out | {"v": math.nan}

    for rate, holds in ((1, False), (16, False), (80, True)):
        _, first = watched(m, 1.2, lambda k, sample, rate=rate, holds=holds: seen(k, sample, rate, holds))
        assert math.isnan(first), (rate, holds)


def test_a_position_that_jumps_a_heading_that_spikes_and_wheels_that_spin_once_are_none():
    def change(k, sample):
        out = dict(sample)
        if k > 600:
            out["x"] += 40.0
        if k % 400 == 7:
            out["psi"] += 2.0
        if 1000 < k < 1060:
            out["u"] *= 4.0
        return out

    _, first = watched(motion(30.0), change=change)
    assert math.isnan(first)


@pytest.mark.parametrize(
    ("name", "bend", "change"),
    (
        ("a heading of 0.1 rad of noise on a straight", 0.0, lambda k, s: s | {"psi": s["psi"] + 0.1 * NOISE[k]}),
        ("a spike of the heading every 3 s there", 0.0, lambda k, s: s | {"psi": s["psi"] + (1.0 if k % 240 == 7 else 0.0)}),
        ("a heading off for 0.6 s, twice", 0.0, lambda k, s: s | {"psi": s["psi"] + (1.0 if k % 1600 < 48 else 0.0)}),
        ("positions of 1.5 m that were declared to be of 0.02", 0.2, lambda k, s: s | {"x": s["x"] + 1.5 * NOISE[k]}),
        ("a position 30 m off at one tick each second", 0.2, lambda k, s: s | {"x": s["x"] + (30.0 if k % 80 == 50 else 0.0)}),
        ("a steering angle that is 0.05 rad off in a long bend", 0.0, lambda k, s: bent(k, s) | {"steer": -0.022}),
        ("a garbage number now and then", 0.2, lambda k, s: s | ({("x", "u", "psi")[k % 3]: 1e200} if k % 50 == 3 else {})),
    ),
)  # fmt: skip
def test_faults_that_are_smaller_or_shorter_do_not_halt_a_vehicle(name, bend, change):
    _, first = watched(motion(60.0, bend=bend), change=change)
    assert math.isnan(first), name


NOISE = np.random.default_rng(11).normal(size=10000)


def bent(k, sample):
    """The sample k of a bend of 100 m at 6 m/s."""
    omega, t = 0.06, k * TICK
    return sample | {"x": 100.0 * math.sin(omega * t), "y": 100.0 * (1.0 - math.cos(omega * t)), "psi": omega * t,
                     "u": 6.0, "v": -L_F * omega, "omega_z": omega}  # fmt: skip


def test_a_parked_vehicle_is_not_judged():
    """Its receiver wanders by metres and gives any heading; driven on, everything is right."""
    m, watch = motion(20.0), MotionWatch(L_F, L_R, 1.2, 0.0175)
    wander = np.cumsum(0.1 * NOISE)
    for k in range(9000):
        parked = {"x": wander[k], "y": -wander[k], "psi": NOISE[k // 40] * 3.0, "u": 0.0, "v": 0.0, "omega_z": 0.0}
        watch.take(k * TICK, parked, 0.0)
        assert watch.disagree == (), k
    for k, t in enumerate(m.t):
        watch.take(9000 * TICK + t, {name: getattr(m, name)[k] for name in ("x", "y", "psi", "u", "v", "omega_z")}, m.steer[k])
        assert watch.disagree == (), k


def test_a_speed_that_is_no_longer_measured_is_not_carried_on():
    """It was 6 m/s for three seconds; the vehicle crawls on at a sixth of that."""
    def change(k, sample):
        x = 6.0 * TICK * min(k, 240) + TICK * max(k - 240, 0)
        return sample | {"x": x, "y": 0.0, "psi": 0.0, "u": 6.0 if k < 240 else math.nan, "v": 0.0, "omega_z": 0.0}

    _, first = watched(motion(40.0), change=change)
    assert math.isnan(first)


def test_a_speed_that_is_frozen_at_zero_is_seen():
    watch, first = watched(motion(20.0), change=lambda _k, s: s | {"u": 0.0, "v": 0.0})
    assert watch.disagree == ("course",) and first < 20.0


@pytest.mark.parametrize("fault", (scaled(u=3.6), scaled(psi=180.0 / math.pi), lambda _k, s: s | {"x": s["y"], "y": -s["x"]}))
def test_good_positions_show_it_within_two_seconds(fault):
    _, first = watched(motion(5.0), change=fault)
    assert first < 2.0


def test_it_disagrees_until_as_many_stretches_agree():
    watch, first = watched(motion(20.0), change=lambda k, s: scaled(u=3.6)(k, s) if k < 400 else s)
    assert first < 5.0 and not watch.disagree
    watch, _ = watched(motion(5.2), change=lambda k, s: scaled(u=3.6)(k, s) if k < 400 else s)
    assert watch.disagree == ("course",)


def test_what_is_not_measured_is_not_judged():
    for gone in ("x", "psi", "u"):
        watch, first = watched(motion(20.0), change=lambda _k, s, gone=gone: s | {"y": -s["y"], gone: math.nan})
        assert math.isnan(first), gone
    watch, first = watched(motion(20.0), change=lambda _k, s: s | {"psi": -s["psi"], "omega_z": math.nan})
    assert watch.disagree == ("course",)
    assert set(KINDS) == {"course", "heading", "steering"}


def test_a_pause_begins_a_stretch_anew_and_a_drive_that_begins_anew_forgets():
    watch, _ = watched(motion(5.0), change=scaled(u=3.6))
    watch.take(100.0, {"x": 900.0, "y": 0.0, "psi": 0.0, "u": 6.0}, 0.0)
    assert watch.disagree == ("course",)
    watch.forget()
    assert watch.disagree == ()
