"""A clean drive as a robot writes it: topics at their own rates, late, jittered, with dropouts and a lever arm."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from softsoil.recording.drive import Array, Recording

RATIO, LATE = 16.0, 0.35
"""Steering wheel over road wheel; s that the steering report is late."""
ANTENNA = (-0.80, 0.30)
"""m ahead of and left of the centre of gravity."""
L_F, RADIUS = 1.546, 0.3313
EPOCH = 1_760_000_000.0
ORIGIN = (48.1, 11.6)
SIGMA = {"omega_z": 0.005, "a_x_imu": 0.1, "a_y_imu": 0.1, "u": 0.03, "v": 0.03, "psi": 0.003, "x": 0.03, "y": 0.03,
         "steer": 0.002, "omega_fl": 0.1, "omega_fr": 0.1, "omega_rl": 0.1, "omega_rr": 0.1}  # fmt: skip
BALLAST = {"/camera/image_raw": "sensor_msgs/msg/Image", "/lidar/points": "sensor_msgs/msg/PointCloud2"}
BALLAST_BYTES = 1_000_000
"""Bytes of one image or cloud."""
STEERING_MSG = """std_msgs/Header header
float32 wheel_angle_deg
uint8 status
"""


@dataclass(frozen=True)
class Messy:
    """One message to be written: topic, arrival (s), type, values by path."""

    topic: str
    arrival: float
    stamp: float
    values: dict[str, float]


def messages(drive: Recording, seed: int = 0, noise: float = 1.0) -> list[Messy]:
    """All messages in order of arrival; noise: factor to SIGMA."""
    rng = np.random.default_rng(seed)
    t = drive.t - drive.t[0]
    at = {
        name: CubicSpline(t, np.unwrap(v) if name == "psi" else v) for name, v in drive.channels.items() if name != "t"
    }
    at |= {name: (lambda s, name=name: np.interp(s, t, drive[name])) for name in ("a_x_imu", "a_y_imu", "steer")}

    def clock(rate: float, start: float, dropouts: int) -> Array:
        times = np.arange(start, t[-1] - 0.01, 1.0 / rate)
        keep = np.ones(len(times), dtype=bool)
        for _ in range(dropouts):
            first = rng.integers(len(times) // 10, len(times) - len(times) // 10)
            keep[first : first + max(round(0.25 * rate), 2)] = False
        return times[keep]

    def read(name: str, s: float) -> float:
        return float(at[name](s)) + noise * SIGMA[name] * rng.standard_normal()

    out: list[Messy] = []

    def add(topic: str, times: Array, late: float, values: Callable[[float], dict[str, float]]) -> None:
        for s in times:
            stamp = EPOCH + s + late + 0.001 * rng.standard_normal()
            out.append(Messy(topic, stamp + abs(0.004 * rng.standard_normal()), stamp, values(s)))

    add("/imu/data", clock(200.0, 0.0, 3), 0.0, lambda s: {n: read(n, s) for n in ("omega_z", "a_x_imu", "a_y_imu")})
    add("/odom", clock(50.0, 0.007, 2), 0.0, lambda s: _odometry(s, read))
    add("/gps/fix", clock(10.0, 0.031, 2), 0.0, lambda s: _antenna(s, at, rng, noise))
    names = ("omega_fl", "omega_fr", "omega_rl", "omega_rr")
    add("/joint_states", clock(100.0, 0.002, 2), 0.0, lambda s: {n: read(n, s) for n in names})
    add("/vehicle/steering", clock(50.0, 0.004, 1), LATE, lambda s: {"deg": np.rad2deg(RATIO * read("steer", s))})
    return sorted(out, key=lambda m: m.arrival)


def _odometry(s: float, read: Callable[[str, float], float]) -> dict[str, float]:
    """Pose and velocity of the centre of gravity."""
    psi = read("psi", s)
    x, y = read("x", s) - L_F * np.cos(psi), read("y", s) - L_F * np.sin(psi)
    return {"x": x, "y": y, "psi": psi, "u": read("u", s), "v": read("v", s), "omega_z": read("omega_z", s)}


def _antenna(s: float, at: dict[str, Any], rng: np.random.Generator, noise: float) -> dict[str, float]:
    from pymap3d import enu2geodetic

    psi = float(at["psi"](s))
    ahead, left = ANTENNA[0] - L_F, ANTENNA[1]
    east = float(at["x"](s)) + ahead * np.cos(psi) - left * np.sin(psi) + noise * SIGMA["x"] * rng.standard_normal()
    north = float(at["y"](s)) + ahead * np.sin(psi) + left * np.cos(psi) + noise * SIGMA["y"] * rng.standard_normal()
    latitude, longitude, altitude = enu2geodetic(east, north, 0.0, *ORIGIN, 500.0)
    return {"latitude": float(latitude), "longitude": float(longitude), "altitude": float(altitude)}


TYPES = {"/imu/data": "sensor_msgs/msg/Imu", "/odom": "nav_msgs/msg/Odometry", "/gps/fix": "sensor_msgs/msg/NavSatFix",
         "/joint_states": "sensor_msgs/msg/JointState", "/vehicle/steering": "my_robot_msgs/msg/SteeringReport"}  # fmt: skip
JOINTS = ("front_left_wheel_joint", "front_right_wheel_joint", "rear_left_wheel_joint", "rear_right_wheel_joint")


class _Maker:
    """Messages of a type store."""

    def __init__(self, store: Any, ros1: bool) -> None:
        self.store, self.ros1 = store, ros1

    def _make(self, kind: str, **values: Any) -> Any:
        return self.store.types[kind](**values)

    def _header(self, stamp: float) -> Any:
        seconds = int(stamp)
        time = self._make("builtin_interfaces/msg/Time", sec=seconds, nanosec=int((stamp - seconds) * 1e9))
        more = {"seq": 0} if self.ros1 else {}
        return self._make("std_msgs/msg/Header", stamp=time, frame_id="base_link", **more)

    def _vector(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, kind: str = "Vector3") -> Any:
        return self._make(f"geometry_msgs/msg/{kind}", x=x, y=y, z=z)

    def _turn(self, psi: float = 0.0) -> Any:
        return self._make(
            "geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=float(np.sin(psi / 2)), w=float(np.cos(psi / 2))
        )

    def _with_covariance(self, kind: str, **value: Any) -> Any:
        return self._make(f"geometry_msgs/msg/{kind}WithCovariance", **value, covariance=np.zeros(36))

    def message(self, m: Messy) -> Any:
        header, v = self._header(m.stamp), m.values
        kind = TYPES[m.topic]
        if m.topic == "/imu/data":
            return self._make(kind, header=header, orientation=self._turn(), orientation_covariance=np.full(9, -1.0),
                              angular_velocity=self._vector(z=v["omega_z"]), angular_velocity_covariance=np.zeros(9),
                              linear_acceleration=self._vector(v["a_x_imu"], v["a_y_imu"], 9.81),
                              linear_acceleration_covariance=np.zeros(9))  # fmt: skip
        if m.topic == "/odom":
            pose = self._make(
                "geometry_msgs/msg/Pose",
                position=self._vector(v["x"], v["y"], kind="Point"),
                orientation=self._turn(v["psi"]),
            )
            twist = self._make(
                "geometry_msgs/msg/Twist", linear=self._vector(v["u"], v["v"]), angular=self._vector(z=v["omega_z"])
            )
            return self._make(kind, header=header, child_frame_id="base_link",
                              pose=self._with_covariance("Pose", pose=pose),
                              twist=self._with_covariance("Twist", twist=twist))  # fmt: skip
        if m.topic == "/gps/fix":
            status = self._make("sensor_msgs/msg/NavSatStatus", status=0, service=1)
            return self._make(
                kind, header=header, status=status, position_covariance=np.zeros(9), position_covariance_type=0, **v
            )
        if m.topic == "/joint_states":
            return self._make(
                kind,
                header=header,
                name=list(JOINTS),
                position=np.zeros(4),
                velocity=np.array(list(v.values())),
                effort=np.zeros(4),
            )
        return self._make(kind, header=header, wheel_angle_deg=v["deg"], status=1)

    def ballast(self, topic: str, stamp: float, content: NDArray[np.uint8]) -> Any:
        """An image or a cloud of content (BALLAST_BYTES,) at a time stamp (s)."""
        header, kind = self._header(stamp), BALLAST[topic]
        if kind.endswith("Image"):
            return self._make(kind, header=header, height=500, width=2000, encoding="mono8", is_bigendian=0, step=2000,
                              data=content)  # fmt: skip
        field = self._make("sensor_msgs/msg/PointField", name="x", offset=0, datatype=7, count=1)
        return self._make(kind, header=header, height=1, width=BALLAST_BYTES // 16, fields=[field], is_bigendian=False,
                          point_step=16, row_step=BALLAST_BYTES, data=content, is_dense=True)  # fmt: skip


def _store(ros1: bool) -> Any:
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg(STEERING_MSG, TYPES["/vehicle/steering"]))
    return store


def write_bag(
    drive: Recording,
    path: Path,
    kind: str,
    seed: int = 0,
    noise: float = 1.0,
    compressed: bool = False,
    ballast: int = 0,
) -> Path:
    """The drive as a bag of kind "mcap", "sqlite3" or "rosbag1", with `ballast` images and clouds; returns its path."""
    ros1 = kind == "rosbag1"
    store = _store(ros1)
    maker = _Maker(store, ros1)
    topics = {**TYPES, **BALLAST} if ballast else TYPES
    ahead = deque(np.linspace(EPOCH, EPOCH + float(drive.t[-1] - drive.t[0]), ballast))
    content = np.random.default_rng(seed).integers(0, 255, BALLAST_BYTES, dtype=np.uint8)
    with _writer(path, kind, compressed) as writer:
        connections = {topic: writer.add_connection(topic, kind_, typestore=store) for topic, kind_ in topics.items()}
        serialize = store.serialize_ros1 if ros1 else store.serialize_cdr
        for m in messages(drive, seed, noise):
            while ahead and ahead[0] < m.arrival:
                topic, stamp = tuple(BALLAST)[len(ahead) % len(BALLAST)], ahead.popleft()
                raw = serialize(maker.ballast(topic, stamp, content), BALLAST[topic])
                writer.write(connections[topic], int(stamp * 1e9), raw)
            writer.write(connections[m.topic], int(m.arrival * 1e9), serialize(maker.message(m), TYPES[m.topic]))
    return path


def _writer(path: Path, kind: str, compressed: bool) -> Any:
    if kind == "rosbag1":
        from rosbags.rosbag1 import Writer as Writer1

        writer = Writer1(path)
        if compressed:
            writer.set_compression(Writer1.CompressionFormat.BZ2)
        return writer
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    writer2 = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3)
    if compressed:
        writer2.set_compression(
            CompressionMode.FILE if kind == "sqlite3" else CompressionMode.MESSAGE, CompressionFormat.ZSTD
        )
    return writer2


def edited(draft: str) -> str:
    """The drafted map with what only the user knows: the steering wheel's unit and ratio, GPS for position, its antenna."""
    lines = []
    for line in draft.splitlines():
        if line.startswith("steer = "):
            line = f'steer = {{source = "/vehicle/steering:wheel_angle_deg", unit = "deg", ratio = {RATIO}}}'
        if line.startswith("x = "):
            line = 'x = "/gps/fix:east"'
        if line.startswith("y = "):
            line = 'y = "/gps/fix:north"'
        lines.append(line)
    return "\n".join([*lines, '[mount."/gps/fix"]', f"x = {ANTENNA[0]}", f"y = {ANTENNA[1]}", ""])


def changed_lines(before: str, after: str) -> int:
    """Lines of `after` that are not in `before`."""
    have = set(before.splitlines())
    return sum(line not in have and bool(line.strip()) for line in after.splitlines())
