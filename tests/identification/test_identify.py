"""Numbers of a vehicle from logs: recovered from drives of the model itself, refused where logs cannot say, judged on others."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from drives import CLAY_LOG, LOAM_LOG, MULTI_LOG
from softsoil.commands.cli import app
from softsoil.declaration.driveline import with_driveline
from softsoil.identification.bench import Bench, first_n, fit_numbers, free_numbers, make_bench
from softsoil.identification.errors import errors_of
from softsoil.identification.identify import identify
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.derive import mark
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.log_names import named_n, named_soil
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive, write_drive
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.vehicle_numbers import vehicle_of
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, load_soil
from softsoil.symbolic.vehicle import load_vehicle

KNOWN = Known(
    "paper",
    {"mass": 1378.33, "l_f": 1.546, "l_r": 1.175, "track": 1.232, "radius": 0.330229, "width": 0.2121, "h_cg": 0.63},
    simulator=load_vehicle("reference").simulator,
    search=0.0018,
)
TRUE = {"yaw_inertia": 2300.0, "scrub": 0.09, "toe": 0.012, "toe_rear": -0.015, "kappa": 0.8, "steering_offset": 0.008}
SIMULATOR = ["[simulator]", *(f"{k} = {v}" for k, v in KNOWN.simulator.items()), f"contact_search = {KNOWN.search}"]
TOML = "\n".join([*(f"{k} = {v}" for k, v in KNOWN.numbers.items()), 'name = "paper"', *SIMULATOR])


def steering(kind, seconds):
    t = 0.012 * np.arange(round(seconds / 0.012) + 1)
    if kind == "lock":
        return 0.42 * np.sin(2 * np.pi * t / 3.0)
    if kind == "straight":
        return np.zeros(len(t))
    return 0.09 * (np.sin(0.9 * t) + np.sin(2.3 * t + 1.0) + 0.7 * np.sin(4.1 * t + 2.0))


def drive_of(values, kind, n, seed=None, seconds=30.0, wheels=True, known=KNOWN):
    model = bicycle(vehicle_of(known, values), CLAY.with_(n=n))
    model = model if wheels else with_driveline(model, ("fl", "fr", "rl", "rr"))
    made = synthetic_drive(model, KNOWN["radius"], seconds=seconds, steer=steering(kind, seconds), substeps=1 if wheels else 4)
    made = made if seed is None else add_noise(made, "good", seed)
    return made if wheels else made.with_channels(**{name: np.full(len(made), np.nan) for name in WHEEL_CHANNELS})


@pytest.mark.slow
def test_numbers_are_recovered_from_drives_of_the_model_itself():
    """The drives' wheel speeds are made up, not balanced: windows alone are fitted here."""
    drives = [drive_of(TRUE, "lock", 0.5, 1), drive_of(TRUE, "multi", 0.65, 2)]
    bench: Bench = replace(make_bench(drives, [CLAY, CLAY], KNOWN, 2.0), balances=())
    fit = fit_numbers(bench, free_numbers(bench, list(TRUE)), {}, first_n(bench, {}))
    std = errors_of(fit).std
    for name, (value, _) in fit.named().items():
        true = {**TRUE, "n_0": 0.5, "n_1": 0.65}[name]
        assert abs(value - true) < 4 * std[name] + 0.01 * abs(true), (name, value, std[name])
    assert std["yaw_inertia"] < 0.05 * 2300.0


@pytest.mark.study
@pytest.mark.slow
def test_the_rear_axle_is_found_where_it_is_left_to_the_logs():
    drives = [drive_of(TRUE, "lock", 0.5, 1), drive_of(TRUE, "multi", 0.65, 2)]
    bench: Bench = replace(make_bench(drives, [CLAY, CLAY], KNOWN, 2.0), balances=())
    off = (1.1 * KNOWN["l_r"], 0.1 * KNOWN["l_r"])
    fit = fit_numbers(bench, free_numbers(bench, [*TRUE, "l_r"], (), {"l_r": off}), {"l_r": off[0]}, first_n(bench, {}))
    assert fit.named()["l_r"][0] == pytest.approx(KNOWN["l_r"], rel=0.02)


