"""Commands say which vehicle they take, and refuse a log of another."""

from pathlib import Path

from typer.testing import CliRunner

from drives import CLAY_LOG, reference_vehicle
from softsoil.commands.cli import app
from softsoil.recording.read import read_drive, write_drive

runner = CliRunner()


def estimate(log, folder, *more):
    return runner.invoke(app, ["estimate", str(log), "--soil", "clay", "--out", str(folder), *more])


def test_the_vehicle_taken_by_default_is_said_first(tmp_path):
    short = write_drive(read_drive(CLAY_LOG).between(0.0, 8.0), tmp_path / "short.csv")
    result = estimate(short, tmp_path / "o")
    assert result.exit_code == 0 and result.output.splitlines()[0].startswith("vehicle: reference, since --vehicle names none")
    named = estimate(short, tmp_path / "o", "--vehicle", "reference")
    assert "since --vehicle names none" not in named.output


def test_a_log_of_larger_wheels_is_refused_and_nothing_is_written(tmp_path):
    drive = read_drive(CLAY_LOG).between(0.0, 8.0)
    slower = {name: 0.6 * drive[name] for name in ("omega_fl", "omega_fr", "omega_rl", "omega_rr")}
    other = write_drive(drive.with_channels(**slower), Path(tmp_path) / "other.csv")
    result = estimate(other, tmp_path / "o")
    assert result.exit_code == 2 and f"expected wheels of radius {reference_vehicle().radius:.3g} m" in result.output
    assert not (tmp_path / "o").exists()
