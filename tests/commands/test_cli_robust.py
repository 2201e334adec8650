"""Commands under bad conditions: folders that cannot be written, interruptions, warnings; and what every result carries."""

import json
import os
import re
import warnings
from importlib.metadata import version

import numpy as np
import pytest
from rich.table import Table
from typer.testing import CliRunner

from drives import MULTI_LOG, PROJECT
from softsoil.commands.cli import COMMANDS, app
from softsoil.commands.output import OutputFolder, console, output_folder
from softsoil.files.package_data import REFERENCE_VEHICLE, VEHICLE_NAMES, source_name, vehicle_file
from softsoil.plant.manoeuvres import PathFollower, Speed
from softsoil.plant.sensors import Sensors
from softsoil.plant.simulate import simulate
from softsoil.plant.start import Start
from softsoil.recording.columns import load_columns
from softsoil.recording.drive import CHANNEL_UNITS
from softsoil.recording.read import read_drive, write_drive
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle


def softsoil(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments], env={"COLUMNS": "160"})


@pytest.mark.study
def test_a_doubtful_channel_is_warned_of_once_and_is_the_first_thing_to_mend(home, monkeypatch):
    monkeypatch.setattr("softsoil.commands.estimate.late_clocks", lambda *_, **__: ())  # looked for elsewhere
    drive = read_drive("short_clay_n0.50.csv")
    write_drive(drive.with_channels(omega_z=1.06 * drive["omega_z"]), home / "gyro.csv")
    result = softsoil("estimate", "gyro.csv", "--soil", "clay")
    said = " ".join(result.output.split())
    assert result.exit_code == 0 and said.count("for omega_z, a gyro's scale") == 1
    assert ("identified:" in said) == ("next: mend what the warnings above name" not in said)


@pytest.fixture
def home(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_drive(read_drive(MULTI_LOG).between(0.0, 9.0), tmp_path / "short_clay_n0.50.csv")
    return tmp_path


def test_version():
    result = softsoil("--version")
    assert result.exit_code == 0 and result.output == f"softsoil {version('softsoil')}\n"


def test_every_result_says_what_made_it(home):
    result = softsoil("estimate", "short_clay_n0.50.csv", "--soil", "clay", "--vehicle", "paper", "--out", "a b")
    assert result.exit_code == 0, result.output
    found = json.loads((home / "a b" / "estimate.json").read_text(encoding="utf-8"))
    command = "softsoil estimate short_clay_n0.50.csv --soil clay --vehicle paper --out 'a b'"
    assert found["software"] == {"version": version("softsoil"), "command": command}
    paper = load_vehicle("paper")
    assert found["vehicle"] == {"name": paper.name, "file": "softsoil/vehicles/paper.toml"}


@pytest.mark.parametrize("name", VEHICLE_NAMES)
def test_built_in_vehicles_have_names(name):
    assert load_vehicle(name) == load_vehicle(PROJECT / "vehicles" / f"{name}.toml")
    assert vehicle_file(vehicle_file(name)) == vehicle_file(name)


def test_a_file_of_the_user_is_named_as_given():
    assert source_name("cars/mine.toml") == "cars/mine.toml"
    assert source_name(REFERENCE_VEHICLE) == "softsoil/vehicles/reference.toml"


@pytest.mark.parametrize("below", ["file", "proc"])
def test_a_folder_that_cannot_be_written_is_refused_before_any_work(home, monkeypatch, below):
    def work(*_, **__):
        raise AssertionError("worked before the folder was checked")

    monkeypatch.setattr("softsoil.commands.estimate.open_drive", work)
    out = home / "short_clay_n0.50.csv" / "out" if below == "file" else "/proc/nowhere/out"
    result = softsoil("estimate", "short_clay_n0.50.csv", "--soil", "clay", "--out", out)
    assert result.exit_code == 2 and result.stderr.startswith("error: --out: expected a folder that can be written")
    assert len(result.stderr.splitlines()) == 1


def test_a_run_that_fails_leaves_no_folder(home):
    for command in (("estimate", "none.csv", "--soil", "clay"), ("study", "none.csv"), ("refine", "none.csv")):
        result = softsoil(*command, "--out", "deep/er/out")
        assert result.exit_code == 2
    assert not (home / "deep").exists()


def test_a_refused_run_says_that_the_folder_holds_an_earlier_ones_results(home):
    refused = ("import", "none.csv", "--out", "kept")
    assert "earlier" not in softsoil(*refused).stderr
    (home / "kept").mkdir()
    (home / "kept" / "import.json").write_text("{}", encoding="utf-8")
    assert "earlier" not in softsoil(*refused).stderr, "of this run, for all that the clock says"
    os.utime(home / "kept" / "import.json", (1e9, 1e9))
    result = softsoil(*refused)
    assert result.exit_code == 2 and len(result.stderr.splitlines()) == 1
    assert result.stderr.strip().endswith("; kept still holds the results of an earlier run")


def test_an_output_folder_is_made_with_its_first_file(tmp_path):
    folder = output_folder(tmp_path / "a" / "b", "estimate")
    assert not (tmp_path / "a").exists() and str(folder) == str(tmp_path / "a" / "b")
    assert (folder / "x.json") == tmp_path / "a" / "b" / "x.json" and (tmp_path / "a" / "b").is_dir()


def test_an_existing_folder_keeps_what_is_in_it(tmp_path):
    (tmp_path / "kept").write_text("x", encoding="utf-8")
    output_folder(tmp_path, "estimate")
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]


