"""Moving horizon and verdict on drives of the model itself: what is right is identified, what is not says why."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from drives import MULTI_LOG, clay_bicycle, clay_drive, reference_vehicle
from softsoil.checking.usable import mark_checked
from softsoil.estimator.driveline_choice import Choice
from softsoil.estimator.estimate import METHODS, estimate, judged_without_wheels, run_method
from softsoil.estimator.evidence import Evidence, gather, percent_above, sensor_variance
from softsoil.estimator.inertia import inertia_error
from softsoil.estimator.late_change import parts_of
from softsoil.estimator.modes import run_horizon
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows, estimate_horizon
from softsoil.estimator.soil_error import SoilError
from softsoil.estimator.strain import VehicleChange
from softsoil.estimator.tuning import EXACT_MODEL, Tuning
from softsoil.estimator.verdict import WORDS, Verdict, decide, judge
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.files.joint_error import JointError
from softsoil.mapping.drive_soil import ON_THE_WAY
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.derive import mark
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SOILS, Soil

TRUE_N = 0.5


@pytest.fixture(scope="module")
def noisy():
    return add_noise(clay_drive(25.0), "good", 4)


def test_the_horizon_ends_at_the_true_n_from_both_sides(noisy):
    for guess in (0.35, 0.8):
        found = estimate_horizon(noisy, clay_bicycle(), guess, tied=True, start=1.0)
        assert found.n[-1, 0] == pytest.approx(TRUE_N, abs=0.03)
        assert abs(found.n[-1, 0] - TRUE_N) < 3 * found.std[-1, 0]
        assert found.changes == ()


def test_a_new_soil_is_followed_and_dated():
    vehicle = reference_vehicle()
    first = synthetic_drive(clay_bicycle(), vehicle.radius, seconds=20.0)
    softer = synthetic_drive(nominal_bicycle(vehicle, CLAY.with_(n=0.8)), vehicle.radius, seconds=20.0)
    turn, end = first["psi"][-1] - softer["psi"][0], len(first)
    cos, sin = np.cos(turn), np.sin(turn)
    x, y = softer["x"] - softer["x"][0], softer["y"] - softer["y"][0]
    moved = {
        **softer.channels,
        "t": softer.t - softer.t[0] + first.t[-1] + first.dt,
        "x": first["x"][-1] + cos * x - sin * y,
        "y": first["y"][-1] + sin * x + cos * y,
        "psi": softer["psi"] + turn,
    }
    both = replace(first, channels={name: np.concatenate([first[name], moved[name]]) for name in first.channels}, truth={})
    found = estimate_horizon(add_noise(both, "good", 1), clay_bicycle(), 0.6, tied=True, start=1.0)
    border = first.t[-1]
    assert any(abs(t - border) < 3.0 for t in found.changes)
    after = found.t > border + 5.0
    assert np.all(np.abs(found.n[after, 0] - 0.8) < 0.1 * 0.8)
    assert len(both) == end + len(softer)


@pytest.mark.parametrize("method", METHODS)
def test_the_vehicle_s_error_of_n_widens_the_bar_and_leaves_n(noisy, method):
    vehicle = reference_vehicle().with_(n_error=0.05)
    plain, wide = (run_method(noisy, nominal_bicycle(v, CLAY), 0.6, method, start=1.0) for v in (reference_vehicle(), vehicle))
    np.testing.assert_array_equal(plain.n_front, wide.n_front)
    np.testing.assert_allclose(wide.n_front_std**2 - plain.n_front_std**2, (0.05 * plain.n_front) ** 2, rtol=1e-9)


def test_a_drive_over_two_soils_says_so_where_the_change_itself_is_too_small_to_date(noisy):
    """n of 0.5 and then of 0.6, with the paper's noise: the horizon sees no change, its windows of both halves differ."""
    rules = HorizonRules()
    for n, same in ((0.5, True), (0.62, False)):
        model = nominal_bicycle(reference_vehicle(), CLAY.with_(n=n))
        halves = [noisy, add_noise(synthetic_drive(model, reference_vehicle().radius, seconds=25.0), "good", 5)]
        horizons = [run_horizon(drive_windows(half, clay_bicycle(), 1.0, rules), 0.55, True, rules) for half in halves]
        summary = horizons[0].summary
        for name in ("at", "hessian", "gradient", "states", "cost"):
            getattr(summary, name).extend(getattr(horizons[1].summary, name))
        parts, sigmas = parts_of(summary, horizons[0].since, horizons[0].share, len(summary.at) - 1)
        assert (sigmas < 2.5) == same, (parts, sigmas)
        assert parts[1] == pytest.approx(n, rel=0.06)


