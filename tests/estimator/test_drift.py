"""The drift monitor: no alarm where corrections cancel, one with its class where they go to one side."""

import numpy as np
import pytest

from drives import clay_bicycle, clay_drive, reference_vehicle
from softsoil.estimator.drift import CHANNELS, DriftMonitor, DriftRules, likely_classes
from softsoil.estimator.terrain import estimate_terrain
from softsoil.recording.noise import add_noise
from softsoil.symbolic.catalogue import catalogue
from softsoil.symbolic.effects.bank import effect as bank

STEP = 0.024
NAMES = [channel.name for channel in CHANNELS]


def effects():
    return list(catalogue(reference_vehicle()).values())


def fed(index: int, rate: float, seconds: float, scale: float = 1.0) -> DriftMonitor:
    """A monitor whose state `index` is corrected by `rate` per second, straight ahead."""
    monitor = DriftMonitor(np.full(len(CHANNELS), scale))
    for k in range(1, round(seconds / STEP)):
        moved = np.zeros(6)
        moved[index] = rate * STEP
        monitor.see(k * STEP, moved, 0.0, (0.0, 6.0, 0.0), 0.0)
    return monitor


@pytest.mark.parametrize(("index", "name"), [(0, "along"), (1, "side"), (2, "heading"), (3, "speed"), (4, "lateral"), (5, "yaw")])
def test_an_alarm_comes_when_page_says_so(index, name):
    """S grows by rate - allowance per second, from `after` on: the alarm is at limit over that."""
    channel = CHANNELS[NAMES.index(name)]
    rate = 5.0 * channel.allowance
    due = DriftRules().after + channel.limit / (rate - channel.allowance)
    monitor = fed(index, -rate, due + 1.0)
    assert monitor.alarm is not None
    assert monitor.alarm[0] == pytest.approx(due, abs=2 * STEP) and monitor.alarm[1] == NAMES.index(name)
    assert fed(index, 0.9 * channel.allowance, 60.0).alarm is None


def test_a_noisy_sensor_raises_the_limit_and_a_sum_comes_back():
    quiet, noisy = fed(2, 0.02, 8.0), fed(2, 0.02, 8.0, scale=10.0)
    assert quiet.level > 1.0 and noisy.level == pytest.approx(quiet.level / 10.0, rel=0.5)
    for k in range(round(60 / STEP)):
        quiet.see(8.0 + k * STEP, np.zeros(6), 0.0, (0.0, 6.0, 0.0), 0.0)
    assert quiet.level == 0.0 and quiet.alarm is not None


def test_corrections_are_taken_in_the_vehicles_frame():
    monitor = DriftMonitor(np.ones(len(CHANNELS)))
    for k in range(1, round(8 / STEP)):
        monitor.see(k * STEP, [0.0, 0.2 * STEP, 0, 0, 0, 0], 0.0, (np.pi / 2, 6.0, 0.0), 0.0)
    assert NAMES[monitor.channel] == "along"


def test_classes_are_those_of_the_catalogue():
    assert likely_classes(CHANNELS[NAMES.index("heading")], effects()) == ["sensor"]
    assert likely_classes(CHANNELS[NAMES.index("yaw_steering")], effects())[0] == "steering"
    assert likely_classes(CHANNELS[NAMES.index("n")], effects())[0] == "soil"
    with pytest.raises(ValueError, match="expected an effect"):
        likely_classes(CHANNELS[0], [bank(reference_vehicle())])


def test_a_gyro_that_gains_a_bias_is_named_within_five_seconds_and_a_clean_drive_is_not():
    clean = add_noise(clay_drive(), "good", 4)
    gyro = clean["omega_z"].copy()
    begins = int(np.searchsorted(clean.t, 15.0))
    gyro[begins:] += 0.05
    assert estimate_terrain(clean, clay_bicycle(), 0.6).drift is None
    found = estimate_terrain(clean.with_channels(omega_z=gyro), clay_bicycle(), 0.6).drift
    assert found is not None and 15.0 <= found.t <= 20.0 and found.likely == "sensor"


@pytest.mark.parametrize(("bias", "alarms"), [(0.05, False), (-0.08, False), (0.4, True)])
def test_an_accelerometers_own_bias_is_no_drift(bias, alarms):
    drive = add_noise(clay_drive(), "good", 4)
    found = estimate_terrain(drive.with_channels(a_x_imu=drive["a_x_imu"] + bias), clay_bicycle(), 0.6).drift
    assert (found is not None) is alarms and (found is None or found.channel == "speed")
