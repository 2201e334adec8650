"""The plant against the independent simulator, and its pictures."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.judges.drive_windows import compare, window
from benchmarks.judges.rig import errors
from softsoil.figures.plant import animation, picture
from softsoil.plant.rig import CHANNELS
from softsoil.plant.rig_sweep import CONDITIONS, draw, sweep
from softsoil.plant.simulate import drive, simulate
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.read import read_drive
from softsoil.symbolic.soil import CLAY, SAND


@pytest.mark.slow
@pytest.mark.shared
def test_rig_matches_the_val_runs(shared_data: Path) -> None:
    found = np.concatenate([errors(p, 8) for p in sorted((shared_data / "chrono_rig").glob("*_val.npz"))])
    assert np.median(found[:, 1]) < 0.05
    assert np.percentile(found[:, 1], 95) < 0.12


@pytest.mark.slow
@pytest.mark.shared
@pytest.mark.parametrize(
    ("name", "begin"), [("multi_clay_n0.65", 17.0), ("multi_sandyloam_n0.70", 2.0), ("paper_sand_n1.08", 2.0)]
)
def test_vehicle_matches_the_drives(shared_data: Path, name: str, begin: float) -> None:
    log = read_drive(shared_data / "chrono_vehicle" / f"{name}.csv.gz")
    found = compare(*window(log, begin))
    assert found["omega_z"] < 0.15
    assert found["v"] < 0.15
    assert min(found["corr_f"], found["corr_r"]) > 0.97
    assert found["ratio"] == pytest.approx(1.0, abs=0.1)
    assert found["c"] == pytest.approx(found["c_log"], rel=0.3)


def test_sweep_has_the_structure_of_the_shared_runs() -> None:
    arrays = sweep(draw(SAND, 2, 1), 1)
    assert arrays["conditions"].dtype == CONDITIONS
    assert arrays["series"].shape == (2, 320, 7)
    assert arrays["t"][0] == 1.0
    assert list(arrays["channels"][:2]) == ["wheel_yaw", "omega"]
    assert np.all(np.isfinite(arrays["series"]))


def test_the_sweep_takes_the_references_contact_search() -> None:
    """Which makes the wheel as if a little larger: at the same speed and spin the soil holds it back more, by up to 40 N m."""
    conditions = draw(CLAY, 3, 2)
    moments = [sweep(conditions, 1, cast)["series"][:, :, CHANNELS.index("my")].mean(axis=1) for cast in (False, True)]
    assert np.all(moments[0] - moments[1] > 2.0)
    assert np.all(moments[0] - moments[1] < 40.0)


def test_pictures(tmp_path: Path) -> None:
    plant = Plant(CLAY, start=Start(u=5.0))
    recording = simulate("paper", CLAY, 0.6, plant=plant)
    assert picture(recording, plant, tmp_path / "drive.png").stat().st_size > 5000
    assert animation(recording, tmp_path / "drive.gif", 5).stat().st_size > 5000


def test_time_goes_on_when_a_plant_drives_on() -> None:
    plant = Plant(CLAY, start=Start(u=5.0))
    one = simulate("straight", CLAY, 0.24, plant=plant)
    two = simulate("straight", CLAY, 0.24, plant=plant)
    assert two.t[0] == pytest.approx(one.t[-1] + 0.012)
    with pytest.raises(ValueError, match="multiple"):
        drive(plant, None, 1.0, 0.003)  # type: ignore[arg-type]
