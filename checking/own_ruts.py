"""Where wheels run in ruts that the vehicle made earlier in the drive: soil that is compacted already, of which n says another
thing.

On the simulated vehicle n of clay rises from 0.50 to more than 0.6 in the ruts of a first lap.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from softsoil.checking.driven_path import driven_path, unwrapped_heading
from softsoil.recording.drive import Array, Recording
from softsoil.recording.evidence import filled
from softsoil.recording.forward import REVERSING, STANDING, slower
from softsoil.recording.geometry import Geometry

PASSAGE = 3.0
"""Wheelbases that a wheel's track lies behind at least to be one of an earlier passage: the rear wheels follow the front ones."""
SIGMAS = 2.0
"""Standard deviations of the distance between two passages that count as none."""
FARTHEST = 1.0
"""m: with a position that is worse than this between two passages it cannot be known in which ruts a wheel runs."""
LEAST = 0.3
"""s: shorter stretches than this between ruts are no fresh soil."""
NOTE = "x, y: wheels run in ruts of earlier in this log"


def with_ruts(recording: Recording, geometry: Geometry) -> Recording:
    """The recording with the times in which wheels run in ruts of earlier in the drive, and a note of them.

    geometry: tracks, wheelbase and width of the wheels. Unchanged where positions are not measured, or not well enough; a heading
    that is not measured is laid on them.
    """
    if not recording.measured("x", "y", "u") or recording.state_of("psi") == "absent" or len(recording) < 2:
        return recording
    ruts = _stretches(recording, geometry)
    if ruts == recording.ruts:
        return recording
    notes = tuple(note for note in recording.notes if not note.startswith(NOTE))
    if ruts:
        notes += (
            f"{NOTE} for {sum(b - a for a, b in ruts):.3g} s, first at {ruts[0][0]:.4g} s: soil is compacted there; n is held, "
            "and no window of a fit or of predictions runs across it",
        )
    return replace(recording, ruts=ruts, notes=notes)


def _stretches(recording: Recording, geometry: Geometry) -> tuple[tuple[float, float], ...]:
    """Start and end (s) of each stretch in which a wheel runs within its width of where one ran before."""
    path, noise = driven_path(recording, geometry)
    width = max(geometry.width, geometry.rear_width)
    reach = width + SIGMAS * np.sqrt(2.0) * noise
    if reach > width + FARTHEST:
        return ()
    step = max(0.5 * width, 0.1)
    along, passage = _along(recording)
    places = np.arange(0.0, along[-1], step)  # of a slow log also between its rows
    if len(places) < 3:
        return ()
    psi = unwrapped_heading(recording)
    channels = (filled(path[:, 0]), filled(path[:, 1]), psi, recording.t)
    x, y, heading, starts = (np.interp(places, along, values) for values in channels)
    first = _earliest(_wheels(np.column_stack([x, y]), heading, geometry), reach)
    wheelbase, times = geometry.l_f + geometry.l_r, passage[np.searchsorted(along, places, side="right") - 1]
    again = (places - places[first] > PASSAGE * wheelbase) | (times > times[first])
    stops = np.append(starts[1:], recording.t[-1])
    ruts: list[tuple[float, float]] = []
    for start, stop in zip(starts[again], stops[again], strict=True):
        if ruts and start - ruts[-1][1] < LEAST:
            ruts[-1] = (ruts[-1][0], float(stop))
        else:
            ruts.append((float(start), float(stop)))
    return tuple(ruts)


def _along(recording: Recording) -> tuple[Array, NDArray[np.int_]]:
    """(N,) metres driven, forwards or back, and (N,) how often the direction has changed; who stands does not move on."""
    speed = np.abs(filled(recording["u"]))
    back = np.zeros(len(speed), dtype=bool)
    for first, last in slower(recording, STANDING):
        speed[first:last] = 0.0
    for first, last in slower(recording, REVERSING):
        speed[first:last], back[first:last] = np.abs(filled(recording["u"]))[first:last], True
    along = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(recording.t))])
    return along, np.concatenate([[0], np.cumsum(back[1:] != back[:-1])])


def _wheels(path: Array, psi: Array, geometry: Geometry) -> Array:
    """(K, 4, 2) where the wheels stand (m), of the front axle's middle path (K, 2) and the heading psi (K,)."""
    ahead, left = np.column_stack([np.cos(psi), np.sin(psi)]), np.column_stack([-np.sin(psi), np.cos(psi)])
    wheelbase, front, rear = geometry.l_f + geometry.l_r, 0.5 * geometry.track, 0.5 * geometry.rear_track
    places = ((0.0, front), (0.0, -front), (-wheelbase, rear), (-wheelbase, -rear))
    return np.stack([path + x * ahead + y * left for x, y in places], axis=1)


def _earliest(wheels: Array, reach: float) -> NDArray[np.int_]:
    """(K,) the earliest passage of any wheel within `reach` (m) of where one of wheels (K, 4, 2) stands.

    A cell of a quarter of the reach keeps the first passage alone, so that many laps cost no more than their ground.
    """
    points = wheels.reshape(-1, 2)
    _, kept = np.unique(np.floor(points / (0.25 * reach)).astype(np.int64), axis=0, return_index=True)
    kept = np.sort(kept)
    near = cKDTree(points[kept]).query_ball_point(points, reach, return_sorted=True)
    first = np.array([kept[own[0]] if own else i for i, own in enumerate(near)])
    return (np.minimum(first, np.arange(len(points))).reshape(-1, 4) // 4).min(axis=1)
