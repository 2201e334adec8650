"""Where wheels run in the drive's own ruts: found on laps, reversing and crossings, not on ground that is met once."""

import numpy as np
import pytest

import softsoil
from softsoil.checking.own_ruts import with_ruts
from softsoil.recording.derive import completed
from softsoil.recording.forward import in_ruts

VEHICLE = softsoil.load_vehicle("reference")
SPEED, RATE = 5.0, 0.35
LAP = 2 * np.pi / RATE


def driven(turning, seconds, speed=SPEED, noise=0.0, heading=0.0, step=0.012):
    """A drive without slip at the front axle: yaw rate (rad/s) and speed (m/s) as functions of time (s); noise of x and y (m)."""
    t = np.arange(0.0, seconds, step)
    omega, u = np.broadcast_to(turning(t), t.shape), np.broadcast_to(speed(t) if callable(speed) else speed, t.shape)
    psi = np.concatenate([[0.0], np.cumsum(omega[1:] * np.diff(t))])
    x, y = (np.concatenate([[0.0], np.cumsum((u * way)[1:] * np.diff(t))]) for way in (np.cos(psi), np.sin(psi)))
    rng = np.random.default_rng(3)
    x, y, psi = (values + std * rng.standard_normal(len(t)) for values, std in ((x, noise), (y, noise), (psi, heading)))
    motion = {"u": u.copy(), "v": -VEHICLE.l_f * omega, "omega_z": omega.copy()}
    return softsoil.Recording("log", {"t": t, "x": x, "y": y, "psi": psi, **motion})


def circle(t):
    return RATE + 0.0 * t


@pytest.mark.parametrize(
    ("noise", "heading", "step"), [(0.0, 0.0, 0.012), (0.3, 0.0175, 0.012), (1.2, 0.0175, 0.012), (0.01, 0.002, 0.1)]
)
def test_a_second_lap_is_in_the_ruts_of_the_first(noise, heading, step):
    ((first, last),) = with_ruts(driven(circle, 3 * LAP, noise=noise, heading=heading, step=step), VEHICLE).ruts
    assert LAP - 0.8 < first < LAP + 0.1  # the front wheels reach the first ruts, which begin at the rear axle
    assert last == pytest.approx(3 * LAP, abs=0.2)


def test_a_lap_beside_the_first_meets_no_rut_where_it_leaves_more_room_than_the_tracks():
    def spiral(t):
        return SPEED / (20.0 + 4.0 * VEHICLE.track * t / 25.0)

    assert with_ruts(driven(spiral, 60.0), VEHICLE).ruts == ()


def test_a_crossing_lasts_as_long_as_the_vehicle_stands_on_it():
    def eight(t):
        return np.where(t < LAP, RATE, -RATE)  # two circles that touch where the second begins

    ruts = with_ruts(driven(eight, 1.9 * LAP), VEHICLE).ruts
    assert ruts and ruts[0][0] == pytest.approx(LAP, abs=1.0)
    assert sum(last - first for first, last in ruts) < 5.0


def with_a_stop(t):
    return np.where((t > 5) & (t < 30), 0.0, SPEED)


@pytest.mark.parametrize(
    ("turning", "speed"),
    [(lambda t: 0.0 * t, SPEED), (lambda t: 0.4 * np.sin(t), SPEED), (lambda t: 0.0 * t, with_a_stop)],
)
def test_rear_wheels_behind_the_front_ones_and_a_vehicle_that_stands_meet_no_earlier_rut(turning, speed):
    assert with_ruts(driven(turning, 60.0, speed, noise=0.3), VEHICLE).ruts == ()


def test_what_was_reversed_over_is_not_fresh_on_the_way_forwards():
    def back(t):
        return np.where((t > 10) & (t < 12), -2.0, np.where((t > 9) & (t < 13), 0.0, SPEED))

    found = with_ruts(driven(lambda t: 0.0 * t, 30.0, back), VEHICLE).ruts
    assert found[-1][0] < 13.1 and 13.0 + 4.0 / SPEED < found[-1][1] < 15.5  # 4 m, and the wheelbase that stood on ruts


@pytest.mark.parametrize("absent", ["x", "u"])
def test_without_a_measured_position_nothing_is_known(absent):
    log = driven(circle, 2 * LAP)
    log = softsoil.Recording("log", dict(log.channels), state={absent: "derived"})
    assert with_ruts(log, VEHICLE).ruts == ()


def test_a_heading_that_is_laid_on_the_positions_does():
    log = driven(circle, 2 * LAP)
    known = with_ruts(log, VEHICLE).ruts
    channels = {name: values for name, values in log.channels.items() if name != "psi"}
    laid = completed(softsoil.Recording("log", channels | {"steer": np.zeros(len(log))}), VEHICLE)
    ((begin, end),) = with_ruts(laid, VEHICLE).ruts
    assert known and laid.state_of("psi") == "derived" and (begin, end) == pytest.approx(known[0], abs=0.5)


def test_a_position_worse_than_the_ruts_are_wide_says_nothing():
    rng = np.random.default_rng(1)
    log = driven(circle, 2 * LAP)
    wander = np.repeat(rng.standard_normal(len(log) // 50 + 1), 50)[: len(log)] * 8.0
    assert with_ruts(log.with_channels(x=log["x"] + wander), VEHICLE).ruts == ()


def test_a_note_says_how_long_and_parts_keep_it():
    found = with_ruts(driven(circle, 2 * LAP), VEHICLE)
    assert "wheels run in ruts of earlier in this log for 1" in found.notes[-1]
    straight = driven(lambda t: 0.0 * t, 2 * LAP)
    gone = with_ruts(found.with_channels(**{k: straight[k] for k in ("x", "y", "psi", "omega_z")}), VEHICLE)
    assert gone.ruts == () and not any("ruts" in note for note in gone.notes)
    part = found.between(0.9 * LAP, 1.5 * LAP)
    assert in_ruts(part).mean() == pytest.approx(0.5 / 0.6, abs=0.08)
