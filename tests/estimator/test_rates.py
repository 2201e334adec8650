"""n does not depend on the rate of a log, nor on a gap in one of its channels."""

from dataclasses import replace

import numpy as np
import pytest

from drives import LOAM_LOG, MULTI_LOG, reference_vehicle
from softsoil.estimator.estimate import estimate
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SANDY_LOAM


def at_rate(hertz):
    """The drive on sandy loam, whose steering is the fastest, with lines between its samples."""
    log = read_drive(LOAM_LOG)
    t = np.arange(log.t[0], log.t[-1], 1.0 / hertz)
    channels = {k: t if k == "t" else np.interp(t, log.t, np.unwrap(v) if k == "psi" else v) for k, v in log.channels.items()}
    return Recording(log.name, channels)


@pytest.mark.study
def test_a_log_of_fewer_hertz_says_the_same():
    model = bicycle(reference_vehicle(), SANDY_LOAM)
    whole = estimate(read_drive(LOAM_LOG).between(0.0, 20.0), model, 0.8)
    slow = estimate(at_rate(50.0).between(0.0, 20.0), model, 0.8)
    assert whole.verdict.word == slow.verdict.word == "identified"
    assert slow.n_front[-1] == pytest.approx(whole.n_front[-1], rel=0.02)


def test_a_gap_in_an_input_is_left_out():
    model, log = bicycle(reference_vehicle(), CLAY), read_drive(MULTI_LOG).between(0.0, 25.0)
    gap = (log.t > log.t[0] + 15.0) & (log.t < log.t[0] + 17.0)
    holed = log.with_channels(**{name: np.where(gap, np.nan, log[name]) for name in ("steer", *WHEEL_CHANNELS)})
    whole, found = (estimate(drive, model, 0.7) for drive in (log, holed))
    assert found.verdict.word == "identified" and not found.changes
    assert found.n_front[-1] == pytest.approx(whole.n_front[-1], rel=0.02)
    assert np.ptp(found.n_front[(found.t > log.t[0] + 15.3) & (found.t < log.t[0] + 16.9)]) < 0.02, "n learns little in it"


def test_what_the_model_leaves_of_a_slow_log_is_asked_too():
    """A steering 0.02 rad off at 40 Hz, with a vehicle's file that states no errors: n was identified."""
    drive = add_noise(read_drive(MULTI_LOG).between(0.0, 25.0), "good", 1)
    slow = replace(drive, channels={name: values[::2] for name, values in drive.channels.items()}, truth={})
    model = bicycle(reference_vehicle().with_(joint_error=None, uncertainty={}), CLAY)
    assert estimate(slow, model, 0.7).verdict.word == "identified"
    found = estimate(slow.with_channels(steer=slow["steer"] + 0.02), model, 0.7)
    assert found.verdict.word == "inconsistent" and "unexplained" in found.verdict.reason
