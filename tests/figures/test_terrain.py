"""The drive of an estimate's figure: a slower sensor's speed is a line, a gap is none, reversing is on the page."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from softsoil.figures.terrain import _drive
from softsoil.recording.drive import Recording


@pytest.fixture
def axis():
    figure, axis = plt.subplots()
    yield axis
    plt.close(figure)


def test_a_slower_sensors_speed_is_a_line_and_a_gap_is_none(axis):
    t = 0.01 * np.arange(400)
    u = np.linspace(-1.0, 3.0, 400)
    u[1::2] = np.nan
    u[200:300] = np.nan
    _drive(axis, Recording("log", {"t": t, "u": u, "steer": 0.1 * np.sin(t)}))
    right = next(one for one in axis.figure.axes if one is not axis)
    (line,) = right.lines
    drawn = np.isfinite(line.get_ydata())
    assert drawn[:198].all() and not drawn[202:298].any() and drawn[302:398].all()
    assert right.get_ylim()[0] == pytest.approx(-1.0)
