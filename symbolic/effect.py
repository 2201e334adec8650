"""Effects that a nominal model lacks: what each is, and how it is added to any model without editing its equations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from softsoil.symbolic.bicycle import Corner
from softsoil.symbolic.model import Added, Compute, Correction, Memory, Model, Quantities
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.vehicle import GRAVITY, Vehicle

__all__ = [
    "GRAVITY", "Corner", "Correction", "Effect", "Layout", "Signal", "Values", "Vehicle", "add_effect", "each_wheel", "neutral",
]  # fmt: skip
"""What the file of an effect needs."""

KINDS = ("body", "load", "sensor", "slope", "soil", "steering", "tyre")
Values = Mapping[str, tuple[float, float]]
"""Name -> value and standard error."""


@dataclass(frozen=True)
class Effect:
    """One physical effect.

    name: as in reports and TOML, that of its file; doc: one line; kind: one of KINDS; reference: where its equation comes from;
    parameters: units and bounds, their nominal values the ones at which the effect is absent; the first one leads;
    typical: a plausible size of each parameter, where a fit starts (its sign is tried both ways where bounds allow);
    corrections: stage -> what it changes there; states: extra states, whose rates `d_<state>` a correction of the stage rates
    sets; memories: histories kept beside the states; effects whose memories have one name share it;
    signatures: what it looks like in a log, in words that effects of a like look share; separates: the manoeuvre that tells it
    from them; drawn: parameters of the vehicle's own build: once declared, no fit of another effect moves them;
    place: parameters x, y and heading of where it begins, which are tried, not fitted;
    repeats: whether a drive may have more of it than its vehicle declares: then it is tried again, from there;
    rests_on: measured channels without which a log does not identify it; excluded_by, carried_by: observations of the
    measurements (`softsoil.refinement.observations`) that rule it out, or that show the measured inputs to contain it;
    for_control: its parameters in the model of a controller whose vehicle declares no effects, empty: not in it;
    answers_to: switch of a simulated world -> parameters (or derived sizes) that equal what the switch is set to;
    derived: name and unit of a size that follows from the parameters; derive: that size and its standard error.
    Example: softsoil.catalogue(softsoil.load_vehicle("paper"))["grade"].parameters["grade"].unit == "rad"
    """

    name: str
    doc: str
    kind: str
    reference: str
    parameters: Layout
    typical: Mapping[str, float]
    corrections: Mapping[str, Correction]
    states: Layout = field(default_factory=Layout)
    memories: tuple[Memory, ...] = ()
    signatures: tuple[str, ...] = ()
    separates: str = ""
    drawn: tuple[str, ...] = ()
    place: tuple[str, ...] = ()
    repeats: bool = False
    rests_on: tuple[str, ...] = ()
    excluded_by: tuple[str, ...] = ()
    carried_by: tuple[str, ...] = ()
    for_control: Mapping[str, float] = field(default_factory=dict)
    answers_to: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    derived: Signal | None = None
    derive: Callable[[Values], tuple[float, float]] | None = None

    def __post_init__(self) -> None:
        if not self.name.isidentifier():
            raise ValueError(f"effect {self.name!r}: expected a name of letters, digits and underscores, as its file's")
        for name in (*self.drawn, *self.place, *self.for_control):
            if name not in self.parameters:
                raise ValueError(f"effect {self.name}: expected one of {', '.join(self.parameters.names)}; found {name!r}")
        if set(self.typical) != set(self.parameters.names):
            raise ValueError(
                f"effect {self.name}: expected typical values for {self.parameters.names}, found {tuple(self.typical)}"
            )
        for name, value in self.typical.items():
            signal = self.parameters[name]
            if not signal.lower <= value <= signal.upper:
                raise ValueError(f"effect {self.name}: expected typical {name} inside its bounds, found {value}")
        if self.kind not in KINDS:
            raise ValueError(f"effect {self.name}: expected a kind of {', '.join(KINDS)}; found {self.kind!r}")

    def looks_like(self, other: Effect) -> bool:
        """Whether the two have a signature in common: logs may not tell one from the other."""
        return self.name != other.name and bool(set(self.signatures) & set(other.signatures))

    def sizes(self, values: Values) -> dict[str, tuple[float, float, str]]:
        """Parameter -> value, standard error and unit, and the derived size; values: at least the effect's parameters."""
        found = {s.name: (*values[s.name], s.unit) for s in self.parameters}
        if self.derived is not None and self.derive is not None:
            found[self.derived.name] = (*self.derive(values), self.derived.unit)
        return found


def add_effect(model: Model, effect: Effect, values: Mapping[str, float] | None = None) -> Model:
    """The model with one more effect; every use downstream (C, filter, predictor, NMPC) carries it.

    values: parameter values to declare as nominal, default the typical ones. Any order of adding gives the same model: what an
    effect reads, others have corrected before, and layouts are in the alphabetical order of the effects.
    Raises ValueError for an effect added twice, effects that have no order, a name that the model has already, KeyError for a
    parameter that it does not have; `Model.ode` for a correction that is not as it declares.
    Example: "grade" in softsoil.add_effect(model, softsoil.catalogue(vehicle)["grade"], {"grade": 0.05}).effects
    """
    if effect.name in model.effects:
        raise ValueError(f"model {model.name}: effect {effect.name!r} is there already")
    if not effect.corrections:
        raise ValueError(f"effect {effect.name}: expected a correction of a stage at least, found none")
    for name in (*effect.parameters.names, *effect.states.names):
        if any(name in layout for layout in (model.x, model.u, model.p)):
            raise ValueError(f"effect {effect.name}: {name!r}: expected a name of its own, found one that the model has already")
    parameters = effect.parameters.with_nominal(**{**effect.typical, **(values or {})})
    new = Added(effect.name, effect.states, parameters, effect.memories)
    added = tuple(sorted((*model.added, new), key=lambda a: a.name))
    memories: dict[str, Memory] = {}
    for memory in (memory for a in added for memory in a.memories):
        if memories.setdefault(memory.name, memory).cells != memory.cells:
            raise ValueError(f"effect {effect.name}: expected a memory of its own name, found another one named {memory.name!r}")
    grown = replace(
        model,
        x=_inserted(model.x, new.x, [a.x for a in added], added.index(new)),
        u=model.external + Layout(tuple(signal for memory in memories.values() for signal in memory.provides)),
        p=_inserted(model.p, new.p, [a.p for a in added], added.index(new)),
        memories=tuple(memories.values()),
        added=added,
    )
    for stage, correction in effect.corrections.items():
        grown = grown.correct(stage, replace(correction, effect=effect.name))
    return grown


def _inserted(layout: Layout, new: Layout, parts: list[Layout], place: int) -> Layout:
    """The layout with `new` among the parts of other effects: parts[place], in their order, at the end where there are none."""
    later = [layout.index(s.name) for part in parts[place + 1 :] for s in part if s.name in layout]
    earlier = [layout.index(s.name) + 1 for part in parts[:place] for s in part if s.name in layout]
    at = min(later, default=max(earlier, default=len(layout)))
    return Layout((*layout.signals[:at], *new, *layout.signals[at:]))


def neutral(model: Model, effect: Effect) -> Model:
    """The model with the effect added but absent: its parameters at the values where it does nothing."""
    return add_effect(model, effect, dict(zip(effect.parameters.names, effect.parameters.nominal, strict=True)))


def each_wheel(change) -> Compute:
    """A correction's compute that changes every wheel: change(quantities, corner) -> corner."""

    def compute(q: Quantities) -> Quantities:
        return {"wheels": tuple(change(q, corner) for corner in q["wheels"])}

    return compute
