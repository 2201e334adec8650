"""softsoil refine on drives of the project's own bicycle: what was added is found, what was not is not invented."""

import json
import math
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG, reference_vehicle
from softsoil.checking.usable import mark_checked
from softsoil.commands.cli import app
from softsoil.commands.output import OutputFolder
from softsoil.commands.refine import write_all
from softsoil.declaration.model_file import Declaration, load_declaration
from softsoil.figures import refine_report
from softsoil.figures.refine import draw_axles, draw_ranking
from softsoil.figures.refine_report import write_report
from softsoil.figures.refine_views import drive_views, held_horizon
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.drive import Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive, write_drive
from softsoil.refinement.excitation import one_wave, strongest_line
from softsoil.refinement.fit import Fit, Free
from softsoil.refinement.folds import folded
from softsoil.refinement.refine import held_mse, refine
from softsoil.refinement.remarks import close_calls, inseparable
from softsoil.refinement.rules import RULES
from softsoil.refinement.selection import (
    Selection,
    hidden_by_noise,
    least_sigmas,
    least_whole,
    placed_for_sure,
    supported,
)
from softsoil.refinement.structure import Structure
from softsoil.refinement.trace import Candidate, everything, fit_base, gain_of, make_bench
from softsoil.refinement.wheel_speeds import all_open, differential_shares, locked_axles
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.soil import CLAY, SAND
from softsoil.windows.shooting import Shooting

runner = CliRunner()
CANDIDATES = ("steering_offset", "bank", "yaw_moment", "gyro_bias")
OFFSET = 0.03
SECONDS = 26.0
N = 0.6


def drive(effects):
    """A noisy multi-sine drive of the bicycle with the given effects, on clay softer than declared."""
    vehicle = reference_vehicle()
    model = bicycle(vehicle, CLAY.with_(n=N), "turn_slip", effects)
    t = 0.012 * np.arange(round(SECONDS / 0.012) + 1)
    steer = MultiSine(0.35, seed=4)(t)
    return add_noise(synthetic_drive(model, vehicle.radius, seconds=SECONDS, speed=5.5, steer=steer), "good", 1)


@pytest.fixture(scope="module")
def declared():
    return Declaration(reference_vehicle().with_(effects={}), CLAY)


@pytest.fixture(scope="module")
def offset_drive():
    return drive({"steering_offset": {"steering_offset": OFFSET}})


@pytest.fixture(scope="module")
def found(offset_drive, declared):
    return refine([offset_drive], declared, workers=1, candidates=CANDIDATES)


def test_offset_that_was_added_is_found_with_its_size(found):
    assert found.verdict == "effect"
    assert found.effects[0].name == "steering_offset"
    value, std, unit = found.effects[0].parameters["steering_offset"]
    assert unit == "rad"
    assert abs(value - OFFSET) < 0.1 * OFFSET
    assert 0 < std < 0.1 * OFFSET
    assert found.n_after[0] == pytest.approx(N, rel=0.05)
    assert found.after["2.5"]["omega_z"] < 0.2 * found.before["2.5"]["omega_z"]


@pytest.mark.study
def test_more_of_a_declared_effect_is_named_with_all_there_is_of_it():
    """A vehicle that pulls by 22 N m as declared, on a drive with 500 N m: what is named is all of it."""
    pulling = Declaration(reference_vehicle().with_(effects={"yaw_moment": {"yaw_moment": 22.0}}), CLAY)
    more = refine([drive({"yaw_moment": {"yaw_moment": 500.0}})], pulling, workers=1, candidates=CANDIDATES)
    assert [effect.name for effect in more.effects] == ["yaw_moment"]
    assert more.effects[0].parameters["yaw_moment"][0] == pytest.approx(500.0, rel=0.1)
    refined = more.declaration.vehicle.effects["yaw_moment"]["yaw_moment"]
    assert refined == more.effects[0].parameters["yaw_moment"][0]
    as_is = refine([drive({"yaw_moment": {"yaw_moment": 22.0}})], pulling, workers=1, candidates=CANDIDATES)
    assert as_is.verdict == "none"


def candidate(name, gain, std):
    fit = Fit((), np.empty(0), np.empty(0), np.empty((1, 0)), 1.0, ())
    return Candidate(name, fit, np.ones(4), gain, std)


