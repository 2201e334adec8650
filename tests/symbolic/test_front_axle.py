"""Front-axle force on the reference simulator's drives, and a sweep over the plant's own rig: nothing fitted on either."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.judges.front_axle import force, judge
from softsoil.calibration.rig_judge import draw_points, judge_point, summary
from softsoil.recording.read import read_drive
from softsoil.symbolic.bicycle import vehicle_law
from softsoil.symbolic.vehicle import load_vehicle

PROJECT = Path(__file__).resolve().parents[2]


@pytest.mark.shared
@pytest.mark.parametrize(
    ("drive", "own", "model"),
    [("paper_sandyloam_n0.70", 0.03, 0.05), ("multi_clay_n0.65", 0.03, 0.05), ("steps_clay_n0.50", 0.1, 0.1)],
)
def test_front_axle_force_on_drives(shared_data, drive, own, model):
    """rms error over peak, with each wheel's own load and with the loads of a 3-DoF model."""
    vehicle = load_vehicle(PROJECT / "vehicles" / "reference.toml")
    function = force(vehicle_law(vehicle, "turn_slip"), vehicle)
    log = read_drive(shared_data / "chrono_vehicle" / f"{drive}.csv.gz")
    log = log.between(2.0, log.t[-1])
    assert judge(log, function, vehicle, own=True)[0] < own
    assert judge(log, function, vehicle, own=False)[0] < model


@pytest.mark.shared
@pytest.mark.parametrize("drive", ["paper_clay_n0.50", "paper_sand_n1.08", "steps_sandyloam_n0.80"])
def test_front_wheels_that_lean_bear_what_they_bear_in_the_log(shared_data, drive):
    """The declared lean takes more than a quarter of the law's error away where the wheels steer far."""
    vehicle = load_vehicle(PROJECT / "vehicles" / "reference.toml")
    function = force(vehicle_law(vehicle, "turn_slip"), vehicle)
    log = read_drive(shared_data / "chrono_vehicle" / f"{drive}.csv.gz")
    log = log.between(2.0, log.t[-1])
    upright, leaning = (judge(log, function, vehicle, True, lean) for lean in (False, True))
    assert leaning[1] < 0.75 * upright[1]
    assert leaning[2] == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("any_soil", [False, True])
def test_law_on_the_plants_own_rig(any_soil):
    """Against another program's stresses: soils of the paper, then any soil under wheels of other sizes."""
    results = [judge_point(point) for point in draw_points(8, seed=11, any_soil=any_soil)]
    found = summary(results, "turn_slip")
    assert found["median"] < 0.014 and found["p95"] < 0.028
    assert found["median"] < summary(results, "bekker")["median"] / 5


def test_points_are_drawn_anew_by_seed_and_alike_by_the_same():
    assert draw_points(4, 1, True) == draw_points(4, 1, True) != draw_points(4, 2, True)
    assert np.ptp([point["radius"] for point in draw_points(9, 1, True)]) > 0.05
