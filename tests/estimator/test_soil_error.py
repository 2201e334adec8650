"""What errors of the soil's class make of n: as measured by other classes, in its error bar, in files and on the terminal."""

from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG
from softsoil.commands.cli import app
from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration, soil_toml
from softsoil.estimator.estimate import estimate
from softsoil.estimator.modes import run_guess
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.estimator.soil_error import SoilError, soil_error
from softsoil.files.joint_error import JointError
from softsoil.files.package_data import PLANT_VEHICLE
from softsoil.mapping.drive_soil import drive_soil
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, PathFollower, Speed
from softsoil.plant.sensors import Sensors
from softsoil.plant.simulate import simulate
from softsoil.plant.start import Start
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive, write_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.effect import Correction, Effect, Layout, Signal, add_effect
from softsoil.symbolic.soil import CLAY, load_soil
from softsoil.symbolic.vehicle import load_vehicle

VEHICLE = load_vehicle("reference")
STATED = (("phi", 0.01), ("k_phi", 1e5))


@pytest.fixture(scope="module")
def drive():
    return add_noise(read_drive(MULTI_LOG).between(0.0, 16.0), "good", 1)


def n_of(drive, soil):
    return estimate(drive, bicycle(VEHICLE, soil), method="horizon")


@pytest.mark.study
def test_n_moves_with_the_class_as_stated(drive):
    """A class with a parameter 2 % larger moves n by a fifth of what a tenth of it is said to."""
    found = n_of(drive, CLAY)
    tenth = found.verdict.evidence.soil.tenth
    assert set(tenth) == {"k_phi", "k_c", "c", "phi", "k"} and found.verdict.evidence.soil.std == 0.0
    for name in ("phi", "k", "k_phi"):
        other = n_of(drive, CLAY.with_(**{name: 1.02 * getattr(CLAY, name)}))
        assert other.n_front[-1] / found.n_front[-1] - 1 == pytest.approx(0.2 * tenth[name], rel=0.25, abs=0.001), name


def more_force(front, rear):
    """The reference vehicle's model with lateral forces of the axles that are larger by these shares."""
    names, base = ("more_front", "more_rear"), VEHICLE.wheelbase

    def compute(q):
        f = q["more_front"] * (q["force_y"] * VEHICLE.l_r + q["moment_z"]) / base
        r = q["more_rear"] * (q["force_y"] * VEHICLE.l_f - q["moment_z"]) / base
        return {"force_y": q["force_y"] + f + r, "moment_z": q["moment_z"] + VEHICLE.l_f * f - VEHICLE.l_r * r}

    layout = Layout.of(*(Signal(name, "-", "share", 0.0, -1.0, 1.0) for name in names))
    corrections = {"balance": Correction(compute, adds=("force_y", "moment_z"), reads=())}
    about = {"kind": "body", "reference": "this test", "typical": dict.fromkeys(names, 0.01)}
    effect = Effect("more_force", "larger axle forces", **about, parameters=layout, corrections=corrections)
    return add_effect(bicycle(VEHICLE, CLAY), effect, {"more_front": front, "more_rear": rear})


def test_n_moves_with_the_forces_of_the_axles_as_stated(drive):
    """Forces of an axle 1 % larger than the law's move n by what the law's own windows say."""
    found = {}
    for front, rear in ((0.0, 0.0), (0.01, 0.0), (0.0, 0.01)):
        windows = drive_windows(drive, more_force(front, rear), 2.0, HorizonRules())
        run = run_guess(windows, 0.7, True, HorizonRules()).horizon
        found[front, rear] = float(run.n[0]), soil_error(windows, run)
    (n, said), (by_front, _), (by_rear, _) = found.values()
    assert abs(said.forces[0]) > 0.01
    assert by_front / n - 1.0 == pytest.approx(said.forces[0], rel=0.25, abs=0.002)
    assert by_rear / n - 1.0 == pytest.approx(said.forces[1], rel=0.25, abs=0.002)
    assert said.law_std == pytest.approx(np.hypot(*said.forces)) and said.more == 0.0


def test_what_a_drive_owes_to_the_law_beyond_any_drive_is_in_the_error_bar():
    assert SoilError({}, 0.01, (0.0, 0.03), 0.03, 0.02).more == pytest.approx(np.sqrt(0.01**2 + 0.03**2 - 0.02**2))


@pytest.mark.study
def test_stated_errors_of_the_class_are_in_the_error_bar(drive):
    plain, stated = n_of(drive, CLAY), n_of(drive, CLAY.with_(uncertainty=STATED))
    tenth = plain.verdict.evidence.soil.tenth
    share = np.hypot(*(10 * tenth[name] * std / getattr(CLAY, name) for name, std in STATED))
    assert stated.n_front[-1] == plain.n_front[-1] and stated.verdict.word == plain.verdict.word
    assert stated.n_front_std[-1] == pytest.approx(np.hypot(plain.n_front_std[-1], share * plain.n_front[-1]), rel=1e-9)
    assert stated.verdict.evidence.std[0] == pytest.approx(stated.n_front_std[-1], rel=1e-6)
    exact, wide = (drive_soil(drive, bicycle(VEHICLE, soil), 0.7).common for soil in (CLAY, CLAY.with_(uncertainty=STATED)))
    assert wide == pytest.approx(np.hypot(exact, share), rel=1e-3)