def test_like_effects_that_gained_nearly_as_much_are_said():
    """A bank and a steering offset push alike: the second, hardly behind, is a close call; a backlash has another look."""
    known = catalogue(reference_vehicle())
    bank, offset, play = candidate("bank", 0.6, 0.05), candidate("steering_offset", 0.57, 0.05), candidate("backlash", 0.58, 0.05)
    none = Selection((bank,), None, (bank, play, offset), (("bank",),))  # type: ignore[arg-type]
    assert close_calls(none, known) == (("bank", "steering_offset"),)
    far = Selection((bank,), None, (bank, candidate("steering_offset", 0.4, 0.05)), (("bank",),))  # type: ignore[arg-type]
    assert close_calls(far, known) == ()


def test_nothing_is_invented_where_nothing_was_added(declared):
    clean = refine([drive({})], declared, workers=1, candidates=CANDIDATES)
    assert clean.verdict == "none"
    assert clean.effects == ()
    assert clean.before == clean.after


ABOUT = {"software": {"version": "0.1", "command": "softsoil refine a.csv"}, "vehicle": {"name": "car", "file": "car.toml"}}


def test_paths_are_of_the_longest_windows_that_the_part_that_judges_holds(found):
    shooting = found.bench.shootings[0]
    row = shooting.rows[found.bench.held[0][0]]
    assert held_horizon(shooting, row) == 0.5, "of 2.5 s it holds fewer than four"
    driven = shooting.drive.driven.copy()
    driven[row :: round(0.4 / shooting.drive.dt)] = False
    gaps = Shooting(shooting.model, replace(shooting.drive, driven=driven), 1.0, compiled=shooting.compiled)
    assert held_horizon(gaps, row) == 0.0


def test_a_report_says_where_there_are_no_paths_and_no_axle_forces(found, tmp_path):
    (view,) = drive_views(found, 2.0)
    none = np.empty((0, 0, 3))
    assert "no window of 0.5 s" in refine_report._paths(replace(view, recorded=none, path_before=none, path_after=none))
    unjudged = Structure({"front": math.nan, "rear": math.nan}, {"front": {}, "rear": {}})
    blind = replace(view, structure_before=unjudged, structure_after=unjudged)
    left = refine_report._left([blind], True)
    assert left.count("not judged") == 4 and "nan" not in left
    assert draw_axles(blind, tmp_path / "axles.png").stat().st_size > 1e4


def test_files_of_a_refinement(found, offset_drive, declared, tmp_path):
    paths = write_all([offset_drive], found, OutputFolder(tmp_path), ABOUT["vehicle"])
    paths.append(write_report(declared, found, 2.0, tmp_path / "report.html", ABOUT))
    assert [path.name for path in paths] == ["refine.json", "refined.toml", "report.html"]
    content = json.loads(paths[0].read_text(encoding="utf-8"), parse_constant=pytest.fail)
    expected = {
        "verdict",
        "effects",
        "contradicted",
        "fitted",
        "n",
        "inseparable",
        "would_separate",
        "ranking",
        "holdout",
        "before",
        "after",
        "seconds",
    }
    assert expected <= set(content)
    assert set(content["effects"][0]["parameters"]["steering_offset"]) == {"value", "std", "unit"}
    assert set(content["ranking"][0]) == {"name", "holdout_gain", "std"}
    assert {entry["name"] for entry in content["ranking"]} >= set(CANDIDATES)
    assert content["n"]["verdict"] == ["identified"] and content["n"]["soil"] == ["clay"]
    assert content["n"]["after"][0] == pytest.approx(N, rel=0.05) and content["n"]["std"][0] > 0
    assert 2.0 < content["holdout"]["from"] < content["holdout"]["to"] < SECONDS
    assert set(content["before"]["mse"]) == {"0.5", "2.5", "5.0"}
    assert paths[1].read_text(encoding="utf-8").startswith("# softsoil ")
    loaded = load_declaration(paths[1])
    assert loaded.vehicle.effects["steering_offset"]["steering_offset"] == pytest.approx(OFFSET, rel=0.1)
    assert loaded.soil.n == pytest.approx(N, rel=0.05)
    assert loaded.build().effects == ("steering_offset",)
    std = found.effects[0].parameters["steering_offset"][1]
    assert loaded.vehicle.uncertainty["steering_offset"] == pytest.approx(std, rel=1e-3)
    html = paths[2].read_text(encoding="utf-8")
    assert html.count("data:image/png;base64,") == 3
    assert not re.search(r"(src|href)=\"(?!data:)", html), "the report is to stand alone"
    assert "softsoil 0.1: softsoil refine a.csv" in html and "vehicle car, car.toml" in html
    assert "steering offset" in html and "which that fit has not seen" in html


