"""A vehicle that drives laps: what it meets in its own ruts is compacted, and n is that of the fresh soil."""

from dataclasses import replace

import numpy as np
import pytest

import softsoil
from softsoil.checking.usable import usable
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.moving_horizon import estimate_horizon
from softsoil.files.package_data import PLANT_VEHICLE
from softsoil.plant.manoeuvres import PathFollower, Speed
from softsoil.plant.sensors import Sensors
from softsoil.plant.start import Start
from softsoil.windows.shooting import Shooting, shooting_drive

TRUE = 0.5


@pytest.fixture(scope="module")
def laps():
    """Two laps and a half of 9 m around, at 3.5 m/s, on clay of the plant."""
    turned = np.linspace(0.0, 6 * np.pi, 1200)
    path = 9.0 * np.column_stack([np.sin(turned), 1.0 - np.cos(turned)])
    soil = softsoil.load_soil("clay").with_(n=TRUE)
    driver = PathFollower(path, Speed(3.5), look_ahead=3.0)
    return softsoil.simulate(driver, soil, 40.0, sensors=Sensors("good"), seed=3, start=Start(u=3.5))


@pytest.fixture(scope="module")
def model():
    return Declaration(softsoil.load_vehicle(PLANT_VEHICLE), softsoil.load_soil("clay")).build()


@pytest.mark.parametrize("method", [pytest.param("ukf", marks=pytest.mark.study), "horizon"])
def test_n_of_the_first_lap_is_kept(laps, model, method):
    found = softsoil.estimate(laps, model, n0=0.65, method=method)
    late = found.n_front[found.t > 14.0]  # windows end with the first lap, the filter goes on
    assert found.verdict.word == "identified", found.verdict.reason
    assert np.abs(late - TRUE).max() < 0.05 * TRUE
    assert found.changes == ()


def test_in_ruts_n_is_that_of_compacted_soil(laps, model):
    log = usable(laps, model.geometry)
    compacted = estimate_horizon(replace(log, ruts=()), model, 0.65, tied=True, start=2.0)
    assert compacted.n[compacted.t > 18.0, 0].max() > 0.6 and compacted.changes


def test_no_window_runs_in_ruts(laps, model):
    log = usable(laps, model.geometry)
    ((begins, _),) = log.ruts
    assert 15.0 < begins < 18.0
    drive = shooting_drive(log, model, 2.0)
    ends = drive.t[(windows := Shooting(model, drive, 1.0)).rows + windows.steps]
    assert len(ends) > 8 and ends.max() <= begins + 1e-9
    assert softsoil.predict(laps, model, TRUE, 2.5).rows.max() * laps.dt + 2.5 <= begins + 0.02


@pytest.mark.parametrize(("wrong", "cure"), [(-1.0, "sign = -1 for steer"), (0.0, "another column")])
def test_a_steering_that_is_wrong_on_a_circle_is_refused(laps, model, wrong, cure):
    """A driver corrects the angle against the turning, so that it is the mean of both that shows the sign."""
    with pytest.raises(ValueError, match=cure):
        usable(laps.with_channels(steer=wrong * laps["steer"]), model.geometry)
