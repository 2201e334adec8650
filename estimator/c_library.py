"""The declared model and its terrain filter as the texts of a C library."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path

from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.c_library.library import FilterNumbers, library_files
from softsoil.codegen.c_library.parts import Parts, take_apart
from softsoil.codegen.sampling import STEP
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.c_horizon import horizon_numbers
from softsoil.estimator.promote import promote_parameters
from softsoil.estimator.terrain import Tuning, terrain_model
from softsoil.symbolic.catalogue import declared_model
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS

N_NAMES = ("n", "n_f", "n_r")
EXTRA_STD = 0.01
"""Of the first value and the noise of states that an effect brings, as in `softsoil.estimator.terrain`."""


def c_parts(declared: Declaration, promote: Sequence[str] = ()) -> Parts:
    """The declared model taken apart: n_f and n_r as states without effects, one n for both axles with them.

    promote: further parameters that are estimated too.
    """
    build = partial(_model_with, declared, tuple(promote))
    return take_apart(build, declared.force_law())


def _model_with(declared: Declaration, promote: tuple[str, ...], law) -> Model:
    built = declared_model(declared.vehicle, declared.soil, law)
    model = terrain_model(built, tied=bool(built.effects))
    return promote_parameters(model, *promote) if promote else model


def filter_numbers(model: Model, tuning: Tuning | None = None) -> FilterNumbers:
    """Defaults of the C filter: the terrain estimator's own numbers."""
    tuning = tuning or Tuning()
    extra = [name in N_NAMES for name in model.x.names[len(tuning.model_error) :]]
    return FilterNumbers(
        q_std=(*tuning.model_error, *(tuning.n_walk if is_n else EXTRA_STD for is_n in extra)),
        r_std=tuning.sensor_floor,
        std0=(*tuning.sensor_floor, *(tuning.n_std if is_n else EXTRA_STD for is_n in extra)),
        gate=tuning.gate,
    )


def c_library_texts(
    declared: Declaration, dt: float = STEP, fmi: bool = False, promote: Sequence[str] = ()
) -> dict[str, str]:
    """Every file of the C library, path -> text, for a declared model with nominal step dt (s); `fmi`: with the FMI unit's;
    promote: parameters of effects that filter and horizon estimate beside n, four numbers in all at most.

    Raises ValueError for a step that is not positive.
    """
    if not 0 < dt <= 0.1:
        raise ValueError(f"--dt: expected a step in (0, 0.1] s, found {dt}")
    parts = c_parts(declared, promote)
    vehicle = {key: value for key, value in vars(declared.vehicle).items() if key not in ("effects", "source")}
    about = {
        "vehicle": vehicle,
        "soil": {"name": declared.soil.name, **{s.name: getattr(declared.soil, s.name) for s in SOIL_SIGNALS}},
        "law": declared.law,
        "declared_effects": declared.vehicle.effects,
        "versions": {"softsoil": version("softsoil"), "casadi": version("casadi")},
    }
    return library_files(parts, filter_numbers(parts.model), horizon_numbers(), dt, about, fmi)


def generate(declaration: Declaration, folder: str | Path, dt: float = STEP, fmi: bool = False) -> list[Path]:
    """Write a declared model and its terrain filter as a C library; returns the paths of its files.

    declaration: vehicle with its effects, soil and force law; folder: made if need be; dt: nominal step (s);
    fmi: also an FMI 3.0 co-simulation unit. Raises ValueError for a step that is not in (0, 0.1] s.

    Example:
        >>> import softsoil, tempfile
        >>> declaration = softsoil.Declaration(softsoil.load_vehicle("paper"), softsoil.load_soil("clay"))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     names = [path.name for path in softsoil.generate(declaration, folder)]
        >>> "softsoil.h" in names
        True
    """
    paths = write_library(folder, c_library_texts(declaration, dt, fmi))
    if fmi:
        from softsoil.codegen.c_library.pack_fmu import pack_fmu

        paths.append(pack_fmu(Path(folder)))
    return paths
