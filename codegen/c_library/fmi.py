"""The model as an FMI 3.0 co-simulation unit: its C source and modelDescription.xml."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from xml.sax.saxutils import quoteattr

from softsoil.codegen.c_library.kernels import number
from softsoil.codegen.c_library.parts import Parts
from softsoil.symbolic.signals import Layout

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
    names = [f"fmi3{verb}{kind}" for kind in _TYPES for verb in ("Get", "Set")] + [f"fmi3{name}" for name in _REST]
    token = f"{{softsoil-{values['magic']}}}"
    source = (files("softsoil.codegen.c_library") / "templates" / "fmu.c.in").read_text(encoding="utf-8")
    source = source.replace("@token@", token).replace("@absent@", "\n".join(f"ABSENT({name})" for name in names))
    return {"fmi/fmu.c": source, "fmi/modelDescription.xml": _description(parts, values, token)}


def _description(parts: Parts, values: Mapping[str, str], token: str) -> str:
    model = parts.model
    variables = [
        '    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>',
        *_variables(model.external, FIRST_INPUT, 'causality="input" variability="continuous"'),
        *_variables(model.x, FIRST_STATE, 'causality="output" variability="continuous" initial="exact"'),
        *_variables(model.p, FIRST_PARAMETER, 'causality="parameter" variability="tunable"'),
    ]
    outputs = [f'    <Output valueReference="{FIRST_STATE + i}"/>' for i in range(len(model.x))]
    about = quoteattr(f"{values['model']}{values['effects']}, softsoil {values['version']}")
    return "\n".join(
        [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<fmiModelDescription fmiVersion="3.0" modelName={quoteattr(model.name)} instantiationToken="{token}"',
            f"    description={about}>",
            f'  <CoSimulation modelIdentifier="{IDENTIFIER}" canHandleVariableCommunicationStepSize="true"/>',
            f'  <DefaultExperiment startTime="0" stepSize="{values["dt"]}"/>',
            "  <ModelVariables>",
            *variables,
            "  </ModelVariables>",
            "  <ModelStructure>",
            *outputs,
            "  </ModelStructure>",
            "</fmiModelDescription>",
            "",
        ]
    )


def _variables(layout: Layout, first: int, kind: str) -> list[str]:
    return [
        f'    <Float64 name="{s.name}" valueReference="{first + i}" {kind} start="{number(s.nominal)}" '
        f"description={quoteattr(f'{s.doc} ({s.unit or 1})')}/>"
        for i, s in enumerate(layout)
    ]
