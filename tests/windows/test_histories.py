"""Histories along known states, for many parameter sets at once: as stepped one by one, and never those of other states."""

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.codegen.compiled import find_compiler
from softsoil.codegen.predictor import Predictor
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.windows.free_windows import FreeWindows, WindowModel
from softsoil.windows.histories import history_loop
from softsoil.windows.shooting import shooting_drive

SIGMA = np.full(6, 0.02)


@pytest.fixture(scope="module")
def model():
    return bicycle(reference_vehicle().with_(effects={"multipass": {"kappa": 0.8}}), CLAY)


@pytest.fixture(scope="module")
def ready(model):
    return shooting_drive(synthetic_drive(model, reference_vehicle().radius, seconds=6.0), model, 1.0)


def sets(model):
    p = np.tile(model.p.nominal, (3, 1))
    p[1, model.p.index("n_f")] += 0.1
    p[2, model.p.index("kappa")] *= 0.5
    return p


def stepped(model, drive, p):
    states = np.column_stack([drive.smooth, np.tile(model.x.nominal[6:], (len(drive.t), 1))])
    found = [Predictor(model, drive.dt).track_memory(states, drive.inputs, row) for row in p]
    return states, np.array([memory for memory, _ in found]), [full for _, full in found]


@pytest.mark.parametrize("compiler", [True, False])
def test_along_known_states_they_are_what_steps_one_by_one_give(model, ready, compiler, monkeypatch):
    if not compiler:
        monkeypatch.setattr("softsoil.codegen.step_loop.find_compiler", lambda: None)
    elif find_compiler() is None:
        pytest.skip("no compiler")
    p, probe = sets(model), model.probe("load_f", "force_f")
    states, memory, full = stepped(model, ready, p)
    loop, rows = history_loop(model, ready.dt, probe), np.array([0, 7, len(states) - 1])
    beside, kept = loop.along(np.tile(states, (3, 1, 1)), memory[:, 0], ready.inputs, p, rows)
    assert np.allclose(kept, memory[:, rows], rtol=1e-9, atol=1e-12)
    for found, row, inputs in zip(beside, p, full, strict=True):
        expected = probe.map(len(states))(states.T, inputs.T, row).full().T
        assert np.allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_what_is_kept_is_never_that_of_other_states_or_parameters(model, ready):
    compiled = WindowModel(model, ready.dt, beside=model.probe("load_f"))
    p = sets(model)
    mine, fresh = (FreeWindows(compiled, ready, 1.0, SIGMA) for _ in range(2))
    first = mine.memories(p, mine.rows)
    moved = mine.first + 0.05
    mine.follow(p[0], moved)
    fresh.follow(p[0], moved)
    again = mine.memories(p, mine.rows)
    assert not np.allclose(again, first)
    assert np.array_equal(again, fresh.memories(p, fresh.rows))
    assert np.array_equal(mine.series(p[:1])[0], mine.series(p)[0])
    assert np.array_equal(mine.memories(p[1:], mine.rows)[0], again[1])
