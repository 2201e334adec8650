"""On drives of the own bicycle with Table-5 noise, n ends at the truth and the filter knows how sure it is."""

from dataclasses import replace

import numpy as np
import pytest

from drives import clay_bicycle, clay_drive, reference_vehicle
from softsoil.estimator.terrain import estimate_terrain
from softsoil.estimator.tuning import EXACT_MODEL
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.noise import add_noise
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.soil import CLAY

SEEDS = 7


@pytest.fixture(scope="module")
def estimates():
    return [
        estimate_terrain(add_noise(clay_drive(), "table5", seed), clay_bicycle(), CLAY.n + 0.2, tuning=EXACT_MODEL)
        for seed in range(SEEDS)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("axle", ["n_front", "n_rear"])
def test_n_ends_at_the_truth_from_a_guess_off_by_0_2(estimates, axle):
    errors = np.array([abs(getattr(e, axle)[-1] / CLAY.n - 1) for e in estimates])
    assert np.median(errors) <= 0.015
    assert errors.max() <= 0.05


@pytest.mark.slow
def test_nis_lies_in_its_band_as_often_as_it_should(estimates):
    inside = np.array([e.nis_inside_95 for e in estimates])
    assert inside.min() >= 0.90
    assert inside.max() <= 0.99


@pytest.mark.slow
def test_truth_lies_within_the_stated_uncertainty(estimates):
    away = np.array([abs(e.n_front[-1] - CLAY.n) / e.n_front_std[-1] for e in estimates])
    assert np.mean(away < 3) >= 0.9


def test_estimate_follows_the_soil_and_not_its_first_guess():
    model = clay_bicycle()
    drive = synthetic_drive(model, reference_vehicle().radius, p=model.p.pack(n_f=0.8, n_r=0.8))
    from_below, from_above = (
        estimate_terrain(add_noise(drive, "table5", 5), model, n0, tuning=EXACT_MODEL) for n0 in (0.6, 1.0)
    )
    assert from_below.n_front[-1] == pytest.approx(0.8, rel=0.05)
    assert from_above.n_front[-1] == pytest.approx(0.8, rel=0.05)


def test_a_drive_after_another_with_one_model_gives_what_it_gives_alone():
    """A filter is kept for the next drive: nothing of the last one, nor of its sensors, stays in it."""
    drive, other = add_noise(clay_drive(), "table5", 3), add_noise(clay_drive(), "good", 4)
    alone = estimate_terrain(drive, nominal_bicycle(reference_vehicle(), CLAY), 0.7)
    model = nominal_bicycle(reference_vehicle(), CLAY)
    estimate_terrain(other, model, 0.4)
    after = estimate_terrain(drive, model, 0.7)
    for name in ("n_front", "n_rear", "n_front_std", "states", "nis"):
        assert np.array_equal(getattr(after, name), getattr(alone, name)), name
    assert after.counts == alone.counts


@pytest.mark.study
def test_another_vehicle_on_another_soil():
    """A light, short vehicle on soil that is none of the classes: nothing is tied to the reference."""
    vehicle = reference_vehicle().with_(
        mass=620.0,
        l_f=0.95,
        l_r=0.85,
        yaw_inertia=380.0,
        track=1.0,
        h_cg=0.45,
        radius=0.25,
        width=0.16,
        load_offset=0.0,
    )
    soil = CLAY.with_(name="silt", k_phi=1.1e6, k_c=8e3, c=2500.0, phi=0.35, k=0.018, n=0.85)
    model = nominal_bicycle(vehicle, soil)
    drive = synthetic_drive(model, vehicle.radius, speed=4.0, swing=0.5)
    found = estimate_terrain(add_noise(drive, "table5", 11), model, 0.65, tuning=EXACT_MODEL)
    assert found.n_front[-1] == pytest.approx(0.85, rel=0.08)
    assert found.n_rear[-1] == pytest.approx(0.85, rel=0.08)
    assert 0.9 <= found.nis_inside_95 <= 0.99


@pytest.mark.parametrize("dt", [pytest.param(0.004, marks=pytest.mark.study), 0.05])
def test_rows_may_be_finer_or_coarser_than_the_papers(dt):
    fine = synthetic_drive(clay_bicycle(), reference_vehicle().radius, dt=0.002)
    every = round(dt / 0.002)
    drive = replace(fine, channels={name: values[::every] for name, values in fine.channels.items()})
    found = estimate_terrain(add_noise(drive, "table5", 8), clay_bicycle(), CLAY.n + 0.2, tuning=EXACT_MODEL)
    assert found.n_front[-1] == pytest.approx(CLAY.n, rel=0.15)


def test_dropped_and_broken_measurements_are_left_out_and_counted():
    noisy = add_noise(clay_drive(), "table5", 3)
    v, x = noisy["v"].copy(), noisy["x"].copy()
    v[500:700] = np.nan
    x[1000] = 1e6
    found = estimate_terrain(noisy.with_channels(v=v, x=x), clay_bicycle(), 0.7, tuning=EXACT_MODEL)
    assert found.counts.invalid["v"] == 200
    assert found.counts.gated == {"x": 1}
    assert found.n_front[-1] == pytest.approx(CLAY.n, rel=0.05)