def test_a_law_whose_numbers_go_by_the_soils_name_takes_one_class(offset_drive, declared):
    drives, by_name = [offset_drive, offset_drive], replace(declared, law="dallas_refit")
    with pytest.raises(ValueError, match=r"one class with the force law dallas_refit, .* found clay, sand: one call for each"):
        refine(drives, by_name, soils=[CLAY, SAND])


def test_unknown_candidate_is_named(offset_drive, declared):
    with pytest.raises(ValueError, match=r"candidates: expected names of .*aligning_moment.*found 'wind'"):
        refine([offset_drive], declared, candidates=["wind"])


@pytest.mark.study
def test_a_drive_that_ends_standing_and_reversing_is_refined_where_it_goes_forwards(offset_drive, declared, found):
    still = {name: np.full(400, values[-1]) for name, values in offset_drive.channels.items()}
    still["t"] = offset_drive.t[-1] + offset_drive.dt * np.arange(1, 401)
    still["u"] = np.r_[np.zeros(200), np.full(200, -1.0)]
    channels = {name: np.r_[values, still[name]] for name, values in offset_drive.channels.items()}
    marked = mark_checked(Recording("stopped", channels))  # a check would refuse a stop that the accelerometer does not feel
    stopped = refine([marked], declared, workers=1, candidates=CANDIDATES)
    assert stopped.effects[0].parameters == found.effects[0].parameters
    assert any("the vehicle reverses for 2.39 s" in note for note in stopped.notes)


@pytest.mark.study
def test_horizons_longer_than_what_is_driven_at_a_stretch_are_left_out(offset_drive, declared):
    u = offset_drive["u"].copy()
    rows = np.arange(len(u)) % round(6.0 / offset_drive.dt) < round(0.3 / offset_drive.dt)
    u[rows] = 0.0  # a stop every six seconds, and two seconds of start-up after each
    bench = make_bench([mark_checked(offset_drive.with_channels(u=u))], declared, 2.0)
    table = held_mse(bench, bench.absent)
    assert np.isfinite(table["2.5"]["omega_z"]) and math.isnan(table["5.0"]["omega_z"])


@pytest.mark.study
def test_an_effect_of_no_size_is_not_named_and_said(declared):
    found = refine([drive({"yaw_moment": {"yaw_moment": 50.0}})], declared, workers=1, candidates=("yaw_moment",))
    assert found.ranking[0].gain > RULES.least_gain
    assert found.verdict == "none" and not found.effects
    assert any(note.startswith("yaw_moment: not named, smaller than") for note in found.notes)


def test_what_no_force_law_knows_of_is_held_to_less(declared):
    known = catalogue(declared.vehicle)
    assert least_whole(known["soil_change"]) == least_whole(known["gyro_bias"]) < least_whole(known["payload"])


@pytest.mark.parametrize(
    ("name", "sigmas", "gain", "sure"),
    [
        ("soil_change", 4.5, 0.05, True),
        ("soil_change", -4.5, 0.05, True),
        ("soil_change", 3.5, 0.05, False),
        ("soil_change", 4.5, -0.01, False),
        ("payload", 9.0, 0.05, False),
    ],
)
def test_a_change_at_a_place_needs_certainty_and_any_gain(declared, name, sigmas, gain, sure):
    effect = catalogue(declared.vehicle)[name]
    lead = effect.parameters[0]
    free = (Free(lead.name, (lead.name,), 0.1, lead.lower, lead.upper),)
    overall = Fit(free, np.array([lead.nominal + 0.04 * sigmas]), np.array([0.04]), np.zeros((1, 1)), 1.0, ())
    candidate = Candidate(name, overall, np.ones(9), gain, 0.1, 0.01, overall)
    assert placed_for_sure(candidate, effect) is sure
    assert not placed_for_sure(replace(candidate, overall=None), effect)


@pytest.mark.parametrize(
    ("gain", "whole", "one", "hidden"), [(0.43, 0.09, False, True), (0.43, 0.09, True, False), (0.2, 0.05, False, False)]
)
def test_much_beyond_noise_that_is_too_little_to_be_named_is_missing_all_the_same(declared, gain, whole, one, hidden):
    effect = catalogue(declared.vehicle)["payload"]
    lead = effect.parameters[0]
    free = (Free(lead.name, (lead.name,), 0.1, lead.lower, lead.upper),)
    fit = Fit(free, np.array([300.0]), np.array([50.0]), np.zeros((1, 1)), 1.0, ())
    candidate = Candidate("payload", fit, np.ones(9), gain, 0.08, whole)
    nothing = Selection((), None, (candidate,), (), {"payload": effect})  # type: ignore[arg-type]
    assert not supported(candidate, effect)
    assert bool(hidden_by_noise(nothing, one)) is hidden
    assert hidden_by_noise(replace(nothing, accepted=(candidate,)), one) == ()


