"""FMI 3.0 co-simulation units: the C source and the description of the model's, and what every description needs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.resources import files
from types import MappingProxyType
from xml.sax.saxutils import quoteattr

from softsoil.codegen.c_library.kernels import number
from softsoil.codegen.c_library.parts import Parts
from softsoil.symbolic.signals import Signal

IDENTIFIER = "softsoil"
FIRST_INPUT, FIRST_STATE, FIRST_PARAMETER = 1, 100, 1000
"""Value references, as in fmu.c."""
_TYPES = (
    "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean", "String", "Binary", "Clock",
)  # fmt: skip
_REST = (
    "ActivateModelPartition", "CompletedIntegratorStep", "DeserializeFMUState", "EnterConfigurationMode",
    "EnterContinuousTimeMode", "EnterEventMode", "EnterStepMode", "EvaluateDiscreteStates", "ExitConfigurationMode",
    "FreeFMUState", "GetAdjointDerivative", "GetContinuousStateDerivatives", "GetContinuousStates",
    "GetDirectionalDerivative", "GetEventIndicators", "GetFMUState", "GetIntervalDecimal", "GetIntervalFraction",
    "GetNominalsOfContinuousStates", "GetNumberOfContinuousStates", "GetNumberOfEventIndicators",
    "GetNumberOfVariableDependencies", "GetOutputDerivatives", "GetShiftDecimal", "GetShiftFraction",
    "GetVariableDependencies", "SerializeFMUState", "SerializedFMUStateSize", "SetContinuousStates", "SetFMUState",
    "SetIntervalDecimal", "SetIntervalFraction", "SetShiftDecimal", "SetShiftFraction", "SetTime", "UpdateDiscreteStates",
)  # fmt: skip
"""Functions that the standard requires every unit to have, and that this one answers with an error."""


def fmi_files(parts: Parts, values: Mapping[str, str]) -> dict[str, str]:
    """fmi/fmu.c and fmi/modelDescription.xml; values: of the library (magic, dt, model, effects, version)."""
    model, token = parts.model, f"{{softsoil-{values['magic']}}}"
    variables = [
        *variables_of(model.external, FIRST_INPUT, 'causality="input" variability="continuous"'),
        *variables_of(model.x, FIRST_STATE, 'causality="output" variability="continuous" initial="exact"'),
        *variables_of(model.p, FIRST_PARAMETER, 'causality="parameter" variability="tunable"'),
    ]
    about = f"{values['model']}{values['effects']}, softsoil {values['version']}"
    text = description(
        IDENTIFIER, model.name, token, about, values["dt"], variables, range(FIRST_STATE, FIRST_STATE + len(model.x)),
        (*model.external, *model.x, *model.p),
    )  # fmt: skip
    return {
        "fmi/fmu.c": _template("fmu.c.in").replace("@token@", token), "fmi/fmu_common.h": common_source(),
        "fmi/modelDescription.xml": text,
    }  # fmt: skip


def common_source() -> str:
    """fmi/fmu_common.h, which every unit includes."""
    names = [f"fmi3{verb}{kind}" for kind in _TYPES for verb in ("Get", "Set")] + [f"fmi3{name}" for name in _REST]
    absent = "\n".join(f"ABSENT({name})" for name in names)
    return _template("fmu_common.h.in").replace("@absent@", absent)


def _template(name: str) -> str:
    return (files("softsoil.codegen.c_library") / "templates" / name).read_text(encoding="utf-8")


def description(
    identifier: str, name: str, token: str, about: str, step: str, variables: Sequence[str], outputs: Iterable[int],
    signals: Iterable[Signal], variable_step: bool = True, calculated: bool = False,
) -> str:  # fmt: skip
    """modelDescription.xml.

    identifier: of the library; name, about: of the unit; token: of its instances; step: s, as text; variables: lines; outputs:
    value references; signals: whose units are declared; variable_step: whether a communication step may have any length;
    calculated: whether the outputs at the start are calculated, not given.
    """
    fixed = "" if variable_step else f' fixedInternalStepSize="{step}"'
    units = sorted({signal.unit for signal in signals if exponents(signal.unit)})
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<fmiModelDescription fmiVersion="3.0" modelName={quoteattr(name)} instantiationToken="{token}"',
            f"    description={quoteattr(about)}>",
            f'  <CoSimulation modelIdentifier="{identifier}"'
            f' canHandleVariableCommunicationStepSize="{str(variable_step).lower()}"{fixed}/>',
            "  <UnitDefinitions>",
            *[f"    <Unit name={quoteattr(unit)}>{_base_unit(unit)}</Unit>" for unit in units],
            "  </UnitDefinitions>",
            f'  <DefaultExperiment startTime="0" stepSize="{step}"/>',
            "  <ModelVariables>",
            '    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>',
            *variables,
            "  </ModelVariables>",
            "  <ModelStructure>",
            *[f'    <Output valueReference="{reference}"/>' for reference in outputs],
            *[f'    <InitialUnknown valueReference="{reference}"/>' for reference in outputs if calculated],
            "  </ModelStructure>",
            "</fmiModelDescription>",
            "",
        ]
    )


def variables_of(layout: Iterable[Signal], first: int, kind: str, start: Callable[[Signal], str] | None = None) -> list[str]:
    """Lines of scalar variables; first: value reference of the first; kind: causality and variability; start: text of a start
    value, the nominal one by default, "" for none."""
    lines = []
    for i, s in enumerate(layout):
        value = number(s.nominal) if start is None else start(s)
        unit = f" unit={quoteattr(s.unit)}" if exponents(s.unit) else ""
        begins = f' start="{value}"' if value else ""
        words = quoteattr(f"{s.doc} ({s.unit or 1})")
        lines.append(f'    <Float64 name="{s.name}" valueReference="{first + i}" {kind}{unit}{begins} description={words}/>')
    return lines


_BASE: Mapping[str, Mapping[str, int]] = MappingProxyType(
    {
        "m": {"m": 1}, "s": {"s": 1}, "kg": {"kg": 1}, "rad": {"rad": 1},
        "N": {"kg": 1, "m": 1, "s": -2}, "Pa": {"kg": 1, "m": -1, "s": -2},
    }
)  # fmt: skip
"""SI exponents of the symbols that a unit may hold."""


def exponents(unit: str) -> dict[str, int]:
    """Exponents of the SI base units of a unit such as `rad s^2/m`; empty for none and where an exponent is no number."""
    found: dict[str, int] = {}
    above, *below = unit.replace("(", "").replace(")", "").split("/")
    for text, sign in ((above, 1), *((part, -1) for part in below)):
        for factor in text.split():
            symbol, _, power = factor.partition("^")
            if factor == "1":
                continue
            if symbol not in _BASE or not (power or "1").lstrip("-").isdigit():
                return {}
            for base, exponent in _BASE[symbol].items():
                found[base] = found.get(base, 0) + sign * exponent * int(power or 1)
    return {base: exponent for base, exponent in found.items() if exponent}


def _base_unit(unit: str) -> str:
    return f"<BaseUnit {' '.join(f'{base}={quoteattr(str(power))}' for base, power in sorted(exponents(unit).items()))}/>"
