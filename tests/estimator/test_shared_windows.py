"""What takes longer than a drive, a model's step in C, is built once for all logs of one rate."""

from dataclasses import replace

import pytest

from drives import clay_bicycle, clay_drive
from softsoil.estimator.moving_horizon import HorizonRules, drive_windows
from softsoil.recording.derive import mark
from softsoil.recording.drive import WHEEL_CHANNELS


def compiled(recording, model):
    return drive_windows(recording, model, 1.0, HorizonRules()).compiled


def test_pieces_copies_and_clocks_of_one_rate_share_a_model():
    log, model = clay_drive(16.0), clay_bicycle()
    one = compiled(log, model)
    epoch = replace(log, channels={**log.channels, "t": 1.7e9 + log.t * (1.0 + 2e-5)})
    assert compiled(log.between(3.3, 12.0), model) is one and compiled(epoch, model) is one


@pytest.mark.study
def test_a_log_without_wheel_speeds_has_its_own():
    log, model = clay_drive(16.0), clay_bicycle()
    assert compiled(mark(log, "derived", *WHEEL_CHANNELS), model) is not compiled(log, model)
