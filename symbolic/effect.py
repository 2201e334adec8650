"""Effects that a nominal model lacks: what each is, and how it is added to any model without editing its equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from softsoil.symbolic.model import Compute, Memory, Model, Quantities, Stage
from softsoil.symbolic.signals import Layout


@dataclass(frozen=True)
class Effect:
    """One physical effect.

    name: as in reports and TOML; doc: one line; reference: where its equation comes from;
    parameters: units and bounds, their nominal values the ones at which the effect is absent;
    typical: a plausible size of each parameter, where a fit starts (its sign is tried both ways where bounds allow);
    corrections: stage -> compute, applied to the quantities right after that stage;
    states, rates: extra states and their rates `d_<state>`, for effects that need them in every sigma point;
    memories: histories kept beside the states; effects whose memories have one name share it;
    confusable: effects with a like signature; separates: the manoeuvre that tells them apart;
    drawn: parameters of the vehicle's own build (its geometry, its shafts): once declared, no fit of another effect moves them.
    Example: softsoil.catalogue(softsoil.load_vehicle("paper"))["grade"].parameters["grade"].unit == "rad"
    """

    name: str
    doc: str
    reference: str
    parameters: Layout
    typical: Mapping[str, float]
    corrections: Mapping[str, Compute]
    states: Layout = field(default_factory=Layout)
    rates: Compute | None = None
    memories: tuple[Memory, ...] = ()
    confusable: tuple[str, ...] = ()
    separates: str = ""
    drawn: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if set(self.typical) != set(self.parameters.names):
            raise ValueError(
                f"effect {self.name}: expected typical values for {self.parameters.names}, found {tuple(self.typical)}"
            )
        for name, value in self.typical.items():
            signal = self.parameters[name]
            if not signal.lower <= value <= signal.upper:
                raise ValueError(f"effect {self.name}: expected typical {name} inside its bounds, found {value}")


def add_effect(model: Model, effect: Effect, values: Mapping[str, float] | None = None) -> Model:
    """The model with one more effect; every use downstream (C, filter, predictor, NMPC) carries it.

    values: parameter values to declare as nominal, default the typical ones. Effects compose in any order.
    Raises ValueError for an effect added twice, KeyError for a parameter that it does not have.
    Example: "grade" in softsoil.add_effect(model, softsoil.catalogue(vehicle)["grade"], {"grade": 0.05}).effects
    """
    if effect.name in model.effects:
        raise ValueError(f"model {model.name}: effect {effect.name!r} is there already")
    parameters = effect.parameters.with_nominal(**{**effect.typical, **(values or {})})
    kept = {memory.name: memory.cells for memory in model.memories}
    clash = [memory.name for memory in effect.memories if kept.get(memory.name, memory.cells) != memory.cells]
    if clash:
        raise ValueError(f"effect {effect.name}: expected a memory of its own name, found another one named {clash[0]!r}")
    memories = tuple(memory for memory in effect.memories if memory.name not in kept)
    provides = Layout(tuple(signal for memory in memories for signal in memory.provides))
    grown = replace(
        model,
        x=model.x + effect.states,
        u=model.u + provides,
        p=model.p + parameters,
        memories=model.memories + memories,
        effects=(*model.effects, effect.name),
    )
    for stage, compute in effect.corrections.items():
        grown = grown.correct(stage, compute)
    if effect.rates is not None:
        grown = replace(grown, stages=(*grown.stages, Stage(f"rates_{effect.name}", effect.rates)))
    return grown


def neutral(model: Model, effect: Effect) -> Model:
    """The model with the effect added but absent: its parameters at the values where it does nothing."""
    return add_effect(model, effect, dict(zip(effect.parameters.names, effect.parameters.nominal, strict=True)))


def each_wheel(change) -> Compute:
    """A correction that changes every wheel: change(quantities, corner) -> corner."""

    def compute(q: Quantities) -> Quantities:
        return {"wheels": tuple(change(q, corner) for corner in q["wheels"])}

    return compute
