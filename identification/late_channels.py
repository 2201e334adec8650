"""Effects that the clocks of logs show: a steering that follows late looks as if its channel were early, in every log alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from softsoil.recording.drive import Recording
from softsoil.recording.offsets import Offset, time_offsets
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.vehicle_numbers import OPTIONAL, Number, declared_vehicle

SEEN = 3.0
"""Standard errors by which the channels are early in every log; a wrong yaw inertia makes less of it (0.008 s for 10 %)."""
ALIKE = 3.0
"""Standard errors within which all logs have to say the same: the vehicle's own lag is in each, a clock's offset changes."""


def with_late_channels(known: Known, recordings: Sequence[Recording]) -> tuple[Known, tuple[str, ...]]:
    """The known numbers with the effects declared that channels which seem early in all logs show, and a note of each.

    known: of the vehicle; an effect that they declare already stays as it is; recordings: its logs, two or more.
    """
    vehicle = declared_vehicle(known)
    offsets = [{offset.group: offset for offset in time_offsets(recording, vehicle)} for recording in recordings]
    notes = []
    for number in OPTIONAL:
        seen = [by_group[number.shown_by] for by_group in offsets if number.shown_by in by_group]
        if number.effect not in known.effects and _shown(seen, len(recordings)):
            known = replace(known, effects={**known.effects, number.effect: {}})
            notes.append(_note(number, seen))
    return known, tuple(notes)


def _shown(seen: Sequence[Offset], count: int) -> bool:
    """Whether all logs say beyond their errors that the channels are early, by as much."""
    early = all(offset.late_s < -SEEN * offset.std and offset.after > offset.before for offset in seen)
    late = [offset.late_s for offset in seen]
    if not early or len(seen) < max(count, 2):
        return False
    return max(late) - min(late) < ALIKE * max(offset.std for offset in seen)


def _note(number: Number, seen: Sequence[Offset]) -> str:
    early, std = -float(np.mean([offset.late_s for offset in seen])), max(offset.std for offset in seen)
    return (
        f"{number.effect}: in all {len(seen)} logs {number.shown_by} seems {early:.2f} ± {std:.2f} s early: taken as a lag of "
        f"the vehicle, {number.name} is identified with the other numbers. If it is the clock of a recorder instead, softsoil "
        "import --align shifts it"
    )
