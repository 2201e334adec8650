"""The closed loop on the plant, with the paper's plain bicycle in estimator and controller: small, but the whole loop."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.guide.json_page import undescribed
from nmpc_problem import small_ocp
from softsoil.commands.cli import app
from softsoil.commands.drive import as_json, recovered
from softsoil.control.courses import WARM_UP, straight
from softsoil.control.live_horizon import LiveHorizon
from softsoil.control.nmpc import Nmpc
from softsoil.control.path import Path
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.verdict import WORDS
from softsoil.figures.drive import animate, draw_drive
from softsoil.files.package_data import VEHICLES
from softsoil.mpc_demo.closed_loop import DEADLINE, ClosedLoop, LoopLog
from softsoil.mpc_demo.closed_loop_parts import OTHERS, TICK, Faults, NoisySensors
from softsoil.mpc_demo.scenarios import scenarios
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle


def course(name: str = "obstacles_clay"):
    """The course cut short: the warm-up and one obstacle after it."""
    full = scenarios()[name]
    path = Path(straight().points[: int(66 / 0.25)])
    return replace(full, path=path, obstacles=full.obstacles[:1], speed=6.0)


@lru_cache(maxsize=1)
def loop() -> ClosedLoop:
    return ClosedLoop(small_ocp(), Nmpc(small_ocp()), wall=False)


@lru_cache(maxsize=4)
def log(faulty: bool = False, failing: bool = False) -> LoopLog:
    faults = Faults(dropout=(4.0, 7.0), burst=(2.0, 3.0)) if faulty else Faults()
    return loop().run(course(), "n_estimated", 1, faults, (lambda k: 60 <= k < 100) if failing else None)


def test_the_course_is_driven_and_the_obstacle_left_alone():
    run = log()
    assert run.finished and not run.collided and run.failures == 0
    assert run.clearance < 1.5, "the obstacle is in the way"


def test_a_run_can_be_repeated():
    again = loop().run(course(), "n_estimated", 1)
    np.testing.assert_array_equal(again.column("truth"), log().column("truth"))


def test_dropout_and_outliers_leave_the_loop_stable():
    run = log(faulty=True)
    assert run.finished and run.gated > 0
    assert np.abs(run.column("error")).max() < 3.5
    astray = np.abs(run.column("estimate")[:, :2] - run.column("truth")[:, :2])
    assert astray.max() < 2.0, "outliers of 14 m are not taken for where the vehicle is"


def test_failed_solves_have_a_status_and_the_vehicle_slows_down():
    run = log(failing=True)
    failed = run.column("status") == "BAD_STATE"
    assert run.failures == failed.sum() == 40
    late = run.column("t")[failed][0] + 1.0
    during = (run.column("t") > late + 0.5) & failed
    assert run.column("safe")[during].all()
    speed = run.column("truth")[:, 3]
    assert speed[during][-1] < speed[0] - 0.5
    assert not run.collided


@pytest.mark.parametrize(("where", "radius"), ((22.0, 6.0), (26.0, 25.0)))
def test_before_what_it_cannot_pass_the_vehicle_stops(where, radius):
    wall = np.array([[WARM_UP + where - 10.0 + radius, 0.2, radius, 0.0, 0.0]])
    run = loop().run(replace(course(), obstacles=wall), "n_estimated", 2)
    assert "BLOCKED" in run.column("status")
    assert run.stopped and not run.finished and run.column("halt").any()
    assert run.clearance > 0.3 and run.column("truth")[-1, 3] < 0.5
    assert np.abs(run.column("truth")[:, 5]).max() < 1.5, "no wild turn"


@pytest.mark.study
def test_a_change_of_soil_in_mid_course_is_followed():
    """Clay whose n goes from 0.5 to 0.75: the estimate moves the same way, and no solve fails on the way."""
    run = loop().run(scenarios()["two_soils"], "n_estimated", 3)
    x, n = run.column("truth")[:, 0], run.column("n")
    before, after = n[(x > 60.0) & (x < 74.0)].mean(), n[x > x[-1] - 25.0].mean()
    assert run.finished and run.failures == 0
    assert after - before > 0.1 and np.abs(run.column("error")).max() < 1.0


def test_sensors_are_the_papers_and_faults_are_where_they_should_be():
    plant = Plant(CLAY, start=Start(u=5.0))
    sample = plant.step((0.0, 0.2, 0.0), TICK)
    sensors = NoisySensors(3, Faults(dropout=(1.0, 2.0), burst=(3.0, 4.0)))
    quiet = np.array([sensors.read(0.5, sample) for _ in range(2000)])
    np.testing.assert_allclose(quiet.std(axis=0), sensors.std, rtol=0.1)
    assert np.isnan(sensors.read(1.5, sample)).all()
    wild = np.array([sensors.read(3.5, sample) for _ in range(200)])
    assert np.all(np.abs(wild - quiet.mean(axis=0)).max(axis=0) > 8 * sensors.std)


def test_all_sensors_may_be_noisy():
    """As many measurements as the driver takes, each as noisy as it is declared; the states as without."""
    sample = Plant(CLAY, start=Start(u=5.0)).step((0.1, 0.2, 0.0), TICK)
    few, all_of_them = NoisySensors(3), NoisySensors(3, noisy="all")
    first, second = few.measure(0.5, sample), all_of_them.measure(0.5, sample)
    assert first["omega_fl"] == sample["omega_fl"] and "steer" not in first
    assert all(second[name] == first[name] for name in ("x", "y", "psi", "u", "v", "omega_z"))
    rows = np.array([[all_of_them.measure(0.5, sample)[name] for name in OTHERS] for _ in range(2000)])
    np.testing.assert_allclose(rows.std(axis=0), all_of_them.other_std, rtol=0.1)
    np.testing.assert_allclose(rows.mean(axis=0), [sample[name] for name in OTHERS], atol=4 * all_of_them.other_std.max() / 44)
    with pytest.raises(ValueError, match="states, all"):
        NoisySensors(3, noisy="some")


def test_paths_project_onto_themselves():
    path = scenarios()["slalom_clay"].path
    for s in (3.0, 50.0, 90.0):
        x, y, psi = path.at(np.array([s]))[0]
        along, left = path.project(x - 0.5 * np.sin(psi), y + 0.5 * np.cos(psi), s)
        assert along == pytest.approx(s, abs=0.1) and left == pytest.approx(0.5, abs=0.05)


def test_json_holds_the_agreed_keys(tmp_path):
    found = as_json([log()])
    entry = found["controllers"]["n_estimated"]
    assert {"tracking_rms", "max_error", "collisions", "solve_ms", "failures"} <= set(entry)
    assert set(entry["solve_ms"]) == {"median", "p99"} and undescribed("drive.json", found) == []
    assert draw_drive(course(), [log()], tmp_path / "a.png").stat().st_size > 1e4
    assert animate(course(), log(), tmp_path / "a.gif", frames=3).stat().st_size > 1e3


def test_an_estimated_n_has_its_verdict():
    """The horizon's while the estimate is in use; the controllers that are given n have none."""
    judge = LiveHorizon(Declaration(load_vehicle("plant"), CLAY), loop().settings.sensor_std, TICK)
    judged = ClosedLoop(small_ocp(), Nmpc(small_ocp()), wall=False, judge=judge)
    estimated, known = judged.run(course(), "n_estimated", 1), judged.run(course(), "n_true", 1)
    assert estimated.rows[0]["verdict"] == "not_excited" and estimated.rows[0]["n_used"] > estimated.rows[0]["n"]
    first, second = as_json([estimated, known])["runs"]
    assert first["verdict"] == estimated.verdict == judge.verdict in WORDS
    assert second["verdict"] == known.verdict == log().verdict == "not_judged"


