"""What commands write over, leave and take away."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG
from softsoil.commands import output
from softsoil.commands.bench import _value
from softsoil.commands.cli import app
from softsoil.commands.drive import _controllers, _courses
from softsoil.commands.invocation import invoked
from softsoil.commands.output import output_folder, say_written
from softsoil.recording.read import read_drive, write_drive


def softsoil(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments], env={"COLUMNS": "160"})


@pytest.fixture
def home(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_drive(read_drive(MULTI_LOG).between(0.0, 9.0), tmp_path / "short.csv")
    return tmp_path


def test_no_input_is_written_over(home):
    write_drive(read_drive("short.csv"), home / "drive.parquet")
    before = (home / "drive.parquet").read_bytes()
    for spelling in ("drive.parquet", home / "drive.parquet", "./drive.parquet"):
        done = softsoil("import", spelling, "--out", ".")
        assert done.exit_code == 2 and "expected a folder where no input is written over" in done.output
    assert (home / "drive.parquet").read_bytes() == before and not (home / "import.json").exists()


def test_what_an_earlier_run_left_goes_once_this_one_has_written(tmp_path):
    (tmp_path / "estimate.png").write_text("old", encoding="utf-8")
    (tmp_path / "mine.png").write_text("mine", encoding="utf-8")
    with invoked(["estimate"]):
        folder = output_folder(tmp_path, "estimate", ("estimate.json", "estimate.png"))
        assert (tmp_path / "estimate.png").exists(), "a run that fails later takes nothing away"
        (folder / "estimate.json").write_text("{}", encoding="utf-8")
        say_written([folder / "estimate.json"])
    assert {path.name for path in tmp_path.iterdir()} == {"estimate.json", "mine.png"}


def test_an_estimate_without_soil_leaves_no_figure_of_another_run(home):
    assert softsoil("estimate", "short.csv", "--soil", "clay", "--out", "out").exit_code == 0
    assert (home / "out" / "estimate.png").exists()
    assert softsoil("estimate", "short.csv", "--law", "hard_ground", "--out", "out").exit_code == 0
    assert [path.name for path in (home / "out").iterdir()] == ["estimate.json"]


def test_a_map_that_somebody_edited_is_kept(home):
    assert softsoil("inspect", "short.csv", "--out", "out").exit_code == 0
    mapped = home / "out" / "map.toml"
    draft = mapped.read_text(encoding="utf-8")
    assert softsoil("inspect", "short.csv", "--out", "out").exit_code == 0
    assert not (home / "out" / "map.before.toml").exists()
    mapped.write_text(draft + "# mine\n", encoding="utf-8")
    assert "is now" in softsoil("inspect", "short.csv", "--out", "out").output
    assert mapped.read_text(encoding="utf-8") == draft
    assert (home / "out" / "map.before.toml").read_text(encoding="utf-8").endswith("# mine\n")
    mapped.write_text(draft + "# another\n", encoding="utf-8")
    assert "is now" in softsoil("inspect", "short.csv", "--out", "out").output
    assert (home / "out" / "map.before.toml").read_text(encoding="utf-8").endswith("# mine\n")
    assert (home / "out" / "map.before.2.toml").read_text(encoding="utf-8").endswith("# another\n")


@pytest.mark.parametrize(
    ("command", "found"), ((("sweep", "--runs", "1", "--workers", "0"), "found 0"), (("sweep", "--spacing", "5"), "0.1"))
)
def test_numbers_of_processes_and_grids_that_cannot_be_are_refused(home, command, found):
    done = softsoil(*command)
    assert done.exit_code == 2 and found in done.output and "program's own" not in done.output


@pytest.mark.parametrize("command", ("identify", "refine"))
def test_a_log_counts_once(home, command):
    pd.read_csv("short.csv").to_csv(home / "again.csv", index=False)
    known = Path(home / "known.toml")
    known.write_text("mass = 1378.3\nl_f = 1.546\nl_r = 1.175\ntrack = 1.232\nradius = 0.3302\nwidth = 0.212\n", encoding="utf-8")
    vehicle = known if command == "identify" else "reference"
    done = softsoil(command, "short.csv", "again.csv", "--vehicle", vehicle, "--soil", "clay")
    assert done.exit_code == 2 and "again: expected drives that differ, found the rows of short again" in done.output


def test_one_log_by_two_paths_is_one(home):
    """Also with --noise, which makes other rows of it each time."""
    (home / "known.toml").write_text("mass = 1378.3\n", encoding="utf-8")
    for noise in ("none", "good"):
        arguments = ("--vehicle", "known.toml", "--soil", "clay", "--noise", noise)
        done = softsoil("identify", "short.csv", home / "short.csv", *arguments)
        assert done.exit_code == 2 and "expected different logs, found one twice" in done.output


def test_single_wheel_data_take_no_options_of_drives(home):
    np.savez(home / "runs.npz", a=np.zeros(1))
    done = softsoil("residual", "runs.npz", "--law", "bekker", "--n", "0.7")
    assert done.exit_code == 2 and "--law, --n: expected none beside single-wheel data" in done.output


def test_courses_and_controllers_that_are_asked_for_twice_drive_once():
    assert [course.name for course in _courses(["slalom_clay", "slalom_clay"], 1.0)] == ["slalom_clay"]
    assert _controllers("n_true,n_true,n_guess") == ["n_true", "n_guess"]


def test_a_ratio_has_no_unit():
    assert [_value(4.35, "1"), _value(57.1, ""), _value(2.0, "us")] == ["4.35", "57.1", "2 µs"]


def test_a_long_command_says_on_stderr_how_far_it_is(capsys, monkeypatch):
    now = iter((0.0, 10.0, 31.0, 40.0, 62.0))
    monkeypatch.setattr(output.time, "monotonic", lambda: next(now))
    with output.progress("four drives") as tell:
        for share in (0.1, 0.3, 0.4, 0.9):
            tell(share)
    shown = capsys.readouterr()
    assert shown.err.splitlines() == ["four drives: 30% after 31 s", "four drives: 90% after 62 s"]
    assert shown.out.splitlines() == ["four drives ..."]
