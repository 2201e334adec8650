"""A steering that follows late is seen by the clocks of all logs alike, and identified with the vehicle's other numbers."""

from dataclasses import replace

import numpy as np
import pytest

from softsoil.identification.bench import fit_numbers, free_numbers, make_bench
from softsoil.identification.identify import identify
from softsoil.identification.late_channels import recorded_late, with_late_channels
from softsoil.identification.result import Found, in_order
from softsoil.identification.vehicle_toml import vehicle_toml
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.noise import add_noise
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.vehicle_numbers import expected, vehicle_of
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY

NUMBERS_GIVEN = {"mass": 1378.33, "l_f": 1.546, "l_r": 1.175, "track": 1.232, "radius": 0.33, "width": 0.2121, "h_cg": 0.63}
KNOWN = Known("late", NUMBERS_GIVEN)
LAG, INERTIA = 0.12, 2300.0
SECONDS = 24.0


def steering(kind):
    t = 0.012 * np.arange(round(SECONDS / 0.012) + 1)
    if kind == "lock":
        return 0.42 * np.sin(2 * np.pi * t / 3.0)
    return 0.09 * (np.sin(0.9 * t) + np.sin(2.3 * t + 1.0) + 0.7 * np.sin(4.1 * t + 2.0))


def log_of(kind, n, seed, lag):
    vehicle = vehicle_of(KNOWN, {"yaw_inertia": INERTIA})
    effects = vehicle.effects | {"steering_lag": {"steering_lag": lag}}
    made = synthetic_drive(bicycle(vehicle.with_(effects=effects), CLAY.with_(n=n)), 0.33, seconds=SECONDS, steer=steering(kind))
    return replace(add_noise(made, "good", seed), name=f"{kind}_{seed}")


@pytest.fixture(scope="module")
def late():
    return [log_of("lock", 0.5, 1, LAG), log_of("multi", 0.65, 2, LAG), log_of("multi", 0.6, 3, LAG)]


@pytest.fixture(scope="module")
def prompt():
    return log_of("multi", 0.65, 2, 0.0)


def test_a_lag_that_all_logs_show_is_where_the_fit_starts(late):
    known, notes = with_late_channels(KNOWN, late)
    value, std = expected(known)["steering_lag"]
    assert value == pytest.approx(LAG, abs=0.02) and std > 2 * expected(KNOWN)["steering_lag"][1]
    assert expected(known) | {"steering_lag": None} == expected(KNOWN) | {"steering_lag": None}, "nothing else moves"
    assert len(notes) == 1 and "in all logs steer seems 0.1" in notes[0] and "--align" in notes[0]


def test_one_log_or_a_log_without_it_shows_none(late, prompt):
    for logs in ([late[0]], [late[0], prompt], [prompt, prompt]):
        assert with_late_channels(KNOWN, logs) == (KNOWN, ())


def test_clocks_that_differ_from_log_to_log_are_no_lag_of_the_vehicle(late):
    rows = 25
    shifted = late[1].with_channels(steer=np.concatenate([late[1]["steer"][rows:], np.full(rows, late[1]["steer"][-1])]))
    assert with_late_channels(KNOWN, [late[0], shifted]) == (KNOWN, ())


def test_a_declared_lag_stays_as_it_is(late):
    for effects in ({"steering_lag": {"steering_lag": 0.05}}, {"steering_delay": {"steering_delay": LAG}}):
        declared = replace(KNOWN, effects=effects)
        assert with_late_channels(declared, late) == (declared, ())


@pytest.mark.study
def test_a_steering_that_is_recorded_late_is_no_other_inertia_or_n():
    """By 0.03 s: with lags of zero and more, inertia and n took it up, and the vehicle was identified."""
    log, late = log_of("multi", 0.6, 3, 0.0), 0.03
    shifted = log.with_channels(steer=np.interp(log.t - late, log.t, log["steer"]))
    bench = make_bench([shifted], [CLAY], KNOWN, 2.0)
    fit = fit_numbers(bench, free_numbers(bench, ["yaw_inertia", "steering_lag"]), {}, [0.5])
    found = fit.named()
    assert found["steering_lag"][0] == pytest.approx(-late, abs=0.005)
    assert found["yaw_inertia"][0] == pytest.approx(INERTIA, rel=0.04) and found["n_0"][0] == pytest.approx(0.6, rel=0.04)


def test_it_is_said_with_its_size():
    one = Found(-0.039, 0.011, "s", "identified", 5.0, None, (0.01, 0.02))
    (note,) = recorded_late({"steering_lag": one})
    assert "-0.039 ± 0.011 s, below zero: steer is recorded that much late" in note and "late = 0.039 at steer" in note
    assert "at least" not in note and "in place of this file" in note
    assert "at least, the bound" in recorded_late({"steering_lag": replace(one, value=-0.08)})[0]
    assert recorded_late({"steering_lag": replace(one, value=-0.01), "toe": one}) == ()
    assert recorded_late({"steering_lag": replace(one, state="not_identifiable")}) == ()


@pytest.mark.study
def test_the_lag_is_identified_and_the_inertia_does_not_take_it_up(late):
    found = identify(late, [CLAY] * 3, KNOWN)
    lag, inertia = found.numbers["steering_lag"], found.numbers["yaw_inertia"]
    assert lag.state == "identified" and lag.given is None
    assert lag.value == pytest.approx(LAG, abs=0.02)  # all wheels of these drives slip alike, as no driveline makes them
    assert inertia.value == pytest.approx(INERTIA, rel=0.05)
    assert found.vehicle.effects["steering_lag"]["steering_lag"] == lag.value
    assert in_order(found.numbers)[-1] == "steering_lag" and "steering_lag" in found.vehicle.joint_error.names
    text = vehicle_toml(found)
    assert "[effects.steering_lag]" in text and "identified" in text.split("[effects.steering_lag]")[1].splitlines()[1]
