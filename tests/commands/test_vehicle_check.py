"""Commands say which vehicle they take, and refuse a log of another."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from drives import CLAY_LOG, MULTI_LOG, PROJECT, reference_vehicle
from softsoil.commands.cli import app
from softsoil.declaration.model_file import Declaration, declaration_toml
from softsoil.recording.read import read_drive, write_drive
from softsoil.symbolic.soil import CLAY

runner = CliRunner()


def estimate(log, folder, *more):
    return runner.invoke(app, ["estimate", str(log), "--soil", "clay", "--out", str(folder), *more])


def test_the_vehicle_taken_by_default_is_said_first(tmp_path):
    short = write_drive(read_drive(MULTI_LOG).between(0.0, 12.0), tmp_path / "short.csv")
    result = estimate(short, tmp_path / "o")
    assert result.exit_code == 0 and result.output.splitlines()[0].startswith("vehicle: reference, since --vehicle names none")


@pytest.fixture
def other(tmp_path):
    """A log of larger wheels than the reference vehicle's."""
    drive = read_drive(CLAY_LOG).between(0.0, 8.0)
    slower = {name: 0.6 * drive[name] for name in ("omega_fl", "omega_fr", "omega_rl", "omega_rr")}
    return write_drive(drive.with_channels(**slower), Path(tmp_path) / "other.csv")


@pytest.mark.parametrize("command", ["estimate", "study", "map", "residual", "refine"])
def test_a_log_of_larger_wheels_is_refused_and_nothing_is_written(command, other, tmp_path):
    result = runner.invoke(app, [command, str(other), "--soil", "clay", "--out", str(tmp_path / "o")])
    assert result.exit_code == 2 and f"expected wheels of radius {reference_vehicle().radius:.3g} m" in result.output
    assert result.output.splitlines()[0].startswith("vehicle: reference, since --vehicle names none")
    assert not (tmp_path / "o").exists()


def test_what_a_named_vehicle_contradicts_is_a_remark_to_residual(other, tmp_path):
    result = runner.invoke(
        app, ["residual", str(other), "--soil", "clay", "--vehicle", "reference", "--out", str(tmp_path / "o")]
    )
    said = " ".join(result.output.split())
    assert result.exit_code == 0 and "another vehicle, or a sensor is wrong or stands elsewhere" in said
    assert "since --vehicle names none" not in said


def test_a_front_axle_elsewhere_is_refused(tmp_path):
    """The log's own vehicle with the centre of gravity half a metre further back."""
    vehicle = reference_vehicle()
    moved = vehicle.with_(l_f=vehicle.l_f + 0.5, l_r=vehicle.l_r - 0.5)
    file = tmp_path / "moved.toml"
    file.write_text(declaration_toml(Declaration(moved, CLAY)), encoding="utf-8")
    result = estimate(CLAY_LOG, tmp_path / "o", "--vehicle", str(file))
    assert result.exit_code == 2 and "expected the front axle" in result.output


def test_every_command_with_a_vehicle_says_which_it_takes():
    files = [path for path in (PROJECT / "commands").glob("*.py") if "vehicle: VehicleOption" in path.read_text(encoding="utf-8")]
    assert len(files) >= 9
    for path in files:
        assert "say_vehicle(" in path.read_text(encoding="utf-8"), f"{path.name}: no first line on the vehicle"