def test_a_right_model_on_an_exciting_drive_is_identified(noisy):
    found = estimate(noisy, clay_bicycle(), 0.7, method="horizon", start=1.0)
    assert found.verdict.word == "identified", found.verdict.reason
    assert found.n_front[-1] == pytest.approx(TRUE_N, rel=0.1)


@pytest.mark.parametrize("tuning", [Tuning(), EXACT_MODEL], ids=["default", "exact"])
def test_a_filter_is_identified_where_it_is_right_and_only_there(noisy, tuning):
    found = estimate(noisy, clay_bicycle(), 0.7, tuning=tuning, start=1.0, correct=False)
    right = abs(found.n_front[-1] / TRUE_N - 1) <= 0.1
    assert found.verdict.usable == right, (found.verdict.reason, found.n_front[-1])


def test_the_windows_correct_the_filter_at_the_end_of_an_identified_drive(noisy):
    alone = estimate(noisy, clay_bicycle(), 0.7, start=1.0, correct=False)
    found, windows = estimate(noisy, clay_bicycle(), 0.7, start=1.0), alone.verdict.evidence
    assert alone.by_filter is None and alone.parameters["n_f"] == alone.n_front[-1] != windows.n[0]
    assert (found.n_front[-1], found.n_rear[-1]) == tuple(found.parameters.values()) == (windows.n[0], windows.n[-1])
    assert (found.n_front_std[-1], found.n_rear_std[-1]) == (windows.std[0], windows.std[-1])
    assert found.by_filter == ((alone.n_front[-1], alone.n_front_std[-1]), (alone.n_rear[-1], alone.n_rear_std[-1]))
    assert np.array_equal(found.n_front[:-1], alone.n_front[:-1])


def test_a_wrong_yaw_inertia_is_inconsistent_and_no_windows_correct_the_filter(noisy):
    wrong = nominal_bicycle(reference_vehicle().with_(yaw_inertia=1.4 * reference_vehicle().yaw_inertia), CLAY)
    found = estimate(noisy, wrong, 0.7, start=1.0)
    assert found.verdict.word == "inconsistent"
    assert found.by_filter is None and found.n_front[-1] != found.verdict.evidence.n[0]


@pytest.mark.parametrize("friction", [pytest.param(0.5, marks=pytest.mark.study), 0.7])
def test_a_drive_on_a_road_is_no_soil(friction):
    road = Soil("road", k_phi=1e9, k_c=0.0, n=0.5, c=0.0, phi=float(np.arctan(friction)), k=0.0015)
    drive = synthetic_drive(nominal_bicycle(reference_vehicle(), road, "hard_ground"), reference_vehicle().radius, seconds=25.0)
    found = estimate(add_noise(drive, "good", 2), clay_bicycle(), 0.7, start=1.0)
    assert found.verdict.word == "no_soil", found.verdict.reason


def test_a_wrong_soil_is_no_road(noisy):
    wrong = nominal_bicycle(reference_vehicle(), SOILS["sandy_loam"])
    assert estimate(noisy, wrong, 0.7, start=1.0).verdict.word in ("inconsistent", "at_bound")


@pytest.mark.parametrize("channel", ["steer", "v"])
def test_a_flipped_sign_is_never_identified(noisy, channel):
    flipped = mark_checked(noisy.with_channels(**{channel: -noisy[channel]}))  # the verdict alone, without the check of channels
    assert not estimate(flipped, clay_bicycle(), 0.7, start=1.0).verdict.usable


