"""Which numbers a model's motion depends on: where it does not depend on the sinkage exponent, the ground is hard."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import casadi as ca

from softsoil.files.toml_file import read_toml
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import SOIL_SIGNALS, Soil, load_soil, soil_from_table

HARD_GROUND = Soil("hard_ground", **{**{s.name: float(s.nominal) for s in SOIL_SIGNALS}, "phi": 0.6, "k": 0.0015})
"""Ground that is declared by no more than that it is hard: of it the law uses phi and k, where a fit starts."""


def idle(model: Model, names: Sequence[str]) -> tuple[str, ...]:
    """Those of a model's parameters `names` on which neither rates nor outputs nor histories depend."""
    x, u, p = model.symbols()
    q = model.quantities(x, u, p)
    q |= {"memory": {name: ca.SX.sym(name) for name in model.cells.names}, "dt": 0.01}
    results = [q[f"d_{name}"] for name in model.x.names] + [q[f"y_{name}"] for name in model.y.names]
    for memory in model.memories:
        results += [*memory.read(q).values(), *memory.advance(q).values(), *memory.start(q).values()]
    every = ca.vertcat(*map(ca.SX, results))
    return tuple(name for name in names if not ca.depends_on(every, p[model.p.index(name)]))


@lru_cache(maxsize=16)
def sinks(model: Model) -> bool:
    """Whether the motion depends on the sinkage exponent n: with a soil's force law, not on hard ground."""
    return len(idle(model, ("n_f", "n_r"))) < 2


def refuse_hard_ground(model: Model) -> None:
    """ValueError for a model on whose ground nothing sinks: what is asked for is its n."""
    if not sinks(model):
        raise ValueError(f"law: expected a soil's, with which wheels sink; found that of {model.name}: it has no n")


def load_ground(source: str, hard: bool) -> Soil:
    """A class of ground by name or from a TOML file; a file of hard ground needs what its law uses alone: phi and k.

    hard: whether nothing sinks with the force law. Raises ValueError as `load_soil` does.
    """
    path = Path(source)
    if not hard or path.suffix != ".toml" or not path.is_file():
        return load_soil(source)
    table = read_toml(path, "soil")
    unused = {name: value for name, value in HARD_GROUND.parameters().items() if name not in ("phi", "k")}
    return soil_from_table({**unused, **table.get("soil", table)}, str(path), path.stem)
