"""Logs as newcomers bring them: read right, or refused with the place and the cure."""

import json
import tomllib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from drives import MULTI_LOG, reference_vehicle
from softsoil.checking.offsets import time_offsets
from softsoil.commands.cli import app
from softsoil.importing.draft_map import draft, offers
from softsoil.importing.hanging import hangs
from softsoil.importing.import_map import map_from_table
from softsoil.importing.loose_table import inspect_table, read_columns
from softsoil.importing.merge import merge
from softsoil.importing.messages import fields_of, reader_of
from softsoil.importing.sources import Holding, Series, Spread, ordered
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.read import read_drive

HEADINGS = {
    "german": ("Zeit [s]", "Geschwindigkeit [km/h]", "Gierrate [°/s]", "Lenkwinkel [°]", "Gierwinkel [°]"),
    "rover": ("time", "speed_kmh", "yaw_rate_dps", "steer_deg", "heading_deg"),
}


@pytest.fixture(scope="module")
def clean():
    return read_drive(MULTI_LOG)


def imported(path, tmp_path):
    return CliRunner().invoke(app, ["import", str(path), "--out", str(tmp_path / "out")])


def table(clean, words, every=8):
    """Speed in km/h, angles in degrees, the heading from 0 to 360, at about 10 Hz."""
    t, u, r, steer, psi = (clean[name][::every] for name in ("t", "u", "omega_z", "steer", "psi"))
    values = (t - t[0], 3.6 * u, np.rad2deg(r), np.rad2deg(steer), np.rad2deg(psi) % 360)
    return pd.DataFrame(dict(zip(words, values, strict=True)))


@pytest.mark.parametrize(
    ("words", "options"),
    [
        ("german", {"sep": ";", "decimal": ",", "encoding": "utf-8"}),
        ("german", {"sep": ";", "decimal": ",", "encoding": "cp1252"}),
        ("german", {"sep": "\t", "decimal": ",", "encoding": "utf-16"}),
        ("rover", {"sep": ",", "decimal": "."}),
    ],
    ids=("german", "windows", "utf-16", "rover"),
)
def test_a_slow_table_in_degrees_and_kilometres_per_hour_needs_no_map(words, options, clean, tmp_path):
    path = tmp_path / "log.csv"
    table(clean, HEADINGS[words]).to_csv(path, index=False, **options)
    done = imported(path, tmp_path)
    assert done.exit_code == 0, done.output
    drive = read_drive(tmp_path / "out" / "drive.parquet")
    t = drive.t + clean.t[0]
    for name in ("u", "omega_z", "steer"):
        assert np.allclose(drive[name], np.interp(t, clean.t, clean[name]), atol=0.02), name
    assert drive.measured("psi") and drive.state_of("v") == "derived" and "vehicle: reference" in done.output


def test_an_imported_drive_has_the_name_of_what_was_imported(clean, tmp_path):
    path = tmp_path / "lap 3.monday.csv"
    table(clean, HEADINGS["rover"]).to_csv(path, index=False)
    assert imported(path, tmp_path).exit_code == 0
    kept = tmp_path / "out" / "drive.parquet"
    assert read_drive(kept).name == "lap 3.monday"
    assert read_drive(kept.rename(tmp_path / "mine.parquet")).name == "mine", "a file that somebody named has that name"


def test_columns_that_are_empty_in_most_rows_are_drafted(clean, tmp_path):
    """A logger with one row per inertial sample: position and heading stand in every tenth."""
    frame = pd.DataFrame({
        "t": clean.t, "pos_x": clean["x"], "pos_y": clean["y"], "heading": clean["psi"], "VelForward_kmh": 3.6 * clean["u"],
        "VelLeft_kmh": 3.6 * clean["v"], "yaw_rate": clean["omega_z"], "steer": clean["steer"], "note": "",
    })  # fmt: skip
    frame.loc[np.arange(len(frame)) % 10 > 0, ["pos_x", "pos_y", "heading"]] = np.nan
    frame.to_csv(tmp_path / "log.csv", index=False)
    (holding,) = inspect_table(tmp_path / "log.csv")
    fields = {offer.channel: (offer.path, offer.unit) for offer in offers([holding])}
    assert fields["x"] == ("pos_x", "") and fields["y"] == ("pos_y", "") and fields["psi"] == ("heading", "")
    assert fields["u"] == ("VelForward_kmh", "km/h") and fields["v"] == ("VelLeft_kmh", "km/h")
    assert "note" not in holding.fields


