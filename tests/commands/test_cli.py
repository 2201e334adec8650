"""The command line end to end on the project's own logs: keys, exit codes, one-line errors, nothing outside --out."""

import json
import math

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from drives import CLAY_LOG, LOAM_LOG, MULTI_LOG, PROJECT
from softsoil.commands.cli import app
from softsoil.estimator.verdict import WORDS
from softsoil.figures.labels import plain
from softsoil.mpc_demo.study import LATERAL, study_log
from softsoil.recording.drive import STATE_CHANNELS
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.read import read_drive, write_drive

runner = CliRunner()
STATES = set(STATE_CHANNELS)


def softsoil(*arguments):
    return runner.invoke(app, [str(a) for a in arguments])


@pytest.fixture(scope="module")
def short_log(tmp_path_factory):
    """Nine seconds of clay, under a name that tells soil and n."""
    path = tmp_path_factory.mktemp("logs") / "short_clay_n0.50.csv"
    return write_drive(read_drive(MULTI_LOG).between(0.0, 9.0), path)


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A working folder of its own, so that what is written shows."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def files(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def finite(value):
    if isinstance(value, dict):
        return all(finite(v) for v in value.values())
    if isinstance(value, list):
        return all(finite(v) for v in value)
    return not isinstance(value, float) or math.isfinite(value)


def test_study_writes_what_it_says(home, short_log):
    result = softsoil("study", short_log, "--seed", 1)
    assert result.exit_code == 0, result.output
    assert files(home) == ["runs/study/short_clay_n0.50.png", "runs/study/study.json"]
    for name in files(home):
        assert f"wrote {name}" in result.output
    (entry,) = json.loads((home / "runs/study/study.json").read_text(encoding="utf-8"))["logs"]
    keys = {"log", "soil", "n_true", "n_initial", "n_estimated", "error_percent", "converged_s", "mse"}
    keys |= {"verdict", "reason"}
    assert set(entry) == keys and finite(entry) and entry["verdict"] in WORDS and plain(entry["verdict"]) in result.output
    assert (entry["log"], entry["soil"], entry["n_true"]) == ("short_clay_n0.50", "clay", 0.5)
    assert entry["n_initial"] == pytest.approx(0.7)
    assert entry["error_percent"] == pytest.approx(100 * abs(entry["n_estimated"] - 0.5) / 0.5)
    assert set(entry["mse"]) == {"0.5", "2.5", "5.0"}
    for horizon in entry["mse"].values():
        assert set(horizon) == {"initial", "estimated"} and all(set(part) == STATES for part in horizon.values())
    assert "left out at the end" in result.output
    ratios = [entry["mse"]["2.5"]["initial"][name] / entry["mse"]["2.5"]["estimated"][name] for name in LATERAL]
    said = " ".join(result.output.split("\n2.5 s ahead: ")[1].split())
    assert said.startswith(f"{np.exp(np.mean(np.log(np.sqrt(ratios)))):.2f};")
    assert f"smaller with the estimate in {sum(ratio > 1 for ratio in ratios)} of 4" in said


@pytest.mark.study
def test_study_of_a_log_whose_name_tells_nothing(home, short_log):
    anonymous = home / "drive.parquet"
    write_drive(read_drive(short_log), anonymous)
    asked = softsoil("study", anonymous)
    assert asked.exit_code == 2 and "expected --soil" in asked.output and "drive.parquet" in asked.output
    result = softsoil("study", anonymous, "--soil", "clay", "--noise", "none", "--out", home / "o")
    assert result.exit_code == 0, result.output
    (entry,) = json.loads((home / "o/study.json").read_text(encoding="utf-8"))["logs"]
    assert entry["n_true"] is None and entry["error_percent"] is None and entry["n_initial"] == 0.5


@pytest.fixture
def no_figures(monkeypatch):
    """The study without its pictures, which take longer than its sums."""
    monkeypatch.setattr("softsoil.commands.study.draw_study", lambda study, path: path)


@pytest.mark.study
def test_logs_of_one_name_have_a_picture_each_and_those_of_an_earlier_study_go(home, short_log, monkeypatch):
    made = []

    def once(clean, *more):
        made.append(study_log(clean, *more) if not made else made[0])
        return made[-1]

    def drawn(study, path):
        path.write_text(study.log, encoding="utf-8")
        return path

    monkeypatch.setattr("softsoil.commands.study.study_log", once)
    monkeypatch.setattr("softsoil.commands.study.draw_study", drawn)
    for name in ("monday/run.csv", "tuesday/run.csv", "run_2.csv"):
        write_drive(read_drive(short_log), home / name)
    options = ("--soil", "clay", "--noise", "none", "--out", home / "o")
    assert softsoil("study", home / "run_2.csv", *options).exit_code == 0
    assert softsoil("study", home / "monday/run.csv", home / "tuesday/run.csv", *options).exit_code == 0
    assert files(home / "o") == ["run (monday).png", "run (tuesday).png", "study.json"]
    told = json.loads((home / "o/study.json").read_text(encoding="utf-8"))["logs"]
    assert [entry["log"] for entry in told] == ["run (monday)", "run (tuesday)"]