def test_no_n_is_identified_between_drivelines_of_different_n(noisy):
    bare = mark(noisy, "derived", *WHEEL_CHANNELS)
    right = Verdict("identified", "fine")
    one = Choice("front wheels driven", {}, {"front wheels driven": 0.5})
    both = Choice("front wheels driven", {}, {"front wheels driven": 0.5, "rear wheels driven": 0.56})
    assert judged_without_wheels(noisy, right, None) is right
    assert judged_without_wheels(bare, right, one).usable and judged_without_wheels(bare, right, None).usable
    doubtful = judged_without_wheels(bare, right, both)
    assert doubtful.word == "inconsistent" and "rear wheels driven (n = 0.560)" in doubtful.reason


def test_a_vehicle_that_parks_in_the_log_is_judged_by_what_it_drove():
    """The motion that a model leaves unexplained is a share of that under the windows, not of a log with a long stop in it."""
    drive, model = clay_drive(16.0), clay_bicycle()
    rows = round(60.0 / drive.dt)
    still = {name: np.full(rows, values[-1] if name in ("x", "y", "psi") else 0.0) for name, values in drive.channels.items()}
    still["t"] = drive.t[-1] + drive.dt * np.arange(1, rows + 1)
    longer = {name: np.concatenate([values, still[name]]) for name, values in drive.channels.items()}
    parked = replace(drive, channels=longer, truth={})
    logs = [add_noise(one, "good", 4) for one in (drive, parked)]
    driven, with_stop = (gather(drive_windows(log, model, 2.0, HorizonRules()), (0.7,), True) for log in logs)
    assert with_stop.windows == driven.windows and with_stop.motion == pytest.approx(driven.motion, rel=0.01)
    for name, share in driven.unexplained.items():
        assert with_stop.unexplained[name] == pytest.approx(share, abs=3.0 * driven.unexplained_std[name])


def test_a_straight_drive_excites_nothing():
    straight = synthetic_drive(clay_bicycle(), reference_vehicle().radius, seconds=15.0, steer=np.zeros(1251))
    with pytest.warns(UserWarning, match="on a straight path the soil does not show"):
        found = estimate(add_noise(straight, "good", 2), clay_bicycle(), 0.7, start=1.0)
    assert found.verdict.word == "not_excited" and "steer more" in found.verdict.reason


def test_an_unknown_method_is_refused(noisy):
    with pytest.raises(ValueError, match="expected one of ukf, horizon"):
        estimate(noisy, clay_bicycle(), 0.7, method="magic")


EVIDENCE = Evidence(
    n=np.array([0.5]), std=np.array([0.02]), information_std=np.array([0.01]), by_guess=np.array([[0.5], [0.49], [0.51]]),
    n_axles=np.array([0.5, 0.5]), axles_std=np.array([0.01, 0.01]), unexplained={"v": 0.0, "omega_z": 1e-4},
    unexplained_std={"v": 0.01, "omega_z": 1e-5}, inertia=0.05, inertia_std=0.01,
    soil=SoilError({}, 0.0), change=None,
    parts=np.array([0.48, 0.51]), parts_sigmas=1.0, motion=2.0, windows=30, guess=0.7,
)  # fmt: skip


@pytest.mark.parametrize(("std", "word"), [(0.1, "inconsistent"), (0.25, "identified")])
def test_an_inertia_that_the_drive_hardly_shows_contradicts_nothing(std, word):
    assert decide(replace(EVIDENCE, inertia=1.0, inertia_std=std), np.array([0.5])).word == word


@pytest.mark.parametrize(("inertia", "word"), [(-0.19, "identified"), (0.19, "identified"), (-0.24, "inconsistent")])
def test_an_identified_inertia_may_be_off_by_its_own_error(inertia, word):
    vehicle = reference_vehicle()
    off = replace(EVIDENCE, inertia=inertia)
    for share in (0.05, 0.5):  # an error so large hides no other vehicle
        error = JointError(("yaw_inertia",), (share * vehicle.yaw_inertia,), ((),))
        stated = VerdictRules().of(nominal_bicycle(vehicle.with_(joint_error=error), CLAY))
        assert decide(off, np.array([0.5]), rules=stated).word == word
    assert decide(off, np.array([0.5]), rules=VerdictRules().of(nominal_bicycle(vehicle, CLAY))).word == "inconsistent"


