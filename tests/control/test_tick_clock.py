"""The clock of a driver's ticks: how long obstacles have moved where it is set back."""

import pytest

from softsoil.control.tick_clock import TickClock


def elapsed(stamps):
    """s for which obstacles have moved at the last of the stamps."""
    clock = TickClock(4.0)
    for t in stamps:
        clock.take(t, clock.check(t))
        clock.begin(t)
    return clock.at - clock.origin


@pytest.mark.parametrize(
    ("stamps", "moved"),
    (
        ((0.0, 1.0, 2.0), 2.0),
        ((1000.0, 1002.0, 1004.0, 3.0, 4.0), 5.0),  # set back before its beginning
        ((1000.0, 1003.0, 1006.0, 1009.0, 1001.0, 1002.0), 10.0),  # set back to after it
        ((0.0, 1.0, 1e6, 2.0, 3.0), 3.0),  # one stamp far ahead
        ((0.0, 1.0, 1e6, 2e6, 2.0, 3.0), 3.0),  # and two
        ((0.0, 1.0, 20.0, 21.0), 21.0),  # a pause
        ((0.0, 1.0, 21.0, 22.0, 23.0, 13.0, 14.0), 24.0),  # a pause, and soon set back
        ((0.0, 1.0, 20.0, 23.0, 26.0, 2.0), 26.0),  # a pause, and much later set back
    ),
)
def test_obstacles_have_moved_as_long_as_they_had(stamps, moved):
    assert elapsed(stamps) == pytest.approx(moved)


@pytest.mark.parametrize("t", (float("nan"), 1.5, -1.0))
def test_a_stamp_that_may_not_be_changes_nothing(t):
    clock = TickClock(4.0)
    for stamp in (0.0, 2.0):
        clock.take(stamp, clock.check(stamp))
        clock.begin(stamp)
    with pytest.raises(ValueError, match="expected a"):
        clock.check(t)
    assert (clock.at, clock.origin) == (2.0, 0.0)
