"""Write the example of a robot's own log, `data/my_log`, from `multi_clay_n0.50.parquet`: `python data/write_my_log.py`.

A bag (rosbag2, sqlite3, compressed) with an IMU at 100 Hz, odometry at 20 Hz and wheel joints at 50 Hz, and a table `can.csv`
with the steering wheel in degrees at 25 Hz, 0.35 s late. Each source has its own jitter and noise. Needs `softsoil[logs]`.
"""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

HERE = Path(__file__).parent
FOLDER = HERE / "my_log"
FIRST, LAST = 2.0, 38.0
"""s of the log that is taken."""
EPOCH = 1_760_000_000.0
RATIO, LATE = 16.0, 0.35
"""Steering wheel over road wheel; s that the steering report is late."""
L_F = 1.546
"""m: odometry is at the centre of gravity, the log at the front axle."""
SIGMA = {"omega_z": 0.005, "a": 0.1, "u": 0.03, "v": 0.03, "psi": 0.003, "x": 0.03, "spin": 0.1, "steer": 0.002}
JOINTS = ("front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel")
WHEELS = ("omega_fl", "omega_fr", "omega_rl", "omega_rr")


def main() -> None:
    """Write bag and table anew."""
    log = pd.read_parquet(HERE / "multi_clay_n0.50.parquet")
    rng = np.random.default_rng(1)
    shutil.rmtree(FOLDER / "bag", ignore_errors=True)
    FOLDER.mkdir(exist_ok=True)
    store = get_typestore(Stores.ROS2_HUMBLE)
    messages = [*imu(log, rng, store), *odometry(log, rng, store), *joints(log, rng, store)]
    writer = Writer(FOLDER / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3)
    writer.set_compression(CompressionMode.FILE, CompressionFormat.ZSTD)
    with writer:
        topics = {topic: kind for _, topic, kind, _ in messages}
        connections = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in topics.items()}
        for arrival, topic, kind, message in sorted(messages, key=lambda m: m[0]):
            writer.write(connections[topic], int(arrival * 1e9), store.serialize_cdr(message, kind))
    steering(log, rng)


def times(rate: float, start: float, rng: np.random.Generator) -> np.ndarray:
    """Sample times (s) of a source at a rate (Hz), with one dropout of a quarter of a second."""
    t = np.arange(FIRST + start, LAST, 1.0 / rate)
    hole = rng.uniform(FIRST + 5.0, LAST - 5.0)
    return t[(t < hole) | (t > hole + 0.25)]


def read(log: pd.DataFrame, name: str, t: float, sigma: float, rng: np.random.Generator) -> float:
    """A channel at time t (s) with noise sigma."""
    values = np.unwrap(log[name]) if name == "psi" else log[name]
    return float(np.interp(t, log["t"], values)) + sigma * rng.standard_normal()


def header(store, t: float, rng: np.random.Generator):
    """(arrival, header) of a message sampled at t (s)."""
    stamp = EPOCH + t + 0.001 * rng.standard_normal()
    time = store.types["builtin_interfaces/msg/Time"](sec=int(stamp), nanosec=int((stamp - int(stamp)) * 1e9))
    return stamp + abs(0.004 * rng.standard_normal()), store.types["std_msgs/msg/Header"](stamp=time, frame_id="base_link")


def imu(log, rng, store):
    """IMU messages: yaw rate and specific force."""
    kind, vector = "sensor_msgs/msg/Imu", store.types["geometry_msgs/msg/Vector3"]
    still = store.types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
    for t in times(100.0, 0.0, rng):
        arrival, head = header(store, t, rng)
        rate = vector(x=0.0, y=0.0, z=read(log, "omega_z", t, SIGMA["omega_z"], rng))
        force = vector(*(read(log, name, t, SIGMA["a"], rng) for name in ("a_x_imu", "a_y_imu")), z=9.81)
        yield arrival, "/imu/data", kind, store.types[kind](
            header=head, orientation=still, orientation_covariance=np.full(9, -1.0), angular_velocity=rate,
            angular_velocity_covariance=np.zeros(9), linear_acceleration=force, linear_acceleration_covariance=np.zeros(9),
        )  # fmt: skip


def odometry(log, rng, store):
    """Odometry messages: pose and velocity of the centre of gravity."""
    kind = "nav_msgs/msg/Odometry"
    of = {name: store.types[f"geometry_msgs/msg/{name}"] for name in (
        "Point", "Quaternion", "Vector3", "Pose", "Twist", "PoseWithCovariance", "TwistWithCovariance")}  # fmt: skip
    for t in times(20.0, 0.007, rng):
        arrival, head = header(store, t, rng)
        psi = read(log, "psi", t, SIGMA["psi"], rng)
        place = (read(log, "x", t, SIGMA["x"], rng) - L_F * np.cos(psi), read(log, "y", t, SIGMA["x"], rng) - L_F * np.sin(psi))
        pose = of["Pose"](
            position=of["Point"](x=float(place[0]), y=float(place[1]), z=0.0),
            orientation=of["Quaternion"](x=0.0, y=0.0, z=float(np.sin(psi / 2)), w=float(np.cos(psi / 2))),
        )
        speed = {"x": read(log, "u", t, SIGMA["u"], rng), "y": read(log, "v", t, SIGMA["v"], rng), "z": 0.0}
        turn = {"x": 0.0, "y": 0.0, "z": read(log, "omega_z", t, SIGMA["omega_z"], rng)}
        twist = of["Twist"](linear=of["Vector3"](**speed), angular=of["Vector3"](**turn))
        yield arrival, "/odom", kind, store.types[kind](
            header=head, child_frame_id="base_link",
            pose=of["PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
            twist=of["TwistWithCovariance"](twist=twist, covariance=np.zeros(36)),
        )  # fmt: skip


def joints(log, rng, store):
    """Wheel speeds as joint states."""
    kind = "sensor_msgs/msg/JointState"
    for t in times(50.0, 0.002, rng):
        arrival, head = header(store, t, rng)
        speeds = np.array([read(log, name, t, SIGMA["spin"], rng) for name in WHEELS])
        message = store.types[kind](header=head, name=list(JOINTS), position=np.zeros(4), velocity=speeds, effort=np.zeros(4))
        yield arrival, "/joint_states", kind, message


def steering(log, rng) -> None:
    """The table of the steering wheel: degrees, left positive, late."""
    t = times(25.0, 0.004, rng)
    angle = [np.rad2deg(RATIO * read(log, "steer", s, SIGMA["steer"], rng)) for s in t]
    stamps = EPOCH + t + LATE + 0.001 * rng.standard_normal(len(t))
    table = pd.DataFrame({"stamp": stamps, "steering_wheel_deg": angle})
    table.to_csv(FOLDER / "can.csv", index=False, float_format="%.3f")


if __name__ == "__main__":
    main()