@pytest.mark.parametrize(("name", "scale"), [("timestamp_ns", 1e9), ("time_us", 1e6), ("t_ms", 1e3), ("stamp_s", 1.0)])
def test_a_time_columns_unit_is_read_from_its_name(name, scale, clean, tmp_path):
    path = tmp_path / "log.parquet"
    epoch = 1_760_000_000 if name == "timestamp_ns" else 0
    ticks = np.round((epoch + clean.t) * scale) if scale > 1 else clean.t
    pd.DataFrame({name: ticks, "u": clean["u"]}).to_parquet(path)
    assert np.allclose(read_columns(path, ["u"]).t - epoch, clean.t, atol=1e-3)


@pytest.mark.parametrize("back", [0.5, 3600.0])
def test_a_clock_that_is_set_back_is_refused_with_its_sample_and_cure(back, clean, tmp_path):
    channels = {name: values.copy() for name, values in clean.channels.items()}
    channels["t"][2000:] -= back
    path = tmp_path / "log.csv"
    pd.DataFrame(channels).to_csv(path, index=False)
    done = imported(path, tmp_path)
    assert done.exit_code == 2 and not (tmp_path / "out").exists()
    said = done.output + done.stderr
    assert "sample 2001: expected a clock that runs forward" in said and "import each part" in said


def test_late_repeated_and_shuffled_samples_are_put_in_order(clean):
    t, u = clean.t.copy(), clean["u"]
    late = np.r_[t[:100], t[101:200], t[100], t[200:]]  # one packet 1.2 s late
    for times in (late, np.repeat(t, 2), np.random.default_rng(0).permutation(t)):
        series = ordered("/odom", times, {"u": np.interp(times, t, u)})
        assert np.array_equal(series.t, t) and np.allclose(series.values["u"], u) and series.notes


def test_columns_of_unknown_names_are_listed_with_the_way_out(clean, tmp_path):
    path = tmp_path / "log.csv"
    pd.DataFrame({"t": clean.t, "alpha": clean["u"], "beta": clean["omega_z"], "speed": clean["u"]}).to_csv(path, index=False)
    done = imported(path, tmp_path)
    said = done.output + done.stderr
    assert done.exit_code == 2 and "found none for omega_z, steer among log.csv:alpha, log.csv:beta" in said and "inspect" in said


@pytest.mark.parametrize("kept", [(), ("a_x_imu", "a_y_imu")])
def test_without_lateral_velocity_one_clock_is_not_shifted(kept, clean):
    """The rear axle's slip angle is guessed then: the offset's error says so."""
    bare = replace(clean, channels={k: v for k, v in clean.channels.items() if k in ("t", "u", "omega_z", "steer", *kept)})
    (steer,) = [o for o in time_offsets(bare, reference_vehicle()) if o.group == "steer"]
    assert abs(steer.late_s) < 1.5 * steer.std


JOINTS = {f"position[{name}_wheel_joint]": f"omega_{name[0]}{name[-1]}" for name in ("fl", "fr", "rl", "rr")}
STEERING = ("position[left_steering_joint]", "position[right_steering_joint]")


def encoders(clean, wrapped):
    """Joint states of a robot whose encoders say positions only, and whose front wheels are steered by two joints."""
    turned = {path: np.cumsum(clean[name]) * clean.dt for path, name in JOINTS.items()}
    values = {path: np.mod(angle, 2 * np.pi) if wrapped else angle for path, angle in turned.items()}
    for path, side in zip(STEERING, (1.0, -1.0), strict=True):
        values[path] = clean["steer"] + side * 0.1 * clean["steer"] ** 2
    motion = {name: clean[name] for name in ("u", "v", "omega_z", "psi", "x", "y", "a_x_imu", "a_y_imu")}
    kinds = {"/joint_states": ("sensor_msgs/msg/JointState", values), "motion.csv": ("table", motion)}
    holdings = [
        Holding(name, kind, name, len(clean), 1 / clean.dt, 0.0, 1.0, "header stamps", {
            path: Spread(float(one.min()), float(one.max()), True) for path, one in fields.items()
        })
        for name, (kind, fields) in kinds.items()
    ]  # fmt: skip
    return holdings, {name: Series(name, clean.t, fields) for name, (_, fields) in kinds.items()}


