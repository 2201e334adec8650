"""Whether a plan clears the obstacles: soft limits let a plan through that does not, and someone has to brake for it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.control.nmpc_status import Status
from softsoil.control.ocp import CIRCLES, Ocp

Array = NDArray[np.float64]
ABSENT = (0.0, 0.0, -1e3)
"""x, y, radius (m) of an obstacle that is not there: a radius below 0 says so, and is clear of everything by itself."""


NEARER = 0.03
"""m by which a plan may come nearer to an obstacle that is inside the room around the vehicle already."""
SPARED = 0.8
"""Share of what is left of that room, when the margin is used up, that such plans may take."""


def placed(ocp: Ocp, obstacles: ArrayLike | None) -> Array:
    """(N + 1, n_obstacles, 3) from obstacles (N + 1, n, 3): x, y, radius over the horizon, or (n, 3) where they stand.

    Those that are not given are `ABSENT`; one of a radius below 0 is not there either. Raises ValueError for
    another shape or more than the Ocp watches.
    """
    n, most = ocp.settings.steps, ocp.settings.obstacles
    full = np.tile(np.array(ABSENT), (n + 1, most, 1))
    if obstacles is None or not np.size(obstacles):
        return full
    given = np.asarray(obstacles, dtype=float)
    given = np.broadcast_to(given, (n + 1, *given.shape)) if given.ndim == 2 else given
    if given.ndim != 3 or given.shape[0] != n + 1 or given.shape[1] > most or given.shape[2] != 3:
        raise ValueError(f"obstacles: expected up to {most} as (x, y, radius), found shape {given.shape}")
    full[:, : given.shape[1]] = np.where(given[:, :, 2:] < 0.0, ABSENT, given)
    return full


def planned_gaps(ocp: Ocp, z: Array, obstacles: Array) -> Array:
    """(N + 1, n) least gap (m) between the vehicle's circles, of radius body - margin, and each obstacle along the plan.

    z (N + 1, n_z); obstacles (N + 1, n, 3); inf for one that is not there.
    """
    back = np.arange(CIRCLES) * ocp.vehicle.wheelbase / (CIRCLES - 1)
    psi = z[:, ocp.z.index("psi"), None]
    x = z[:, ocp.z.index("x"), None] - back * np.cos(psi)
    y = z[:, ocp.z.index("y"), None] - back * np.sin(psi)
    apart = np.hypot(x[:, :, None] - obstacles[:, None, :, 0], y[:, :, None] - obstacles[:, None, :, 1])
    reach = np.where(obstacles[:, :, 2] < 0.0, -np.inf, obstacles[:, :, 2])
    gaps: Array = (apart - reach[:, None, :]).min(axis=1) - (ocp.body - ocp.settings.margin)
    return gaps


def gaps_now(ocp: Ocp, z0: Array, obstacles: Array) -> Array:
    """(n,) gap (m) of each obstacle (n, 3) to the vehicle in the state z0 (n_z,), its sides straight between the circles."""
    x, y, psi = (float(z0[ocp.z.index(name)]) for name in ("x", "y", "psi"))
    dx, dy = obstacles[:, 0] - x, obstacles[:, 1] - y
    back = np.clip(-(dx * np.cos(psi) + dy * np.sin(psi)), 0.0, ocp.vehicle.wheelbase)
    reach = np.where(obstacles[:, 2] < 0.0, -np.inf, obstacles[:, 2])
    gaps: Array = np.hypot(dx + back * np.cos(psi), dy + back * np.sin(psi)) - reach - (ocp.body - ocp.settings.margin)
    return gaps


def closest(ocp: Ocp) -> float:
    """Gap (m) of `planned_gaps`, below 0, that a plan may come to where the vehicle is inside the room around it already."""
    return -SPARED * (ocp.settings.room - ocp.settings.margin)


def judged(status: Status, gaps: Array, now: Array, nearest: float) -> tuple[Status, float, int]:
    """(status, least gap, first stage that touches or -1): a usable plan that touches an obstacle is BLOCKED.

    gaps (N + 1, n): of `planned_gaps`; now (n,): of `gaps_now`; nearest: as of `closest`. Where the vehicle stands now counts for
    nothing, no plan can change it; where an obstacle is inside the room around it already, a plan may come NEARER by a little, as
    the rear does when it steers away, but not beyond `nearest`.
    """
    limit = np.where(now < 0.0, np.maximum(now - NEARER, np.minimum(now, nearest)), 0.0)
    touching = np.flatnonzero((gaps[1:] < limit).any(axis=1))
    least, stage = float(gaps[1:].min(initial=np.inf)), int(touching[0]) + 1 if len(touching) else -1
    return (Status.BLOCKED if status.usable and stage > 0 else status), least, stage
