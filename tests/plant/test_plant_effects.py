"""Effects beyond the catalogue, and soil that differs between the sides: each does what its name says."""

import numpy as np

from softsoil.plant.effects import Effects
from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.manoeuvres import Manoeuvre, PathFollower, Sine, Speed, lane_change
from softsoil.plant.simulate import simulate
from softsoil.plant.soil_field import SoilField
from softsoil.recording.drive import Recording
from softsoil.symbolic.soil import CLAY, SANDY_LOAM

STRAIGHT = Manoeuvre("straight", Sine(0.0), Speed(5.0))
CURVES = Manoeuvre("curves", Sine(0.3, 3.0), Speed(5.0))


def settled(drive: Recording, name: str) -> np.ndarray:
    """A channel or truth column after the first second."""
    values = drive.truth[name] if name.startswith("true_") else drive[name]
    return values[drive.t > 1.0]


def test_imbalance_shakes_at_wheel_speed() -> None:
    plain, shaken = (
        simulate(STRAIGHT, CLAY, 4.0, effects=e, sample=0.004) for e in (Effects(), Effects(imbalance=(1.0, 0, 0, 0)))
    )
    frequency = np.mean(settled(shaken, "omega_fl")) / (2 * np.pi)
    lines = []
    for drive in (plain, shaken):
        z = settled(drive, "true_z_fl")
        phase = 2 * np.pi * frequency * drive.t[drive.t > 1.0]
        lines.append(abs(np.mean((z - z.mean()) * np.exp(-1j * phase))))
    assert lines[1] > 3 * lines[0]


def test_an_imbalance_shakes_the_accelerometer_as_it_moves_the_vehicle() -> None:
    drive = simulate(STRAIGHT, CLAY, 4.0, effects=Effects(imbalance=(0.3, 0.3, 0.3, 0.3)), sample=0.002)
    moved = np.gradient(drive["u"], drive.dt) - drive["v"] * drive["omega_z"]
    rows = slice(len(drive) // 4, -5)
    assert np.std(moved[rows] - drive["a_x_imu"][rows]) < 0.3 * np.std(moved[rows])


def test_out_of_round_wheel_lifts_once_a_turn() -> None:
    plain, lame = (simulate(STRAIGHT, CLAY, 3.0, effects=e) for e in (Effects(), Effects(out_of_round=(0.01, 0, 0, 0))))
    assert np.std(settled(lame, "true_z_fl")) > 2 * np.std(settled(plain, "true_z_fl"))


def test_broken_roll_bar_lets_the_body_lean() -> None:
    plain, broken = (simulate(CURVES, CLAY, 4.0, effects=e) for e in (Effects(), Effects(bar_factor=(1.0, 0.0))))
    assert np.std(settled(broken, "true_roll")) > 1.08 * np.std(settled(plain, "true_roll"))


def test_stuck_dampers_hold_the_body() -> None:
    plain, stuck = (simulate(CURVES, CLAY, 4.0, effects=e) for e in (Effects(), Effects(damper_factor=(8.0,) * 4)))
    assert np.std(settled(stuck, "true_roll")) < 0.9 * np.std(settled(plain, "true_roll"))


def test_waving_bank_pushes_with_the_position() -> None:
    plain, waving = (
        simulate(STRAIGHT, CLAY, 6.0, effects=e) for e in (Effects(), Effects(undulation=0.08, undulation_length=15.0))
    )
    push = settled(waving, "a_y_imu") - settled(plain, "a_y_imu")
    wave = np.sin(2 * np.pi * settled(waving, "x") / 15.0)
    assert abs(np.corrcoef(push, wave)[0, 1]) > 0.5


def test_odd_tyres_pull_to_a_side() -> None:
    smaller = Effects(radius_factor=(0.97, 1.0, 0.97, 1.0), locked_front=True, locked_rear=True)
    drives = [simulate(STRAIGHT, CLAY, 4.0, effects=e) for e in (Effects(), smaller)]
    turn = [float(np.mean(settled(d, "omega_z"))) for d in drives]
    assert turn[1] - turn[0] > 0.005


def test_single_soft_side_drags() -> None:
    soft = SANDY_LOAM.with_(n=1.1)
    left = simulate(STRAIGHT, SoilField.left_right(soft, CLAY), 4.0)
    right = simulate(STRAIGHT, SoilField.left_right(CLAY, soft), 4.0)
    assert np.mean(settled(left, "true_sinkage_fl")) > 1.5 * np.mean(settled(left, "true_sinkage_fr"))
    assert abs(np.mean(settled(left, "omega_z"))) > 0.003
    assert np.mean(settled(left, "omega_z")) * np.mean(settled(right, "omega_z")) < 0


def test_passes_kept_apart_leave_fresh_soil_to_the_rear() -> None:
    together, apart = (simulate(STRAIGHT, CLAY, 3.0, effects=e) for e in (Effects(), Effects(multipass=False)))
    # On fresh soil the rear wheels must do the front wheels' work again.
    assert np.mean(settled(apart, "u")) < np.mean(settled(together, "u"))


def test_soil_that_shears_anew_holds_the_rear_less() -> None:
    """In a turn the rear wheels need more side slip where the front wheels' shearing does not help them; they sink as before."""
    turn = Manoeuvre("turn", Sine(0.2, 60.0), Speed(5.0))
    kept, anew = (simulate(turn, CLAY, 6.0, effects=Effects(shears_anew=on)) for on in (False, True))
    slips = [np.mean(np.abs((one["v"] - load_plant_vehicle().l_r * one["omega_z"]) / one["u"])[300:]) for one in (kept, anew)]
    assert slips[1] > 1.15 * slips[0]
    depth = [np.mean(settled(one, "true_sinkage_rl")) for one in (kept, anew)]
    assert abs(depth[1] / depth[0] - 1.0) < 0.1


def test_pure_pursuit_keeps_to_its_path() -> None:
    path = lane_change(80.0)
    drive = simulate(PathFollower(path), CLAY, 12.0)
    here = np.stack([drive["x"], drive["y"]], axis=1)[drive["x"] < 75.0]
    off = np.min(np.linalg.norm(here[:, None, :] - path[None, :, :], axis=2), axis=1)
    assert np.max(off) < 0.8


def test_steering_follows_what_the_vehicle_can_stand_for() -> None:
    vehicle = load_plant_vehicle()
    drive = simulate(Manoeuvre("lock", Sine(0.6, 4.0), Speed(3.0)), CLAY, 2.0)
    mean = 0.5 * (drive.truth["true_delta_fl"] + drive.truth["true_delta_fr"])
    assert np.max(mean) < vehicle.max_steer + 0.02
    gentle = simulate(Manoeuvre("gentle", Sine(0.2, 4.0), Speed(3.0)), CLAY, 2.0)
    mean = 0.5 * (gentle.truth["true_delta_fl"] + gentle.truth["true_delta_fr"])
    assert np.max(np.abs(mean - gentle["steer"])) < 0.01