def test_an_interruption_says_what_is_kept(home, monkeypatch):
    def stopped(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("softsoil.commands.estimate.open_drive", stopped)
    result = softsoil("estimate", "short_clay_n0.50.csv", "--soil", "clay")
    assert result.exit_code == 1 and result.stderr.strip().endswith("error: stopped by the user; nothing was written")
    assert not (home / "runs").exists()

    def stopped_later(study, path):
        path.write_text("x", encoding="utf-8")
        raise KeyboardInterrupt

    monkeypatch.setattr("softsoil.commands.study.draw_study", stopped_later)
    result = softsoil("study", "short_clay_n0.50.csv")
    assert "1 files written before are kept in runs/study" in result.stderr


def test_a_study_that_is_refused_changes_no_picture_of_an_earlier_one(home):
    """Every log is looked at before the first is computed."""
    (home / "kept").mkdir()
    (home / "kept" / "short_clay_n0.50.png").write_bytes(b"a picture")
    (home / "plain.csv").write_bytes((home / "short_clay_n0.50.csv").read_bytes())
    result = softsoil("study", "short_clay_n0.50.csv", "plain.csv", "--out", "kept")
    assert result.exit_code == 2 and "plain.csv: expected --soil" in result.stderr
    assert [path.read_bytes() for path in (home / "kept").iterdir()] == [b"a picture"]


def test_a_sweep_that_is_interrupted_says_that_it_resumes(home, monkeypatch):
    def stopped(task, points, out, *_):
        OutputFolder(out) / "results.jsonl"
        (out / "results.jsonl").write_text("", encoding="utf-8")
        raise KeyboardInterrupt

    monkeypatch.setattr("softsoil.commands.sweep.run_sweep", stopped)
    result = softsoil("sweep", "--runs", 2)
    assert result.exit_code == 1
    assert "finished results are kept in runs/sweep/results.jsonl, and the same command resumes there" in result.stderr


def test_warnings_are_one_plain_line_each(home, monkeypatch):
    def loud(*_, **__):
        for _ in range(2):
            warnings.warn("the compiler\nis missing", stacklevel=1)
        warnings.warn("old", DeprecationWarning, stacklevel=1)
        raise ValueError("end")

    monkeypatch.setattr("softsoil.commands.estimate.open_drive", loud)
    result = softsoil("estimate", "short_clay_n0.50.csv", "--soil", "clay")
    assert result.stderr.splitlines() == ["warning: the compiler is missing", "error: end"]


@pytest.mark.parametrize("command", [*(name for name in COMMANDS if name != "case"), ("case", "cmu"), ("case", "dart")])
def test_help_shows_no_absolute_path(command):
    result = softsoil(*([command] if isinstance(command, str) else command), "--help")
    assert result.exit_code == 0 and str(PROJECT) not in result.output
    assert not re.search(r"(?<![\w.])/(home|root|tmp|usr|work)/", result.output)


def test_tables_are_not_cut_off_in_a_file():
    table = Table("name", "why")
    table.add_row("x" * 150, "because " * 20)
    with console.capture() as printed:
        console.print(table)
    assert "x" * 150 in printed.get() and "because " * 19 in printed.get() and "…" not in printed.get()


def test_keys_in_brackets_are_printed_as_they_are():
    words = "[uncertainty] radius = 0.014 in the known numbers, [mount] or /joints:velocity[left]"
    table = Table("why")
    table.add_row(words)
    with console.capture() as printed:
        console.print(words)
        console.print(table)
    assert printed.get().count(words) == 2


@pytest.mark.parametrize("command", [("calibrate",), ("case", "cmu"), ("case", "dart")])
def test_commands_on_measurements_say_which_data_they_want(home, command):
    result = softsoil(*command)
    assert result.exit_code == 2 and len(result.stderr.splitlines()) == 1
    assert "expected" in result.stderr and ("single-wheel runs" in result.stderr or "--data" in result.stderr)


def test_residual_checks_the_range_of_n(home):
    result = softsoil("residual", "short_clay_n0.50.csv", "--n", 9)
    assert result.exit_code == 2 and "n: expected a sinkage exponent in [0.2, 1.6], found 9" in result.stderr


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ('{column = "v", sign = 2}', "expected sign of 1 or -1"),
        ('{column = "v", sign = 0}', "expected a finite number other than 0|expected sign"),
        ('{column = "v", factor = 0}', "expected a finite number other than 0 for factor"),
        ('{column = "v", factor = "2"}', "expected a number for factor"),
        ('{column = "v", offset = inf}', "expected a finite number"),
    ],
)
def test_a_column_map_is_checked(tmp_path, entry, words):
    path = tmp_path / "map.toml"
    path.write_text(f"u = {entry}\n", encoding="utf-8")
    with pytest.raises(ValueError, match=words):
        load_columns(path, CHANNEL_UNITS)


def test_a_column_map_scales_and_a_byte_order_mark_does_no_harm(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('u = {column = "v", unit = "km/h", factor = 2, sign = -1, offset = 1}\n', encoding="utf-8-sig")
    source = load_columns(path, CHANNEL_UNITS)["u"]
    assert source.factor == pytest.approx(-2 / 3.6) and source.offset == 1.0


@pytest.mark.study
def test_a_log_of_laps_says_where_it_runs_in_its_own_ruts(tmp_path):
    turned = np.linspace(0.0, 6 * np.pi, 1200)
    path = 9.0 * np.column_stack([np.sin(turned), 1.0 - np.cos(turned)])
    driver = PathFollower(path, Speed(3.5), look_ahead=3.0)
    laps = simulate(driver, CLAY, 24.0, sensors=Sensors("good"), seed=3, start=Start(u=3.5))
    log = write_drive(laps, tmp_path / "laps.csv")
    done = softsoil("estimate", log, "--soil", "clay", "--vehicle", "plant", "--out", tmp_path)
    said = " ".join(done.output.split())
    assert done.exit_code == 0 and "wheels run in ruts of earlier in this log for 8" in said
    assert (tmp_path / "estimate.png").is_file()