@pytest.mark.parametrize("wrapped", [False, True], ids=["counting on", "within a turn"])
def test_encoders_that_say_positions_and_two_steering_joints_need_no_map(wrapped, clean):
    holdings, series = encoders(clean, wrapped)
    plan = map_from_table(tomllib.loads(draft(holdings)), "map")
    assert plan.channels["steer"].fields == STEERING and plan.channels["omega_rl"].rate
    drive = merge("robot", plan, series, reference_vehicle()).recording
    assert np.allclose(drive["steer"], clean["steer"], atol=1e-9)
    for name in JOINTS.values():
        assert np.abs(drive[name][2:-2] - clean[name][2:-2]).max() < 0.02 * np.ptp(clean[name])


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ('steer = {source = "/a:b", rate = true}', "expected rate for a channel in rad/s or m/s, found one in rad"),
        ('omega_fl = {source = "/a:b", rate = true, unit = "rad/s"}', "expected a unit of rad"),
        ('steer = ["/a:left", "/b:right"]', "expected fields of one source"),
        ("steer = []", 'expected "source:field", a list of such'),
    ],
)
def test_a_rate_or_a_mean_that_cannot_be_is_named(entry, words):
    with pytest.raises(ValueError, match=words):
        map_from_table(tomllib.loads(f"[channels]\n{entry}\n"), "map")


def test_the_way_of_a_wheel_becomes_its_speed():
    plan = map_from_table(tomllib.loads('[channels]\nomega_fl = {source = "/a:way", rate = true, unit = "mm"}\n'), "map")
    t = np.linspace(0.0, 1.0, 11)
    origin = plan.channels["omega_fl"]
    assert np.allclose(origin.si(origin.samples(Series("/a", t, {"way": 3000.0 * t})), radius=0.3), 10.0)


@pytest.mark.parametrize(("bits", "first"), [(16, 0), (16, -(2**15)), (32, 0), (32, -(2**31))])
@pytest.mark.parametrize("sign", [1, -1])
def test_counts_that_wrap_go_on(clean, bits, first, sign):
    text = '[channels]\nomega_fl = {source = "/a:ticks", rate = true, factor = 0.001}\n'
    origin = map_from_table(tomllib.loads(text), "map").channels["omega_fl"]
    t = np.linspace(0.0, 2.0, 101)
    turned = sign * np.round(4000.0 * t) + (2**bits - 1500.0 if sign > 0 else 1500.0)
    series = Series("/a", t, {"ticks": np.mod(turned, 2**bits) + first})
    assert origin.wraps(series) == 1
    assert np.allclose(origin.si(origin.samples(series), radius=0.3), sign * 4.0, atol=1e-6)


def test_what_never_wraps_is_left_and_a_wrap_is_noted(clean):
    text = """
        [channels]
        u = "a:u"
        omega_z = "a:omega_z"
        steer = "a:steer"
        omega_fl = {source = "a:ticks", rate = true, factor = 0.001}
        """
    ticks = np.round(np.cumsum(clean["omega_fl"]) * clean.dt * 1000.0)
    fields = {name: clean[name] for name in ("u", "omega_z", "steer")}
    plan = map_from_table(tomllib.loads(text), "map")
    drives = []
    for counts in (ticks, np.mod(ticks, 2**16)):
        made = merge("log", plan, {"a": Series("a", clean.t, {**fields, "ticks": counts})}, reference_vehicle())
        drives.append(made.recording)
    assert np.allclose(drives[0]["omega_fl"], drives[1]["omega_fl"], atol=1e-9)
    assert not any("wrapped" in note for note in drives[0].notes)
    (note,) = [note for note in drives[1].notes if "wrapped" in note]
    assert note.startswith("omega_fl: a:ticks (rate): a counter that wrapped ")


