"""Where a recording says that its sensors stand: transforms between frames, and the frame of each source."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

TRANSFORMS = "TFMessage"
"""End of the type of messages that hold transforms."""

VEHICLE = ("base_link", "base_footprint")
"""Names of a vehicle's own frame, often at its rear axle."""


@dataclass(frozen=True)
class Transform:
    """A frame `child` in its `parent`: place (3,) in m, turn (3, 3), whose columns are the child's axes."""

    parent: str
    child: str
    place: Array
    turn: Array


@dataclass(frozen=True)
class Place:
    """A frame in that of the vehicle, `base`: x, y (m ahead, left), yaw (rad) of its first axis, upside_down: its third axis
    points down."""

    base: str
    x: float
    y: float
    yaw: float
    upside_down: bool


def transforms_of(message: Any) -> list[Transform]:
    """The transforms of a message, none of one that holds none, or whose rotation is no quaternion."""
    found = []
    for one in getattr(message, "transforms", ()):
        at, q = one.transform.translation, one.transform.rotation
        if 0.5 < q.x**2 + q.y**2 + q.z**2 + q.w**2 < 1.5:
            turn = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
            parent, child = (str(name).lstrip("/") for name in (one.header.frame_id, one.child_frame_id))
            found.append(Transform(parent, child, np.array([at.x, at.y, at.z]), turn))
    return found


def frame_of(message: Any) -> str:
    """The frame of a message's values: that of an odometry's velocity, else of its header; empty where it names none."""
    child = getattr(message, "child_frame_id", "")
    return str(child or getattr(getattr(message, "header", None), "frame_id", "")).lstrip("/")


def places(transforms: Sequence[Transform]) -> Mapping[str, Place]:
    """Frame -> its place in the vehicle's frame: the first of VEHICLE that is named; empty where none is.

    Frames that no chain of transforms ties to it are left out.
    """
    named = {name for one in transforms for name in (one.parent, one.child)}
    root = next((name for name in VEHICLE if name in named), None)
    if root is None:
        return {}
    found: dict[str, tuple[Array, Array]] = {root: (np.zeros(3), np.eye(3))}
    while True:
        more = {
            one.child: (found[one.parent][0] + found[one.parent][1] @ one.place, found[one.parent][1] @ one.turn)
            for one in transforms
            if one.parent in found and one.child not in found
        }
        if not more:
            break
        found |= more
    return {
        name: Place(root, float(at[0]), float(at[1]), float(np.arctan2(turn[1, 0], turn[0, 0])), bool(turn[2, 2] < 0.0))
        for name, (at, turn) in found.items()
        if name != root
    }
