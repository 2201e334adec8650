"""The declared model and its terrain filter as the texts of a C library."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.c_library.library import DriftNumbers, DriftSum, FilterNumbers, library_files
from softsoil.codegen.c_library.parts import Parts, take_apart
from softsoil.codegen.c_library.steering import HEADER, steering_header
from softsoil.codegen.sampling import STEP
from softsoil.control.c_horizon import horizon_numbers
from softsoil.control.c_vehicle import vehicle_numbers
from softsoil.declaration.handed import check_declaration
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.drift import DriftRules, likely_classes
from softsoil.estimator.promote import promote_parameters
from softsoil.estimator.soil_change import CHANGE_CLIP, CHANGE_SAMPLES, CHANGE_YOUNGEST
from softsoil.estimator.soil_trial import DETERMINED
from softsoil.estimator.terrain import terrain_model
from softsoil.estimator.tuning import LEAP, N_NAMES, POSE, WHEELS_TURN, Tuning, by_unit, common_error
from softsoil.files.identify_verdict import CONTRADICTED
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS
from softsoil.symbolic.vehicle import load_vehicle


def c_parts(declared: Declaration, promote: Sequence[str] = ()) -> Parts:
    """The declared model split: n_f and n_r as states without effects, one n for both axles with them.

    promote: further parameters that are estimated too.
    """
    build = partial(_model_with, declared, tuple(promote))
    return take_apart(build, declared.force_law())


def _model_with(declared: Declaration, promote: tuple[str, ...], law) -> Model:
    built = bicycle(declared.vehicle, declared.soil, law)
    model = terrain_model(built, tied=bool(built.effects))
    return promote_parameters(model, *promote) if promote else model


def filter_numbers(model: Model, tuning: Tuning | None = None) -> FilterNumbers:
    """Defaults of the C filter: the terrain estimator's own numbers."""
    tuning = tuning or Tuning()
    states = model.x
    return FilterNumbers(
        q_std=_floats(tuning.q_std(states)), r_std=tuning.sensor_floor, gate=tuning.gate,
        std0=_floats(tuning.std0(states, tuning.sensor_floor)), miss_std=tuning.output_error,
        kick_std=_floats(tuning.kick_std(states)), fastest=tuning.fastest, run_in=tuning.run_in,
        common_error=common_error(tuning.common_error, model),
        ceiling=_floats(by_unit(states, tuning.ceiling, 1e5)), patience=tuning.patience, patience_rates=tuning.patience_rates,
        pose=tuple(int(name in POSE) for name in model.y.names), soil=tuple(name for name in states.names if name in N_NAMES),
        change_after=tuning.change_after, change_sigmas=tuning.change_sigmas, change_std=tuning.change_std,
        change_error=tuning.change_error, change_samples=CHANGE_SAMPLES, change_clip=CHANGE_CLIP,
        change_youngest=CHANGE_YOUNGEST, trial_determined=DETERMINED,
        standstill=tuning.standstill, held_inputs=tuning.held_inputs, fade=tuning.fade, leap=LEAP,
        wheels_turn=WHEELS_TURN, u_limit=_floats(by_unit(model.external, tuning.input_limit, 1e9)),
        y_limit=_floats(by_unit(model.y, tuning.output_limit, 1e9)),
        drift=_drift_numbers(model),
    )  # fmt: skip


def _drift_numbers(model: Model) -> DriftNumbers:
    rules, effects = DriftRules(), catalogue(load_vehicle("reference")).values()
    channels = (
        DriftSum(
            channel.name,
            channel.allowance,
            channel.limit,
            model.y.index(channel.state) if channel.state else -1,
            ", or ".join(likely_classes(channel, effects)),
        )
        for channel in rules.channels
    )
    return DriftNumbers(rules.after, rules.gap, rules.turning, rules.steering, rules.most, tuple(channels))


def _floats(values: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(float(value) for value in values)


def c_library_texts(
    declared: Declaration, dt: float = STEP, fmi: bool = False, promote: Sequence[str] = ()
) -> dict[str, str]:
    """Every file of the C library, path -> text, for a declared model with nominal step dt (s); `fmi`: with the FMI unit's;
    promote: parameters of effects that filter and horizon estimate beside n, four numbers in all at most.

    Raises ValueError for a step that is not positive, a vehicle whose given numbers `softsoil identify` contradicts, or a soil
    that `softsoil soil` does.
    """
    if not 0 < dt <= 0.1:
        raise ValueError(f"--dt: expected a step in (0, 0.1] s, found {dt}")
    if declared.vehicle.verdict == CONTRADICTED:
        where = declared.vehicle.source or declared.vehicle.name
        raise ValueError(
            f"{where}: expected a vehicle whose numbers identify does not contradict; found verdict {CONTRADICTED!r}: "
            "measure again what its first line names, and identify anew"
        )
    if declared.soil.verdict == CONTRADICTED:
        raise ValueError(
            f"{declared.soil.name}: expected a soil that its own drives do not contradict (softsoil soil); found verdict "
            f"{CONTRADICTED!r}: what its file's first line says decides whether class or vehicle is another"
        )
    parts = c_parts(declared, promote)
    steering = declared.vehicle.steering
    elsewhere = ("effects", "source", "steering", "joint_error")
    vehicle = {key: value for key, value in vars(declared.vehicle).items() if key not in elsewhere and value != ""}
    if steering is not None:
        vehicle["steering"] = {"command": steering.command, "angle": steering.angle}
    about = {
        "vehicle": vehicle,
        "soil": {"name": declared.soil.name, **{s.name: getattr(declared.soil, s.name) for s in SOIL_SIGNALS}},
        "law": declared.law,
        "declared_effects": declared.vehicle.effects,
        "versions": {"softsoil": version("softsoil"), "casadi": version("casadi")},
    }
    numbers, horizon = filter_numbers(parts.model), horizon_numbers(parts.model)
    texts = library_files(parts, numbers, horizon, dt, about, fmi, vehicle_numbers(declared, tuple(promote)))
    return texts if steering is None else {**texts, HEADER: steering_header(steering)}


def generate(declaration: Declaration, folder: str | Path, dt: float = STEP, fmi: bool = False) -> list[Path]:
    """Write a declared model and its terrain filter as a C library; returns the paths of its files.

    declaration: vehicle with its effects, soil and force law; folder: made if need be; dt: nominal step (s);
    fmi: also an FMI 3.0 co-simulation unit. Raises ValueError for a step that is not in (0, 0.1] s, TypeError for
    what is no declaration.

    Example:
        >>> import softsoil, tempfile
        >>> declaration = softsoil.Declaration(softsoil.load_vehicle("paper"), softsoil.load_soil("clay"))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     names = [path.name for path in softsoil.generate(declaration, folder)]
        >>> "softsoil.h" in names
        True
    """
    check_declaration("generate", declaration)
    paths = write_library(folder, c_library_texts(declaration, dt, fmi))
    if fmi:
        from softsoil.codegen.c_library.pack_fmu import pack_fmus

        paths += pack_fmus(Path(folder))
    return paths
