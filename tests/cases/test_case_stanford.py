"""A race car's log without pose, wheels or soil: checked, completed, traced on hard ground, and no n anywhere."""

import json
import re

import pytest
from typer.testing import CliRunner

from benchmarks.guide.json_page import undescribed
from softsoil.cases.dart import candidates_of
from softsoil.cases.stanford import CAR, KINDS, read_stanford
from softsoil.commands.cli import app
from softsoil.symbolic.catalogue import catalogue


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


@pytest.mark.study
@pytest.mark.shared
def test_the_command_says_what_can_be_said_and_no_n(folder, tmp_path):
    result = CliRunner().invoke(app, ["case", "stanford", "--data", str(folder), "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "stanford.json").read_text(encoding="utf-8"))
    assert undescribed("stanford.json", content) == []
    content = content["refinement"]
    (ground,) = content["ground"]
    assert set(ground) == {"name", "drives", "friction", "tread"} and ground["friction"]["verdict"] == "at_bound"
    tried = {entry["name"] for entry in content["ranking"]}
    rest_on_a_pose = {name for name, effect in catalogue(CAR).items() if {"x", "y", "psi"} & set(effect.rests_on)}
    candidates = set(candidates_of(CAR, KINDS))
    assert tried & candidates and not rest_on_a_pose & {effect["name"] for effect in content["effects"]}
    for name in rest_on_a_pose & candidates:  # those that are fitted as rivals can explain as much, and are not named
        word = "not to be named" if name in tried else "not tried"
        assert any(note.startswith(f"{name}: {word}, it rests on") for note in content["notes"])
    assert content["before"]["mse"]["0.5"]["x"] is None and content["before"]["mse"]["0.5"]["v"] > 0
    assert "n" not in content and not any(name.startswith("n_") for e in content["effects"] for name in e["parameters"])
    assert not re.search(r"(?<!\w)n(_[fr0-9])? *[=:]|n front", result.output)
    assert "road: friction at bound" in result.output


def test_a_folder_without_the_log_is_refused(tmp_path):
    with pytest.raises(ValueError, match="expected the race car's log"):
        read_stanford(tmp_path)
