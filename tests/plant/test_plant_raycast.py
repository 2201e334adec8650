"""The reference simulator's ray cast: never above the wheel, at most as far below as is said, and what follows for the plant."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.judges.drive_windows import compare, window, with_the_others_steering
from softsoil.plant.bed import SoilBed
from softsoil.plant.kernel import kernel
from softsoil.plant.reference.raycast import EARLY, EDGE, ray_hit
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.read import read_drive
from softsoil.symbolic.soil import CLAY

RADIUS, WIDTH, RAY = 0.330229, 0.2121, 0.5


@kernel
def _hits(points, ry, rz, radius, half_width, out):
    simplex, share = np.empty((4, 3)), np.empty(4)
    for k in range(points.shape[0]):
        out[k] = ray_hit(points[k, 0], points[k, 1], points[k, 2], ry, rz, radius, half_width, simplex, share)


def hits(x: np.ndarray, y: np.ndarray, start: float, lean: float = 0.0) -> np.ndarray:
    """Heights (m, in the frame of the wheel's centre) at which vertical rays from `start` meet a wheel that leans; inf where
    they do not."""
    c, s = np.cos(lean), np.sin(lean)
    local = np.stack([x, c * y + s * start, -s * y + c * start], axis=1)
    met = np.empty(len(x))
    _hits(local, RAY * s, RAY * c, RADIUS, 0.5 * WIDTH, met)
    return np.where(met >= 0, start + RAY * met, np.inf)


def test_hits_lie_below_the_wheel_by_no_more_than_is_said() -> None:
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-0.2, 0.2, 5000), rng.uniform(-0.09, 0.09, 5000)
    for start in (-0.72, -0.70, -0.68):
        below = -np.sqrt(RADIUS**2 - x**2) - hits(x, y, start)
        assert below.min() > -1e-9
        assert 8e-3 < below.max() < EARLY
        assert 2e-3 < below.mean() < 3.5e-3


def test_hits_are_those_of_a_single_precision_library() -> None:
    """How far below the cylinder (mm) the ray test of Bullet 2 (panda3d 1.10) met one of margin 0.01 m, rays from 0.7 m below."""
    x = np.array([-0.10, -0.04, -0.01, 0.03, 0.07, 0.12])
    measured = {
        -0.06: [1.09, 1.27, 2.72, 1.13, 2.44, 3.20],
        0.01: [0.86, 1.35, 3.99, 0.23, 2.12, 0.68],
        0.03: [1.43, 0.26, 5.17, 8.73, 0.37, 4.88],
        0.09: [0.32, 2.22, 1.16, 1.72, 4.60, 0.23],
        0.104: [-3.36, 0.22, -0.14, 0.05, 1.06, -2.39],
    }
    for y, below in measured.items():
        found = -np.sqrt(RADIUS**2 - x**2) - hits(x, np.full(len(x), y), -0.7)
        assert 1e3 * found == pytest.approx(np.array(below), abs=0.05)


def test_a_ray_beside_the_wheel_misses_it() -> None:
    x = np.linspace(-0.2, 0.2, 41)
    assert np.all(np.isinf(hits(x, np.full(41, 0.5 * WIDTH + 0.03), -0.7)))
    assert np.all(np.isinf(hits(np.array([RADIUS + 0.03]), np.zeros(1), -0.7)))


def test_edges_are_rounded() -> None:
    """At the very edge the underside is up to EDGE higher than the cylinder's: never more."""
    x = np.linspace(-0.1, 0.1, 41)
    above = hits(x, np.full(41, 0.5 * WIDTH - 1e-4), -0.7) + np.sqrt(RADIUS**2 - x**2)
    assert above.max() > 1e-3
    assert above.max() < EDGE


def test_a_wheel_that_leans_is_met_lower_on_the_side_it_leans_to() -> None:
    """Its axle points up on the left, by 0.1: the underside falls by 12 mm over 0.12 m to the right."""
    under = RADIUS * np.sin(0.1)
    left, right = hits(np.zeros(2), np.array([under + 0.06, under - 0.06]), -0.7, lean=0.1)
    assert left - right == pytest.approx(0.012, abs=0.01)


def test_the_soil_bears_more_under_a_wheel_that_is_met_too_low() -> None:
    loads = []
    for cast in (False, True):
        bed = SoilBed(CLAY, cast=cast)
        loads.append(bed.touch((0.013, 0.007, RADIUS - 0.02)).force[2])
    assert 1.02 * loads[0] < loads[1] < 1.5 * loads[0]


def test_a_plant_goes_on_as_it_was_saved(tmp_path: Path) -> None:
    plant = Plant(CLAY, start=Start(u=5.0), cast=True)
    plant.step((0.1, 0.3, 0.0), 0.024)
    plant.save(tmp_path / "here.npz")
    again = Plant.load(tmp_path / "here.npz")
    there, here = plant.step((0.2, 0.3, 0.0), 0.024), again.step((0.2, 0.3, 0.0), 0.024)
    assert np.array_equal(there.row, here.row)
    exact = Plant(CLAY, start=Start(u=5.0))
    exact.step((0.1, 0.3, 0.0), 0.024)
    assert not np.array_equal(exact.step((0.2, 0.3, 0.0), 0.024).row, here.row)


@pytest.mark.slow
@pytest.mark.shared
@pytest.mark.parametrize(
    ("name", "begin", "speed"),
    [
        ("effect_bank", 2.0, 0.01),
        ("effect_wind", 17.0, 0.01),
        ("multi_sandyloam_n0.55", 2.0, 0.01),
        ("steps_sandyloam_n0.80", 2.0, 0.03),
    ],
)
def test_with_it_the_plant_follows_the_reference_closely(shared_data: Path, name: str, begin: float, speed: float) -> None:
    log = read_drive(shared_data / "chrono_vehicle" / f"{name}.csv.gz")
    ours, theirs = window(log, begin, vehicle=with_the_others_steering(), cast=True)
    for wheel in ("fl", "fr", "rl", "rr"):
        assert abs(np.mean(ours.truth[f"true_z_{wheel}"] - theirs.truth[f"true_z_{wheel}"])) < 0.5e-3
    found = compare(ours, theirs)
    assert found["omega_z"] < 0.04
    assert found["v"] < 0.06
    assert found["u"] < speed
    assert found["gain_f"] == pytest.approx(1.0, abs=0.02)
    assert found["gain_r"] == pytest.approx(1.0, abs=0.03)
