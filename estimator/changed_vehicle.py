"""Words on a drive that would have its vehicle other than the file states: its numbers, its mass or its steering's scale."""

from __future__ import annotations

from softsoil.estimator.strain import VehicleChange

CHANGED = (
    "something of the vehicle has changed, as by a load or the scale of its steering, or the soil's class is another one than "
    "declared, or none of those that the vehicle was identified on"
)
"""What strained numbers of an identified vehicle may come from."""
LIGHTEST, HEAVIEST = -0.4, 1.0
"""Shares of the declared mass between which a load, or the lack of one, is believed."""


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
        said.append(f"is that {mass_words(change.load, change.load_std)}")
    if turned:
        size, side = 100 * abs(change.steering), "farther" if change.steering > 0 else "less"
        std = max(100 * change.steering_std, 1.0)
        said.append(f"has road wheels that turn {size:.0f} ± {std:.0f} % {side} than steer says, by its ratio or its sensor")
    if not said:
        return ""
    return f"the drive {', or '.join(said)}: {CHANGED}; two drives of different manoeuvres show best which"


def is_a_load(load: float) -> bool:
    """Whether a load can be such a share of the declared mass, negative for one that is missing: beyond, something else is other
    than declared."""
    return LIGHTEST < load < HEAVIEST


def mass_words(load: float, std: float) -> str:
    """Whose drive it is, by its mass, in words; load, std: as of `VerdictRules.another_mass`."""
    side = "heavier" if load > 0 else "lighter"
    if not is_a_load(load):
        return f"of no such vehicle with any load (one {100 * abs(load):.0f} % {side} would fit best)"
    return f"of a vehicle {100 * abs(load):.0f} ± {max(100 * std, 1.0):.0f} % {side} than declared"