def test_errors_that_were_identified_together_count_together(drive):
    """phi and k press alike on n: where one is larger the other is smaller, and n is known better than by each for itself."""
    std = dict(STATED)
    names, share = (*std,), {}
    for correlation in (0.0, 1.0, -1.0):
        soil = CLAY.with_(joint_error=JointError(names, (*std.values(),), ((), (correlation,))))
        windows = drive_windows(drive, bicycle(VEHICLE, soil), 2.0, HorizonRules())
        found = soil_error(windows, run_guess(windows, 0.7, True, HorizonRules()).horizon)
        one, other = (10 * found.tenth[name] * std[name] / getattr(CLAY, name) for name in names)
        share[correlation] = found.std
        assert found.std == pytest.approx(np.sqrt(one**2 + other**2 + 2 * correlation * one * other), rel=1e-6)
    assert share[-1.0] != share[1.0]
    soil = CLAY.with_(joint_error=JointError(("phi",), (std["phi"],), ((),)), uncertainty=STATED)
    windows = drive_windows(drive, bicycle(VEHICLE, soil), 2.0, HorizonRules())
    mixed = soil_error(windows, run_guess(windows, 0.7, True, HorizonRules()).horizon).std
    assert mixed == pytest.approx(share[0.0], rel=1e-6), "an error that is stated beside the joint one counts too"


def test_joint_errors_are_read_from_files_and_written_to_them(tmp_path):
    soil = CLAY.with_(name="mine", joint_error=JointError(("phi", "k"), (0.01, 0.002), ((), (-0.9,))))
    (tmp_path / "mine.toml").write_text(soil_toml(soil), encoding="utf-8")
    assert load_soil(tmp_path / "mine.toml") == soil
    (tmp_path / "model.toml").write_text(declaration_toml(Declaration(VEHICLE, soil)), encoding="utf-8")
    assert load_declaration(tmp_path / "model.toml").soil == soil
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8").replace('"phi"', '"mass"')
    (tmp_path / "wrong.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match="joint_error: expected names of c, k, k_c, k_phi, phi; found 'mass'"):
        load_soil(tmp_path / "wrong.toml")
    wider = soil_toml(soil.with_(uncertainty=(("phi", 0.02),)))
    (tmp_path / "wider.toml").write_text(wider, encoding="utf-8")
    with pytest.raises(ValueError, match=r"uncertainty.phi: expected 0.01, as \[joint_error\] has it, found 0.02"):
        load_soil(tmp_path / "wider.toml")


def test_stated_errors_are_read_from_files_and_written_to_them(tmp_path):
    values = {**CLAY.parameters(), "name": "mine"}
    text = "\n".join(f'{k} = "{v}"' if k == "name" else f"{k} = {v}" for k, v in values.items())
    path = tmp_path / "mine.toml"
    path.write_text(f"{text}\n[uncertainty]\nphi = 0.01\nk_phi = 1e5\n", encoding="utf-8")
    soil = load_soil(path)
    assert soil == replace(CLAY, name="mine", uncertainty=STATED)
    whole = tmp_path / "model.toml"
    whole.write_text(declaration_toml(Declaration(VEHICLE, soil)), encoding="utf-8")
    assert load_declaration(whole).soil == soil
    short = write_drive(read_drive(MULTI_LOG).between(0.0, 12.0), tmp_path / "short.csv")
    said = CliRunner().invoke(app, ["estimate", str(short), "--soil", str(path), "--out", str(tmp_path / "out")])
    assert said.exit_code == 0, said.output
    assert "n is that of the declared soil" in said.output and "by the errors that its file states" in said.output


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("phi = -0.1", "uncertainty.phi: expected"),
        ("phi = 1.0", "uncertainty.phi: expected 1e-12 to 0.3, found 1"),
        ("n = 0.1", "uncertainty: expected keys k_phi, k_c, c, phi, k; found 'n'"),
        ("phi = true", "expected a finite number"),
    ],
)
def test_stated_errors_that_make_no_sense_are_refused(tmp_path, table, words):
    path = tmp_path / "mine.toml"
    values = "\n".join(f"{k} = {v}" for k, v in CLAY.parameters().items())
    path.write_text(f"{values}\n[uncertainty]\n{table}\n", encoding="utf-8")
    with pytest.raises(ValueError, match=words):
        load_soil(path)


def test_a_soil_in_kilonewtons_is_refused(tmp_path):
    path = tmp_path / "mine.toml"
    in_kilo = {**CLAY.parameters(), **{name: 1e-3 * getattr(CLAY, name) for name in ("k_phi", "k_c", "c")}}
    path.write_text("\n".join(f"{k} = {v}" for k, v in in_kilo.items()), encoding="utf-8")
    with pytest.raises(ValueError, match=r"mine.toml: expected .* found 824.2: no soil is so soft; .*kN and kPa"):
        load_soil(path)


@pytest.mark.study
def test_long_curves_near_the_limit_of_grip_leave_n_to_the_law():
    """An axle's force is worth twice as much of n there as in quick changes of direction, and n is not used."""
    soil, plant = CLAY.with_(n=0.5), bicycle(load_vehicle(PLANT_VEHICLE), CLAY)
    turned = np.linspace(0.0, 2 * np.pi, 400, endpoint=False)
    eight = 20.0 * np.column_stack([np.sin(turned), 1.6 * np.sin(turned) * np.cos(turned)])
    found = []
    for course in (PathFollower(eight, Speed(5.0), look_ahead=3.0), Manoeuvre("multi", MultiSine(), Speed(5.0))):
        drive = simulate(course, soil, 32.0, start=Start(u=4.0), sensors=Sensors("good"), seed=2)
        found.append(estimate(drive, plant, 0.6, method="horizon").verdict)
    long, quick = found
    assert long.word == "not_excited" and "of the lateral force of the front axle" in long.reason
    assert quick.word == "identified" and 2.0 * quick.evidence.soil.law_std < long.evidence.soil.law_std
