"""The interval of a log's samples: one number for logs of one rate, whatever rounding, jitter and gaps do to their stamps."""

import numpy as np
import pytest

from softsoil.checking.usable import usable
from softsoil.recording.drive import Recording
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import load_vehicle


def interval(t):
    return Recording("log", {"t": t, "u": np.zeros(len(t))}).dt


@pytest.mark.parametrize("begin", [0.0, 3.7, 1.7e9])
@pytest.mark.parametrize("rows", [40, 1000, 3751])
def test_rounding_of_stamps_makes_no_other_rate(begin, rows):
    """A model is compiled for each interval: two logs of one rate, or two pieces of one, share it."""
    assert {interval(begin + step * np.arange(rows)) for step in (0.012, 0.012 * (1.0 + 3e-5))} == {0.012}


@pytest.mark.parametrize("rate", [10.0, 50.0, 100.0])
@pytest.mark.parametrize("seed", range(3))
def test_jitter_drops_and_gaps_do_not_either(rate, seed):
    rng = np.random.default_rng(seed)
    t = 1.7e9 + (np.arange(3000) + rng.uniform(-0.25, 0.25, 3000)) / rate
    kept = rng.uniform(size=3000) > 0.03
    kept[700:790] = False
    assert interval(t[kept]) == pytest.approx(1.0 / rate, rel=1e-12)


def test_two_rates_are_two():
    assert interval(0.0101 * np.arange(500)) == 0.0101 != interval(0.01 * np.arange(500))


def test_one_sample_has_no_interval():
    with pytest.raises(ValueError, match="log: expected two samples or more, found 1"):
        interval(np.array([3.0]))
    with pytest.raises(ValueError, match="log: expected at least 2 rows, found 1"):
        usable(Recording("log", {"t": np.zeros(1), "u": np.zeros(1)}), bicycle(load_vehicle("reference"), CLAY).geometry)