@pytest.mark.study
def test_a_change_too_small_for_its_gain_is_named_by_its_certainty(declared):
    change = {"n_change": 0.055, "change_x": 55.0, "change_y": 0.0, "change_heading": 0.2}
    known = Declaration(declared.vehicle.with_(uncertainty={"yaw_inertia": 1.0, "radius": 1e-5}), CLAY)
    found = refine([drive({"soil_change": change})], known, workers=1, candidates=("soil_change", "bank"))
    assert [effect.name for effect in found.effects] == ["soil_change"]
    assert not supported(found.selection.accepted[0], catalogue(declared.vehicle)["soil_change"])
    assert found.effects[0].parameters["n_change"][0] == pytest.approx(0.055, rel=0.5)


def test_what_is_handed_on_is_fitted_to_the_whole_drive(found):
    bench = found.selection.bench
    part = bench.absent[0, bench.model.p.index("steering_offset")]
    whole = fit_base(everything(bench)).named()["steering_offset"]
    assert found.effects[0].parameters["steering_offset"][:2] == pytest.approx(whole)
    assert part != pytest.approx(whole[0], rel=1e-4)
    assert found.after == held_mse(bench, bench.absent)


@pytest.mark.study
def test_a_change_of_soil_is_found_where_it_is(declared):
    change = {"n_change": 0.25, "change_x": 55.0, "change_y": 0.0, "change_heading": 0.2}
    found = refine([drive({"soil_change": change})], declared, workers=1, candidates=("soil_change", "bank"))
    assert [effect.name for effect in found.effects] == ["soil_change"]
    value, std, _ = found.effects[0].parameters["n_change"]
    assert abs(value - 0.25) < max(4 * std, 0.03)
    crossed = found.recordings[0]
    rows = [int(np.argmax(crossed["x"] * math.cos(h) + crossed["y"] * math.sin(h) > d)) for h, d in _borders(found, change)]
    assert abs(crossed.t[rows[0]] - crossed.t[rows[1]]) < 0.8


