"""The plant's vehicle: mirror symmetry, determinism, save and resume, effects and sensors."""

from dataclasses import replace

import numpy as np
import pytest

from softsoil.plant.effects import Effects
from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.manoeuvres import Logged, Manoeuvre, Sine, Speed
from softsoil.plant.replay import replay
from softsoil.plant.sensors import Sensors
from softsoil.plant.simulate import drive, simulate
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.drive import CHANNEL_UNITS, Recording
from softsoil.symbolic.soil import CLAY, SANDY_LOAM

LEFT = Manoeuvre("left", Sine(0.3, 3.0), Speed(5.0))
RIGHT = Manoeuvre("right", Sine(-0.3, 3.0), Speed(5.0))


def test_recording_has_the_channels_of_the_shared_drives() -> None:
    recording = simulate(LEFT, CLAY, 0.24)
    assert set(CHANNEL_UNITS) <= set(recording.channels)
    assert "true_fy_rr" in recording.truth
    assert len(recording) == 20
    assert recording.dt == pytest.approx(0.012)


def test_drive_in_the_mirror() -> None:
    reference = load_plant_vehicle()
    # The shaft's torque rolls the body to one side: not a mirrored thing.
    vehicle = replace(reference, machine=reference.machine._replace(torque_reaction=0.0))
    left, right = (simulate(m, CLAY, 3.0, vehicle=vehicle) for m in (LEFT, RIGHT))
    # The steering link's own small asymmetry (a_2 of the command's polynomial) is what is left.
    for name in ("omega_z", "v", "y"):
        assert np.max(np.abs(left[name] + right[name])) < 0.05 * np.max(np.abs(left[name])), name
    assert np.max(np.abs(left["omega_fl"] - right["omega_fr"])) < 0.5


def test_same_call_same_bits() -> None:
    sensors = Sensors("good", dropout=0.05, outliers=0.01)
    a, b = (simulate("multi", SANDY_LOAM, 1.2, sensors=sensors, seed=3) for _ in range(2))
    for name in a.channels:
        assert np.array_equal(a[name], b[name], equal_nan=True), name
    other = simulate("multi", SANDY_LOAM, 1.2, sensors=sensors, seed=4)
    assert not np.array_equal(a["u"], other["u"], equal_nan=True)


@pytest.mark.parametrize(("share", "gap"), [(0.3, 0.5), (0.8, 0.012), (0.8, 0.024)])
def test_as_many_rows_are_lost_as_asked_for(share, gap) -> None:
    t = 0.012 * np.arange(20000)
    drive = Recording("long", {"t": t, "u": np.full(len(t), 5.0)})
    lost = np.isnan(Sensors(dropout=share, gap=gap).apply(drive, 1)["u"])
    assert lost.mean() == pytest.approx(share, abs=0.05)


def test_save_and_resume_to_the_same_bits(tmp_path) -> None:
    effects = Effects(steer_delay=0.1, steer_lag=0.05, bank=0.03)
    whole = Plant(CLAY, effects=effects, start=Start(u=5.0))
    drive(whole, LEFT, 1.2)
    whole.save(tmp_path / "plant.npz")
    resumed = Plant.load(tmp_path / "plant.npz")
    one, two = drive(whole, LEFT, 1.2), drive(resumed, LEFT, 1.2)
    for name in one.channels:
        assert np.array_equal(one[name], two[name]), name


def test_a_recording_names_the_soil_of_its_plant(tmp_path) -> None:
    assert simulate(LEFT, SANDY_LOAM, 0.024).meta["soil"] == "sandy_loam"
    plant = Plant(SANDY_LOAM, start=Start(u=5.0))
    plant.advance(np.zeros((0, 3)))
    assert plant.time == 0.0 and simulate(LEFT, CLAY, 0.024, plant=plant).meta["soil"] == "sandy_loam"
    plant.save(tmp_path / "plant.npz")
    assert Plant.load(tmp_path / "plant.npz").soil.name == "sandy_loam"


def test_a_replay_of_rows_between_the_plants_steps_is_refused() -> None:
    drive = simulate(LEFT, CLAY, 0.6)
    t = 0.0125 * np.arange(len(drive))
    other = Recording("odd", {**drive.channels, "t": t})
    with pytest.raises(ValueError, match=r"odd: expected rows every multiple of 0\.002 s, found every 0\.0125 s"):
        replay(other, CLAY, 0.1, 0.4)


def test_step_holds_its_command_and_checks_it() -> None:
    plant = Plant(CLAY, start=Start(u=5.0))
    sample = plant.step((0.1, 0.3, 0.0))
    assert sample["t"] == pytest.approx(0.012)
    assert sample["steer"] == 0.1
    with pytest.raises(ValueError, match="throttle"):
        plant.step((0.1, 1.3, 0.0))
    with pytest.raises(ValueError, match="multiple"):
        plant.step((0.1, 0.3, 0.0), 0.003)


