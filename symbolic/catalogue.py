"""The effect catalogue by name, found in the package of effects, and models from a declared vehicle."""

from collections.abc import Mapping
from types import ModuleType

from softsoil.files.own_modules import EFFECTS, made, module_names, own_file
from softsoil.symbolic import effects as package
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.effect import Effect, add_effect
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Layout
from softsoil.symbolic.soil import Soil
from softsoil.symbolic.vehicle import Vehicle
from softsoil.symbolic.wheel import ForceLaw


def catalogue(vehicle: Vehicle) -> dict[str, Effect]:
    """Every known effect by name, sized for the vehicle: `effect(vehicle)` of each module of `softsoil.symbolic.effects`.

    Raises ValueError for a module that has no `effect`, whose effect has another name than its file, or a parameter that another
    effect has, and for a user's file of which no effect can be made.
    Example: "payload_mass" in softsoil.catalogue(softsoil.load_vehicle("paper"))["payload"].parameters.names
    """
    known = {}
    for name in effect_names():
        known[name] = made(package.__name__, name, EFFECTS, lambda module: _effect(module, vehicle))
    taken: dict[str, str] = {}
    for name, effect in known.items():
        for parameter in effect.parameters.names:
            other = taken.setdefault(parameter, name)
            if other != name:
                own, its = (name, other) if own_file(name, EFFECTS) else (other, name)
                where = own_file(own, EFFECTS) or f"{own}.py"
                raise ValueError(f"{where}: expected parameters with names of their own, found {parameter}, which {its} has")
    return known


def _effect(module: ModuleType, vehicle: Vehicle) -> Effect:
    """The effect of a module, called as its file."""
    name = module.__name__.rpartition(".")[2]
    if not hasattr(module, "effect"):
        raise ValueError(f"{module.__file__}: expected a function effect(vehicle), found none")
    effect: Effect = module.effect(vehicle)
    if effect.name != name:
        raise ValueError(f"{module.__file__}: expected an effect called {name!r}, found {effect.name!r}")
    return effect


def effect_names() -> tuple[str, ...]:
    """Names of the modules of effects, alphabetically, the user's own among them; those with a leading underscore are none."""
    return module_names(package.__path__, EFFECTS)


def bicycle(
    vehicle: Vehicle,
    soil: Soil,
    law: ForceLaw | str = "turn_slip",
    effects: Mapping[str, Mapping[str, float]] | None = None,
    free: Layout = Layout(),  # noqa: B008
) -> Model:
    """The bicycle model of a vehicle on a soil, with the vehicle's declared effects (or the given ones).

    law: of a wheel, by name or itself; what the vehicle's [simulator] declares of its options takes the place of their defaults;
    effects: name -> parameters, in place of the vehicle's own; {} gives the paper's structure.
    free: numbers of the vehicle that become parameters of the model.
    Raises TypeError for a vehicle or soil of another kind, ValueError for an effect that the catalogue lacks, or a parameter that
    the effect lacks or that is out of its bounds.
    Example: softsoil.bicycle(softsoil.load_vehicle("paper"), softsoil.load_soil("clay")).x.names[:3] == ("x", "y", "psi")
    """
    for name, one, kind in (("vehicle", vehicle, Vehicle), ("soil", soil, Soil)):
        if not isinstance(one, kind):
            raise TypeError(f"bicycle: {name}: expected a {kind.__name__}, as of softsoil.load_{name}; found {one!r}")
    chosen = vehicle.effects if effects is None else effects
    known = catalogue(vehicle)
    _check_effects(chosen, known, vehicle.source or f"vehicle {vehicle.name}")
    model = nominal_bicycle(vehicle, soil, law, free)
    for name, values in chosen.items():
        model = add_effect(model, known[name], values)
    return model


def _check_effects(effects: Mapping[str, Mapping[str, float]], known: Mapping[str, Effect], where: str) -> None:
    """Raise ValueError naming `where` and the key for an effect that is not known, or a parameter that it lacks or forbids."""
    for name, values in effects.items():
        if name not in known:
            own = f"; one of your own has its file in a folder that {EFFECTS} names"
            raise ValueError(f"{where}: effects: expected names of {', '.join(known)}; found {name!r}{own}")
        layout = known[name].parameters
        for key, value in values.items():
            if key not in layout:
                raise ValueError(f"{where}: effects.{name}: expected parameters {', '.join(layout.names)}; found {key!r}")
            signal = layout[key]
            if not signal.lower <= value <= signal.upper:
                bounds = f"[{signal.lower:g}, {signal.upper:g}] {signal.unit}".rstrip()
                raise ValueError(f"{where}: effects.{name}.{key}: expected a number in {bounds}, found {value:g}")
