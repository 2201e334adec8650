"""Calibration: known factors come back, with honest standard errors; what runs cannot fix is said; curve fits recover."""

from dataclasses import replace

import numpy as np
import pytest

from softsoil.calibration.calibration_study import calibrated_law, run_study, study_text
from softsoil.calibration.refit_dallas import G2_SCALE, Matched, fit_branch, match_run, side_force, tables_to_toml
from softsoil.calibration.single_wheel import RunError, by_soil_and_slip, law_for, run_errors
from softsoil.calibration.turn_slip_fit import calibrate, with_soil
from softsoil.figures.single_wheel import draw_force_against_slip
from softsoil.recording.rig import WheelRun
from softsoil.symbolic.laws.bekker import Bekker
from softsoil.symbolic.laws.dallas import Branch, Dallas, Factor, SlipRange
from softsoil.symbolic.laws.dallas_refit import load_tables
from softsoil.symbolic.laws.turn_slip import Factors
from softsoil.symbolic.laws.turn_slip_calibrated import load_factors
from wheel_runs import own_data, sine_run

TRUE = Factors(width=0.9, path=1.15, turn=1.1, entry_time=4e-4)


@pytest.fixture(scope="module")
def runs() -> list[WheelRun]:
    rng = np.random.default_rng(0)
    blank = [sine_run(0.1 + 0.05 * i, 0.45 + 0.1 * i, -0.3 + 0.12 * i, 1500 + 300 * i) for i in range(6)]
    mine = own_data(blank, replace(law_for("turn_slip", blank), factors=TRUE))
    return [replace(r, f_y=r.f_y + 2.0 * rng.standard_normal(len(r))) for r in mine]


def test_known_factors_come_back_within_their_standard_errors(runs):
    found = calibrate(runs)
    assert not found.not_identified
    for name, value in found.values.items():
        true = getattr(TRUE, name)
        assert abs(value - true) < 5 * found.std[name] + 0.002 * abs(true), name
        assert found.std[name] < 0.05
    errors = [e.lateral for e in run_errors(calibrated_law(runs, found), runs)]
    assert max(errors) < 0.015  # the noise of 2 N is 1 % of the smallest peak


def test_a_soil_parameter_can_be_fitted(runs):
    wrong = [replace(r, soil={**r.soil, "c": 1.25 * r.soil["c"]}) for r in runs]
    found = calibrate(wrong, ("width", "path", "turn", "entry_time", "c"))
    assert found.values["c"] == pytest.approx(0.8, abs=0.04)
    assert with_soil(wrong, found)[0].soil["c"] == pytest.approx(runs[0].soil["c"], rel=0.05)


def test_steady_rows_cannot_tell_the_turn(runs):
    steady = [
        replace(r, dt=None, yaw_rate=0 * r.v_x, steer_rate=0 * r.v_x, dv_y=0 * r.v_x, yaw=0 * r.v_x) for r in runs
    ]
    steady = own_data(steady, replace(law_for("turn_slip", steady), factors=Factors(path=1.2)))
    found = calibrate(steady, ("path", "turn"))
    assert found.not_identified == ("turn",)
    assert found.values["path"] == pytest.approx(1.2, rel=1e-3)


def test_a_study_of_runs_that_show_no_parameter_is_refused(runs):
    cohesionless = [replace(r, soil={**r.soil, "k_c": 0.0}) for r in runs]
    with pytest.raises(ValueError, match="expected runs that show one of k_c; found 3 that show none"):
        run_study(cohesionless[:3], cohesionless[3:], ("k_c",))


def test_bad_names_and_no_runs_are_refused(runs):
    with pytest.raises(ValueError, match="found 'grip'"):
        calibrate(runs, ("grip",))
    with pytest.raises(ValueError, match="found none"):
        calibrate([])


def test_one_run_in_time_states_no_error(runs, tmp_path):
    """What differs from run to run it cannot show: 16 runs fitted one by one scatter by 5 to 15 times what their samples say."""
    found = calibrate(runs[:1], ("path",))
    assert found.values["path"] == pytest.approx(TRUE.path, abs=0.2) and np.isnan(found.std["path"])
    study = run_study(runs[:1], runs[4:], ("path",))
    assert study.report["parameters"]["path"]["std"] is None and "not known: one run" in study_text(study)
    (tmp_path / "one.toml").write_text(study.coefficients["calibrated.toml"], encoding="utf-8")
    assert load_factors(tmp_path / "one.toml", "soil").path == pytest.approx(found.values["path"], rel=1e-5)


