"""`softsoil generate`: a model as C."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from estimator.terrain import terrain_model
from estimator.unscented import UnscentedScaling, predict_function, update_function
from mpc_demo.c_example import write_beside
from mpc_demo.options import LawOption, ModelOption, SoilOption, VehicleOption, declaration
from mpc_demo.output import output_folder, say_written
from symbolic.codegen import write_c
from symbolic.discretize import discretize

STEM = "softsoil_model"


def generate(
    folder: Annotated[Path, typer.Argument(help="Folder to write in.", show_default=False)],
    vehicle: VehicleOption = None,
    soil: SoilOption = None,
    law: LawOption = "turn_slip",
    model: ModelOption = None,
    dt: Annotated[float, typer.Option("--dt", help="Step of the discrete model and the filter (s).")] = 0.012,
) -> None:
    """Write a model and its filter as C (ode, step, predict, update), with a README and an example.

    Example: softsoil generate build/clay --soil clay
    """
    built = declaration(vehicle, soil, law, model).build()
    augmented = terrain_model(built, tied=bool(built.effects))
    scaling = UnscentedScaling()
    step = discretize(augmented, dt)
    functions = [
        built.ode(),
        step,
        predict_function(step, augmented.x, scaling),
        update_function(augmented.measurement(), augmented.x, augmented.y, scaling),
    ]
    target = output_folder(folder, "generate")
    written = write_c(functions, target, name=STEM)
    say_written([*written, *write_beside(target, STEM, built, augmented, dt)])