@pytest.mark.slow
def test_balances_follow_the_states_of_the_windows():
    """The noise of recorded speeds is slip that is not there."""
    clean = drive_of(TRUE, "multi", 0.65)
    exact, noisy = (make_bench([one], [CLAY], KNOWN, 2.0) for one in (clean, add_noise(clean, "table5", 3)))
    p = exact.parameters(TRUE, [0.65])[0]
    wanted, recorded = exact.balances[0].residual(p), noisy.balances[0].residual(p)
    noisy.windows[0].follow(p, exact.windows[0].first)
    followed = noisy.balances[0].residual(p)
    assert np.abs(followed - wanted).mean() < 0.2 * np.abs(recorded - wanted).mean()


@pytest.mark.study
@pytest.mark.slow
def test_a_number_that_the_logs_have_moved_is_not_called_given():
    """l_f with an error that its owner states: tape and motion together, though motion makes it hardly better known."""
    drives = [drive_of(TRUE, "lock", 0.5, 1, 16.0), drive_of(TRUE, "multi", 0.65, 2, 16.0)]
    found = identify(drives, [CLAY] * 2, replace(KNOWN, stated={"l_f": 0.004, "l_r": 0.03})).numbers
    assert found["l_f"].value != found["l_f"].given and found["l_f"].state == "identified"
    assert found["l_r"].value == found["l_r"].given and found["l_r"].state == "given"


@pytest.mark.study
def test_logs_driven_straight_on_say_so_and_ask_for_a_manoeuvre():
    drives = [drive_of({}, "straight", n, seed, 12.0) for seed, n in enumerate((0.5, 0.6))]
    found = identify(drives, [CLAY] * 2, KNOWN)
    assert found.verdict == "needs_data" and "straight on" in found.reason
    assert found.asks


@pytest.mark.study
def test_a_log_that_repeats_one_wave_says_so_and_asks_for_more_waves():
    drives = [read_drive(log).between(0.0, 10.0) for log in (CLAY_LOG, LOAM_LOG)]
    found = identify(drives, [CLAY, load_soil("sandy_loam")], KNOWN)
    assert found.verdict == "needs_data" and "one steering wave" in found.reason
    assert "several sines" in found.asks[0]


@pytest.mark.study
@pytest.mark.slow
def test_ground_that_shears_anew_in_ruts_is_found():
    """Drives of the model itself on such ground, wheels turned by the balance of forces."""
    known, anew = replace(KNOWN, driveline={"centre_lock": 1.0, "front_drive": 0.5}), replace(KNOWN, other_ground=True)
    asked = (("lock", 0.5, 1), ("multi", 0.6, 2), ("multi", 0.7, 3))
    drives = [drive_of({}, kind, n, seed, 40.0, False, anew) for kind, n, seed in asked]
    found = identify(drives, [CLAY] * 3, known)
    assert found.vehicle.effects["multipass"]["sheared"] == 0.0 and any("sheared = 0" in note for note in found.notes)
    for (n, _), (_, true, _) in zip(found.n.values(), asked, strict=True):
        assert n == pytest.approx(true, rel=0.08)


def test_fewer_than_two_logs_are_refused():
    with pytest.raises(ValueError, match="expected two logs or more"):
        identify([drive_of({}, "lock", 0.5, seconds=6.0)], [CLAY], KNOWN)


def test_logs_without_wheel_speeds_need_the_driveline():
    log = mark(drive_of({}, "lock", 0.5, seconds=6.0), "derived", *WHEEL_CHANNELS)
    with pytest.raises(ValueError, match=r"expected the table \[driveline\].*have no measured speed in .*; found none"):
        identify([log, log], [CLAY] * 2, KNOWN)


