"""vehicle.toml of an identification: every number with its state, its standard deviation and what it costs n."""

from __future__ import annotations

from softsoil.files.toml_file import toml_text
from softsoil.identification.result import Found, Identification
from softsoil.identification.rules import RULES
from softsoil.identification.words import NO_BETTER
from softsoil.refinement.vehicle_numbers import FIXED, by_name
from softsoil.symbolic.vehicle import NUMBERS

STATES = {"given": "given", "identified": "identified", "not_identifiable": "not identifiable: as expected of any vehicle"}


def vehicle_toml(found: Identification) -> str:
    """A complete vehicle file, each number commented with its state; `load_vehicle` reads it back."""
    vehicle = found.vehicle
    lines = [
        f"# {found.verdict}: {found.reason}",
        f"# Identified from {', '.join(log for log in found.n if log != found.judged.log)}; judged on {found.judged.log}.",
        "# In brackets: change of n when the number is wrong by its standard deviation.",
        *(f"# Asked for: {words}." for words in found.asks),
        f"name = {toml_text(vehicle.name)}",
        f"verdict = {toml_text(vehicle.verdict)}",
    ]
    lines += [_line(n.name, getattr(vehicle, n.name), found.numbers.get(n.name), n.unit, doc=n.doc) for n in NUMBERS]
    for part, values in (("simulator", vehicle.simulator), ("driveline", vehicle.driveline)):
        if values:
            lines += ["", f"[{part}]", *(f"{key} = {value:.6g}" for key, value in values.items())]
    lines += [] if vehicle.steering is None else ["", *vehicle.steering.toml()]
    for effect, values in vehicle.effects.items():
        lines += ["", f"[effects.{effect}]"]
        for key, value in values.items():
            lines.append(_line(key, value, found.numbers.get(key), _unit(key), FIXED.get(effect, {}).get(key)))
    lines += _unexplained(found)
    alone = (
        f"# Standard deviations with all other numbers as they are, {RULES.model_error:g} times what noise alone makes since the "
        "force law errs, for commands that doubt the vehicle."
    )
    lines += ["", alone, "[uncertainty]"]
    lines += [f"{key} = {std:.4g}" for key, std in vehicle.uncertainty.items()]
    joint = (
        f"# Those whatever the other numbers are, {RULES.model_error_joint:g} times what noise alone makes, with their "
        "correlation, for commands that free all of them at once."
    )
    lines += [] if vehicle.joint_error is None else ["", joint, *vehicle.joint_error.toml()]
    return "\n".join(lines) + "\n"


def _unexplained(found: Identification) -> list[str]:
    """Lines of the table [unexplained]."""
    own = found.vehicle.unexplained
    about = "# Share of the motion (root mean square) of its own logs that these numbers leave beyond sensor noise, at most."
    return ["", about, "[unexplained]", *(f"{key} = {share:.4g}" for key, share in own.items())] if own else []


def _line(name: str, value: float, number: Found | None, unit: str, fixed: float | None = None, doc: str = "") -> str:
    unit = "" if unit == "1" else unit
    words = f"{unit}: {doc}".strip(": ")
    if number is not None:
        words = f"{unit} ± {number.std:.2g}, {STATES[number.state]}".strip()
        if number.state == "identified" and number.given is not None:
            words += f" (given {number.given:.6g})"
        words += f", {NO_BETTER}" if number.no_better else ""
        words += f" [{abs(number.n_percent_per_std):.1f} %]"
    elif fixed is not None:
        words = f"{unit} {'' if value == fixed else 'other than '}by the soil contact model".strip()
    return f"{name} = {value:.6g}  # {words}".rstrip(" #")


def _unit(name: str) -> str:
    number = by_name().get(name)
    return number.unit if number is not None else ""
