"""What an identification is made of: known numbers, priors, geometry by motion, standard errors, manoeuvres to ask for."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from drives import clay_drive, reference_vehicle
from softsoil.checking.geometry_check import beyond_doubt, front_axle, rolling_radius
from softsoil.figures.numbers import shown_states
from softsoil.identification.asks import MANOEUVRES, Excitation, asks, excitation
from softsoil.identification.axle_places import axle_places
from softsoil.identification.errors import Errors, departures, errors_of, n_costs
from softsoil.identification.identify import by_rolling
from softsoil.identification.n_errors import model_error, n_stds
from softsoil.identification.result import Found
from softsoil.identification.rules import RULES
from softsoil.identification.words import state_words, taking_up_sentence
from softsoil.recording.derive import completed
from softsoil.recording.drive import Recording
from softsoil.recording.noise import add_noise
from softsoil.refinement.known_vehicle import Known, known_from_table, load_known
from softsoil.refinement.vehicle_numbers import NUMBERS, declared_vehicle, expected, free_layout, vehicle_of
from softsoil.windows.parameters import Free
from softsoil.windows.window_fit import WindowFit

NUMBERS_GIVEN = {"mass": 1400.0, "l_f": 1.5, "l_r": 1.2, "track": 1.25, "radius": 0.33, "width": 0.21}
KNOWN = Known("car", NUMBERS_GIVEN)


def test_axle_loads_and_wheelbase_give_the_place_of_the_centre_of_gravity():
    table = {k: v for k, v in NUMBERS_GIVEN.items() if k not in ("l_f", "l_r")}
    known = known_from_table({**table, "wheelbase": 2.7, "load_front": 800.0, "load_rear": 600.0}, "car.toml", "car")
    assert known["l_f"] == pytest.approx(2.7 * 600 / 1400) and known.wheelbase == pytest.approx(2.7)


@pytest.mark.parametrize(
    ("state", "std", "given", "words"),
    [
        ("identified", 0.19, None, "identified"), ("identified", 0.2, None, "fitted (no better known than before)"),
        ("identified", 0.2, 1.2, "identified (given 1.2)"), ("not_identifiable", 0.2, None, "not identifiable"),
    ],
)  # fmt: skip
def test_an_identified_number_that_is_no_better_known_than_before_says_so(state, std, given, words):
    assert state_words(Found(1.1, std, "m", state, 0.5, given, (1.0, 0.2))) == words


def test_numbers_that_take_up_what_the_model_lacks_are_named_where_they_are_identified():
    one = Found(1.1, 0.1, "m", "identified", 0.5, None, (1.0, 0.2))
    numbers = {"yaw_inertia": one, "scrub": one, "lean_steer": replace(one, state="not_identifiable"), "track": one}
    said = taking_up_sentence(SimpleNamespace(numbers=numbers))
    assert "does not hold: track, scrub." in said
    assert taking_up_sentence(SimpleNamespace(numbers={"yaw_inertia": one})) == ""
    far = replace(one, value=-1.0)
    said = taking_up_sentence(SimpleNamespace(numbers={"yaw_inertia": far, "scrub": replace(far, given=1.0)}))
    assert "does not hold: yaw_inertia, scrub." in said and said.endswith("of any vehicle: yaw_inertia by 10.0.")


@pytest.mark.parametrize("unit", (1.0, 9.81, 9.81e-3, 2.2046), ids=("kg", "N", "kN", "lb"))
def test_axle_loads_make_up_the_mass(unit):
    """In any unit of a scale; a mass that is half of what the axles bear would make every n wrong, and no log shows it."""
    weighed = {name: value for name, value in NUMBERS_GIVEN.items() if name not in ("l_f", "l_r")}
    weighed |= {"wheelbase": 2.7, "load_front": 790.0 * unit, "load_rear": 620.0 * unit}
    assert known_from_table(dict(weighed), "car.toml", "car")["mass"] == 1400.0
    with pytest.raises(ValueError, match=r"car\.toml: expected load_front and load_rear that make up the mass of 700 kg"):
        known_from_table({**weighed, "mass": 700.0}, "car.toml", "car")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mass": None}, "expected key 'mass'"),
        ({"l_f": None}, "expected key 'l_f' \\(or wheelbase, load_front and load_rear\\)"),
        ({"radius": -1.0}, "expected radius in"),
        ({"weight": 5.0}, "found 'weight'"),
        ({"mass": "heavy"}, "expected a finite number, found 'heavy'"),
    ],
)
def test_a_known_file_that_cannot_be_used_is_refused_naming_the_key(tmp_path, change, words):
    numbers = {**NUMBERS_GIVEN, **change}
    path = tmp_path / "known.toml"
    lines = [f'{k} = "{v}"' if isinstance(v, str) else f"{k} = {v}" for k, v in numbers.items() if v is not None]
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(ValueError, match=words):
        load_known(path)


def test_a_given_number_has_the_error_of_measuring_it_and_an_unknown_one_its_prior():
    before = expected(KNOWN.with_numbers(yaw_inertia=2000.0))
    assert before["yaw_inertia"] == (2000.0, pytest.approx(100.0))
    free = expected(KNOWN)["yaw_inertia"]
    assert free[0] == pytest.approx(0.85 * KNOWN.swing) and free[1] > 0.3 * free[0]
    stated = replace(KNOWN, numbers={**NUMBERS_GIVEN, "yaw_inertia": 2000.0}, stated={"yaw_inertia": 7.0})
    assert expected(stated)["yaw_inertia"] == (2000.0, 7.0)


def test_priors_scale_with_the_vehicle_and_stay_inside_their_bounds():
    small = Known("small", {"mass": 40.0, "l_f": 0.3, "l_r": 0.3, "track": 0.5, "radius": 0.1, "width": 0.08})
    large = Known("large", {"mass": 9000.0, "l_f": 2.0, "l_r": 2.0, "track": 2.2, "radius": 0.6, "width": 0.4})
    for known in (small, KNOWN, large):
        for number in NUMBERS:
            value, std = expected(known)[number.name]
            assert number.lower <= value <= number.upper and std > 0
        assert set(free_layout(known).names) <= {number.name for number in NUMBERS}
    assert expected(small)["scrub"][1] < 0.2 * expected(large)["scrub"][1]


def test_the_vehicle_carries_numbers_effects_and_their_uncertainty():
    vehicle = vehicle_of(KNOWN, {"kappa": 0.7, "toe_rear": 0.01}, {"kappa": 0.1, "mass": 7.0})
    assert vehicle.effects["multipass"]["kappa"] == 0.7 and vehicle.toe_rear == 0.01
    assert vehicle.uncertainty == {"kappa": 0.1, "mass": 7.0}
    assert declared_vehicle(KNOWN).effects == {}


def test_a_contact_search_enlarges_the_expected_radius_and_is_no_number_of_the_vehicle():
    table = {**NUMBERS_GIVEN, "simulator": {"contact_step": 0.002, "contact_search": 0.002}}
    known = known_from_table(table, "car.toml", "car")
    value, std = expected(known)["radius"]
    assert value == pytest.approx(0.332) and std > expected(KNOWN)["radius"][1]
    assert known.value("radius") == 0.33 and vehicle_of(known, {}).simulator == {"contact_step": 0.002}
    with pytest.raises(ValueError, match="contact_search: expected 0 to a tenth of the radius"):
        known_from_table({**NUMBERS_GIVEN, "simulator": {"contact_search": 0.2}}, "car.toml", "car")


def radius_errors(std):
    return Errors(("radius",), np.array([0.33]), np.array([[std**2]]), np.array([std**2]), np.zeros(1), np.ones(1))


@pytest.mark.parametrize(("share", "said"), [(1.0, False), (1.002, False), (1.01, True), (0.99, True)])
def test_a_radius_that_does_not_roll_is_contradicted(share, said):
    errors = radius_errors(0.0002)
    contradiction, note = by_rolling(KNOWN, {"radius": share * 0.33}, errors, RULES)
    assert (contradiction is not None) == said
    measured = float(note.split("m, ")[1].split(" ")[0])
    assert measured == pytest.approx(share * 0.33, abs=1e-4) and "these logs contradict one that is 2.2 mm off" in note
    if said:
        assert contradiction.value == pytest.approx(share * 0.33) and contradiction.sigmas > RULES.contradicted_rolling
    rough = known_from_table({**NUMBERS_GIVEN, "simulator": {"contact_search": 0.0033}}, "car.toml", "car")
    assert by_rolling(rough, {"radius": 1.01 * 0.33}, errors, RULES)[0] is None, "the search makes up for it"


def moving(l_f=1.4, seconds=40.0, dt=0.012, sway=0.0):
    """A body that moves as prescribed, positions of its front axle recorded: kinematics alone. sway: m per m/s^2."""
    fine = dt / 20
    t = fine * np.arange(round(seconds / fine))
    psi, u, v = 0.5 * np.sin(2.1 * t), 5.0 + np.sin(0.6 * t), 0.3 * np.cos(2.1 * t)
    x = np.cumsum(u * np.cos(psi) - v * np.sin(psi)) * fine + l_f * np.cos(psi)
    y = np.cumsum(u * np.sin(psi) + v * np.cos(psi)) * fine + l_f * np.sin(psi)
    aside = sway * (np.gradient(v, fine) + u * 1.05 * np.cos(2.1 * t))
    x, y = x - aside * np.sin(psi), y + aside * np.cos(psi)
    channels = {"t": t, "x": x, "y": y, "psi": psi, "u": u, "v": v, "omega_z": 1.05 * np.cos(2.1 * t)}
    return Recording("moving", {name: values[::20] for name, values in channels.items()})


def test_the_front_axle_is_where_positions_and_course_say():
    drive = moving(1.4)
    exact = front_axle([drive])
    assert exact.value == pytest.approx(1.4, abs=2e-3)
    noisy = [front_axle([add_noise(drive, "good", seed)]) for seed in range(5)]
    assert all(abs(place.value - 1.4) < 3.5 * place.std for place in noisy)
    assert all(exact.std < place.std < 0.05 for place in noisy)


@pytest.mark.parametrize("l_f, l_r", [(1.47, 1.26), (1.5, 1.2)], ids=["wheelbase", "axle loads"])
def test_a_contradicted_front_axle_leaves_the_rear_one_to_the_logs(l_f, l_r):
    """The axles are 1.4 m before and 1.2 or 1.3 m behind the centre of gravity: one of the two numbers that a person measures,
    5 % wrong, gives what is given."""
    drives = [add_noise(moving(1.4), "good", seed) for seed in range(2)]
    places = axle_places(drives, replace(KNOWN, numbers={**NUMBERS_GIVEN, "l_f": l_f, "l_r": l_r}), RULES)
    assert [c.name for c in places.contradictions] == ["l_f"]
    assert places.values["l_f"] == pytest.approx(1.4, abs=0.02)
    value, std = places.left["l_r"]
    assert value == places.values["l_r"]
    assert value - 1.01 * std - 0.02 < (1.2 if l_f == 1.47 else 1.3) < value + 1.01 * std + 0.02
    assert std > 0.03


def test_a_stated_uncertainty_of_the_axles_leaves_them_to_the_logs():
    drives = [add_noise(moving(1.4), "good", seed) for seed in range(2)]
    wrong = {**NUMBERS_GIVEN, "l_f": 1.5}
    places = axle_places(drives, replace(KNOWN, numbers=wrong, stated={"l_f": 0.1, "l_r": 0.1}), RULES)
    assert not places.contradictions and places.left["l_r"] == (1.2, 0.1)
    assert places.values["l_f"] == pytest.approx(1.4, abs=0.02) and places.left["l_f"][1] < 0.02
    as_given = axle_places(drives, replace(KNOWN, numbers={**NUMBERS_GIVEN, "l_f": 1.4}), RULES)
    assert not as_given.contradictions and not as_given.left and not as_given.values


def test_the_sway_of_a_rolling_body_is_no_length():
    swaying = [front_axle([moving(1.4, sway=sway)]).value for sway in (0.0, 0.002, 0.004)]
    assert np.abs(np.array(swaying) - 1.4).max() < 2e-3
    noisy = [front_axle([add_noise(moving(1.4, sway=0.004), "good", seed)]) for seed in range(5)]
    assert all(abs(place.value - 1.4) < 3.0 * place.std for place in noisy)


def test_a_pose_slower_than_the_log_says_where_the_front_axle_is():
    """Odometry at 41.7 Hz on the clock of an inertial sensor at 100 Hz: no two rows in a line hold all states."""
    drive = add_noise(moving(1.4, dt=0.01), "good", 1)
    seen = np.diff(np.floor(drive.t / 0.024), prepend=-1.0) > 0
    slow = {name: np.where(seen, drive[name], np.nan) for name in ("x", "y", "u", "v")}
    place, whole = front_axle([drive.with_channels(**slow)]), front_axle([drive])
    assert 0.35 < seen.mean() < 0.5
    assert abs(place.value - 1.4) < 3.0 * place.std < 0.15 and place.std > 0.7 * whole.std


def test_a_gap_in_a_log_costs_windows_only():
    drive = moving(1.4)
    gap = np.where((drive.t > 11.0) & (drive.t < 13.0), np.nan, 1.0)
    place = front_axle([drive.with_channels(x=drive["x"] * gap, y=drive["y"] * gap)])
    assert place.value == pytest.approx(1.4, abs=2e-3) and place.windows < front_axle([drive]).windows


def test_a_drive_straight_on_says_nothing_of_the_front_axle():
    drive = clay_drive(12.0)
    still = np.zeros(len(drive))
    straight = drive.with_channels(psi=still, y=still, v=still, x=np.cumsum(drive["u"]) * drive.dt)
    assert front_axle([straight]) is None


@pytest.mark.parametrize("absent", [("x", "y"), ("v",), ("psi",)])
def test_channels_that_are_derived_say_nothing_of_the_front_axle(absent):
    drive = moving(1.4)
    lacking = drive.with_channels(steer=np.zeros(len(drive)), **dict.fromkeys(absent, np.full(len(drive), np.nan)))
    assert front_axle([drive]) is not None and front_axle([completed(lacking, reference_vehicle())]) is None


def test_n_of_a_log_without_side_slip_or_wheels_is_less_sure():
    drive = moving(1.4)
    without = drive.with_channels(v=np.full(len(drive), np.nan))
    assert model_error(drive, True, RULES) == RULES.model_error_n < RULES.unseen_error_n
    assert model_error(without, True, RULES) == model_error(drive, False, RULES) > RULES.unseen_error_n
    assert model_error(without, False, RULES) > model_error(drive, False, RULES)


def test_a_log_of_another_vehicle_is_refused_and_its_own_is_not():
    drive, vehicle = clay_drive(), reference_vehicle()
    assert beyond_doubt(drive, vehicle) == ""
    assert "wheels of radius" in beyond_doubt(drive, vehicle.with_(radius=0.6))
    assert "front axle" in beyond_doubt(drive, vehicle.with_(l_f=2.4))
    assert rolling_radius(drive) == pytest.approx(vehicle.radius * 0.95, rel=1e-3)


def linear_fit(given=1.0, std=0.1, seed=0, slope=1.0):
    """A fit of one number and n to clusters of white residuals: number 2, n 0.5."""
    rng = np.random.default_rng(seed)
    free = (Free("a", ("a",), 1.0, -9, 9, known=(given, std)), Free("n_0", ("n_f",), 0.1, 0.2, 1.6, drive=0))
    rows = rng.standard_normal((40, 30, 2)) * (1.0, slope)
    hessians = np.einsum("cmi,cmj->cij", rows, rows)
    noise = rng.standard_normal((40, 30))
    prior = np.diag([std**-2, 0.0])
    target = np.array([2.0, 0.5])
    score = np.einsum("cmi,cm->ci", rows, rows @ target + noise)
    value = np.linalg.solve(hessians.sum(axis=0) + prior, score.sum(axis=0) + prior @ [given, 0.0])
    scores = np.einsum("cij,j->ci", hessians, value) - score
    places = np.column_stack([np.zeros(40), np.arange(40.0)])
    empty = np.zeros(0)
    return WindowFit(
        free, value, empty, np.zeros((2, 2)), hessians.sum(axis=0), empty, (), 1.0, empty, scores, hessians, places, ()
    )


def test_standard_errors_are_those_of_the_estimates_spread():
    fits = [linear_fit(std=10.0, seed=seed) for seed in range(60)]
    spread = np.std([fit.value[0] for fit in fits])
    said = np.mean([errors_of(fit).std["a"] for fit in fits])
    assert said == pytest.approx(spread, rel=0.35) and said > 0.9 / np.sqrt(1200)


def test_what_the_logs_alone_say_of_a_given_number_does_not_hold_its_prior():
    fit = linear_fit(given=1.0, std=0.03)
    assert fit.value[0] < 1.6  # the prior holds it back
    value, std, sigmas = departures(fit, errors_of(fit), {})["a"]
    assert value == pytest.approx(2.0, abs=5 * std) and sigmas > 10
    assert departures(linear_fit(given=2.0, std=0.03), errors_of(linear_fit(given=2.0, std=0.03)), {})["a"][2] < 4
    wide = departures(fit, errors_of(fit), {"a": 0.3})["a"]
    assert wide[:2] == pytest.approx((value, np.hypot(std, 0.3)))
    assert wide[2] == pytest.approx((value - 1.0) / np.hypot(wide[1], 0.03)) and wide[2] < 4


def test_the_cost_of_a_number_is_the_change_of_n_that_balances_it():
    fit = linear_fit(std=10.0)
    hessian = fit.hessians.sum(axis=0)
    cost = n_costs(fit, {"a": 0.1})["a"]
    assert cost == pytest.approx(-100 * hessian[1, 0] / hessian[1, 1] * 0.1 / fit.value[1])


def test_the_manoeuvre_asked_for_is_one_that_the_logs_lack():
    drive, vehicle = clay_drive(), reference_vehicle()
    assert not excitation([drive], 2.0).many_waves
    t = drive.t
    several = drive.with_channels(steer=0.08 * (np.sin(2 * t) + np.sin(1.1 * t) + np.sin(4.7 * t)))
    open_ = {"yaw_inertia": Found(1800.0, 500.0, "kg m^2", "not_identifiable", 9.0, None, (1800.0, 500.0))}
    assert asks(vehicle, open_, excitation([several], 2.0), 2.0)[0].startswith("20 s of sine steering to full lock (27 deg)")
    assert asks(vehicle, open_, excitation([drive], 2.0), 2.0)[0].startswith("45 s of steering by several sines")


def test_circles_that_were_driven_are_asked_for_no_more():
    """And those that are asked for are shorter than once around, since in its own ruts a log shows less."""
    drive, vehicle = clay_drive(), reference_vehicle()
    held = 0.24 * np.sign(np.sin(2 * np.pi * drive.t / 24.0)) + 0.005 * np.sin(5.0 * drive.t)
    circles = excitation([drive.with_channels(steer=held)], 2.0)
    assert circles.circled == pytest.approx(0.24, abs=0.01) and excitation([drive], 2.0).circled < 0.1
    assert excitation([drive.with_channels(steer=np.abs(held))], 2.0).circled == 0.0, "one way alone"
    (manoeuvre,) = (m for m in MANOEUVRES if m.name == "circles")
    assert manoeuvre.has(vehicle, circles) and not manoeuvre.has(vehicle, replace(circles, circled=0.0))
    around = 2 * np.pi * vehicle.wheelbase / np.tan(0.5 * vehicle.max_steer)
    parts = re.findall(r"(\d+) s at ([\d.]+) m/s", manoeuvre.words(vehicle, circles))
    assert len(parts) == 2 and all(float(seconds) * float(speed) < 0.95 * around for seconds, speed in parts)


@pytest.mark.parametrize(("scale", "fastest"), [(1.0, 8.0), (0.3, 3.0)])
def test_manoeuvres_are_asked_for_at_two_speeds_that_the_vehicle_drives(scale, fastest):
    vehicle = reference_vehicle().with_(l_f=scale * 1.5, l_r=scale * 1.2, track=scale * 1.2)
    had = Excitation(largest=0.1, many_waves=False, speeds=(0.5 * fastest, fastest), steers=True)
    open_ = {
        name: Found(1.0, 0.5, "m", "not_identifiable", 9.0, None, (1.0, 0.5)) for name in ("scrub", "track", "toe_rear")
    }
    for manoeuvre in MANOEUVRES:
        speeds = [float(word) for word in re.findall(r"([\d.]+)(?= m/s| and at| to [\d.]+ m/s)", manoeuvre.words(vehicle, had))]
        assert speeds and max(speeds) <= fastest + 0.5 and len(set(speeds)) == len(speeds), manoeuvre.words(vehicle, had)
    assert asks(vehicle, open_, had, 2.0)


def test_a_number_that_no_log_shows_is_asked_for_where_it_costs_n_much():
    vehicle, had = reference_vehicle(), excitation([clay_drive()], 2.0)
    arms = Found(0.0, 0.25, "", "not_identifiable", -5.0, None, (0.0, 0.25))
    first = asks(vehicle, {"swing_rear": arms}, had, 2.0)[0]
    assert first.startswith("measure swing_rear (tape") and "5 % off" in first
    for known in (replace(arms, n_percent_per_std=-1.0), replace(arms, given=0.0, state="given")):
        assert not any("swing_rear" in words for words in asks(vehicle, {"swing_rear": known}, had, 2.0))


def test_what_an_unmeasured_number_makes_of_n_is_in_its_standard_deviation():
    bench = SimpleNamespace(balances=(), recordings=(moving(1.4),))
    errors = Errors(("n_0",), np.array([0.5]), np.array([[0.01**2]]), np.ones(1), np.zeros(1), np.ones(1))
    own = n_stds(bench, [0.5], errors, {}, RULES)[0]
    with_arms = n_stds(bench, [0.5], errors, {"swing_rear": np.array([-0.06])}, RULES)[0]
    assert own > 0.01 and with_arms == pytest.approx(np.hypot(own, 0.06 * 0.5))


def test_what_scale_and_tape_say_of_the_same_must_agree():
    taped = {**NUMBERS_GIVEN, "wheelbase": NUMBERS_GIVEN["l_f"] + NUMBERS_GIVEN["l_r"]}
    assert known_from_table(taped, "car.toml", "car")["l_f"] == NUMBERS_GIVEN["l_f"]
    with pytest.raises(ValueError, match=r"car\.toml: expected l_f \+ l_r to be the wheelbase of 3\.5 m"):
        known_from_table({**taped, "wheelbase": 3.5}, "car.toml", "car")
    front, rear = taped["l_r"] / taped["wheelbase"] * 1400.0, taped["l_f"] / taped["wheelbase"] * 1400.0
    known_from_table({**taped, "load_front": front, "load_rear": rear}, "car.toml", "car")
    with pytest.raises(ValueError, match=r"car\.toml: expected l_f and l_r as the axle loads have them"):
        known_from_table({**taped, "load_front": rear, "load_rear": front}, "car.toml", "car")


def test_a_number_that_is_no_better_known_is_not_drawn_as_identified():
    better, vague = (Found(1.1, std, "m", "identified", 0.5, None, (1.0, 0.2)) for std in (0.1, 0.2))
    assert shown_states({"toe": better, "scrub": vague}) == {"toe": "identified", "scrub": "fitted"}


@pytest.mark.parametrize(("stated", "words"), [({"track": -0.01}, "track"), ({"trakc": 0.05}, "trakc"), ({"l_f": 0.0}, "l_f")])
def test_errors_of_known_numbers_are_checked(stated, words):
    """A standard deviation below zero was taken for a number that is known exactly, a key that is none for nothing."""
    assert known_from_table({**NUMBERS_GIVEN, "uncertainty": {"track": 0.01}}, "car.toml", "car").stated == {"track": 0.01}
    with pytest.raises(ValueError, match=rf"car\.toml: uncertainty.*{words}"):
        known_from_table({**NUMBERS_GIVEN, "uncertainty": stated}, "car.toml", "car")
