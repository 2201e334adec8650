"""The yaw inertia that a drive asks for, from the windows of an estimate with another one declared."""

import numpy as np
import pytest

from drives import clay_bicycle, clay_drive, reference_vehicle
from softsoil.estimator.evidence import gather
from softsoil.estimator.inertia import inertia_error
from softsoil.estimator.modes import run_horizon
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.recording.noise import add_noise
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.soil import CLAY


@pytest.fixture(scope="module")
def noisy():
    return add_noise(clay_drive(25.0), "good", 4)


def declared(times: float):
    return nominal_bicycle(reference_vehicle().with_(yaw_inertia=times * reference_vehicle().yaw_inertia), CLAY)


@pytest.mark.parametrize("times", [0.7, 0.9, 1.0, 1.15, 1.4])
def test_the_true_inertia_is_asked_for(noisy, times):
    """One step from the declared value: within a third of the way, and within 4 % where that is right."""
    rules = HorizonRules()
    windows = drive_windows(noisy, declared(times), 1.0, rules)
    share, std = inertia_error(windows, run_horizon(windows, 0.55, True, rules))
    true = 1.0 / times - 1.0
    assert abs(share - true) < max(0.04, abs(true) / 3.0), (share, std)
    assert 0.001 < std < 0.06


def test_the_evidence_has_it_and_a_straight_drive_knows_nothing_of_it():
    rules, straight = HorizonRules(), clay_drive(15.0)
    windows = drive_windows(add_noise(straight, "good", 4), clay_bicycle(), 1.0, rules)
    evidence = gather(windows, (0.55,), True, rules)
    assert abs(evidence.inertia) < 3.0 * evidence.inertia_std + 0.02
    way = np.concatenate([[0.0], np.cumsum(straight["u"][:-1]) * straight.dt])
    still = {name: np.zeros(len(straight)) for name in ("y", "psi", "v", "omega_z", "steer")}
    along = straight.with_channels(x=way, **still)
    windows = drive_windows(add_noise(along, "good", 4), clay_bicycle(), 1.0, rules)
    assert gather(windows, (0.55,), True, rules).inertia_std > 0.5
