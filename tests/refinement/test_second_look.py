"""Effects that noisy starts hide: named with free starts where the vehicle's file states a joint error, and not without."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration
from softsoil.estimator.strain import VehicleChange
from softsoil.estimator.verdict import judge
from softsoil.estimator.verdict_rules import VerdictRules
from softsoil.files.joint_error import joint_error_of
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.noise import add_noise
from softsoil.refinement.joint_fit import JointFit, stated_error
from softsoil.refinement.refine import refine
from softsoil.refinement.rules import RULES
from softsoil.refinement.second_look import Look, look_twice, still_there, strained_words, worth_it
from softsoil.refinement.selection import accept
from softsoil.refinement.structure import Structure
from softsoil.refinement.trace import make_bench, whole_model
from softsoil.refinement.words import verdict_sentence
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.soil import CLAY
from softsoil.windows.free_starts import joint_prior

N, LOAD, PLACE, SECONDS = 0.6, 400.0, 2.3, 26.0
NUMBERS = ("yaw_inertia", "radius")
STD = np.array([20.0, 5e-4])
ERROR = joint_error_of(NUMBERS, np.outer(STD, STD) * [[1.0, 0.5], [0.5, 1.0]])


def vehicle():
    """The reference vehicle without effects, as an identification would state it."""
    return reference_vehicle().with_(effects={}, uncertainty={}, joint_error=ERROR)


def drive(load, noise="table5", seed=1):
    """A multi-sine drive of the model itself with a load, with sensor noise."""
    effects = {"payload": {"payload_mass": load, "payload_x": PLACE}} if load else {}
    model = bicycle(vehicle(), CLAY.with_(n=N), "turn_slip", effects)
    steer = MultiSine(0.35, seed=4)(0.012 * np.arange(round(SECONDS / 0.012) + 1))
    return add_noise(synthetic_drive(model, vehicle().radius, seconds=SECONDS, speed=5.5, steer=steer), noise, seed)


def traced(load, declared, *noise):
    return refine([drive(load, *noise)], Declaration(declared, CLAY), workers=1, candidates=("payload", "yaw_moment"))


@pytest.fixture(scope="module")
def without():
    return traced(LOAD, vehicle().with_(joint_error=None))


@pytest.fixture(scope="module")
def clean():
    return traced(0.0, vehicle())


@pytest.mark.study
@pytest.mark.slow
def test_a_load_that_noise_hides_is_named_by_free_starts(without, tmp_path):
    assert not without.effects, "without a joint error the tracing alone decides"
    found = traced(LOAD, vehicle())
    assert found.verdict == "effect" and [effect.name for effect in found.effects] == ["payload"]
    mass, std, _ = found.effects[0].parameters["payload_mass"]
    place, place_std, _ = found.effects[0].parameters["payload_x"]
    assert abs(mass / LOAD - 1) < 0.15 and abs(mass - LOAD) < 3 * std
    assert abs(place - PLACE) < 3 * place_std
    assert abs(found.n_after[0] / N - 1) < 0.05 < abs(without.n_after[0] / N - 1), "n was in the load's place"
    assert any("free initial states" in note for note in found.notes)
    file = tmp_path / "refined.toml"
    file.write_text(declaration_toml(found.declaration), encoding="utf-8")
    assert load_declaration(file).vehicle.joint_error == ERROR


@pytest.mark.study
@pytest.mark.slow
def test_a_load_that_the_tracing_names_is_sized_by_free_starts():
    masses = []
    for joint in (None, ERROR):
        found = traced(LOAD, vehicle().with_(joint_error=joint), "good", 8)
        assert [effect.name for effect in found.effects] == ["payload"]
        assert not any("free initial states" in note for note in found.notes), "the tracing itself names it"
        masses.append(found.effects[0].parameters["payload_mass"])
    (recorded, recorded_std, _), (free, std, _) = masses
    assert std < 0.7 * recorded_std, "with the error that the vehicle's numbers have together"
    assert abs(free / LOAD - 1) < 0.05 < abs(recorded / LOAD - 1), "noise at recorded starts biases the size"
    assert abs(found.n_after[0] / N - 1) < 0.03
    assert found.declaration.vehicle.effects["payload"]["payload_mass"] == free


def test_effects_of_sensors_and_places_are_not_sized_again(without):
    known, declared = catalogue(vehicle()), Declaration(vehicle(), CLAY)
    for name in ("gyro_bias", "soil_change"):
        named = replace(without.selection, accepted=(replace(without.ranking[0], name=name),))
        look = look_twice(without.recordings, declared, without.bench, named, {name: known[name]})
        assert look == Look(named)
    fixed = Declaration(vehicle().with_(joint_error=None), CLAY)
    again = look_twice(without.recordings, fixed, without.bench, without.selection, known)
    assert again == Look(without.selection)


@dataclass(frozen=True)
class Found:
    """A fit that says one parameter."""

    value: float
    std: float

    def named(self):
        return {"yaw_moment": (self.value, self.std)}


@pytest.mark.parametrize(
    "value, std, there", [(400.0, 150.0, True), (400.0, 250.0, False), (-900.0, 100.0, False), (20.0, 50.0, False)]
)
def test_what_is_there_stands_far_enough_from_absence_on_the_same_side(value, std, there):
    assert still_there(Found(value, std), Found(800.0, 90.0), catalogue(vehicle())["yaw_moment"]) is there


@pytest.mark.study
@pytest.mark.slow
def test_what_free_starts_do_not_show_is_not_named(clean, monkeypatch):
    """A yaw moment that the tracing were to name on a drive without one."""
    declared, known = Declaration(vehicle(), CLAY), {"yaw_moment": catalogue(vehicle())["yaw_moment"]}
    (moment,) = (candidate for candidate in clean.ranking if candidate.name == "yaw_moment")
    bench, _ = accept(clean.bench, moment, known)
    named = replace(clean.selection, accepted=(moment,), bench=bench, groups=(("yaw_moment",),))
    look = look_twice(clean.recordings, declared, clean.bench, named, known)
    assert look.selection.accepted == () == look.selection.groups and look.fits is None
    assert any("do not show it" in note and "standard errors from absence" in note for note in look.notes)
    tried = []

    def again(fit_of, selection, effects, alone):
        tried.append(effects)
        return look

    monkeypatch.setattr("softsoil.refinement.second_look._look_again", again)
    look_twice(clean.recordings, declared, clean.bench, named, {**known, "payload": catalogue(vehicle())["payload"]})
    assert [set(effects) for effects in tried] == [{"payload"}], "what they do not show, they do not name"


@pytest.mark.slow
def test_nothing_is_named_where_nothing_is_missing(clean):
    assert clean.verdict == "none"
    assert clean.strain < 2.0 and clean.as_json()["strain"] == clean.strain
    share, std = clean.load
    assert abs(share) < 3.0 * std < 0.3 and clean.as_json()["load"] == {"share": share, "std": std}
    assert [verdict.word for verdict in clean.judged] == ["identified"]
    stated = {one.name: one.stated for one in clean.fitted}
    assert [stated[name] for name in NUMBERS] == pytest.approx(STD), "the error that the fit had"


@pytest.mark.slow
@pytest.mark.parametrize("joint, verdict", [(ERROR, "none"), (None, "unexplained")])
def test_strain_speaks_before_axle_forces(joint, verdict, monkeypatch):
    """Axle forces that lack half, on a drive without an effect: kicks and noise make such a share, which strains no number."""
    left = Structure({"front": 0.1, "rear": 0.5}, {"front": {}, "rear": {}})
    monkeypatch.setattr("softsoil.refinement.refine.structure", lambda *_: left)
    found = traced(0.0, vehicle().with_(joint_error=joint))
    assert found.verdict == verdict and found.structure == (left,)
    assert verdict_sentence(found).lower().startswith(verdict) and "axle forces" in verdict_sentence(found)


def test_another_vehicle_than_the_file_states_strains_its_numbers(clean):
    """15 % more yaw inertia than its bodies have, known to 1.7 %."""
    right = vehicle().yaw_inertia
    for share, strained in ((1.0, False), (1.15, True)):
        declared = Declaration(vehicle().with_(yaw_inertia=share * right), CLAY)
        bench = make_bench(clean.recordings, declared, 1.0, names=["yaw_moment"])
        look = look_twice(clean.recordings, declared, bench, clean.selection, {})
        assert look.strained is strained and look.selection is clean.selection


@pytest.mark.study
@pytest.mark.slow
def test_one_drive_is_judged_as_estimate_judges_it(without, clean):
    """Several by their joint fit, which has limits of its own."""
    declared = Declaration(vehicle(), CLAY)
    for traced_drive, heavy in ((without, True), (clean, False)):
        look = look_twice(traced_drive.recordings, declared, traced_drive.bench, traced_drive.selection, {})
        (drive_,) = traced_drive.recordings
        change = judge(drive_, declared.build(), CLAY.n, None, tied=True, start=2.0).evidence.change
        assert look.load == pytest.approx((change.load, change.load_std), rel=1e-6) and (look.load[0] > 0.08) is heavy
        assert (look.strain, look.most) == (pytest.approx(change.strain, rel=1e-6), VerdictRules().strain)
    both = [*without.recordings, *clean.recordings]
    bench = make_bench(both, declared, 2.0, names=["yaw_moment"])
    assert look_twice(both, declared, bench, clean.selection, {}).most == RULES.strain != VerdictRules().strain


@pytest.mark.slow
def test_a_first_n_beyond_a_ridge_is_left_behind(clean):
    """Noise at recorded starts may have put n of a drive on its bound, from where a fit does not come back."""
    absent = clean.bench.absent.copy()
    absent[:, [clean.bench.model.p.index(name) for name in ("n_f", "n_r")]] = 1.6
    declared, bench = Declaration(vehicle(), CLAY), replace(clean.bench, absent=absent)
    look = look_twice(clean.recordings, declared, bench, clean.selection, {})
    fitted, last = look.declared
    assert last.named()[fitted.ground[0].name][0] == pytest.approx(N, rel=0.05) and look.strain < 3.0
    problem = JointFit.of(clean.recordings, declared, stated_error(declared, bench), bench, [])
    assert problem.fitted()[1] > 1.005 * problem.plain()[1]


@pytest.mark.slow
def test_no_n_is_identified_where_the_vehicle_has_changed(monkeypatch):
    """Whatever the strain, here that of a clean drive and a look that calls it one of another vehicle."""
    changed = VehicleChange(9.0, 0.0, 0.02, 0.02, 0.0, 0.01)
    monkeypatch.setattr("softsoil.refinement.second_look.change_of_drive", lambda *_: changed)
    found = traced(0.0, vehicle())
    assert found.verdict == "unexplained" and not found.effects
    assert [verdict.word for verdict in found.judged] == ["inconsistent"] and "strain" in found.judged[0].reason
    assert any("something of the vehicle has changed" in note for note in found.notes)


@pytest.mark.study
@pytest.mark.slow
def test_standard_errors_grow_with_the_root_of_the_strain(without, monkeypatch):
    stds, payload = [], {"payload": catalogue(vehicle())["payload"]}
    for strain in (0.5, 6.25):
        monkeypatch.setattr("softsoil.refinement.second_look.JointFit.strain", lambda *_, strain=strain: strain)
        look = look_twice(without.recordings, Declaration(vehicle(), CLAY), without.bench, without.selection, payload)
        assert [candidate.name for candidate in look.selection.accepted] == ["payload"] and not look.strained
        stds.append(look.fits.last.named()["payload_mass"][1])
    assert stds[1] == pytest.approx(2.5 * stds[0], rel=1e-3)


@pytest.mark.slow
def test_an_effect_that_leaves_the_numbers_strained_is_not_named(without, monkeypatch):
    monkeypatch.setattr("softsoil.refinement.second_look.JointFit.strain", lambda *_: 9.0)
    payload = {"payload": catalogue(vehicle())["payload"]}
    look = look_twice(without.recordings, Declaration(vehicle(), CLAY), without.bench, without.selection, payload)
    assert not look.selection.accepted and look.strained
    assert len(look.notes) == 1 and look.notes[0].startswith("payload: not named") and "strain 9.0" in look.notes[0]


@pytest.mark.parametrize(
    "without, strain, explained", [(17.0, 1.0, True), (17.0, 9.0, False), (1.5, 1.0, False), (None, 1.0, False)]
)
def test_an_effect_explains_where_the_numbers_are_strained_without_it_alone(without, strain, explained):
    assert Look(None, strain=strain, without=without).explained is explained


def test_what_is_looked_at_again(without):
    payload = next(c for c in without.ranking if c.name == "payload")
    effect = catalogue(vehicle())["payload"]
    assert worth_it(payload, effect)
    assert not worth_it(replace(payload, gain=0.9 * RULES.look_gain, std=0.0), effect)
    assert not worth_it(replace(payload, std=payload.gain), effect), "a gain that scatter explains"
    assert not worth_it(replace(payload, overall=None), effect)
    assert not worth_it(payload, replace(effect, corrections={"outputs": next(iter(effect.corrections.values()))}))


@pytest.mark.study
def test_what_rests_on_absent_channels_is_not_named(without):
    declared = Declaration(vehicle(), CLAY)
    again = (without.recordings, declared, without.bench)
    effects = {name: catalogue(vehicle())[name] for name in ("payload", "yaw_moment")}
    assert look_twice(*again, without.selection, effects).fits is not None
    strain_alone = look_twice(*again, without.selection, effects, more=False)
    assert strain_alone.selection == without.selection and strain_alone.fits is None and strain_alone.strain is not None
    lacking = replace(without.selection, rivals={"payload": ("v",)})
    found = look_twice(*again, lacking, effects).selection
    assert not found.accepted and found.unnamable == ("payload",)


def test_drives_without_such_windows_stay_as_they_are(without, monkeypatch):
    def none(*_):
        raise ValueError("expected at least 2 windows")

    monkeypatch.setattr("softsoil.refinement.joint_fit.free_windows", none)
    effects = {"payload": catalogue(vehicle())["payload"]}
    again = (without.recordings, Declaration(vehicle(), CLAY), without.bench)
    assert look_twice(*again, without.selection, effects) == Look(without.selection)
    payload = next(c for c in without.ranking if c.name == "payload")
    bench, _ = accept(without.bench, payload, effects)
    named = replace(without.selection, accepted=(payload,), bench=bench)
    assert look_twice(*again, named, effects) == Look(named)


def test_the_prior_is_the_joint_error():
    model = whole_model(Declaration(vehicle(), CLAY), ["payload"])
    mean = {name: float(model.p[name].nominal) for name in (*NUMBERS, "toe")}
    prior = joint_prior(ERROR, model, mean)
    assert prior.names == NUMBERS, "of toe it says nothing"
    p, moved = model.p.nominal.copy(), np.array([30.0, -2e-4])
    p[[model.p.index(name) for name in NUMBERS]] += moved
    residual = prior.residual(p)[0]
    assert residual @ residual == pytest.approx(moved @ np.linalg.solve(ERROR.covariance, moved))


@pytest.mark.parametrize(
    "load, strained", [((0.12, 0.04), True), ((-0.12, 0.04), True), ((0.12, 0.06), False), ((0.05, 0.01), False)]
)
def test_another_mass_is_a_change_until_an_effect_explains_it(load, strained):
    look = Look(None, strain=2.0, load=load)
    assert look.strained is strained and not look.explained
    assert ("heavier" in strained_words(look) or "lighter" in strained_words(look)) is strained
    with_effect = Look(None, strain=2.0, without=2.0, load_without=load)
    assert not with_effect.strained and with_effect.explained is strained
    alone = with_effect.without_effects()
    assert (alone.load, alone.without, alone.strained) == (load, None, strained)
    still = replace(with_effect, load=load)
    assert still.strained is strained and not (still.strained and still.explained), "a load beside the named effect"


@pytest.mark.slow
def test_one_step_tells_another_mass(clean, without):
    for found, share in ((clean, 0.0), (without, LOAD / vehicle().mass)):
        declared = Declaration(vehicle(), CLAY)
        problem = JointFit.of(found.recordings, declared, stated_error(declared, clean.bench), found.bench, ["payload"])
        load, std = problem.load(problem.plain()[0])
        assert 0.0 < std < 0.1 and abs(load - share) < 3.0 * std
    plain = JointFit.of(clean.recordings, declared, stated_error(declared, clean.bench), clean.bench, [])
    load, std = plain.load(plain.plain()[0])
    assert abs(load) < 3.0 * std < 0.3, "a load is looked for whatever effects are tried"