@pytest.mark.parametrize(("inertia", "words"), [(-0.3, "one 30 ± 1 % smaller"), (-1.07, "no yaw inertia fits the drive")])
def test_no_yaw_inertia_is_smaller_than_nothing(inertia, words):
    found = decide(replace(EVIDENCE, inertia=inertia), np.array([0.5]))
    assert found.word == "inconsistent" and words in found.reason and "107" not in found.reason


@pytest.mark.parametrize(("inertia", "said"), [(-0.3, True), (0.4, True), (-1.1, False)])
def test_a_negative_yaw_inertia_is_not_spoken_of(inertia, said):
    found = decide(replace(EVIDENCE, unexplained={"omega_z": 0.0025}, inertia=inertia), np.array([0.5]))
    assert found.word == "inconsistent" and ("of yaw inertias" in found.reason) == said


@pytest.mark.parametrize(
    ("changes", "n", "others", "word"),
    [
        ({}, 0.5, (), "identified"),
        ({"unexplained": {"omega_z": 0.0025}}, 0.5, (), "inconsistent"),
        ({"unexplained": {"omega_z": 0.0025}, "unexplained_std": {"omega_z": 0.002}}, 0.5, (), "identified"),
        ({"information_std": np.array([0.05])}, 0.5, (), "not_excited"),
        ({"information_std": np.array([np.nan])}, 0.5, (), "not_excited"),
        ({"soil": SoilError({}, 0.11)}, 0.5, (), "not_excited"),
        ({"soil": SoilError({}, 0.09)}, 0.5, (), "identified"),
        ({"soil": SoilError({}, 0.0, (0.03, 0.03), 0.042)}, 0.5, (), "not_excited"),
        ({"soil": SoilError({}, 0.0, (0.02, 0.03), 0.036)}, 0.5, (), "identified"),
        ({"n": np.array([0.2])}, 0.2, (), "at_bound"),
        ({"by_guess": np.array([[0.5], [0.9]])}, 0.5, (), "depends_on_first_guess"),
        ({}, 0.5, ([0.7],), "depends_on_first_guess"),
        ({}, 0.6, (), "inconsistent"),
        ({"n_axles": np.array([0.4, 0.6])}, 0.5, (), "axles_disagree"),
        ({"inertia": -0.2}, 0.5, (), "inconsistent"),
        ({"inertia": -0.2, "inertia_std": 0.1}, 0.5, (), "identified"),
        ({"change": VehicleChange(4.0, 0.0, 0.05, 0.05, 0.0, 0.01)}, 0.5, (), "inconsistent"),
        ({"change": VehicleChange(3.0, 0.0, 0.05, 0.05, 0.0, 0.01)}, 0.5, (), "identified"),
        ({"change": VehicleChange(4.0, 0.3, 0.05, 0.05, 0.0, 0.01), "motion": 0.1}, 0.5, (), "not_excited"),
        ({"change": VehicleChange(1.0, 0.2, 0.05, 0.05, 0.0, 0.01)}, 0.5, (), "inconsistent"),
        ({"change": VehicleChange(1.0, -0.2, 0.05, 0.05, 0.0, 0.01)}, 0.5, (), "inconsistent"),
        ({"change": VehicleChange(1.0, 0.2, 0.08, 0.05, 0.0, 0.01)}, 0.5, (), "identified"),
        ({"change": VehicleChange(1.0, 0.07, 0.01, 0.01, 0.0, 0.01)}, 0.5, (), "identified"),
        ({"change": VehicleChange(1.0, 0.07, 0.07, 0.07, 0.0, 0.01)}, 0.5, (), "not_excited"),
        ({"change": VehicleChange(1.0, 0.0, 0.05, 0.05, 0.05, 0.01)}, 0.5, (), "inconsistent"),
        ({"change": VehicleChange(1.0, 0.0, 0.05, 0.05, 0.05, 0.03)}, 0.5, (), "identified"),
        ({"parts": np.array([0.42, 0.52]), "parts_sigmas": 3.2}, 0.5, (), "inconsistent"),
        ({"parts": np.array([0.42, 0.52]), "parts_sigmas": 1.5}, 0.5, (), "identified"),
    ],
)
def test_each_word_has_its_evidence(changes, n, others, word):
    found = decide(replace(EVIDENCE, **changes), np.array([n]), [np.array(other) for other in others])
    assert found.word == word and found.word in WORDS and found.reason


