"""Parameters of a model that an estimator turns into states, or holds together."""

from __future__ import annotations

from dataclasses import replace

from softsoil.symbolic.model import Model, Stage
from softsoil.symbolic.signals import Layout, Signal


def promote_parameters(model: Model, *names: str) -> Model:
    """The model with the named parameters as states of zero rate (paper, eq. (bicycle_est)).

    names: parameters, appended to x in this order with their bounds. Raises KeyError for a name that is not a parameter.
    """
    promoted = Layout(tuple(model.p[name] for name in names))
    still = Stage("promoted", lambda q: {f"d_{name}": 0.0 for name in names})
    return replace(model, x=model.x + promoted, p=model.p.without(*names), stages=(*model.stages, still))


def tie_parameters(model: Model, signal: Signal, *names: str) -> Model:
    """The model with one parameter in the place of several, e.g. n for n_f and n_r.

    Raises KeyError for a name that is not a parameter.
    """
    remaining = model.p.without(*names)
    spread = Stage(f"tie_{signal.name}", lambda q: dict.fromkeys(names, q[signal.name]))
    return replace(model, p=Layout((signal, *remaining)), stages=(spread, *model.stages))
