"""A race car's log without pose, wheels or soil: checked, completed, traced on hard ground, and no n anywhere."""

import json

import pytest
from typer.testing import CliRunner

from softsoil.cases.dart import candidate_names
from softsoil.cases.stanford import CAR, MEASURED, read_stanford
from softsoil.commands.cli import app


@pytest.fixture
def folder(shared_data):
    found = shared_data / "real" / "stanford_250lm"
    if not found.is_dir():
        pytest.skip("the race car's log is not beside the project")
    return found


@pytest.mark.shared
def test_real_channels_agree_and_absent_ones_are_marked(folder):
    drive, checks = read_stanford(folder)
    assert len(checks) >= 8 and all(check.passed for check in checks)
    assert drive.measured("u", "v", "omega_z", "steer", "a_y_imu")
    assert {drive.state_of(name) for name in ("x", "y", "psi", "omega_fl", "omega_rr")} == {"derived"}


@pytest.mark.shared
def test_the_command_says_what_can_be_said_and_no_n(folder, tmp_path):
    result = CliRunner().invoke(app, ["case", "stanford", "--data", str(folder), "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "stanford.json").read_text(encoding="utf-8"))
    log = content["log"]
    assert set(log["ground"][1]) == {"phi", "k"}
    assert {entry["name"] for entry in log["ranking"]} == set(candidate_names(CAR, MEASURED))
    assert log["before"]["rms"]["0.5"]["x"] is None and log["before"]["rms"]["0.5"]["v"] > 0
    assert not any(name.startswith("n_") or name == "n" for name in (*log["parameters"], *log["ground"][0]))
    assert "n =" not in result.output and "n_f" not in result.output


def test_a_folder_without_the_log_is_refused(tmp_path):
    with pytest.raises(ValueError, match="expected the race car's log"):
        read_stanford(tmp_path)
