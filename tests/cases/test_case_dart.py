"""The 1:10 car: hard ground behind the soil laws' interface, logs read into drives, the steering's lag found by the loop."""

import casadi as ca
import numpy as np
import pytest

from softsoil.cases.dart import CAR, candidates_of, trace_log, transferred
from softsoil.cases.dart_data import POINT, STEP, WHEELBASE, read_dart, road_wheel_angle
from softsoil.checking.cross_check import check_channels
from softsoil.declaration.ground import HARD_GROUND
from softsoil.symbolic.laws.hard_ground import HardGround
from softsoil.symbolic.wheel import Contact, Wheel

LAW, WHEEL = HardGround(), Wheel(0.033, 0.025)


def side(alpha, load=4.0, speed=2.0, **soil):
    contact = Contact(speed * np.cos(alpha), -speed * np.sin(alpha), 60.0, load)
    return float(ca.DM(LAW(HARD_GROUND.with_(**soil), WHEEL, contact).f_y))


def test_hard_ground_is_linear_then_saturates_at_the_friction():
    stiffness = np.tan(HARD_GROUND.phi) * 4.0 * LAW.length_share * WHEEL.radius / (2 * HARD_GROUND.k)
    assert side(0.01) == pytest.approx(0.01 * stiffness, rel=0.05)
    forces = [side(a) for a in np.linspace(0.0, 1.4, 60)]
    assert np.all(np.diff(forces) > 0) and forces[-1] < 4.0 * np.tan(HARD_GROUND.phi)
    assert side(1.4, k=1e-4) == pytest.approx(4.0 * np.tan(HARD_GROUND.phi), rel=1e-2)
    assert side(-0.3) == pytest.approx(-side(0.3))
    assert side(0.3, load=8.0) == pytest.approx(2 * side(0.3, load=4.0), rel=1e-2)
    assert side(0.3, n=0.9) == side(0.3)


def test_hard_ground_options_are_checked():
    with pytest.raises(ValueError, match=r"expected length_share > 0, found 0\.0"):
        HardGround(length_share=0.0)


def test_steering_map_is_the_laboratorys():
    assert road_wheel_angle(np.array([0.027]))[0] == pytest.approx(0.0)
    assert road_wheel_angle(np.array([1.0]))[0] == pytest.approx(0.366 * np.tanh(1.393 * 0.973))
    assert road_wheel_angle(np.array([-1.0]))[0] == pytest.approx(-0.515 * np.tanh(1.023 * 1.027))


def circle(path, speed=1.5, rate=0.8, command=0.5, seconds=9.0):
    """A log of a car whose rear axle runs on a circle without side slip, raw yaw as captured."""
    t = np.arange(0.0, seconds, 0.01)
    psi = rate * t
    x = speed / rate * np.sin(psi) + POINT * np.cos(psi)
    y = -speed / rate * np.cos(psi) + POINT * np.sin(psi)
    table = np.column_stack([t, x, y, np.angle(np.exp(1j * (psi - 0.0077))), np.full_like(t, command)])
    np.savetxt(path, table, delimiter=",", header="vicon time,vicon x,vicon y,vicon yaw,steering", comments="")
    return path


def test_poses_become_velocities_at_the_right_points(tmp_path):
    drive = read_dart(circle(tmp_path / "1_circle.csv"))[0]
    inner = slice(20, -20)
    assert drive.dt == pytest.approx(STEP)
    assert drive["u"][inner] == pytest.approx(1.5, abs=1e-2)
    assert drive["omega_z"][inner] == pytest.approx(0.8, abs=1e-3)
    assert drive["v"][inner] == pytest.approx(0.8 * CAR.l_r, abs=1e-2)
    rear = np.hypot(drive["x"] - WHEELBASE * np.cos(drive["psi"]), drive["y"] - WHEELBASE * np.sin(drive["psi"]))
    assert rear[inner] == pytest.approx(1.5 / 0.8, abs=1e-3)
    assert not any(name in drive.channels for name in ("omega_fl", "omega_rr"))


def test_a_log_without_driving_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"1_still\.csv: expected 6 s of driving"):
        read_dart(circle(tmp_path / "1_still.csv", speed=0.3))


def test_candidates_are_those_of_the_declared_kinds():
    some = candidates_of(CAR, ("slope",))
    assert some and set(some) < set(candidates_of(CAR, ("slope", "steering")))


@pytest.mark.study
@pytest.mark.shared
def test_refine_names_the_delay_of_the_steering_which_fits_the_other_log(shared_data):
    folder = shared_data / "real" / "tudelft_dart_1to10"
    if not folder.is_dir():
        pytest.skip("the measured data are not beside the project")
    (first,), (other,) = (sorted(folder.glob(f"{name}*.csv.gz")) for name in ("83_24", "83_16"))
    some = ("steering_lag", "steering_delay", "steering_offset", "steering_gain")
    found = trace_log(first, names=some)
    assert found.verdict == "effect" and found.effects[0].name in some[:2]
    (value, std, unit), = found.effects[0].parameters.values()
    assert unit == "s" and 0.05 < value < 0.15 and value > 3 * std
    for state in ("x", "y", "psi"):
        assert found.after["0.5"][state] < 0.8 * found.before["0.5"][state]
    friction = found.ground[0].numbers[0]
    assert friction.word == "identified" and 0.35 < friction.value < 0.5
    assert found.n_after == () and found.ground[0].name == "83_24"
    (key,) = found.effects[0].parameters
    gain, gain_std, falls = transferred(trace_log(other, names=some), found.effects[0], {key: value})
    assert gain > 3 * gain_std and falls > 1.5


@pytest.mark.shared
def test_the_channels_themselves_say_that_the_steering_is_early(shared_data):
    logs = sorted((shared_data / "real" / "tudelft_dart_1to10").glob("83_16*.csv.gz"))
    if not logs:
        pytest.skip("the measured data are not beside the project")
    for drive in read_dart(logs[0]):
        checks = {check.name: check for check in check_channels(drive, CAR)}
        assert not checks["clock_steer"].passed and not any(check.beyond_doubt for check in checks.values())