def _borders(found, change):
    """Heading and distance from the origin of the border that was found and of the true one."""
    values = {name: entry[0] for name, entry in found.effects[0].parameters.items()}
    for at in (values, change):
        h = at["change_heading"]
        yield h, at["change_x"] * math.cos(h) + at["change_y"] * math.sin(h)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["absent.csv", "--soil", "clay"], "absent.csv"),
        (["short.csv"], "--soil"),
        (["short.csv", "--soil", "mud"], "mud"),
        (["short.csv", "--soil", "clay"], "at least 3 s of drive"),
        (["short.csv", "--soil", "clay", "--workers", "0"], "workers"),
    ],
)
def test_bad_input_is_one_line_with_code_2(arguments, words, offset_drive, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_drive(offset_drive.between(0.0, 4.0), tmp_path / "short.csv")
    result = runner.invoke(app, ["refine", *arguments])
    assert result.exit_code == 2
    lines = [line for line in result.output.splitlines() if line.startswith("error:")]
    assert len(lines) == 1 and words in lines[0]


def test_numbers_carry_the_digits_of_their_error():
    from softsoil.refinement.words import with_error

    assert with_error(0.08712, 0.0013) == "0.0871 ± 0.0013"
    assert with_error(912.4, 31.0) == "912 ± 31"
    assert with_error(0.7, 0.0) == "0.7"
    assert with_error(0.7, math.nan) == "0.7"


def test_gain_is_as_sure_as_its_share_is_steady():
    before = np.array([1.0, 10.0, 2.0, 30.0, 5.0])
    gain, std = gain_of(before, 0.2 * before)
    assert gain == pytest.approx(0.8)
    assert std < 1e-12
    gain, std = gain_of(before, before * [0.2, 0.9, 0.1, 0.9, 0.2])
    assert gain == pytest.approx(1 - (0.2 + 9 + 0.2 + 27 + 1) / 48)
    assert std > 0.03


def test_wheel_speeds_tell_a_locked_differential_from_an_open_one(declared):
    """Rigid kinematics: freely rolling wheels differ by track omega_z/radius, locked ones by nothing."""
    vehicle, plain = declared.vehicle, drive({})
    half = vehicle.track / 2 * plain["omega_z"] / vehicle.radius
    apart = {f"omega_{axle}{side}": plain[f"omega_{axle}{side}"] + sign * half
             for axle in "fr" for side, sign in (("l", -1), ("r", 1))}  # fmt: skip
    rolling = plain.with_channels(**apart)
    assert differential_shares(rolling, vehicle) == pytest.approx({"front": 1.0, "rear": 1.0}, abs=0.05)
    assert all_open(rolling, vehicle) and not locked_axles(rolling, vehicle)
    rear_locked = rolling.with_channels(omega_rl=plain["omega_rl"], omega_rr=plain["omega_rl"])
    assert locked_axles(rear_locked, vehicle) == ("rear",) and not all_open(rear_locked, vehicle)
    every_other = np.where(np.arange(len(plain)) % 2 == 0, 1.0, np.nan)
    slow = rolling.with_channels(**{name: values * every_other for name, values in rolling.channels.items() if name in apart})
    assert differential_shares(slow, vehicle) == pytest.approx(differential_shares(rolling, vehicle), abs=0.02)
    narrow = replace(vehicle, track_rear=0.5 * vehicle.track)
    assert differential_shares(rolling, narrow) == pytest.approx({"front": 1.0, "rear": 2.0}, abs=0.1)


@pytest.mark.study
def test_what_the_wheel_speeds_exclude_is_not_tried():
    log = read_drive(MULTI_LOG).between(0.0, 14.0)
    found = refine([log], Declaration(reference_vehicle(), CLAY), workers=1, candidates=["locked_differential", "bank"])
    known = catalogue(reference_vehicle())
    assert [candidate.name for candidate in found.ranking if candidate.name in known] == ["bank"]


def test_noise_that_no_model_removes_does_not_hide_a_gain():
    noise = np.array([1.0, 1.1, 0.9, 1.0, 1.05, 0.95])
    excess = np.array([0.2, 0.5, 0.3, 0.4, 0.6, 0.4])
    plain, _ = gain_of(noise + excess, noise + 0.1 * excess)
    gain, _ = gain_of(noise + excess, noise + 0.1 * excess, floor=1.0)
    assert plain < 0.3 and gain == pytest.approx(0.9, rel=0.01)
    # Noise is not known well: nothing becomes certain where it is all there is.
    gain, _ = gain_of(noise, 0.98 * noise, floor=2.0)
    assert gain == pytest.approx(0.02 / 0.2)


def test_few_windows_ask_for_more():
    assert least_sigmas(3) > least_sigmas(7) > 1.9
    assert math.isnan(least_sigmas(1))


@pytest.mark.parametrize("one_wave", [False, True])
def test_every_window_is_held_out_once(declared, one_wave):
    bench = make_bench([drive({})], declared, 2.0, names=("bank",))
    parts = [folded(bench, fold, one_wave) for fold in range(RULES.folds)]
    assert all(np.all(np.diff(part.held[0]) == (1 if one_wave else RULES.folds)) for part in parts)
    held = np.concatenate([part.held[0] for part in parts])
    assert np.array_equal(np.sort(held), np.arange(len(bench.shootings[0].rows)))
    for part in parts:
        assert not set(part.held[0]) & set(part.fitted[0])


def test_one_wave_is_told_from_many():
    t = 0.012 * np.arange(2000)
    still = Recording("still", {"t": t, "steer": np.zeros(len(t))})
    sine = still.with_channels(steer=0.4 * np.sin(2 * np.pi * t / 3.0))
    many = still.with_channels(steer=MultiSine(0.35, seed=4)(t))
    assert one_wave(sine) and strongest_line(sine) > 0.95
    assert not one_wave(many) and not one_wave(still) and strongest_line(still) == 0.0


def test_effects_that_are_both_needed_have_been_told_apart():
    candidates = tuple(Candidate(name, None, np.zeros(1), 0.5, 0.1) for name in ("multipass", "load_transfer"))
    groups = (("multipass", "load_transfer"), ("load_transfer", "payload"), ("bank",))
    found = inseparable(Selection(candidates, None, (), groups))
    assert found == (("load_transfer", "payload"),)


def test_a_gain_that_is_not_known_is_drawn_as_none(tmp_path):
    """Of a part that judges without a measurement: the report has no picture to fail at."""
    fit = Fit((), np.zeros(0), np.zeros(0), np.zeros((1, 1)), 1.0, ())
    ranking = [Candidate(name, fit, np.ones(9), gain, gain, gain) for name, gain in (("bank", 0.3), ("payload", np.nan))]
    path = draw_ranking(SimpleNamespace(ranking=ranking, effects=(), contradicted=()), tmp_path / "ranking.png")
    assert path.read_bytes()[:4] == b"\x89PNG"
