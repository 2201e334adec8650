"""Small drives and files that several tests use."""

from functools import lru_cache
from pathlib import Path

from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.drive import Recording
from softsoil.symbolic.bicycle import nominal_bicycle
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import Vehicle, load_vehicle

PROJECT = Path(__file__).resolve().parents[1]
DATA = PROJECT / "data"
CLAY_LOG = DATA / "paper_clay_n0.50.csv.gz"
MULTI_LOG = DATA / "multi_clay_n0.50.parquet"
LOAM_LOG = DATA / "paper_sandyloam_n0.70.parquet"


@lru_cache(maxsize=1)
def reference_vehicle() -> Vehicle:
    """The vehicle of the reference logs."""
    return load_vehicle(PROJECT / "vehicles" / "reference.toml")


@lru_cache(maxsize=1)
def clay_bicycle() -> Model:
    """The paper's structure on clay with the default law."""
    return nominal_bicycle(reference_vehicle(), CLAY)


@lru_cache(maxsize=4)
def clay_drive(seconds: float = 33.0) -> Recording:
    """A clean drive of the project's own bicycle on clay."""
    return synthetic_drive(clay_bicycle(), reference_vehicle().radius, seconds=seconds)
