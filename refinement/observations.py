"""What measurements show without a model, by the names under which effects declare what rules them out or carries them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

from softsoil.recording.drive import Recording
from softsoil.refinement.wheel_speeds import all_open, locked_axles
from softsoil.symbolic.effect import Effect
from softsoil.symbolic.vehicle import Vehicle

OBSERVATIONS: Mapping[str, Callable[[Recording, Vehicle], str]] = MappingProxyType(
    {
        "wheels_turn_apart": lambda recording, vehicle: (
            "the wheels of both axles turn at different speeds in turns" if all_open(recording, vehicle) else ""
        ),
        "wheels_turn_together": lambda recording, vehicle: _together(locked_axles(recording, vehicle)),
    }
)
"""Name -> what is seen in a recording, in words, empty where it is not."""
SHOWN_BY: Mapping[str, tuple[str, ...]] = MappingProxyType({"v": ("x", "y", "psi")})
"""Absent channel -> channels that show the same motion: positions move across the heading with the lateral velocity."""


def _together(axles: Sequence[str]) -> str:
    return f"the {' and '.join(axles)} wheels turn together in turns: a locked axle differential" if axles else ""


def seen(name: str, recording: Recording, vehicle: Vehicle) -> str:
    """What an observation sees in a recording, in words; ValueError for a name that is none."""
    if name not in OBSERVATIONS:
        raise ValueError(f"observations: expected one of {', '.join(OBSERVATIONS)}; found {name!r}")
    return OBSERVATIONS[name](recording, vehicle)


def ruled_out(effect: Effect, recordings: Sequence[Recording], vehicle: Vehicle) -> bool:
    """Whether one of the observations that exclude the effect is made in every recording."""
    return any(all(seen(name, r, vehicle) for r in recordings) for name in effect.excluded_by)


def carried(effect: Effect, recordings: Sequence[Recording], vehicle: Vehicle) -> dict[str, str]:
    """Recording -> what shows that its measured inputs carry the effect, so that the model needs none for it."""
    found = {r.name: [words for name in effect.carried_by if (words := seen(name, r, vehicle))] for r in recordings}
    return {name: "; ".join(words) for name, words in found.items() if words}


def lacking(effect: Effect, recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Channels that the effect rests on and that a recording neither measures nor shows through others.

    Channels that the effect itself rests on show nothing else: of one that moves the positions, positions do not show v as well.
    """

    def there(name: str, recording: Recording) -> bool:
        shown = SHOWN_BY.get(name, ())
        independent = bool(shown) and not {*shown} <= {*effect.rests_on}
        return recording.measured(name) or (independent and recording.measured(*shown))

    return tuple(name for name in effect.rests_on if not all(there(name, recording) for recording in recordings))
