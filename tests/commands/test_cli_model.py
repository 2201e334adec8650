"""Commands with a declared model, other columns, and single-wheel data."""

import json

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG, PROJECT, reference_vehicle
from softsoil.commands.cli import app
from softsoil.declaration.model_file import Declaration, declaration_toml
from softsoil.recording.drive import CHANNEL_UNITS
from softsoil.recording.read import read_drive, write_drive
from softsoil.symbolic.soil import CLAY

runner = CliRunner()
PAPER = ("--soil", "clay", "--vehicle", PROJECT / "vehicles" / "paper.toml")
"""The paper's structure: no declared effects."""


def run(*arguments):
    result = runner.invoke(app, [str(a) for a in arguments])
    assert result.exit_code == 0, result.output
    return result


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def refined(tmp_path_factory):
    """What physics says these logs hold beyond the paper's model: wheels in ruts and load from side to side; not fitted here."""
    effects = {"multipass": {"kappa": 0.7}, "load_transfer": {"transfer_height": 0.63}}
    path = tmp_path_factory.mktemp("model") / "refined.toml"
    declared = Declaration(reference_vehicle(), CLAY).with_effects(effects)
    path.write_text(declaration_toml(declared), encoding="utf-8")
    return path


@pytest.mark.study
def test_declared_effects_bring_n_near_the_truth_and_leave_less_unexplained(tmp_path, refined):
    """A log of the independent simulator, which nothing here was fitted on."""
    run("estimate", MULTI_LOG, "--model", refined, "--n0", 0.7, "--noise", "table5", "--out", tmp_path / "with")
    run("estimate", MULTI_LOG, *PAPER, "--n0", 0.7, "--noise", "table5", "--out", tmp_path / "without")
    found, plain = (read(tmp_path / name / "estimate.json") for name in ("with", "without"))
    assert found["n_front"] == found["n_rear"]
    assert abs(found["n_front"] / 0.5 - 1) < 0.2 < abs(plain["n_front"] / 0.5 - 1)
    run("residual", MULTI_LOG, "--model", refined, "--out", tmp_path / "with")
    run("residual", MULTI_LOG, *PAPER, "--out", tmp_path / "without")
    less, more = (read(tmp_path / name / "residual.json") for name in ("with", "without"))
    assert less["axles"]["rear"]["rms"] < 0.5 * more["axles"]["rear"]["rms"]
    assert less["mse"]["2.5"]["v"] < 0.2 * more["mse"]["2.5"]["v"]


def test_generate_writes_the_declared_model(tmp_path, refined):
    run("generate", tmp_path / "c", "--model", refined)
    assert "kappa" in (tmp_path / "c/README.md").read_text(encoding="utf-8")


def test_log_with_other_columns_and_units_gives_the_same_estimate(tmp_path):
    table = pd.DataFrame(read_drive(MULTI_LOG).between(0.0, 12.0).channels)
    table.to_csv(tmp_path / "plain.csv", index=False)
    other = table.rename(columns={name: f"bus_{name}" for name in table.columns})
    other["bus_u"] *= 3.6
    other["bus_steer"] = np.rad2deg(other["bus_steer"])
    other.to_parquet(tmp_path / "other.parquet", index=False)
    units = {**CHANNEL_UNITS, "u": "km/h", "steer": "deg"}
    lines = [f'{name} = {{column = "bus_{name}", unit = "{units[name]}"}}' for name in table.columns]
    (tmp_path / "columns.toml").write_text("\n".join(lines), encoding="utf-8")
    run("estimate", tmp_path / "plain.csv", "--soil", "clay", "--out", tmp_path / "a")
    columns = ("--columns", tmp_path / "columns.toml")
    run("estimate", tmp_path / "other.parquet", *columns, "--soil", "clay", "--out", tmp_path / "b")
    first, second = (read(tmp_path / name / "estimate.json") for name in "ab")
    assert first["n_front"] == pytest.approx(second["n_front"], rel=1e-6)


@pytest.mark.study
def test_log_with_gaps_jitter_and_holes_is_estimated_all_the_same(tmp_path, refined):
    even = write_drive(read_drive(MULTI_LOG).between(0.0, 14.0), tmp_path / "even.csv")
    table = pd.read_csv(even)
    rng = np.random.default_rng(7)
    table["t"] += rng.uniform(-0.003, 0.003, len(table))
    table.loc[100:299, "v"] = np.nan
    table = table.drop(index=range(900, 960))
    table.to_csv(tmp_path / "rough.csv", index=False)
    common = ("--model", refined, "--n0", 0.7, "--noise", "table5")
    result = run("estimate", tmp_path / "rough.csv", *common, "--out", tmp_path / "o")
    assert "gap of" in result.output and "v: 200 of" in result.output
    run("estimate", even, *common, "--out", tmp_path / "s")
    rough, even = (read(tmp_path / name / "estimate.json") for name in "os")
    assert rough["n_front"] == pytest.approx(even["n_front"], rel=0.1)
    assert rough["nis_inside_95"] > 0.85


@pytest.mark.study
@pytest.mark.shared
def test_residual_of_single_wheel_runs_shows_the_laws_side_by_side(tmp_path, shared_data):
    run("residual", shared_data / "chrono_rig/sand_val.npz", "--out", tmp_path)
    laws = read(tmp_path / "residual.json")["laws"]
    assert {"bekker", "dallas", "dallas_refit", "turn_slip", "turn_slip_calibrated"} <= set(laws)
    assert laws["turn_slip"]["median"] < 0.25 * laws["bekker"]["median"]