def test_the_speed_of_a_velocity_to_the_east_and_north_is_drafted():
    twist = SimpleNamespace(linear=SimpleNamespace(x=3.0, y=-4.0, z=0.5), angular=SimpleNamespace(x=0.0, y=0.0, z=0.0))
    message = SimpleNamespace(twist=twist)
    assert dict(fields_of(message))["twist.linear.speed"] == reader_of("twist.linear.speed")(message) == 5.0
    fields = {path: Spread(-5.0, 5.0, True) for path, _ in fields_of(message)}
    gps, body = (Holding(name, "geometry_msgs/msg/TwistStamped", "bag", 10, 5.0, 0.0, 2.0, "header stamps", fields)
                 for name in ("/gps/vel", "/base/velocity"))  # fmt: skip
    offered = [("u", "twist.linear.speed"), ("velocity_east", "twist.linear.x"), ("velocity_north", "twist.linear.y")]
    assert sorted((o.channel, o.path) for o in offers([gps])) == offered
    assert ("u", "twist.linear.x") in [(o.channel, o.path) for o in offers([body])]


@pytest.mark.parametrize(
    ("unit", "reads", "down"),
    [("", -9.7, True), ("m/s²", -9.8, True), ("g", -1.0, True), ("g", 1.0, False), ("rpm", -9.8, False), ("", -0.2, False)],
)
def test_the_unit_of_gravity_is_read(unit, reads, down):
    fields = {"imu.linear_acceleration.z": Spread(reads - 0.1, reads + 0.1, True, unit)}
    assert hangs(Holding("/imu", "sensor_msgs/msg/Imu", "bag", 10, 100.0, 0.0, 2.0, "header stamps", fields)) == down