@pytest.mark.study
def test_numbers_are_recovered_without_wheel_speeds():
    """Wheels that turn as the balance asks, in the drives and in the model; no balance of measured ones."""
    known = replace(KNOWN, driveline={"centre_lock": 1.0, "front_drive": 0.5})
    made = (("lock", 0.5, 1), ("multi", 0.65, 2), ("multi", 0.65, 3))
    drives = [replace(drive_of(TRUE, kind, n, seed, wheels=False), name=f"{kind}_{seed}") for kind, n, seed in made]
    found = identify(drives, [CLAY] * 3, known)
    assert found.vehicle.n_error > 0.05
    assert found.verdict == "identified"
    assert any("not every speed is measured in" in note for note in found.notes)
    assert found.numbers["radius"].value == pytest.approx(KNOWN["radius"] + KNOWN.search, rel=0.002)
    inertia = found.numbers["yaw_inertia"]
    assert inertia.value == pytest.approx(TRUE["yaw_inertia"], abs=3.0 * inertia.std + 23.0)
    for drive, (_, true, _) in zip(drives, made, strict=True):
        n, std = found.n[drive.name]
        assert n == pytest.approx(true, rel=0.06) and 0.04 * true < std < 0.1 * true


def test_soils_and_known_numbers_that_do_not_fit_the_logs_are_refused():
    logs = [MULTI_LOG, MULTI_LOG]
    with pytest.raises(ValueError, match="one soil, or one for each of 2 logs; found 3"):
        identify(logs, [CLAY] * 3, KNOWN)
    with pytest.raises(ValueError, match="known: expected key 'radius'"):
        identify(logs, CLAY, {key: value for key, value in KNOWN.numbers.items() if key != "radius"})


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """The command on logs of the reference vehicle, from what a scale and a tape say of it."""
    folder = tmp_path_factory.mktemp("identify")
    (folder / "known.toml").write_text(TOML, encoding="utf-8")
    arguments = ["identify", CLAY_LOG, MULTI_LOG, LOAM_LOG, "--vehicle", folder / "known.toml", "--out", folder]
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    assert result.exit_code == 0, result.output
    return folder, result.output


@pytest.mark.study
def test_the_reference_vehicle_is_identified_from_a_scale_and_a_tape(identified):
    folder, output = identified
    found = json.loads((folder / "identify.json").read_text(encoding="utf-8"))
    assert found["verdict"] == "identified" and "Identified" in output
    assert found["judged_on"] == "paper_sandyloam_n0.70"
    for log, n in found["n"].items():
        assert n["value"] == pytest.approx(named_n(log), rel=0.1 if log == found["judged_on"] else 0.06)
    inertia = found["numbers"]["yaw_inertia"]
    assert inertia["value"] == pytest.approx(load_vehicle("reference").yaw_inertia, rel=0.05) and inertia["state"] == "identified"
    assert found["numbers"]["mass"]["state"] == "given"
    for state in ("v", "omega_z", "psi", "y"):
        assert found["after"]["mse"]["2.5"][state] < 0.2 * found["before"]["mse"]["2.5"][state]
    assert found["asks"] and found["software"]["version"] and found["vehicle"]["name"] == "paper"


@pytest.mark.study
def test_the_vehicle_file_is_complete_and_says_the_state_of_each_number(identified):
    folder, _ = identified
    text = (folder / "vehicle.toml").read_text(encoding="utf-8")
    vehicle = load_vehicle(folder / "vehicle.toml")
    found = json.loads((folder / "identify.json").read_text(encoding="utf-8"))
    assert vehicle.yaw_inertia == pytest.approx(found["numbers"]["yaw_inertia"]["value"], rel=1e-4)
    for name, std in vehicle.uncertainty.items():  # with all others as they are: no larger than with all others free
        assert 0 < std <= 1.001 * found["numbers"][name]["std"]
    assert vehicle.uncertainty["track"] < 0.5 * found["numbers"]["track"]["std"], "both tracks' errors are correlated"
    assert "mass = 1378.33  # kg ± 6.9, given" in text and "identified" in text
    own = [n["std"] / n["value"] for log, n in found["n"].items() if log != found["judged_on"]]
    assert vehicle.n_error == pytest.approx(np.sqrt(np.mean(np.square(own))), rel=1e-4) and 0.025 < vehicle.n_error < 0.04
    assert vehicle.unexplained["omega_z"] == pytest.approx(max(one["omega_z"] for one in found["unexplained"].values()), rel=1e-3)
    assert 0.005 < vehicle.unexplained["omega_z"] < 0.04 and set(found["unexplained"]) == set(found["n"])
    report = (folder / "report.html").read_text(encoding="utf-8")
    assert report.count("<img") == 3 and "http" not in report


