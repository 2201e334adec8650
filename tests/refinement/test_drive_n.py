"""n of each drive by windows with free initial states, where noise at recorded starts biases it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.verdict import Verdict
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.plant.manoeuvres import MultiSine
from softsoil.recording.noise import add_noise
from softsoil.refinement.drive_n import FittedDrives, not_to_be_used
from softsoil.refinement.trace import fit_base, make_bench
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY

N, START, SECONDS = 0.6, 2.0, 26.0
DECLARED = Declaration(reference_vehicle().with_(effects={}, n_error=0.0), CLAY)


def drive(noise, seed=1, seconds=SECONDS):
    """A multi-sine drive of the model itself."""
    model = bicycle(DECLARED.vehicle, CLAY.with_(n=N))
    steer = MultiSine(0.35, seed=4)(0.012 * np.arange(round(seconds / 0.012) + 1))
    clean = synthetic_drive(model, DECLARED.vehicle.radius, seconds=seconds, speed=5.5, steer=steer)
    return add_noise(clean, noise, seed)


@pytest.fixture(scope="module")
def noisy():
    return [drive("table5", seed) for seed in (1, 2, 3)]


def fitted(recordings, declared=DECLARED):
    bench = make_bench(recordings, declared, START, names=[])
    return bench, fit_base(bench)


@pytest.mark.study
def test_noise_at_recorded_starts_biases_n_and_free_starts_do_not(noisy):
    bench, last = fitted(noisy)
    recorded = np.array([last.named()[free.name][0] for free in bench.ground])
    drives = FittedDrives(noisy, DECLARED, [CLAY] * len(noisy), START, bench, last, joint=False)
    found = drives.judged()
    assert [one.verdict.word for one in found] == ["identified"] * len(noisy)
    off = np.array([one.n for one in found]) / N - 1
    assert np.sqrt(np.mean(off**2)) < 0.5 * np.sqrt(np.mean((recorded / N - 1) ** 2))
    assert all(abs(one.n - N) < 3 * one.std for one in found)
    assert drives.plain() == tuple(one.n for one in found)


def test_n_of_a_joint_fit_stands_and_takes_the_error_of_numbers_in(noisy):
    bench, last = fitted(noisy[:1])
    wider = replace(DECLARED, vehicle=DECLARED.vehicle.with_(n_error=0.04))
    for declared, share in ((DECLARED, 0.0), (wider, 0.04)):
        drives = FittedDrives(noisy[:1], declared, [CLAY], START, bench, last, joint=True)
        (found,) = drives.judged()
        n, std = last.named()[bench.ground[0].name]
        assert found.n == n and found.std == pytest.approx(np.hypot(std, share * n))
        assert drives.plain() == (n,)


def test_a_drive_without_windows_keeps_the_n_of_its_fit(noisy, monkeypatch):
    def none(*_):
        raise ValueError("expected at least 2 windows")

    bench, last = fitted(noisy[:1])
    monkeypatch.setattr("softsoil.estimator.verdict.drive_windows", none)
    monkeypatch.setattr("softsoil.refinement.drive_n.drive_windows", none)
    drives = FittedDrives(noisy[:1], DECLARED, [CLAY], START, bench, last, joint=False)
    (found,) = drives.judged()
    assert (found.n, found.verdict.word) == (last.named()[bench.ground[0].name][0], "not_excited")
    assert drives.plain() == (found.n,)


def test_there_is_no_n_on_hard_ground(noisy):
    road = Declaration(DECLARED.vehicle, CLAY, "hard_ground")
    drives = FittedDrives(noisy[:1], road, [CLAY], START, *fitted(noisy[:1], road), joint=False)
    assert drives.judged() == drives.plain() == ()


def test_a_reason_in_the_vehicle_replaces_identified_alone(noisy):
    bench, last = fitted(noisy[:1])
    (found,) = FittedDrives(noisy[:1], DECLARED, [CLAY], START, bench, last, joint=False).judged()
    (strained,) = not_to_be_used([found], "it carries a load")
    assert (strained.verdict.word, strained.verdict.reason, strained.n) == ("inconsistent", "it carries a load", found.n)
    other = replace(found, verdict=replace(found.verdict, word="not_excited", reason="straight"))
    assert not_to_be_used([other], "it carries a load") == (other,)


@pytest.mark.parametrize(("share", "word"), [(0.06, "identified"), (0.2, "not_excited")])
def test_n_that_the_joint_fit_leaves_uncertain_is_not_identified(noisy, share, word, monkeypatch):
    """As with a payload free beside it, of which nothing else is known."""
    bench, last = fitted(noisy[:1])
    judged = Verdict("identified", "the drive determines n to ± 2 %", SimpleNamespace(soil=SimpleNamespace(more=0.0)))
    monkeypatch.setattr("softsoil.refinement.drive_n.judge", lambda *args, **options: judged)
    wider = replace(DECLARED, vehicle=DECLARED.vehicle.with_(n_error=share))
    (found,) = FittedDrives(noisy[:1], wider, [CLAY], START, bench, last, joint=True).judged()
    assert found.verdict.word == word
    assert ("determine n to ± 2" in found.verdict.reason and "limit 10 %" in found.verdict.reason) is (word == "not_excited")
