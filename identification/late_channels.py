"""Effects that the clocks of logs show: a steering that follows late looks as if its channel were early, in every log alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from softsoil.checking.offsets import Offset, time_offsets
from softsoil.declaration.late_steering import late_steering
from softsoil.identification.result import Found
from softsoil.recording.drive import Recording
from softsoil.refinement.known_vehicle import Known
from softsoil.refinement.vehicle_numbers import NUMBERS, Number, declared_vehicle
from softsoil.refinement.words import with_error

SEEN = 3.0
"""Standard errors by which the channels are early in every log; a wrong yaw inertia makes less of it (0.008 s for 10 %)."""
LATE = 1.5
"""Standard errors, four times the logs' scatter, below zero by which an identified lag is a channel that is recorded late."""
ALIKE = 3.0
"""Standard errors within which all logs have to say the same: the vehicle's own lag is in each, a clock's offset changes."""


def with_late_channels(known: Known, recordings: Sequence[Recording]) -> tuple[Known, tuple[str, ...]]:
    """The known numbers with the groups of channels that seem early in all logs, and a note of each.

    known: of the vehicle; a group that an effect they declare explains stays out; recordings: its logs, two or more.
    """
    vehicle = declared_vehicle(known)
    declared = late_steering(vehicle)
    offsets = [{o.group: _beside(o, declared) for o in time_offsets(recording, vehicle)} for recording in recordings]
    notes = []
    for number in NUMBERS:
        seen = [by_group[number.shown_by] for by_group in offsets if number.shown_by in by_group]
        if number.effect not in known.effects and _shown(seen, len(recordings)):
            early = -float(np.mean([offset.late_s for offset in seen]))
            known = replace(known, early={**known.early, number.shown_by: early})
            notes.append(_note(number, early, max(offset.std for offset in seen)))
    return known, tuple(notes)


def recorded_late(numbers: Mapping[str, Found]) -> tuple[str, ...]:
    """A note of each group of channels that an identified number below zero says is recorded late."""
    notes = []
    for number in NUMBERS:
        one = numbers.get(number.name) if number.shown_by else None
        if one is not None and one.state == "identified" and one.value < -LATE * one.std:
            notes.append(
                f"{number.name}: {with_error(one.value, one.std)} s, below zero: {number.shown_by} is recorded that much late"
                f"{' at least, the bound of its range' if one.value <= number.lower + 1e-4 else ''}. This file makes up for it "
                f"wherever {number.shown_by} is recorded alike; or, in place of this file, softsoil import shifts the channel "
                f"(late = {-one.value:.3f} at {number.shown_by} in its map), and softsoil identify anew"
            )
    return tuple(notes)


def _beside(offset: Offset, declared: float) -> Offset:
    """The offset beside what the vehicle's effects declare of a late steering (s)."""
    return replace(offset, late_s=offset.late_s + declared) if offset.group == "steer" else offset


def _shown(seen: Sequence[Offset], count: int) -> bool:
    """Whether all logs say beyond their errors that the channels are early, by as much."""
    early = all(offset.late_s < -SEEN * offset.std and offset.after > offset.before for offset in seen)
    late = [offset.late_s for offset in seen]
    if not early or len(seen) < max(count, 2):
        return False
    return max(late) - min(late) < ALIKE * max(offset.std for offset in seen)


def _note(number: Number, early: float, std: float) -> str:
    return (
        f"{number.effect}: in all logs {number.shown_by} seems {early:.2f} ± {std:.2f} s early: taken as a lag of the vehicle, "
        f"{number.name} is identified with the other numbers from there. If it is a recorder's clock instead, softsoil import "
        "--align shifts it"
    )