@pytest.mark.study
def test_the_road_from_a_new_vehicle_to_its_c_library(identified, tmp_path):
    """identify -> refine -> estimate -> generate on one vehicle file, and the refined file on another soil."""
    folder, _ = identified
    vehicle = folder / "vehicle.toml"
    log = write_drive(read_drive(MULTI_LOG).between(0.0, 24.0), tmp_path / "multi.csv")

    def run(*arguments):
        result = CliRunner().invoke(app, [str(a) for a in arguments])
        assert result.exit_code == 0, result.output
        return result.output

    said = run("refine", log, "--vehicle", vehicle, "--soil", "clay", "--out", tmp_path / "refine")
    found = json.loads((tmp_path / "refine" / "refine.json").read_text(encoding="utf-8"))
    assert found["verdict"] == "none" and not found["contradicted"]
    assert found["n"]["verdict"] == ["identified"] and found["n"]["after"][0] == pytest.approx(0.5, rel=0.1)
    assert "n identified" in said and set(found["fitted"]) <= set(load_vehicle(vehicle).uncertainty)
    run("estimate", log, "--vehicle", vehicle, "--soil", "clay", "--n0", "0.7", "--out", tmp_path / "estimate")
    estimate = json.loads((tmp_path / "estimate" / "estimate.json").read_text(encoding="utf-8"))
    assert estimate["verdict"] == "identified" and estimate["n_front"] == pytest.approx(0.5, rel=0.1)
    refined = tmp_path / "refine" / "refined.toml"
    run("generate", tmp_path / "library", "--vehicle", refined, "--soil", "sandy_loam")
    declared = json.loads((tmp_path / "library" / "formulation.json").read_text(encoding="utf-8"))
    assert "sandy_loam" in json.dumps(declared)


def test_bad_input_is_refused_in_one_line(tmp_path):
    (tmp_path / "known.toml").write_text("mass = 1000.0\n", encoding="utf-8")
    logs = [str(CLAY_LOG), str(MULTI_LOG)]
    arguments = ["identify", *logs, "--vehicle", str(tmp_path / "known.toml"), "--out", str(tmp_path / "o")]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 2 and "expected key 'l_f'" in result.output
    (tmp_path / "known.toml").write_text(TOML, encoding="utf-8")
    for more, words in (
        (["--soil", "clay", "--soil", "clay", "--soil", "sand"], "one for all or one per log (2"),
        (["--judge", str(tmp_path / "none.csv")], "none.csv"),
    ):
        result = CliRunner().invoke(app, [*arguments, *more])
        assert result.exit_code == 2 and words in result.output
    assert not (tmp_path / "o").exists()


@pytest.mark.study
@pytest.mark.shared
def test_the_second_vehicle_is_identified_and_n_is_right_on_other_drives(shared_data):
    """Judged figures: `python -m benchmarks.identify_suv`."""
    from benchmarks.identify_suv import FITTED, HELD
    from benchmarks.identify_suv import KNOWN as SUV

    names = (*FITTED, HELD)
    folder = shared_data / "chrono_suv"
    drives = [add_noise(read_drive(folder / f"{name}.csv.gz"), "good", 10 * i) for i, name in enumerate(names)]
    found = identify(drives, [load_soil(str(named_soil(name))) for name in names], SUV)
    assert found.verdict == "identified"
    assert found.n[HELD][0] == pytest.approx(named_n(HELD), rel=0.05)
    assert found.numbers["yaw_inertia"].value == pytest.approx(3920.0, rel=0.06)
    wrong = SUV.with_numbers(radius=1.01 * SUV["radius"])
    parts = [drive.between(drive.t[0], drive.t[0] + 18.0) for drive in drives]
    found = identify(parts, [load_soil(str(named_soil(name))) for name in names], wrong)
    assert found.verdict == "contradicts_given" and found.contradictions[0].name == "radius"
    assert "[uncertainty] radius = 0.0" in found.reason
