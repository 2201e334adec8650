"""Places of sensors from a recording's transforms, and what the draft map makes of them."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from softsoil.importing.draft_map import draft
from softsoil.importing.frames import frame_of, places, transforms_of
from softsoil.importing.sources import Holding, Spread


def message(*frames):
    """A message of transforms: (parent, child, place, roll, yaw)."""
    made = []
    for parent, child, at, roll, yaw in frames:
        x, y, z, w = Rotation.from_euler("ZX", [yaw, roll]).as_quat()
        made.append(
            SimpleNamespace(
                header=SimpleNamespace(frame_id=parent), child_frame_id=child,
                transform=SimpleNamespace(
                    translation=SimpleNamespace(x=at[0], y=at[1], z=at[2]), rotation=SimpleNamespace(x=x, y=y, z=z, w=w)
                ),
            )
        )  # fmt: skip
    return SimpleNamespace(transforms=made)


TREE = message(
    ("mast", "/imu_link", (0.1, 0.0, 0.0), np.pi, 0.0),
    ("base_link", "mast", (0.5, 0.2, 1.0), 0.0, np.pi / 2),
    ("map", "odom", (9.0, 9.0, 0.0), 0.0, 0.0),
    ("base_link", "gps", (-0.3, 0.0, 1.2), 0.0, 0.0),
)


def test_chains_of_transforms_give_places_in_the_vehicles_frame():
    found = places(transforms_of(TREE))
    assert set(found) == {"mast", "imu_link", "gps"}, "odom is not tied to the vehicle"
    imu = found["imu_link"]
    assert (imu.x, imu.y, imu.yaw) == pytest.approx((0.5, 0.3, np.pi / 2)) and imu.upside_down
    assert (found["gps"].x, found["gps"].yaw) == pytest.approx((-0.3, 0.0)) and not found["gps"].upside_down
    assert places(transforms_of(message(("map", "odom", (1.0, 0.0, 0.0), 0.0, 0.0)))) == {}


def test_a_rotation_that_is_no_quaternion_is_left_out():
    wrong = message(("base_link", "gps", (1.0, 0.0, 0.0), 0.0, 0.0))
    wrong.transforms[0].transform.rotation = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=0.0)
    assert transforms_of(wrong) == [] and transforms_of(SimpleNamespace()) == []


def test_the_frame_of_an_odometry_is_that_of_its_velocity():
    header = SimpleNamespace(frame_id="/odom")
    assert frame_of(SimpleNamespace(header=header)) == "odom"
    assert frame_of(SimpleNamespace(header=header, child_frame_id="base_link")) == "base_link"
    assert frame_of(SimpleNamespace()) == ""


def test_the_draft_puts_the_places_in():
    def holding(name, kind, frame, **fields):
        spreads = {path.replace("__", "."): Spread(-1.0, 1.0, True) for path in fields}
        return Holding(name, f"sensor_msgs/msg/{kind}", "bag", 9, 100.0, 0.0, 1.0, "arrival", spreads, frame)

    tf = Holding("/tf_static", "tf2_msgs/msg/TFMessage", "bag", 1, 1.0, 0.0, 1.0, "arrival", {}, "", tuple(transforms_of(TREE)))
    imu = holding("/imu", "Imu", "imu_link", angular_velocity__z=1)
    odom = Holding("/odom", "nav_msgs/msg/Odometry", "bag", 9, 50.0, 0.0, 1.0, "arrival", {}, "base_link")
    text = draft([tf, imu, odom])
    section = text.split('[mount."/imu"]')[1].split("[mount")[0]
    assert "imu_link from base_link" in section and "# x = 0.500" in section and "# yaw = 1.571" in section
    assert 'frame = "z-down"' in section and "-l_r at the rear axle" in section
    assert "of base_link: x = -l_r" in text.split('[mount."/odom"]')[1]
    assert '[mount."/tf_static"]' not in text