@pytest.mark.study
def test_study_is_the_same_for_the_same_seed(home, short_log, no_figures):
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        assert softsoil("study", short_log, "--seed", seed, "--out", home / name).exit_code == 0
    read = [json.loads((home / name / "study.json").read_text(encoding="utf-8")) for name in "abc"]
    first, second, other = (found["logs"] for found in read)
    assert first == second != other
    assert [found["software"]["command"].split()[0] for found in read] == ["softsoil"] * 3


def test_estimate_writes_what_it_says(home, short_log):
    result = softsoil("estimate", short_log, "--soil", "clay", "--n0", 0.7, "--out", home / "e")
    assert result.exit_code == 0, result.output
    assert files(home) == ["e/estimate.json", "e/estimate.png"]
    found = json.loads((home / "e/estimate.json").read_text(encoding="utf-8"))
    keys = {"software", "vehicle", "n_front", "n_rear", "n_front_std", "n_rear_std", "n0", "converged_s", "late_clocks"}
    keys |= {"nis_inside_95", "step_us", "trace", "verdict", "reason", "changes_s", "revoked_s", "drift", "filter", "windows"}
    missing = {"nis_inside_95", "drift"}  # the log carries no sensor noise, and drifts nowhere
    assert set(found) == keys and finite({key: value for key, value in found.items() if key not in missing})
    assert found["verdict"] in WORDS and found["nis_inside_95"] is None and found["drift"] is None
    lines = result.output.splitlines()
    assert next(i for i, line in enumerate(lines) if plain(found["verdict"]) in line) < next(
        i for i, line in enumerate(lines) if "n front" in line
    )
    assert set(found["step_us"]) == {"median", "p99"} and set(found["trace"]) == {"t", "n_front", "n_rear"}
    assert found["trace"]["n_front"][-1] == found["n_front"]
    assert set(found["windows"]) == {"n", "std", "yaw_inertia", "strain", "load", "steering", "soil"}
    assert len(found["windows"]["n"]) == len(found["windows"]["std"]) == 1
    assert found["verdict"] == "identified" and found["n_front"] == found["n_rear"] == found["windows"]["n"][0]
    assert set(found["filter"]) == {"n", "std"} and abs(found["filter"]["n"][0] / found["n_front"] - 1.0) < 0.1
    assert f"the filter itself ends at {found['filter']['n'][0]:.3f}" in result.output
    assert len({len(series) for series in found["trace"].values()}) == 1


def test_residual_writes_what_it_says(home):
    result = softsoil("residual", LOAM_LOG, "--soil", "sandy_loam", "--out", home / "r")
    assert result.exit_code == 0, result.output
    found = json.loads((home / "r/residual.json").read_text(encoding="utf-8"))
    assert set(found) == {"software", "vehicle", "channels", "axles", "mse"} and finite(found)
    assert set(found["channels"]) == STATES and set(found["channels"]["v"]) == {"rms", "whiteness_p"}
    assert set(found["axles"]) == {"front", "rear"} and set(found["mse"]) == {"0.5", "2.5", "5.0"}
    # The rut under the rear wheels is in the declared vehicle, and not in the paper's structure.
    paper = PROJECT / "vehicles" / "paper.toml"
    result = softsoil("residual", LOAM_LOG, "--soil", "sandy_loam", "--vehicle", paper, "--out", home / "p")
    assert result.exit_code == 0, result.output
    plain = json.loads((home / "p/residual.json").read_text(encoding="utf-8"))
    assert plain["axles"]["rear"]["rms"] > 2 * found["axles"]["rear"]["rms"]


def test_generate_writes_c(home):
    result = softsoil("generate", home / "c", "--soil", "clay")
    assert result.exit_code == 0, result.output
    names = ("filter.c", "horizon.c", "kernels.h", "lanes.h", "model.c", "model.h", "policy.h", "rows.c", "vehicle.c",
             "vehicle_kernels.h")  # fmt: skip
    expected = ["CMakeLists.txt", "README.md", "example.c", "formulation.json", "include/softsoil.h"]
    expected += [f"include/softsoil_{name}.h" for name in ("horizon", "rows", "vehicle")]
    expected += [f"src/softsoil_{name}" for name in names]
    assert sorted(files(home / "c")) == sorted(expected)


def test_generate_again_writes_the_same(home):
    for _ in range(2):
        assert softsoil("generate", home / "c", "--soil", "clay").exit_code == 0
    before = {path: path.stat().st_mtime_ns for path in (home / "c").rglob("*") if path.is_file()}
    assert softsoil("generate", home / "c", "--soil", "clay").exit_code == 0
    assert {path: path.stat().st_mtime_ns for path in before} == before


