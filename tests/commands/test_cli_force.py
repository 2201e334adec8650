"""softsoil calibrate, sweep and residual on single-wheel data, from the command line."""

import json

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from benchmarks.guide.json_page import undescribed
from softsoil.calibration.single_wheel import law_for
from softsoil.commands.cli import app
from wheel_runs import SOIL, own_data, sine_run


@pytest.fixture
def rig_table(tmp_path):
    """Four runs with a turn-slip wheel of its own size, as a user's table with its wheel and soil."""
    blank = [sine_run(0.1 + 0.08 * i, 0.5, 0.1 * i, 1500.0 + 500 * i) for i in range(4)]
    runs = own_data(blank, law_for("turn_slip", blank))
    rows = []
    for i, run in enumerate(runs):
        columns = {key: getattr(run, key) for key in ("v_x", "v_y", "omega", "load", "f_x", "f_y", "yaw_rate", "dv_y")}
        rows.append(pd.DataFrame({"run": f"r{i}", "t": 0.005 * np.arange(len(run)), **columns}))
    pd.concat(rows).to_csv(tmp_path / "rig.csv", index=False)
    (tmp_path / "wheel.toml").write_text("radius = 0.35\nwidth = 0.21\n", encoding="utf-8")
    soil = "\n".join(f"{key} = {value!r}" for key, value in {**SOIL, "n": 0.5}.items())
    (tmp_path / "soil.toml").write_text(soil, encoding="utf-8")
    return [str(tmp_path / "rig.csv"), "--wheel", str(tmp_path / "wheel.toml"), "--soil", str(tmp_path / "soil.toml")]


def test_calibrate_on_a_users_table(rig_table, tmp_path):
    out = tmp_path / "out"
    done = CliRunner().invoke(app, ["calibrate", *rig_table, "--fit", "path,turn", "--out", str(out)])
    assert done.exit_code == 0, done.output
    content = json.loads((out / "calibrate.json").read_text(encoding="utf-8"))
    found = content["parameters"]
    assert undescribed("calibrate.json", content) == []
    assert found["path"]["value"] == pytest.approx(1.0, abs=0.02)
    assert found["turn"]["value"] == pytest.approx(1.0, abs=0.05)
    assert "calibrated.toml" in done.output


def test_runs_that_are_fitted_do_not_judge(rig_table, tmp_path):
    done = CliRunner().invoke(app, ["calibrate", *rig_table, "--judge", rig_table[0], "--out", str(tmp_path / "out")])
    assert done.exit_code == 2 and "expected runs that differ, found the rows of" in done.output


def test_a_table_given_twice_does_not_judge_itself(rig_table, tmp_path):
    done = CliRunner().invoke(app, ["calibrate", rig_table[0], *rig_table, "--out", str(tmp_path / "out")])
    assert done.exit_code == 2 and "a run counts once" in done.output


def test_residual_on_a_users_table(rig_table, tmp_path):
    out = tmp_path / "out"
    done = CliRunner().invoke(app, ["residual", *rig_table, "--out", str(out)])
    assert done.exit_code == 0, done.output
    content = json.loads((out / "residual.json").read_text(encoding="utf-8"))
    laws = content["laws"]
    assert undescribed("residual.json", content) == []
    assert set(laws) == {"bekker", "dallas", "dallas_refit", "turn_slip", "turn_slip_calibrated"}
    assert laws["turn_slip"]["median"] < 0.01 < laws["bekker"]["median"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["calibrate", "absent.csv"], "absent.csv"), (["sweep", "--runs", "1", "--scheduler", "nowhere"], "tcp://host")],
)
def test_bad_input_is_one_line_and_code_2(arguments, words, tmp_path):
    done = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert words in done.output and "Traceback" not in done.output


@pytest.mark.slow
def test_sweep_resumes(tmp_path):
    arguments = ["sweep", "--workers", "1", "--out", str(tmp_path)]
    assert CliRunner().invoke(app, [*arguments, "--runs", "1"]).exit_code == 0
    done = CliRunner().invoke(app, [*arguments, "--runs", "2"])
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "sweep.json").read_text(encoding="utf-8"))
    assert found["runs"] == 2 and found["resumed"] == 1
    assert found["laws"]["turn_slip"]["median"] < 0.02
