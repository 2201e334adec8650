"""Several recordings of one drive: bags with a part of the topics each, the files of a bag that was split, names given twice."""

import numpy as np
import pandas as pd
import pytest
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from softsoil.importing.bring_in import inspect_sources, read_sources
from softsoil.importing.import_map import map_from_table

STORE = get_typestore(Stores.ROS1_NOETIC)
RATE, BEGIN = 100.0, 100.0


def bag(path, topic, numbers=range(300), silent="", stamped=True):
    """Messages of 100 Hz, whose forward speed is their number."""
    names = ("geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist", "geometry_msgs/msg/Vector3", "std_msgs/msg/Header")
    with_header, twist, vector, header = (STORE.types[name] for name in names)
    path.parent.mkdir(exist_ok=True)
    with Writer(path) as out:
        kind = with_header if stamped else twist
        connection = out.add_connection(topic, kind.__msgtype__, typestore=STORE)
        if silent:
            out.add_connection(silent, kind.__msgtype__, typestore=STORE)
        for k in numbers:
            ns = int(1e9 * (BEGIN + k / RATE))
            stamp = STORE.types["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9)
            moving = twist(vector(float(k), 0.0, 0.0), vector(0.0, 0.0, 0.1))
            message = with_header(header(k, stamp, "base"), moving) if stamped else moving
            out.write(connection, ns, STORE.serialize_ros1(message, kind.__msgtype__))
    return path


def plan(**channels):
    return map_from_table({"channels": {name: f"{topic}:twist.linear.x" for name, topic in channels.items()}}, "map")


def test_each_bag_brings_the_topics_that_it_has(tmp_path):
    both = [bag(tmp_path / "a.bag", "/a"), bag(tmp_path / "b.bag", "/b")]
    for paths in (both, both[::-1]):
        found = read_sources(paths, plan(u="/a", v="/b"))
        assert set(found) == {"/a", "/b"} and all(len(one.t) == 300 for one in found.values())
    with pytest.raises(ValueError, match=r"expected topics of /a, /b; found none called '/c'"):
        read_sources(both, plan(u="/a", v="/c"))


def test_the_files_of_a_bag_that_was_split_are_one_recording(tmp_path):
    folder = tmp_path / "drive"
    bag(folder / "drive_0.bag", "/a", range(170))
    bag(folder / "drive_1.bag", "/a", range(170, 300))
    (holding,) = inspect_sources([folder])
    assert holding.count == 300 and holding.stop_s == pytest.approx(BEGIN + 299 / RATE, abs=1e-6)
    (series,) = read_sources([folder], plan(u="/a")).values()
    assert list(series.values["twist.linear.x"]) == list(range(300))


def test_two_recordings_in_a_folder_are_not_joined(tmp_path):
    bag(tmp_path / "days" / "monday.bag", "/a")
    bag(tmp_path / "days" / "tuesday.bag", "/a", range(8640000, 8640300))
    with pytest.raises(ValueError, match=r"found tuesday.bag 8639\d s after the end of monday.bag: give one of them"):
        read_sources([tmp_path / "days"], plan(u="/a"))


def test_two_recordings_at_one_time_are_not_mixed(tmp_path):
    for name in ("drive", "drive.orig"):
        bag(tmp_path / "cars" / f"{name}.bag", "/a")
    with pytest.raises(ValueError, match=r"found drive.*\.bag with /a at the same time as drive.*\.bag: give one of them"):
        inspect_sources([tmp_path / "cars"])
    bag(tmp_path / "devices" / "imu.bag", "/imu")
    bag(tmp_path / "devices" / "gps.bag", "/gps")
    assert {holding.name for holding in inspect_sources([tmp_path / "devices"])} == {"/imu", "/gps"}


def test_a_topic_without_a_message_is_none_of_a_bag(tmp_path):
    """Recorders list every topic that they listened to."""
    paths = [bag(tmp_path / "p0.bag", "/a", silent="/b"), bag(tmp_path / "p1.bag", "/b", silent="/a")]
    assert {name: len(one.t) for name, one in read_sources(paths, plan(u="/a", v="/b")).items()} == {"/a": 300, "/b": 300}
    with pytest.raises(ValueError, match=r"expected topics of /a, /b; found no message of '/b'"):
        read_sources(paths[:1], plan(u="/a", v="/b"))


def test_a_topic_or_a_file_given_twice_is_refused_and_none_of_them_dropped(tmp_path):
    parts = [bag(tmp_path / "p0.bag", "/a", range(170)), bag(tmp_path / "p1.bag", "/a", range(170, 300))]
    with pytest.raises(ValueError, match=r"found '/a' twice: bag files in one folder are read as the parts of one recording"):
        read_sources(parts, plan(u="/a"))
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        pd.DataFrame({"t": np.arange(9.0), "u": np.ones(9)}).to_csv(tmp_path / name / "log.csv", index=False)
    one = map_from_table({"channels": {"u": "log.csv:u"}}, "map")
    with pytest.raises(ValueError, match=r"expected distinct topics and file names, found 'log.csv' twice"):
        read_sources([tmp_path / "a" / "log.csv", tmp_path / "b" / "log.csv"], one)


@pytest.mark.parametrize("stamped", [True, False])
def test_the_end_of_a_topic_is_that_of_its_last_message(tmp_path, stamped):
    """A topic that pauses: its first messages say nothing of the last."""
    path = bag(tmp_path / "pause.bag", "/a", [*range(300), 35900, 35950], stamped=stamped)
    (holding,) = inspect_sources([path])
    assert holding.stop_s - holding.start_s == pytest.approx(359.5, abs=0.01)
