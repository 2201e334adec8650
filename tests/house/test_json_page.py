"""What commands write against the page that describes it, for the commands that no tutorial calls."""

import json

import pytest
from typer.testing import CliRunner

import softsoil
from benchmarks.guide.json_page import undescribed
from softsoil.commands.cli import app

BENCH = {
    "filter": {"ukf_step_python", "ukf_step_c", "log_replay_per_step", "force_call", "rebuild_cold", "rebuild_cached"},
    "c_library": {"rollout_step", "clibrary_step_c", "clibrary_step_python"},
}
"""Names of bench.json that scripts rely on, by subject."""


def written(folder, file, *words):
    """The content of the file that a command writes under `folder`."""
    result = CliRunner().invoke(app, [*map(str, words), "--out", str(folder)])
    assert result.exit_code == 0, result.output
    return json.loads((folder / file).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """A log of 20 s under the name of the one that it is cut from."""
    log = softsoil.example_logs()[0]
    path = tmp_path_factory.mktemp("short") / log.name
    return softsoil.write_drive(softsoil.read_drive(log).between(0.0, 20.0), path)


@pytest.mark.slow
def test_the_map_is_described(short, tmp_path):
    content = written(tmp_path, "map.json", "map", short, "--soil", "clay")
    assert undescribed("map.json", content) == []
    assert len(content["features"]) > 2 and content["logs"][0]["used"]
    for cell in content["features"]:
        (ring,) = cell["geometry"]["coordinates"]
        assert ring[0] == ring[-1] and len(ring) == 5
        assert 0.2 < cell["properties"]["n"] < 1.6 and cell["properties"]["std"] > 0


def test_a_residual_is_described(short, tmp_path):
    assert undescribed("residual.json", written(tmp_path, "residual.json", "residual", short, "--soil", "clay")) == []


@pytest.mark.slow
@pytest.mark.compiler
@pytest.mark.parametrize("subject", [pytest.param(name, marks=pytest.mark.study) for name in ("filter", "c_library")])
def test_the_speed_figures_are_described(subject, tmp_path):
    content = written(tmp_path, "bench.json", "bench", "--only", subject)
    assert undescribed("bench.json", content) == []
    rows = {row["name"]: row for row in content["rows"]}
    assert BENCH[subject] <= set(rows)
    for row in rows.values():
        assert row["value"] > 0 and row["ratio"] > 0


@pytest.mark.slow
def test_a_sweep_is_described(tmp_path):
    assert undescribed("sweep.json", written(tmp_path, "sweep.json", "sweep", "--runs", 3)) == []
