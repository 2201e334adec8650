"""Predictions of channels that are not measured, and n's error by unmeasured numbers once motion has moved a given one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from drives import CLAY_LOG, reference_vehicle
from softsoil.checking.usable import usable
from softsoil.identification import n_errors
from softsoil.identification.judge import path_errors
from softsoil.recording.read import read_drive
from softsoil.refinement.known_vehicle import as_known
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY
from softsoil.windows.free_starts import steps_of
from softsoil.windows.free_windows import WindowModel
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import shooting_drive


def test_a_channel_that_is_not_measured_has_no_error():
    """It had one of 0: predicted perfectly."""
    log = read_drive(CLAY_LOG).between(0.0, 18.0)
    bare = replace(log, channels={name: values for name, values in log.channels.items() if name != "v"})
    drive, model = usable(bare, reference_vehicle()), bicycle(reference_vehicle(), CLAY)
    shooting = shooting_drive(drive, model, 2.0)
    table = path_errors(WindowModel(model, shooting.dt, steps_of(shooting.dt)), shooting, model.p.nominal, shooting.first + 800)
    for horizon in ("0.5", "2.5"):
        assert np.isnan(table[horizon]["v"]) and table[horizon]["omega_z"] > 0.0


def test_numbers_that_motion_moved_stay_moved(monkeypatch):
    known = as_known({"mass": 1378.3, "l_f": 1.646, "l_r": 1.175, "track": 1.232, "radius": 0.3302, "width": 0.212})
    free = [Free("yaw_inertia", ("yaw_inertia",), 10.0, 1.0, 1e5), Free("n_0", ("n_f",), 0.1, 0.2, 1.6, drive=0)]
    fit = SimpleNamespace(free=free, value=np.array([1900.0, 0.5]))
    asked = []

    def refit(bench, free, values, n):
        asked.append(values)
        return fit

    monkeypatch.setattr(n_errors, "fit_numbers", refit)
    moved = n_errors.unmeasured(SimpleNamespace(known=known), free[:1], fit, {"l_f": 1.546})
    assert moved and all(values["l_f"] == 1.546 and values["yaw_inertia"] == 1900.0 for values in asked)
    assert all(by == pytest.approx([0.0]) for by in moved.values())
