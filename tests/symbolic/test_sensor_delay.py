"""Sensors that report late: the effect against a drive whose odometry was shifted in time, which no expansion knows of."""

from dataclasses import replace

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.mpc_demo.synthetic import STEP, synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.effect import add_effect
from softsoil.symbolic.soil import CLAY
from softsoil.windows.shooting import Shooting, shooting_drive

ROWS = 15
LATE = ROWS * STEP


@pytest.fixture(scope="module")
def plain():
    return bicycle(reference_vehicle().with_(effects={}), CLAY)


@pytest.fixture(scope="module")
def late(plain):
    """A drive of the model, its odometry LATE s behind everything else."""
    t = STEP * np.arange(round(16.0 / STEP) + 1)
    drive = synthetic_drive(plain, reference_vehicle().radius, seconds=16.0, steer=MultiSine(0.3, seed=2)(t))
    shifted = {name: values[ROWS:] for name, values in drive.channels.items()}
    shifted |= {name: drive[name][:-ROWS] for name in STATE_CHANNELS}
    return replace(drive, channels=shifted)


def errors(model, drive):
    """(6,) rms of what two seconds of prediction miss, over the rms of the channel's own change."""
    shooting = Shooting(model, shooting_drive(drive, model, 2.0), 2.0)
    change = shooting.recorded - shooting.recorded[:, :1]
    return np.sqrt(np.mean(shooting.residual(model.p.nominal) ** 2, axis=(0, 1)) / np.mean(change**2, axis=(0, 1)))


def test_late_sensors_are_predicted_as_well_as_prompt_ones(plain, late):
    told = add_effect(plain, catalogue(reference_vehicle())["sensor_delay"], {"pose_delay": LATE, "rate_delay": LATE})
    prompt, found = errors(plain, late), errors(told, late)
    rates = [STATE_CHANNELS.index(name) for name in ("v", "omega_z")]
    assert np.all(prompt[rates] > 0.15)
    assert np.all(found < 0.01)  # a first-order expansion leaves up to 0.14


def test_a_late_pose_shows_in_the_pose_alone(plain):
    told = add_effect(plain, catalogue(reference_vehicle())["sensor_delay"], {"pose_delay": 0.2, "rate_delay": 0.0})
    x, u = told.x.pack(u=5.0, omega_z=0.3), told.u.nominal
    outputs = told.measurement()(x, u, told.p.nominal).full()[:, 0]
    assert outputs == pytest.approx(np.array([-5.0 * 0.2, -0.2 * reference_vehicle().l_f * 0.3, -0.06, 5.0, 0.0, 0.3]), abs=1e-9)
