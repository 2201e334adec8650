"""Multiple shooting: predictions over windows of a drive."""

import casadi as ca
import numpy as np
import pytest

from drives import MULTI_LOG, clay_bicycle, clay_drive, reference_vehicle
from softsoil.declaration.model_file import Declaration
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.clock import on_even_clock
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.forward import states_known
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.effect import neutral
from softsoil.symbolic.soil import CLAY
from softsoil.windows.free_windows import FreeWindows, WindowModel
from softsoil.windows.shooting import LONGEST_SMOOTHING, SMOOTHING, Shooting, lengths, shooting_drive, smoothed


@pytest.fixture(scope="module")
def shooting() -> Shooting:
    vehicle = reference_vehicle()
    model = neutral(Declaration(vehicle, CLAY).build(), catalogue(vehicle)["lever_arm"])
    return Shooting(model, shooting_drive(read_drive(MULTI_LOG), model, 1.0), 0.5)


@pytest.mark.parametrize("windows", [[], [0], [1, 4, 5]])
def test_windows_asked_for_are_those_of_all(shooting: Shooting, windows: list[int]) -> None:
    p = np.tile(shooting.model.p.nominal, (2, 1))
    p[1, shooting.model.p.index("velocity_lever")] = 0.5
    chosen = np.array(windows, dtype=int)
    np.testing.assert_array_equal(shooting.residual(p, chosen), shooting.residual(p)[:, chosen])


def test_noisy_states_are_smoothed_for_longer_than_good_ones() -> None:
    clean = on_even_clock(read_drive(MULTI_LOG))
    assert all((lengths(add_noise(clean, noise, 1)) == SMOOTHING).all() for noise in ("none", "good"))
    noisy = add_noise(clean, "table5", 1)
    length = dict(zip(STATE_CHANNELS, lengths(noisy), strict=True))
    assert all(length[name] == LONGEST_SMOOTHING for name in ("x", "y", "u", "v"))
    assert SMOOTHING == length["omega_z"] < length["psi"] < LONGEST_SMOOTHING
    true, (short, long) = clean["v"][:, None], (smoothed(noisy["v"][:, None], clean.dt, one) for one in (SMOOTHING, length["v"]))
    assert np.std(long - true) < 0.75 * np.std(short - true)


def test_no_effect_lets_what_is_measured_depend_on_inputs() -> None:
    """Late and misplaced sensors too: with every effect of the catalogue in it, the declared model can be shot."""
    vehicle = reference_vehicle()
    model = Declaration(vehicle, CLAY).build()
    for effect in catalogue(vehicle).values():
        if effect.name not in model.effects:
            model = neutral(model, effect)
    x, u, p = model.symbols()
    assert len(model.effects) == len(catalogue(vehicle))
    assert not ca.depends_on(ca.cse(model.measurement()(x, u, p)), u)


def test_no_window_begins_in_a_gap_or_runs_across_most_of_one() -> None:
    """A navigation system that is silent for 2.6 s: a window began on a line through its gap, and no effect had any gain."""
    model = clay_bicycle()
    drive = clay_drive()
    silent = (drive.t > 18.0) & (drive.t < 20.6)
    log = drive.with_channels(**{name: np.where(silent, np.nan, drive[name]) for name in STATE_CHANNELS})
    shooting = Shooting(model, shooting_drive(log, model, 2.0), 2.0)
    begun = shooting.drive.t[shooting.rows]
    assert len(begun) > 10 and not ((begun > 18.0) & (begun < 20.6)).any()
    left = shooting.residual(model.p.nominal)
    assert np.isfinite(left).mean(axis=(1, 2)).min() > 0.4 and np.nanmax(np.abs(left)) < 0.01


@pytest.mark.study
def test_forces_that_build_up_are_there_where_a_window_begins() -> None:
    vehicle = reference_vehicle()
    model = bicycle(vehicle, CLAY, effects={**vehicle.effects, "relaxation": {"relaxation_length": 0.6}})
    log = synthetic_drive(model, vehicle.radius, seconds=12.0)
    shooting = Shooting(model, shooting_drive(log, model, 2.0), 1.0)
    assert np.abs(shooting.residual(model.p.nominal)).max(axis=(0, 1))[4] < 1e-3, "0.06 m/s where they began at none"
    free = FreeWindows(WindowModel(model, log.dt), shooting.drive, 1.0, np.ones(6))
    left = free.residual(model.p.nominal, shooting.drive.smooth[free.rows])
    assert np.abs(left.reshape(len(left), -1, 6)[..., 4]).max() < 1e-3


def test_a_state_that_is_measured_once_is_not_known_for_long() -> None:
    drive = clay_drive()
    once = drive.with_channels(psi=np.where(np.arange(len(drive)) == 900, drive["psi"], np.nan))
    near = drive.t[states_known(once, 0.25)]
    assert [near.min(), near.max()] == pytest.approx([drive.t[900] - 0.25, drive.t[900] + 0.25], abs=0.02)
    assert states_known(drive, 0.25).all()
