"""Stamps of samples that the horizon in C meets, a horizon that never began, and what C measures of a channel's noise."""

import numpy as np
import pytest

from c_folders import declared, library
from drives import reference_vehicle
from softsoil.codegen.c_library.build import FLAGS
from softsoil.codegen.c_library.horizon_binding import CHorizon
from softsoil.codegen.c_library.statuses import STATUSES
from softsoil.codegen.sampling import STEP
from softsoil.estimator.evidence import sensor_variance, unexplained
from softsoil.estimator.modes import run_horizon
from softsoil.estimator.moving_horizon import LEAST_NOISE, HorizonRules, drive_windows
from softsoil.files.package_data import example_logs
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.recording.states import sensor_std
from softsoil.windows.shooting import shooting_drive

pytestmark = pytest.mark.compiler
LATE = [name for name, _ in STATUSES].index("MEASUREMENT_LATE")
CIRCLING = 0.15 + 0.05 * np.sin(1.5 * STEP * np.arange(round(16.0 / STEP) + 1))
"""rad: the steering angle of a vehicle that turns left all along."""
WRONG = 6.0
"""s: when a stamp is wrong, or the clock set back."""


def pushed(stamps):
    """The horizon after a log whose stamps (s) are `stamps(t)`, and how many of its samples were late."""
    recording = add_noise(read_drive(example_logs()[0]), "good", 2).between(0.0, 14.0)
    drive, c, late = shooting_drive(recording, declared("tracks").build(), 0.0), CHorizon(library("tracks", FLAGS)), 0
    c.options.dt = drive.dt
    c.start(drive.t[0])
    for t, u, y in zip(drive.t, drive.inputs, drive.measured, strict=True):
        late += c.push(u, y, stamps(float(t))) == LATE
        c.update()
    return c, late


@pytest.mark.parametrize(
    "stamps",
    [
        pytest.param(lambda t: t + 3600.0 * (abs(t - WRONG) < 0.006), id="one an hour ahead"),
        pytest.param(lambda t: t + 20.0 * (abs(t - WRONG) < 0.03), id="some ahead"),
        pytest.param(lambda t: t - 500.0 * (t > WRONG), id="clock set back"),
    ],
)
def test_a_wrong_stamp_costs_a_second(stamps):
    right, none = pushed(lambda t: t)
    c, late = pushed(stamps)
    assert none == 0 and 60 < late < 100
    assert right.head.windows - 12 <= c.head.windows < right.head.windows
    assert c.n[0] == pytest.approx(right.n[0], rel=0.05)


@pytest.mark.parametrize("pause", (0.0, 100.0))
def test_a_change_of_soil_keeps_its_time_where_the_logger_pauses_after_it(pause, shared_data):
    """The soil changes near 16 s and that is found seconds later, behind a pause: rows were counted back from there."""
    recording = read_drive(shared_data / "chrono_vehicle" / "change_clay_n0.50_to_0.75.csv.gz").between(0.0, 25.0)
    drive, c = shooting_drive(recording, declared("tracks").build(), 0.0), CHorizon(library("tracks", FLAGS))
    c.options.dt = drive.dt
    c.start(drive.t[0])
    for t, u, y in zip(drive.t, drive.inputs, drive.measured, strict=True):
        c.push(u, y, t + (pause if t > 17.5 else 0.0))
        c.update()
    assert c.head.changes == 1
    assert 15.0 < c.head.changed_at < 17.0


def test_samples_of_a_second_source_that_is_always_late_are_left_out():
    c, late = CHorizon(library("tracks", FLAGS)), 0
    for k in range(400):
        assert c.push(np.zeros(len(c.library.formulation["inputs"])), np.full(6, np.nan), 0.012 * (k + 1)) != LATE
        late += c.push(np.zeros(len(c.library.formulation["inputs"])), np.full(6, np.nan), 0.012 * (k - 20)) == LATE
    assert late == 400


@pytest.mark.parametrize("first", [1.005, 40.0])
def test_a_slow_source_that_is_always_late_is_left_out(first):
    """Once in about a second, among samples that are in time: it is no clock that was set back."""
    c, nothing = CHorizon(library("tracks", FLAGS), 50.0), np.full(6, np.nan)
    u = np.zeros(len(c.library.formulation["inputs"]))
    for k in range(500):
        assert c.push(u, nothing, 50.0 + 0.012 * (k + 1)) != LATE
        if k % 83 == 0:
            assert c.push(u, nothing, first + 1.005 * (k // 83)) == LATE


def test_zeros_are_no_verdict_to_drive_on():
    """A horizon in static memory that was never started, or whose start was refused."""
    c = CHorizon(library("tracks", FLAGS))
    assert c.words[0] == "not_excited" and "identified" in c.words[1:]
    assert c.words[c.head.verdict] == "not_excited"


@pytest.mark.parametrize("every", [1, 2, 5])
def test_noise_of_a_channel_that_is_slower_than_the_rows_is_measured(every):
    """At the channel's own samples: without it no drive slower than 75 Hz was asked what its model leaves."""
    rng, dt = np.random.default_rng(1), 0.012
    t = dt * np.arange(1500)
    values = 0.3 * np.sin(t) + 0.01 * rng.standard_normal(len(t))
    values[np.arange(len(t)) % every > 0] = np.nan
    variance, error = sensor_variance(values, dt)
    assert variance == pytest.approx(1e-4, rel=0.25) and error < 0.25 * variance


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize("every", [1, 2])
def test_what_the_model_leaves_is_asked_as_in_python(every, turning):
    """Of a yaw rate at the rows' rate and at half of it; and where the vehicle turns one way, whose mean is motion, too."""
    model = declared("tracks").build()
    clean = read_drive(example_logs()[0]).between(0.0, 16.0)
    if turning:
        clean = synthetic_drive(model, reference_vehicle().radius, seconds=16.0, steer=CIRCLING)
    recording = add_noise(clean, "good", 2)
    kept = np.where(np.arange(len(recording)) % every == 0, recording["omega_z"], np.nan)
    recording = recording.with_channels(omega_z=kept)
    windows = drive_windows(recording, model, 2.0, HorizonRules())
    python, c = run_horizon(windows, 0.6, True, HorizonRules()), CHorizon(library("tracks", FLAGS))
    drive = windows.drive
    c.options.dt, c.options.start_up = drive.dt, 2.0
    c.options.r_std[:] = sensor_std(recording, LEAST_NOISE)
    c.options.guess[:] = [0.6] * len(c.names)
    c.start(drive.t[0])
    for t, u, y in zip(drive.t, drive.inputs, drive.measured, strict=True):
        c.push(u, y, t)
        c.update()
    shares, errors = unexplained(windows, python)
    for j, name in enumerate(("v", "omega_z")):
        assert c.head.unexplained[j] == pytest.approx(shares[name], abs=2.0 * errors[name]), name
