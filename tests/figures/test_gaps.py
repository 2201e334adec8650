"""Lines of samples that are seldom, and of stretches that are apart."""

import numpy as np
import pytest

from softsoil.figures.gaps import bridged, broken, root_mean_square

NAN = float("nan")


def test_errors_of_a_slow_pose_are_not_zero_between_its_samples():
    """Two windows whose samples fall on different rows: the mean counts both wherever they reach, and no row is without error."""
    side = bridged([[NAN, 0.2, NAN, 0.2, NAN, 0.2], [0.4, NAN, 0.4, NAN, 0.4, NAN]])
    assert np.isnan(side[0, 0]) and np.isnan(side[1, 5])
    both = np.sqrt((0.2**2 + 0.4**2) / 2)
    assert root_mean_square(side) == pytest.approx([0.4, both, both, both, both, 0.2])


def test_a_row_that_no_window_has_seen_has_no_error():
    assert root_mean_square([[NAN, 3.0], [NAN, 4.0]]) == pytest.approx([NAN, np.sqrt(12.5)], nan_ok=True)


def test_a_line_is_broken_where_time_leaps():
    t, values = broken([0.0, 0.5, 1.0, 20.0, 20.5], [1.0, 2.0, 3.0, 4.0, 5.0])
    assert t == pytest.approx([0.0, 0.5, 1.0, NAN, 20.0, 20.5], nan_ok=True)
    assert values == pytest.approx([1.0, 2.0, 3.0, NAN, 4.0, 5.0], nan_ok=True)
