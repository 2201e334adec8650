"""Vehicles on deformable soil: one declaration becomes model, estimator, prediction, controller and C.

`import softsoil` offers the names below, each loaded on first use; `help(softsoil.estimate)` shows arguments, units and an
example. The modules that docs/reference/python.md lists are public as well; everything else is internal and may change.
"""

from __future__ import annotations

from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from softsoil.control.c_estimator import generate
    from softsoil.control.nmpc import Nmpc
    from softsoil.control.ocp import Ocp
    from softsoil.control.plugs_acados import to_acados
    from softsoil.control.plugs_do_mpc import to_do_mpc
    from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration
    from softsoil.estimator.estimate import estimate
    from softsoil.estimator.horizons import predict
    from softsoil.estimator.late_clocks import late_clocks
    from softsoil.files.package_data import example_logs
    from softsoil.identification.identify import identify
    from softsoil.identification.soil_numbers import identify_soil
    from softsoil.mapping.map_file import load_map
    from softsoil.mapping.soil_map import SoilMap, map_soil
    from softsoil.plant.simulate import simulate
    from softsoil.recording.drive import Recording
    from softsoil.recording.read import read_drive, write_drive
    from softsoil.refinement.refine import refine
    from softsoil.refinement.residual import residual
    from softsoil.symbolic.catalogue import bicycle, catalogue
    from softsoil.symbolic.effect import Effect, add_effect
    from softsoil.symbolic.model import Model
    from softsoil.symbolic.signals import Layout, Signal
    from softsoil.symbolic.soil import Soil, load_soil
    from softsoil.symbolic.vehicle import Vehicle, load_vehicle

    __version__: str

__all__ = [
    "Declaration",
    "Effect",
    "Layout",
    "Model",
    "Nmpc",
    "Ocp",
    "Recording",
    "Signal",
    "Soil",
    "SoilMap",
    "Vehicle",
    "__version__",
    "add_effect",
    "bicycle",
    "catalogue",
    "declaration_toml",
    "estimate",
    "example_logs",
    "generate",
    "identify",
    "identify_soil",
    "late_clocks",
    "load_declaration",
    "load_map",
    "load_soil",
    "load_vehicle",
    "map_soil",
    "predict",
    "read_drive",
    "refine",
    "residual",
    "simulate",
    "to_acados",
    "to_do_mpc",
    "write_drive",
]

if not TYPE_CHECKING:
    _MODULES = {
        "control.c_estimator": ("generate",),
        "control.nmpc": ("Nmpc",),
        "control.ocp": ("Ocp",),
        "control.plugs_acados": ("to_acados",),
        "control.plugs_do_mpc": ("to_do_mpc",),
        "estimator.estimate": ("estimate",),
        "estimator.horizons": ("predict",),
        "estimator.late_clocks": ("late_clocks",),
        "files.package_data": ("example_logs",),
        "mapping.map_file": ("load_map",),
        "mapping.soil_map": ("SoilMap", "map_soil"),
        "plant.simulate": ("simulate",),
        "recording.drive": ("Recording",),
        "recording.read": ("read_drive", "write_drive"),
        "identification.identify": ("identify",),
        "identification.soil_numbers": ("identify_soil",),
        "refinement.refine": ("refine",),
        "refinement.residual": ("residual",),
        "symbolic.catalogue": ("bicycle", "catalogue"),
        "declaration.model_file": ("Declaration", "declaration_toml", "load_declaration"),
        "symbolic.effect": ("Effect", "add_effect"),
        "symbolic.model": ("Model",),
        "symbolic.signals": ("Layout", "Signal"),
        "symbolic.soil": ("Soil", "load_soil"),
        "symbolic.vehicle": ("Vehicle", "load_vehicle"),
    }
    _WHERE = MappingProxyType({
        name.partition("=")[0]: (f"softsoil.{module}", name.rpartition("=")[2])
        for module, names in _MODULES.items()
        for name in names
    })  # fmt: skip

    def __getattr__(name: str) -> Any:
        if name == "__version__":
            return import_module("importlib.metadata").version("softsoil")
        if name not in _WHERE:
            raise AttributeError(f"module 'softsoil' has no attribute {name!r}; it offers {', '.join(__all__)}")
        module, attribute = _WHERE[name]
        return getattr(import_module(module), attribute)


def __dir__() -> list[str]:
    return sorted(__all__)