def test_brakes_stop_the_vehicle() -> None:
    plant = Plant(SANDY_LOAM, start=Start(u=4.0))
    for _ in range(200):
        sample = plant.step((0.0, 0.0, 1.0))
    assert abs(sample["u"]) < 0.1


@pytest.mark.parametrize(
    ("effects", "channel", "sign"),
    [
        (Effects(bank=0.08), "v", -1),
        (Effects(wind=(0.0, 900.0)), "v", 1),
        (Effects(yaw_moment=1000.0), "omega_z", 1),
        (Effects(steer_offset=0.05), "omega_z", 1),
        (Effects(drag=500.0), "u", -1),
        (Effects(grade=0.05), "u", -1),
        (Effects(rear_toe=(-0.05, -0.05)), "omega_z", 1),
        (Effects(bearing=(0.0, 400.0, 0.0, 0.0)), "omega_z", -1),
    ],
)
def test_effects_push_where_they_should(effects: Effects, channel: str, sign: int) -> None:
    straight = Manoeuvre("straight", Sine(0.0), Speed(5.0, gain=0.0, base=0.2))
    plain, pushed = (simulate(straight, CLAY, 2.4, effects=e) for e in (Effects(), effects))
    change = float(np.mean((pushed[channel] - plain[channel])[100:]))
    assert sign * change > 0.004


def test_effects_refuse_nonsense() -> None:
    with pytest.raises(ValueError, match="degrees"):
        Effects(bank=5.0)
    with pytest.raises(ValueError, match="steer_delay"):
        Plant(CLAY, effects=Effects(steer_delay=5.0))


def test_sensors() -> None:
    clean = simulate(LEFT, CLAY, 2.4)
    assert np.allclose(Sensors(bias={"omega_z": 0.03}).apply(clean)["omega_z"], clean["omega_z"] + 0.03)
    late = Sensors(delay={"u": 0.024}).apply(clean)
    assert np.allclose(late["u"][2:], clean["u"][:-2])
    wrapped = clean.with_channels(psi=np.angle(np.exp(1j * (clean["psi"] + np.pi - 0.05))))
    late = Sensors(delay={"psi": 0.03}).apply(wrapped)["psi"]
    assert np.ptp(wrapped["psi"]) > 6.0 and np.abs(np.angle(np.exp(1j * (late - wrapped["psi"])))).max() < 0.1
    moved = Sensors(lever_arm=(1.0, 0.0)).apply(clean)
    assert np.allclose(moved["v"], clean["v"] + clean["omega_z"])
    lost = np.isnan(Sensors(dropout=0.2).apply(clean, 1)["u"]).mean()
    assert 0.05 < lost < 0.5
    assert np.all(np.isfinite(Sensors(dropout=0.2).apply(clean, 1)["steer"]))
    for name in clean.truth:
        assert np.array_equal(Sensors("table5").apply(clean).truth[name], clean.truth[name])
    with pytest.raises(ValueError, match="expected some of"):
        Sensors(bias={"speed": 1.0})


def test_a_step_in_a_logs_steering_stays_a_step() -> None:
    """And all else is interpolated; a fast but steady steering is none."""
    t = np.arange(6) * 0.012
    steer = np.array([0.30, 0.30, -0.01, -0.02, -0.03, -0.04])
    driver = Logged(t, np.stack([steer, np.linspace(0.0, 1.0, 6), np.zeros(6)], axis=1))
    found = driver(np.array([0.012, 0.017, 0.019, 0.030, 0.054]), None)  # type: ignore[arg-type]
    assert found[:, 0] == pytest.approx([0.30, 0.30, -0.01, -0.015, -0.035])
    assert found[:, 1] == pytest.approx(np.array([0.012, 0.017, 0.019, 0.030, 0.054]) / 0.06)


def test_outliers_are_as_large_as_the_noise_says_whatever_else_a_sensor_does() -> None:
    clean = simulate(LEFT, CLAY, 2.4)
    sizes = []
    for more in ({}, {"delay": {"omega_z": 0.2}}, {"scale": {"omega_z": 1.3}}):
        sensors = [Sensors("table5", outliers=share, outlier_size=50.0, **more) for share in (0.0, 0.2)]
        whole, hit = (one.apply(clean, 3)["omega_z"] for one in sensors)
        jumps = np.abs(hit - whole)
        sizes.append(float(jumps[jumps > 0].max()))
    assert sizes == pytest.approx([sizes[0]] * 3, rel=0.05)


def test_a_manoeuvre_without_a_name_says_what_it_is_made_of():
    with pytest.raises(TypeError, match=r"expected a name, a steering and a throttle, found Sine\("):
        Manoeuvre(Sine(0.3, 3.0), Speed(5.0))