def test_recovery_is_the_share_of_what_knowing_is_worth():
    table = {
        name: {"tracking_rms": value} for name, value in (("n_guess", 0.3), ("n_true", 0.2), ("n_estimated", 0.22))
    }
    assert recovered(table) == pytest.approx(0.8)
    table["n_guess"]["tracking_rms"] = 0.205
    assert recovered(table) is None


def test_an_unknown_controller_is_refused():
    with pytest.raises(ValueError, match="expected one of"):
        loop().run(course(), "n_wrong")


def test_solves_are_counted_late_against_the_period():
    run = LoopLog("a", "n_true", 0, rows=[{"solve_ms": 1e3 * DEADLINE + 1, "status": "LATE"}, {"solve_ms": 1.0}])
    assert run.late == 1


def test_the_command_refuses_what_it_does_not_know():
    runner = CliRunner()
    for arguments, word in (
        (["drive", "moon"], "lane_change_clay"),
        (["drive", "--controllers", "n_wrong"], "n_estimated"),
    ):
        result = runner.invoke(app, arguments)
        assert result.exit_code == 2 and word in result.output


@pytest.mark.parametrize(("name", "another"), [("mine", True), ("plant", False), ("heavy", False)])
def test_the_command_says_which_vehicle_it_simulates(name, another, tmp_path, monkeypatch):
    def stop(*_):
        raise ValueError("stop")

    file = tmp_path / f"{name}.toml"
    text = (VEHICLES / "heavy.toml").read_text(encoding="utf-8")
    file.write_text(text.replace('name = "heavy"', f'name = "{name}"'), encoding="utf-8")
    monkeypatch.setattr("softsoil.commands.drive._loop", stop)
    said = CliRunner().invoke(app, ["drive", "--vehicle", str(file), "--out", str(tmp_path / "out")]).output
    assert f"plant: softsoil/vehicles/{'heavy' if name == 'heavy' else 'reference'}_plant.toml" in said
    assert ("found no mine_plant.toml beside its file: the reference vehicle (1378 kg) is simulated" in said) == another
