"""Histories along a vehicle that stands: noise of its sensors leaves no rut that grows from sample to sample."""

import numpy as np
import pytest

import softsoil
from softsoil.codegen.discretize import start_memory
from softsoil.windows.histories import history_loop

DT, STEP, ROWS = 0.012, 5e-7, 300
WHEELS = ("omega_fl", "omega_fr", "omega_rl", "omega_rr")


@pytest.mark.parametrize("name", ["plant", "reference"])
def test_histories_of_a_vehicle_that_stands_follow_n_smoothly(name):
    """Derivatives by n after 3.6 s of standing are those of a straight history, at any n; they grew without bound, and a window
    after a start held n at its guess."""
    model = softsoil.bicycle(softsoil.load_vehicle(name), softsoil.load_soil("clay"))
    assert "multipass" in {memory.name for memory in model.memories}
    loop, start = history_loop(model, DT), start_memory(model)
    exponents = [model.p.index("n_f"), model.p.index("n_r")]
    for seed in range(8):
        rng = np.random.default_rng(seed)

        def smooth(level, count=21, rng=rng):
            return np.convolve(level * rng.standard_normal(ROWS + count - 1), np.ones(count) / count**0.5, mode="valid")

        x, u = np.zeros((ROWS, len(model.x))), np.tile(model.external.nominal, (ROWS, 1))
        for state, values in (("u", smooth(0.01)), ("v", smooth(0.03, 41)), ("omega_z", smooth(0.0015))):
            x[:, model.x.index(state)] = values
        for inputs, level in (*((wheel, 0.08) for wheel in WHEELS), ("a_x", 0.15), ("steer", 0.001), ("steer_rate", 0.03)):
            u[:, model.external.index(inputs)] = level * rng.standard_normal(ROWS)
        for n in (0.4, 0.6, 0.8, 1.1):
            p = np.tile(model.p.nominal, (2, 1))
            p[:, exponents] = [[n], [n + STEP]]
            straight = np.array([start(x[0], u[0], one).full()[:, 0] for one in p])
            m = loop.along(np.tile(x, (2, 1, 1)), straight, u, p, np.array([ROWS - 1]))[1][:, 0]
            assert np.isfinite(m).all(), (seed, n)
            slope, first = (np.abs(values[1] - values[0]).max() / STEP for values in (m, straight))
            assert slope < 2.0 * first, (seed, n)