@pytest.mark.slow
def test_truth_never_enters(home, short_log, no_figures):
    """The same JSON, apart from times, whether the log has its true_* columns or lies about them."""
    table = pd.read_csv(short_log)
    truth = [name for name in table.columns if name.startswith("true_")]
    assert truth
    table.drop(columns=truth).to_csv(home / "without_clay_n0.50.csv", index=False)
    table.assign(**dict.fromkeys(truth, 1e3)).to_csv(home / "lies_clay_n0.50.csv", index=False)
    results = []
    for name in ("without", "lies"):
        assert softsoil("study", home / f"{name}_clay_n0.50.csv", "--out", home / name).exit_code == 0
        (entry,) = json.loads((home / name / "study.json").read_text(encoding="utf-8"))["logs"]
        results.append({key: value for key, value in entry.items() if key != "log"})
    assert results[0] == results[1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["estimate", "none.csv", "--soil", "clay"], "none.csv: expected a log"),
        (["estimate", ".", "--soil", "clay"], "found a folder"),
        (["estimate", CLAY_LOG], "--soil: expected one of clay"),
        (["estimate", CLAY_LOG, "--soil", "mud"], "found 'mud'"),
        (["estimate", CLAY_LOG, "--soil", "clay", "--n0", "7"], "n0: expected a first guess in [0.2, 1.6], found 7"),
        (["estimate", CLAY_LOG, "--soil", "clay", "--n0", "much"], "'--n0'"),
        (["estimate", CLAY_LOG, "--soil", "clay", "--noise", "loud"], "noise: expected one of none"),
        (["estimate", CLAY_LOG, "--soil", "clay", "--law", "magic"], "expected one of bekker"),
        (["estimate", CLAY_LOG, "--soil", "clay", "--vehicle", "no.toml"], "no.toml"),
        (["estimate", CLAY_LOG, "--soil", "clay", "--columns", "no.toml"], "no.toml"),
        (["estimate", CLAY_LOG, "--model", "no.toml"], "no.toml"),
        (["estimate", CLAY_LOG, "--soil", "clay", "--model", "m.toml"], "--soil: expected none beside --model"),
        (["estimate", CLAY_LOG, "--law", "dallas", "--model", "m.toml"], "--law: expected none beside --model"),
        (["drive", "--vehicle", "mine.toml", "--model", "m.toml"], "--vehicle: expected none beside --model"),
        (["drive", "--law", "dallas", "--model", "m.toml"], "--law: expected none beside --model"),
        (["estimate", CLAY_LOG, "--soil", "clay", "--skip", "100"], "expected at least 4 rows"),
        (["estimate", CLAY_LOG, "--soil", "clay", "--out", CLAY_LOG], "expected a folder"),
        (["residual", CLAY_LOG, "--skip", "100"], "expected more than"),
        (["study", CLAY_LOG, "--nonsense"], "--nonsense"),
        (["generate", "--soil", "clay", "--hessian", "exact"], "--hessian: expected --controller beside it"),
        (["case", "cmu", "--data", ".", "--grouser", "0.02"], "--grouser: expected --judge beside it"),
        (["estimate"], "Missing argument"),
        (["nonsense"], "nonsense"),
    ],
    ids=lambda value: " ".join(str(v) for v in value)[-40:] if isinstance(value, list) else None,
)
def test_bad_input_is_one_line_and_exit_code_2(home, arguments, words):
    result = softsoil(*arguments)
    assert result.exit_code == 2, result.output
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: ") and words in lines[0]
    assert "Traceback" not in result.output


@pytest.mark.parametrize("error", [KeyError("lost"), np.linalg.LinAlgError("Singular matrix")], ids=lambda e: type(e).__name__)
def test_failure_of_its_own_is_said_as_such(home, monkeypatch, short_log, error):
    def broken(*_, **__):
        raise error

    monkeypatch.setattr("softsoil.commands.estimate.estimate_log", broken)
    result = softsoil("estimate", short_log, "--soil", "clay")
    assert result.exit_code == 1
    assert result.stderr.startswith(f"error: a failure of the program's own: {type(error).__name__}")


@pytest.mark.parametrize("command", ["study", "estimate", "residual", "generate", "calibrate", "bench"])
def test_help_has_an_example(command):
    result = softsoil(command, "--help")
    assert result.exit_code == 0 and f"Example: softsoil {command}" in result.output


@pytest.mark.parametrize(
    ("name", "n", "soil"),
    [
        ("paper_clay_n0.50", 0.5, "clay"),
        ("multi_sandyloam_n0.55", 0.55, "sandy_loam"),
        ("paper_sand_n1.08", 1.08, "sand"),
        ("change_clay_n0.50_to_0.75", None, "clay"),
        ("effect_wind", None, None),
        ("undeclared_1", None, None),
        ("sandy_loam_n0.7", 0.7, "sandy_loam"),
        ("thousand_n1", None, None),
    ],
)
def test_what_a_name_tells(name, n, soil):
    assert named_n(name) == n and named_soil(name) == soil