def test_a_wheel_that_runs_straight_is_a_run_like_others(runs):
    """Its side force is noise, or nothing at all: neither is scaled up to a whole peak."""
    alone = calibrate(runs, ("path", "turn"))
    for noise in (0.0, 2.0):
        force = noise * np.random.default_rng(1).standard_normal(len(runs[0]))
        blank = sine_run(1e-9, 0.45, 0.1, 2500)
        found = calibrate([*runs, replace(blank, f_y=force, f_x=0.0 * force)], ("path", "turn"))
        for name, value in found.values.items():
            assert value == pytest.approx(alone.values[name], abs=0.02) and found.std[name] < 3 * alone.std[name] + 0.005
    with pytest.raises(ValueError, match="expected lateral force, found zeros only, in 2 runs"):
        calibrate([replace(r, f_y=0.0 * r.f_y, f_x=0.0 * r.f_x) for r in runs[:2]])


def test_runs_of_different_contact_steps_are_refused_in_any_order(runs):
    other = replace(runs[1], contact_step=2e-3)
    for mixed in ([runs[0], other], [other, runs[0]]):
        with pytest.raises(ValueError, match="expected one contact_step"):
            calibrate(mixed, ("path",))


def test_a_name_given_twice_is_fitted_once(runs):
    found = calibrate(runs[:2], ("path", "path"))
    assert set(found.values) == {"path"} and not found.not_identified


def test_coefficients_of_a_study_can_be_read_back(runs, tmp_path):
    study = run_study(runs[:4], runs[4:], ("width", "path", "turn", "entry_time"))
    assert study.report["laws"]["turn_slip_calibrated"]["median"] < study.report["laws"]["turn_slip"]["median"]
    (tmp_path / "calibrated.toml").write_text(study.coefficients["calibrated.toml"], encoding="utf-8")
    again = load_factors(tmp_path / "calibrated.toml", "soil")
    assert again.path == pytest.approx(study.found.values["path"], rel=1e-5)
    figure = draw_force_against_slip(runs[4:], tmp_path / "force.png", extra=study.calibrated)
    assert figure.read_bytes()[:4] == b"\x89PNG"


def test_a_calibration_file_that_is_none_is_named(tmp_path):
    path = tmp_path / "c.toml"
    for text, words in (("width = 0.9\n", "sections"), ("[rig]\ngrip = 1.0\n", "grip"), ("[rig\n", "TOML")):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(ValueError, match=words):
            load_factors(path, "rig")


@pytest.mark.parametrize("arm", (0.0, 0.6))
def test_correction_factors_of_a_run_are_matched(arm):
    """Of a wheel, too, whose centre is `arm` m beside the axis that it yaws about: it does not move as the rig does."""
    true = (1.2, 20.0, 0.03)
    branch = Branch(*[Factor(n=(g,)) for g in true])
    blank = [replace(run := sine_run(), v_x=run.v_x - arm * run.yaw_rate)]
    law = Dallas((SlipRange(-1.0, 1.0, branch, branch),), Bekker(), n_range=(0.4, 1.3))
    (run,) = own_data(blank, law)
    found = match_run(side_force(run), run, upper=False)
    assert found.g[0] == pytest.approx(true[0], rel=0.1)
    assert found.g[2] == pytest.approx(true[2], rel=0.15)
    assert abs(found.g[1] - true[1]) < G2_SCALE


def test_function_families_recover_their_own_products(tmp_path):
    rng = np.random.default_rng(1)

    def truth(n, s, load, v):
        return (
            (1 + 0.3 * n - 0.2 * n**2) * (1 + 2 * s),
            (5 + 30 * n) * (1 - s) * (0.7 + 1e-4 * load) * v**-0.9,
            0.03 * (0.5 + n) * (1 + s**2) * (0.8 + 8e-5 * load),
        )

    states = [
        (rng.uniform(0.4, 1.3), rng.uniform(0, 0.16), rng.uniform(1000, 4000), rng.uniform(2.5, 8.5))
        for _ in range(150)
    ]
    branch = fit_branch([Matched(*state, truth(*state)) for state in states])
    for state in states[:30]:
        n, s, load, v = state
        for factor, expected in zip((branch.g_1, branch.g_2, branch.g_3), truth(*state), strict=True):
            assert float(factor(n, s, load, np.log(v))) == pytest.approx(expected, rel=0.05)
    path = tmp_path / "t.toml"
    path.write_text(tables_to_toml({"clay": [SlipRange(0.0, 0.16, branch, branch)]}, "test"), encoding="utf-8")
    (piece,) = load_tables(path)["clay"]
    again = piece.lower.g_2(0.7, 0.1, 2000.0, np.log(5.0))
    assert float(again) == pytest.approx(float(branch.g_2(0.7, 0.1, 2000.0, np.log(5.0))), rel=1e-4)


def test_no_slip_is_left_out_of_the_table():
    errors = [RunError("clay", slip, 0.1, 0.1, 0.0, 0.0) for slip in (-1.2, -1.0, 0.5, 1.0)]
    assert [row["runs"] for row in by_soil_and_slip(errors)] == [2, 2]