@pytest.mark.parametrize("axle", [0, 1])
def test_both_axles_are_to_end_alike_from_every_guess(axle):
    n, ends = np.array([0.5, 0.5]), np.full((3, 2), 0.5)
    right = replace(EVIDENCE, n=n, std=np.full(2, 0.01), information_std=np.full(2, 0.01), n_axles=n, by_guess=ends)
    assert decide(right, n).word == "identified"
    ends = ends.copy()
    ends[2, axle] = 0.64
    assert decide(replace(right, by_guess=ends), n).word == "depends_on_first_guess"
    other = n.copy()
    other[axle] = 0.64
    assert decide(right, n, [other]).word == "depends_on_first_guess"


def test_a_guess_that_is_left_out_is_said():
    found = decide(replace(EVIDENCE, left_out=((1.1, 1.6, 0.39),)), np.array([0.5]))
    assert found.word == "identified" and "1.10 ends at 1.60, where windows fit 39 % worse" in found.reason


def test_soils_that_change_along_the_way_are_what_a_map_is_for():
    two = replace(EVIDENCE, parts=np.array([0.42, 0.52]), parts_sigmas=3.2)
    assert decide(two, np.array([0.5])).word == "inconsistent"
    assert decide(two, np.array([0.5]), rules=ON_THE_WAY).word == "identified"


def test_windows_that_say_nothing_give_no_parts_and_no_inertia(noisy):
    """Windows in which the model has no finite answer have no curvature: they neither fail nor contradict."""
    rules = HorizonRules()
    windows = drive_windows(noisy, clay_bicycle(), 1.0, rules)
    horizon = run_horizon(windows, 0.55, True, rules)
    horizon.summary.hessian = [np.zeros((1, 1)) for _ in horizon.summary.hessian]
    horizon.summary.gradient = [np.zeros(1) for _ in horizon.summary.gradient]
    _, sigmas = parts_of(horizon.summary, horizon.since, horizon.share, len(windows.rows) - 1)
    assert sigmas < 1.0
    windows.sigma = np.full(6, np.inf)  # no channel counts
    share, std = inertia_error(windows, horizon)
    assert abs(share) < std


def test_a_window_without_a_finite_answer_says_nothing_and_warns_of_nothing(noisy):
    windows = drive_windows(noisy, clay_bicycle(), 1.0, HorizonRules())
    p, x0 = windows.compiled.model.p.nominal, windows.first
    x0[3, STATE_CHANNELS.index("x")] = np.inf
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        linear = windows.linearise(p, x0, ())
    assert not linear.residual[3].any() and not linear.by_state[3].any() and np.isnan(linear.path[3]).all()
    assert np.isfinite(linear.by_state).all() and linear.residual[2].any()


def test_noise_of_a_channel_from_its_third_differences():
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 30.0, 0.012)
    estimates = [sensor_variance(np.sin(t) + 0.1 * rng.standard_normal(len(t)), 0.012) for _ in range(50)]
    values = np.array([value for value, _ in estimates])
    assert np.mean(values) == pytest.approx(0.01, rel=0.02)
    assert np.std(values) == pytest.approx(estimates[0][1], rel=0.4)


def test_a_share_above_its_limit_is_printed_as_one():
    """A load shown to ± 6.04 % was printed as "± 6.0 % (limit 6 %)"."""
    assert [percent_above(share, 0.06) for share in (0.0604, 0.063, 0.08, 1e9)] == ["6.04", "6.3", "8", "999"]


@pytest.mark.study
def test_a_filter_that_stays_where_the_windows_are_confirms_them():
    """One that has not yet left its initial guess is no evidence against them; one that leaves their n is."""
    drive, model = read_drive(MULTI_LOG).between(0.0, 13.0), bicycle(reference_vehicle(), CLAY)

    windows = float(judge(drive, model, 0.7, None, tied=True, start=2.0).evidence.n[0])

    def word(again, corrected):
        end = (1.13 * windows,)
        return judge(drive, model, 0.7, end, tied=True, start=2.0, again=lambda n: (again * n,), corrected=corrected).word

    assert word(1.05, True) == "identified"
    assert word(1.05, False) == word(1.15, True) == "inconsistent"
