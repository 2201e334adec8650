"""What the numbers leave of their own logs: in the file, in limits and errors of n, and against what was given."""

from dataclasses import replace

import numpy as np
import pytest

from drives import CLAY_LOG, LOAM_LOG, MULTI_LOG
from softsoil.control.c_horizon import horizon_numbers
from softsoil.declaration.ground import HARD_GROUND
from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration
from softsoil.estimator.verdict_rules import OWN_MARGIN, OWN_MOST, VerdictRules
from softsoil.identification.identify import identify
from softsoil.identification.rules import RULES
from softsoil.identification.unexplained import Unexplained, doubt, more_than_right, own_unexplained
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.refinement.known_vehicle import Known
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, load_soil
from softsoil.symbolic.vehicle import load_vehicle

KNOWN = Known(
    "paper",
    {"mass": 1378.33, "l_f": 1.546, "l_r": 1.175, "track": 1.232, "radius": 0.330229, "width": 0.2121, "h_cg": 0.63},
    simulator=load_vehicle("reference").simulator,
    search=0.0018,
)


def left(log="a", **shares):
    return Unexplained(log, shares, shares, 0.5)


def test_the_largest_share_of_each_channel_counts():
    logs = [left(omega_z=0.01, v=0.0), left("b", omega_z=0.03, v=0.02), left("straight")]
    assert own_unexplained(logs) == {"omega_z": 0.03, "v": 0.02} and own_unexplained([left()]) == {}
    assert more_than_right(logs) == pytest.approx(0.03 / 0.022) and more_than_right(logs[:1]) == 1.0
    assert more_than_right([left(omega_z=0.5)]) == 2.0
    for one, channel in ((left(omega_z=0.043), ""), (left(omega_z=0.045), "omega_z"), (left(v=0.21), "v")):
        limits = {name: OWN_MOST * limit for name, limit in VerdictRules().unexplained}
        assert one.beyond(limits) == channel and one.beyond(dict.fromkeys(limits, 0.5)) == ""


@pytest.mark.parametrize(("share", "n_error", "said"), [(0.03, 0.08, True), (0.03, 0.04, False), (0.02, 0.08, False)])
def test_where_n_is_vague_no_more_may_be_left_than_a_right_model_leaves(share, n_error, said):
    vague = n_error if n_error > RULES.n_error else 0.0
    drive = read_drive(MULTI_LOG).between(0.0, 15.0)
    reason = doubt([drive], [CLAY], load_vehicle("reference"), [left(omega_z=share)], [], 1.0, vague)
    assert ("n by them has an error of 8 %" in reason and "another class" in reason) if said else reason == ""


def test_the_log_that_is_farthest_beyond_its_own_limit_is_named():
    """More is left of the other, in a channel of which this vehicle's own logs leave as much."""
    drives = [read_drive(MULTI_LOG).between(0.0, 15.0)] * 2
    logs = [left("a", omega_z=0.0, v=0.19), left("b", omega_z=0.035, v=0.0)]
    said = doubt(drives, [CLAY] * 2, load_vehicle("reference"), logs, [], 1.0, limits={"omega_z": 0.022, "v": 0.195})
    assert "motion of b unexplained" in said


def test_limits_of_one_s_own_are_those_that_count_and_are_said():
    drive, vehicle = read_drive(MULTI_LOG).between(0.0, 15.0), load_vehicle("reference")
    said = [
        doubt([drive], [CLAY], vehicle, [left(omega_z=0.03)], [], 1.0, limits={"omega_z": limit, "v": 0.1})
        for limit in (0.022, 0.028, 0.035)
    ]
    assert "(a right one at most 2.2 %): " in said[0] and "2.8 % are allowed" in said[1] and said[2] == ""


@pytest.mark.parametrize(
    ("own", "limit"), [({}, 0.022), ({"omega_z": 0.01}, 0.022), ({"omega_z": 0.025}, 0.0325), ({"omega_z": 0.2}, 0.044)]
)
def test_a_vehicle_is_judged_by_what_its_numbers_leave_of_its_own_logs(own, limit):
    model = bicycle(load_vehicle("reference").with_(unexplained=own), CLAY)
    rules = VerdictRules().of(model)
    assert dict(rules.unexplained) == {"omega_z": pytest.approx(limit), "v": 0.10} and OWN_MARGIN == 1.3
    assert horizon_numbers(model).unexplained == [0.10, pytest.approx(limit)]


def test_what_a_file_states_is_read_back_by_every_command(tmp_path):
    vehicle = load_vehicle("reference").with_(unexplained={"omega_z": 0.025, "v": 0.0})
    path = tmp_path / "model.toml"
    path.write_text(declaration_toml(Declaration(vehicle, CLAY)), encoding="utf-8")
    assert load_declaration(path).vehicle.unexplained == vehicle.unexplained


@pytest.mark.study
def test_a_wrong_soil_class_is_no_number_of_the_vehicle():
    drives = [add_noise(read_drive(log).between(0.0, 24.0), "good", i) for i, log in enumerate((CLAY_LOG, MULTI_LOG, LOAM_LOG))]
    found = identify(drives, load_soil("sand"), KNOWN)
    assert found.verdict == "contradicts_given"
    assert "unexplained beyond sensor noise" in found.reason and "soil is of another class" in found.reason


@pytest.mark.study
def test_hard_ground_is_no_soil_to_identify_a_vehicle_on():
    vehicle = load_vehicle("reference")
    model = bicycle(vehicle, HARD_GROUND.with_(phi=np.arctan(0.6), k=0.003), "hard_ground", {})
    t = 0.012 * np.arange(1668)
    waves = (0.42 * np.sin(2 * np.pi * t / 3.0), MultiSine(0.35, seed=2)(t), MultiSine(0.35, seed=3)(t))
    drives = [synthetic_drive(model, vehicle.radius, seconds=20.0, speed=4.5 + 0.5 * i, steer=s) for i, s in enumerate(waves)]
    drives = [replace(add_noise(drive, "good", i), name=f"road_{i}") for i, drive in enumerate(drives)]
    found = identify(drives, load_soil("sandy_loam"), KNOWN)
    assert found.verdict == "contradicts_given" and "this is no soft soil" in found.reason


@pytest.mark.study
def test_stated_errors_of_a_class_are_in_n_of_every_log_and_not_in_that_of_the_vehicle():
    drives = [add_noise(read_drive(log).between(0.0, 20.0), "good", i) for i, log in enumerate((CLAY_LOG, MULTI_LOG))]
    exact, wide = (identify(drives, CLAY.with_(uncertainty=stated), KNOWN) for stated in ((), (("phi", 0.02),)))
    for log, (value, std) in exact.n.items():
        assert wide.n[log][0] == value and wide.n[log][1] > std + 0.05 * value
    assert wide.vehicle.n_error == exact.vehicle.n_error
