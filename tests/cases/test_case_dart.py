"""The 1:10 car: hard ground behind the soil laws' interface, logs read into drives, the steering's lag found by the loop."""

import casadi as ca
import numpy as np
import pytest

from softsoil.cases.dart import CAR, FLOOR, candidate_model, trace_log
from softsoil.cases.dart_data import POINT, STEP, WHEELBASE, read_dart, road_wheel_angle
from softsoil.symbolic.laws.hard_ground import HardGround
from softsoil.symbolic.wheel import Contact, Wheel

LAW, WHEEL = HardGround(), Wheel(0.033, 0.025)


def side(alpha, load=4.0, speed=2.0, **soil):
    contact = Contact(speed * np.cos(alpha), -speed * np.sin(alpha), 60.0, load)
    return float(ca.DM(LAW(FLOOR.with_(**soil), WHEEL, contact).f_y))


def test_hard_ground_is_linear_then_saturates_at_the_friction():
    stiffness = np.tan(FLOOR.phi) * 4.0 * LAW.length_share * WHEEL.radius / (2 * FLOOR.k)
    assert side(0.01) == pytest.approx(0.01 * stiffness, rel=0.05)
    forces = [side(a) for a in np.linspace(0.0, 1.4, 60)]
    assert np.all(np.diff(forces) > 0) and forces[-1] < 4.0 * np.tan(FLOOR.phi)
    assert side(1.4, k=1e-4) == pytest.approx(4.0 * np.tan(FLOOR.phi), rel=1e-2)
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
    assert any("there is no encoder" in note for note in drive.notes)


def test_a_log_without_driving_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"1_still\.csv: expected 6 s of driving"):
        read_dart(circle(tmp_path / "1_still.csv", speed=0.3))


@pytest.mark.shared
def test_the_loop_finds_the_lag_between_command_and_road_wheels(shared_data):
    logs = sorted((shared_data / "real" / "tudelft_dart_1to10").glob("83_16*.csv.gz"))
    if not logs:
        pytest.skip("the measured data are not beside the project")
    some = ("steering_lag", "steering_offset", "steering_gain")
    found = trace_log(logs[0], candidate_model(some), names=some)
    assert found.accepted[0].name == "steering_lag"
    value, std, unit = found.parameters["steering_lag"]
    assert unit == "s" and 0.05 < value < 0.15 and value > 3 * std
    for state in ("x", "y", "psi"):
        assert found.after["0.5"][state] < 0.8 * found.before["0.5"][state]
