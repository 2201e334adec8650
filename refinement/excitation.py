"""Whether a drive's steering moves the vehicle in enough ways to separate like effects."""

from __future__ import annotations

import numpy as np

from softsoil.recording.clock import on_even_clock
from softsoil.recording.drive import Recording
from softsoil.refinement.rules import RULES


def strongest_line(recording: Recording) -> float:
    """Share of the steering's variance in the strongest line of its spectrum, 0 for a wheel held still.

    A sine gives 1, steps to and fro in one rhythm 0.86, a sum of sines much less.
    """
    log = on_even_clock(recording)
    steer = log["steer"]
    rows = np.arange(len(steer))
    good = np.isfinite(steer)
    steer = np.interp(rows, rows[good], steer[good]) if good.any() else np.zeros(len(steer))
    power = np.abs(np.fft.rfft((steer - steer.mean()) * np.hanning(len(steer)))) ** 2
    total = power[1:].sum()
    if not total > 1e-12 * len(steer):
        return 0.0
    at = 1 + int(np.argmax(power[1:]))
    return float(power[max(at - RULES.lines, 1) : at + RULES.lines + 1].sum() / total)


def one_wave(recording: Recording) -> bool:
    """Whether the steering repeats one wave, as in the paper's manoeuvre, which separates few effects."""
    return strongest_line(recording) > RULES.one_wave
