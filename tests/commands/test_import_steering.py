"""Import of a log with the command of its steering: a map where both are there, angles by the vehicle's map where one is."""

import json

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG, reference_vehicle
from softsoil.commands.cli import app
from softsoil.declaration.model_file import Declaration, declaration_toml
from softsoil.files.steering_map import SteeringMap
from softsoil.recording.read import read_drive
from softsoil.symbolic.soil import CLAY

RATIO = SteeringMap((-10.0, 0.0, 12.0), (-0.5, 0.02, 0.55))
CHANNELS = ("x", "y", "psi", "u", "v", "omega_z", "a_x_imu", "a_y_imu", "omega_fl", "omega_fr", "omega_rl", "omega_rr")


@pytest.fixture
def table(tmp_path):
    drive = read_drive(MULTI_LOG).between(0.0, 30.0)
    columns = {"t": drive.t, **{name: drive[name] for name in CHANNELS}}
    path = tmp_path / "log.csv"
    pd.DataFrame({**columns, "wheel": RATIO.command_of(drive["steer"]), "road": drive["steer"]}).to_csv(path, index=False)
    return path


def write_map(table, *lines):
    text = "\n".join(["[channels]", *(f'{name} = "log.csv:{name}"' for name in CHANNELS), *lines])
    path = table.with_name("map.toml")
    path.write_text(text, encoding="utf-8")
    return path


def run(table, mapped, *more):
    out = table.with_name("out")
    return out, CliRunner().invoke(app, ["import", str(table), "--map", str(mapped), "--out", str(out), *more])


def test_a_log_with_both_gives_the_map_and_a_log_with_the_command_alone_its_angles(table):
    command = 'steer_command = {source = "log.csv:wheel", unit = "rad"}'
    out, done = run(table, write_map(table, command, 'steer = "log.csv:road"'))
    assert done.exit_code == 0, done.output
    assert "steering map: a polynomial of degree" in done.output
    entry = json.loads((out / "import.json").read_text(encoding="utf-8"))["steering"]
    assert 0.0 <= entry["delay_s"] < 0.01 and entry["residual"] < 0.01
    fitted = SteeringMap(tuple(entry["command"]), tuple(entry["angle"]))
    truth = read_drive(MULTI_LOG).between(0.0, 30.0)["steer"]
    np.testing.assert_allclose(fitted.angle_of(RATIO.command_of(truth)), truth, atol=0.015)

    vehicle = reference_vehicle().with_(steering=fitted)
    file = table.with_name("vehicle.toml")
    text = declaration_toml(Declaration(vehicle, CLAY)).split("[soil]")[0].replace("vehicle.", "")
    file.write_text(text.partition("[vehicle]\n")[2], encoding="utf-8")
    out, done = run(table, write_map(table, command), "--vehicle", str(file))
    assert done.exit_code == 0, done.output
    drive = read_drive(out / "drive.parquet")
    assert np.abs(drive["steer"] - np.interp(drive.t, drive.t[0] + np.arange(len(truth)) * 0.012, truth)).max() < 0.02


def test_the_command_alone_needs_a_vehicle_with_a_map(table):
    out, done = run(table, write_map(table, 'steer_command = "log.csv:wheel"'))
    assert done.exit_code == 2 and "[steering]" in done.output and not out.exists()
    _, done = run(table, write_map(table, 'steer_command = {source = "log.csv:wheel", unit = "m"}'))
    assert done.exit_code == 2 and "expected a unit of" in done.output


@pytest.mark.study
def test_the_map_is_of_the_part_that_is_wanted(table):
    """After 20 s the linkage has another ratio; the part that [clock] wants ends before."""
    columns = pd.read_csv(table)
    late = columns["t"] > 20.0
    columns.loc[late, "wheel"] *= 1.5
    columns.to_csv(table, index=False)
    lines = ('steer_command = {source = "log.csv:wheel", unit = "rad"}', 'steer = "log.csv:road"')
    slopes = []
    for more in ((), ("[clock]", "end = 19.5")):
        out, done = run(table, write_map(table, *lines, *more))
        if more:
            assert done.exit_code == 0, done.output
            entry = json.loads((out / "import.json").read_text(encoding="utf-8"))["steering"]
            fitted = SteeringMap(tuple(entry["command"]), tuple(entry["angle"]))
            slopes.append(fitted.angle_of(np.array([4.0]))[0] / RATIO.angle_of(np.array([4.0]))[0])
            assert entry["residual"] < 0.01
        else:
            assert done.exit_code != 0 or "rms of their angle" in done.output
    assert slopes == [pytest.approx(1.0, abs=0.05)]
