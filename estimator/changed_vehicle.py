"""Words on a drive that would have its vehicle other than the file states: its numbers, its mass or its steering's scale."""

from __future__ import annotations

from softsoil.estimator.strain import VehicleChange

CHANGED = (
    "something of the vehicle has changed, as by a load, or the soil's class is another one than declared, or none of those that "
    "the vehicle was identified on"
)
"""What strained numbers of an identified vehicle may come from."""


def change_words(change: VehicleChange, most: float, strained: bool, heavier: bool, turned: bool) -> str:
    """What a drive says of its vehicle, and what that may come from; empty where it says nothing.

    change: by the drive; most: strain allowed; strained, heavier, turned: which of its numbers, its mass and its steering's scale
    are other ones.
    """
    said = []
    if strained:
        said.append(
            "asks for other numbers of the vehicle than its file states, beyond their joint error (strain "
            f"{change.strain:.1f}, 1 expected, {most:g} at most)"
        )
    if heavier:
        said.append(f"is that of a vehicle {heavier_words(change.load, change.load_std)} than declared")
    if turned:
        size, side = 100 * abs(change.steering), "farther" if change.steering > 0 else "less"
        std = max(100 * change.steering_std, 1.0)
        said.append(f"has road wheels that turn {size:.0f} ± {std:.0f} % {side} than steer says, by its ratio or its sensor")
    if not said:
        return ""
    return f"the drive {', or '.join(said)}: {CHANGED}; two drives of different manoeuvres show best which"


def heavier_words(load: float, std: float) -> str:
    """By how much a vehicle is heavier or lighter, in words; load, std: as of `VerdictRules.another_mass`."""
    return f"{100 * abs(load):.0f} ± {max(100 * std, 1.0):.0f} % {'heavier' if load > 0 else 'lighter'}"