@pytest.mark.parametrize("side", [1.0, -1.0], ids=("up", "down"))
def test_a_sensor_with_z_down_is_told_by_the_gravity_that_it_reads(side, clean, tmp_path):
    """One table is the sensor, where side is -1 with y right and z down; another has speed and steering."""
    t = clean.t - clean.t[0]
    jolts = np.random.default_rng(0).normal(0.0, 0.3, len(t))
    turned = {"yaw_rate": "omega_z", "heading": "psi", "accel_y": "a_y_imu"}
    sensor = {"t": t, "accel_x": clean["a_x_imu"], **{column: side * clean[name] for column, name in turned.items()}}
    pd.DataFrame({**sensor, "accel_z": side * (9.81 + jolts)}).to_csv(tmp_path / "imu.csv", index=False)
    pd.DataFrame({"t": t, "speed": clean["u"], "steering_angle": clean["steer"]}).to_csv(tmp_path / "can.csv", index=False)
    sources = [str(tmp_path / name) for name in ("imu.csv", "can.csv")]
    done = CliRunner().invoke(app, ["import", *sources, "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert ("imu.csv: taken as a sensor with z down" in done.output) == (side < 0)
    drive = read_drive(tmp_path / "out" / "drive.parquet")
    for name in ("psi", "omega_z", "a_y_imu"):
        assert np.allclose(drive[name], clean[name][: len(drive)], atol=1e-6), name


def test_a_vehicle_of_which_little_is_known_yet_brings_a_log_in(clean, tmp_path):
    """Known numbers, before there is a vehicle file: the wheels' radius and the axles are taken from them."""
    known = "mass = 1378.0\nl_f = 1.546\nl_r = 1.175\ntrack = 1.19\nradius = 0.330\nwidth = 0.21\n"
    path, file = tmp_path / "log.csv", tmp_path / "known.toml"
    path.write_text(pd.DataFrame({name: clean[name] for name in clean.channels}).to_csv(index=False), encoding="utf-8")
    for radius in (0.330, 0.250):
        file.write_text(known.replace("radius = 0.330", f"radius = {radius}"), encoding="utf-8")
        done = CliRunner().invoke(app, ["import", str(path), "--vehicle", str(file), "--out", str(tmp_path / "out")])
        assert ("contradict" in done.output or "warning" in done.output) == (radius < 0.3), done.output
        assert "since --vehicle names none" not in done.output
    about = json.loads((tmp_path / "out" / "import.json").read_text(encoding="utf-8"))["vehicle"]
    assert about["file"] == str(file) and about["name"] == "known"
    file.write_text(known.replace("mass = 1378.0\n", ""), encoding="utf-8")
    refused = CliRunner().invoke(app, ["import", str(path), "--vehicle", str(file), "--out", str(tmp_path / "out")])
    assert refused.exit_code != 0 and "mass" in refused.output


@pytest.mark.parametrize("mounted", [False, True])
def test_odometry_of_the_rear_axle_shifts_no_steering_clock(mounted, clean, tmp_path):
    """Positions and velocities of the rear axle, which nothing declares: their v makes the steering seem early."""
    axles, psi = reference_vehicle(), np.unwrap(clean["psi"])
    x, y = (clean[name] - axles.wheelbase * side for name, side in (("x", np.cos(psi)), ("y", np.sin(psi))))
    motion = {"x": x, "y": y, "psi": psi, "u": clean["u"], "v": clean["v"] - axles.l_r * clean["omega_z"]}
    odometry = {"t": clean.t, **motion, "omega_z": clean["omega_z"]}
    pd.DataFrame(odometry).to_csv(tmp_path / "odom.csv", index=False)
    pd.DataFrame({"t": clean.t, "steer": clean["steer"]}).to_csv(tmp_path / "can.csv", index=False)
    entries = "\n".join(f'{name} = "odom.csv:{name}"' for name in ("x", "y", "psi", "u", "v", "omega_z"))
    place = f'[mount."odom.csv"]\nx = {-axles.l_r}\n' if mounted else ""
    (tmp_path / "map.toml").write_text(f'[channels]\n{entries}\nsteer = "can.csv:steer"\n{place}', encoding="utf-8")
    sources = [str(tmp_path / name) for name in ("odom.csv", "can.csv")]
    options = ["--map", str(tmp_path / "map.toml"), "--align", "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(app, ["import", *sources, *options])
    assert "can.csv: clock shifted" not in done.output, done.output
    assert (done.exit_code == 0) == mounted  # positions and velocities that do not belong together are refused
    assert ("if the source is odometry of the rear axle (base_link)" in done.output) == (not mounted)


def test_what_is_shifted_with_a_late_channel_is_said_and_errors_name_the_file_that_holds_the_channel(clean, tmp_path):
    rows = np.clip(np.arange(len(clean)) - 25, 0, None)
    pd.DataFrame({n: clean[n] for n in ("t", "x", "y", "psi", "u", "v", "omega_z")}).to_csv(tmp_path / "ins.csv", index=False)
    bus = pd.DataFrame({"t": clean.t, "steer": clean["steer"][rows], **{n: clean[n] for n in WHEEL_CHANNELS}})
    bus.to_csv(tmp_path / "can.csv", index=False)
    of = {**dict.fromkeys(("x", "y", "psi", "u", "v", "omega_z"), "ins"), **dict.fromkeys(("steer", *WHEEL_CHANNELS), "can")}
    lines = {name: f'{name} = "{source}.csv:{name}"' for name, source in of.items()}

    def brought_in(entries):
        (tmp_path / "map.toml").write_text("[channels]\n" + "\n".join(entries.values()) + "\n", encoding="utf-8")
        files = [str(tmp_path / name) for name in ("ins.csv", "can.csv")]
        options = ["--map", str(tmp_path / "map.toml"), "--align", "--out", str(tmp_path / "out")]
        return CliRunner().invoke(app, ["import", *files, *options])

    said = brought_in(lines).output
    assert "can.csv: clock shifted by -0.3" in said
    assert "can.csv: shifted with it, not compared: omega_fl, omega_fr, omega_rl, omega_rr" in said and "put late = 0.3" in said
    turned = {"omega_fl": 'omega_fl = {source = "can.csv:omega_fl", sign = -1}'}
    refused = brought_in({**lines, **turned})
    assert refused.exit_code != 0 and "can.csv: omega_fl: expected" in f"{refused.output} {refused.exception}"


def test_an_import_leaves_outliers_out(clean, tmp_path):
    wrong = np.random.default_rng(3).random(len(clean)) < 0.02
    table = pd.DataFrame({name: clean[name] for name in clean.channels}).assign(omega_z=clean["omega_z"] + 2.0 * wrong)
    table.to_csv(tmp_path / "log.csv", index=False)
    done = CliRunner().invoke(app, ["import", str(tmp_path / "log.csv"), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0 and "left out: omega_z" in done.output, done.output
    assert np.nanmax(np.abs(read_drive(tmp_path / "out" / "drive.parquet")["omega_z"])) < 1.5
