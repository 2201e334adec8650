"""Which wheels the model turns, of those that a log does not measure."""

import pytest

from drives import MULTI_LOG
from softsoil.recording.derive import mark
from softsoil.recording.read import read_drive
from softsoil.windows.absent_wheels import absent_wheels


@pytest.mark.parametrize(
    ("absent", "turned"),
    [((), ()), (("rr",), ("rr",)),
     (("fr", "rr"), ("fl", "fr", "rl", "rr")), (("rl", "rr"), ("rl", "rr")),
     (("fr", "rl", "rr"), ("fl", "fr", "rl", "rr")), (("fl", "fr", "rl", "rr"), ("fl", "fr", "rl", "rr"))],
)  # fmt: skip
def test_one_encoder_on_an_axle_is_used_beside_a_measured_axle(absent, turned):
    drive = mark(read_drive(MULTI_LOG), "derived", *(f"omega_{wheel}" for wheel in absent))
    assert absent_wheels([drive]) == turned
    assert absent_wheels([drive, read_drive(MULTI_LOG)]) == turned
