"""A vehicle's or a soil's file keeps what was said of it, and nobody takes a contradicted one for a good one."""

import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG, PROJECT
from softsoil.commands.cli import app
from softsoil.control.c_estimator import c_library_texts
from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration, soil_toml
from softsoil.estimator.estimate import estimate
from softsoil.recording.read import read_drive, write_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, load_soil
from softsoil.symbolic.vehicle import load_vehicle

REFERENCE = (PROJECT / "vehicles" / "reference.toml").read_text(encoding="utf-8")


def file_with(tmp_path, verdict):
    path = tmp_path / f"{verdict}.toml"
    path.write_text(f'verdict = "{verdict}"\n{REFERENCE}', encoding="utf-8")
    return path


def soil_file(tmp_path, verdict):
    path = tmp_path / f"soil_{verdict}.toml"
    path.write_text(soil_toml(CLAY.with_(name="field", verdict=verdict)), encoding="utf-8")
    return path


@pytest.mark.study
@pytest.mark.slow
def test_an_estimate_with_a_contradicted_vehicle_is_not_identified(tmp_path):
    drive = read_drive(MULTI_LOG).between(0.0, 12.0)
    words = {}
    for verdict in ("needs_data", "contradicts_given"):
        model = Declaration(load_vehicle(file_with(tmp_path, verdict)), CLAY).build()
        words[verdict] = estimate(drive, model, 0.7).verdict
    assert words["needs_data"].usable
    assert words["contradicts_given"].word == "inconsistent" and "measure them again" in words["contradicts_given"].reason
    soil = load_soil(soil_file(tmp_path, "contradicts_given"))
    found = estimate(drive, bicycle(load_vehicle("reference"), soil), 0.7).verdict
    assert found.word == "inconsistent" and "soil's file is contradicted" in found.reason


def test_no_library_comes_of_a_contradicted_vehicle(tmp_path):
    path = file_with(tmp_path, "contradicts_given")
    with pytest.raises(ValueError, match=rf"{path}: expected a vehicle whose numbers identify does not contradict; found"):
        c_library_texts(Declaration(load_vehicle(path), CLAY))
    soil = load_soil(soil_file(tmp_path, "contradicts_given"))
    with pytest.raises(ValueError, match=r"field: expected a soil that its own drives do not contradict .*; found"):
        c_library_texts(Declaration(load_vehicle("reference"), soil))


def test_a_declaration_keeps_the_verdict(tmp_path):
    declared = Declaration(load_vehicle(file_with(tmp_path, "needs_data")), CLAY.with_(verdict="identified"))
    refined = tmp_path / "refined.toml"
    refined.write_text(declaration_toml(declared), encoding="utf-8")
    assert load_declaration(refined).vehicle.verdict == "needs_data"
    assert load_declaration(refined).soil.verdict == "identified"
    assert load_vehicle("reference").verdict == "" and load_soil("clay").verdict == ""


def test_an_unknown_verdict_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"key 'verdict': expected one of identified, needs_data, .* found 'good'"):
        load_vehicle(file_with(tmp_path, "good"))
    with pytest.raises(ValueError, match=r"key 'verdict': expected one of identified, needs_data, .* found 'good'"):
        load_soil(soil_file(tmp_path, "good"))


def test_commands_warn_of_a_vehicle_that_is_not_to_be_used(tmp_path):
    needs, good = file_with(tmp_path, "needs_data"), file_with(tmp_path, "identified")
    for path, said in ((needs, True), (good, False)):
        run = CliRunner().invoke(app, ["generate", str(tmp_path / path.stem), "--soil", "clay", "--vehicle", str(path)])
        assert run.exit_code == 0, run.output
        assert ("identify said 'needs_data' of this vehicle" in run.output) is said


def test_commands_warn_of_a_soil_that_is_not_to_be_used(tmp_path):
    for verdict, said in (("needs_data", True), ("identified", False)):
        soil = soil_file(tmp_path, verdict)
        run = CliRunner().invoke(app, ["generate", str(tmp_path / verdict), "--soil", str(soil)])
        assert run.exit_code == 0, run.output
        assert ("soil field: softsoil soil said 'needs_data'" in run.output + run.stderr) is said


@pytest.mark.study
@pytest.mark.slow
def test_what_answers_a_contradicted_file_is_another_identification_not_a_tracing(tmp_path):
    """refine looks for what a right vehicle lacks: of a wrong file it would name effects."""
    log = write_drive(read_drive(MULTI_LOG).between(0.0, 12.0), tmp_path / "log.parquet")
    out = ["--out", str(tmp_path / "out")]
    path, soil = file_with(tmp_path, "contradicts_given"), soil_file(tmp_path, "contradicts_given")
    for options, command in ((["--vehicle", str(path), "--soil", "clay"], "identify"), (["--soil", str(soil)], "soil")):
        done = CliRunner().invoke(app, ["estimate", str(log), *options, *out])
        assert f"next: softsoil {command} anew" in done.output and "next: softsoil refine" not in done.output, done.output
