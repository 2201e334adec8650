"""Generated folders that several tests compile: the reference vehicle without effects and with two that keep histories."""

from functools import lru_cache
from pathlib import Path
from tempfile import mkdtemp

import identified
from drives import reference_vehicle
from softsoil.codegen.c_library.binding import CLibrary
from softsoil.codegen.c_library.folder import write_library
from softsoil.control.c_estimator import c_library_texts
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.soil import CLAY

NAMES = ("plain", "tracks")
IDENTIFIED = "identified"
"""Plain too, and the vehicle's file states the joint error of its numbers: the library looks at the vehicle."""
SCALAR = ("-O2", "-DSOFTSOIL_SCALAR")


@lru_cache(maxsize=3)
def declared(name: str) -> Declaration:
    """The reference vehicle on clay: plain, on two tracks in its own ruts, or identified."""
    vehicle = identified.vehicle() if name == IDENTIFIED else reference_vehicle()
    return Declaration(vehicle if name == "tracks" else vehicle.with_(effects={}), CLAY)


@lru_cache(maxsize=4)
def folder(name: str) -> Path:
    """The generated library of `declared(name)`."""
    path = Path(mkdtemp(prefix="softsoil_c_"))
    write_library(path, c_library_texts(declared(name)))
    return path


def library_of(own: Declaration) -> CLibrary:
    """The library of any declared model, compiled."""
    path = Path(mkdtemp(prefix="softsoil_c_"))
    write_library(path, c_library_texts(own))
    return CLibrary(path, SCALAR)


@lru_cache(maxsize=8)
def library(name: str, flags: tuple[str, ...] = SCALAR) -> CLibrary:
    """It, compiled."""
    return CLibrary(folder(name), flags)
