"""Names of columns as loggers write them: units in brackets, axes of sensors, what is asked for, sideways accelerations."""

import tomllib

import numpy as np
import pandas as pd
import pytest

from softsoil.importing.draft_map import draft
from softsoil.importing.hanging import hangs
from softsoil.importing.loose_table import inspect_table, open_table, read_columns
from softsoil.importing.sources import Holding, Spread
from softsoil.recording.table import read_table


def holding(**fields):
    spreads = {name: Spread(low, high, True) for name, (low, high) in fields.items()}
    return Holding("log.csv", "table", "log.csv", 500, 50.0, 0.0, 10.0, "t", spreads)


def drafted(**fields):
    return tomllib.loads(draft([holding(**fields)]))["channels"]


def written(tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_separator_at_the_end_of_rows_shifts_no_column(tmp_path):
    rows = "".join(f"{0.1 * k:.1f},{k},{10 * k},\n" for k in range(20))
    path = written(tmp_path, "t,u,v\n" + rows)
    series = read_columns(path, ["u", "v"])
    assert np.allclose(series.t, 0.1 * np.arange(20)) and list(series.values["u"]) == list(range(20))
    assert list(read_table(path)["v"]) == [10 * k for k in range(20)]


@pytest.mark.parametrize("read", [read_table, open_table])
def test_rows_with_more_cells_than_names_are_refused(read, tmp_path):
    path = written(tmp_path, "t,u,v\n" + "".join(f"{0.1 * k:.1f},{k},{10 * k},7\n" for k in range(20)))
    with pytest.raises(ValueError, match=r"log.csv: .* rows have more cells than there are names of columns"):
        read(path)


def test_brackets_that_tell_columns_from_each_other_stay(tmp_path):
    values = np.arange(20.0)
    names = ("velocity[front_left]", "velocity[front_right]", "speed (m/s)", "speed (km/h)", "yaw rate [deg/s]")
    path = tmp_path / "log.csv"
    pd.DataFrame({"t [s]": 0.1 * values, **{name: values + i for i, name in enumerate(names)}}).to_csv(path, index=False)
    (found,) = inspect_table(path)
    assert set(found.fields) == {*names[:4], "yaw rate"}
    assert [found.fields[name].unit for name in (*names[:4], "yaw rate")] == ["", "", "m/s", "km/h", "deg/s"]
    assert read_columns(path, ["velocity[front_right]"]).values["velocity[front_right]"][0] == 1.0


def test_an_axis_of_a_gyro_is_no_position():
    fields = {"gyro_x_dps": (-9.0, 9.0), "gyr_y": (-0.2, 0.2), "gyro_z_dps": (-30.0, 30.0), "imu_x_degs": (-3.0, 3.0)}
    fields |= {"latitude": (48.1, 48.2), "longitude": (11.5, 11.6)}
    found = drafted(**fields)
    assert found["x"] == "log.csv:east" and found["y"] == "log.csv:north"
    assert found["omega_z"]["source"] == "log.csv:gyro_z_dps"
    assert drafted(utm_x=(1.0, 90.0), local_y=(2.0, 50.0)) == {"x": "log.csv:utm_x", "y": "log.csv:local_y"}


def test_what_is_measured_comes_before_what_was_asked_for():
    fields = {"steer_cmd": 0.5, "steering_angle": 0.4, "speed_setpoint": 6.0, "vehicle_speed": 5.0}
    found = draft([holding(**{name: (-size, size) for name, size in fields.items()})])
    channels = tomllib.loads(found)["channels"]
    assert channels["steer"] == "log.csv:steering_angle" and channels["u"] == "log.csv:vehicle_speed"
    assert '# steer_command = "log.csv:steer_cmd"' in found
    assert drafted(steer_command=(-0.5, 0.5))["steer"] == "log.csv:steer_command"


def test_lateral_and_longitudinal_accelerations_are_no_place():
    found = drafted(a_lat=(-4.0, 4.0), a_lon=(-2.0, 2.0), heading=(0.0, 359.0), speed=(0.0, 6.0))
    assert "x" not in found and "compass" not in found["psi"]
    assert found["a_y_imu"] == "log.csv:a_lat" and found["a_x_imu"] == "log.csv:a_lon"
    both = drafted(a_lat=(-4.0, 4.0), a_lon=(-2.0, 2.0), gps_lat=(48.1, 48.2), gps_lon=(11.5, 11.6))
    assert both["x"] == "log.csv:east"


@pytest.mark.parametrize("name", ["acc_z_g", "acc_z", "accel_z_g", "a_z_imu", "linear_acceleration_z", "imu.acc_z_mps2"])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_gravity_is_found_under_any_name_and_beside_a_jolt(name, side):
    """-1 g of a sensor with z down, with one jolt of 9 g."""
    size = 9.81 if name.endswith("mps2") else 1.0
    values = size * side * np.r_[np.full(400, 1.0), -9.0, np.full(99, 1.02)]
    found = Holding("imu.csv", "table", "imu.csv", 500, 50.0, 0.0, 10.0, "t", {name: Spread.of(values)})
    assert hangs(found) == (side < 0)


@pytest.mark.parametrize("name", ["integrated_x", "calibrated_pos_x", "controller_x", "travel_x"])
def test_words_inside_others_say_nothing(name):
    assert drafted(**{name: (0.0, 90.0)}) == {"x": f"log.csv:{name}"}


def test_a_rate_in_degrees_is_one_per_second():
    assert drafted(yaw_rate_deg=(-40.0, 40.0))["omega_z"] == {"source": "log.csv:yaw_rate_deg", "unit": "deg/s"}
