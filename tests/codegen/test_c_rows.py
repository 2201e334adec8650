"""Rows in C from sensors of different rates, whose messages come late and out of order."""

import ctypes

import numpy as np
import pytest

from c_folders import library
from softsoil.codegen.c_library.binding import CFilter
from softsoil.codegen.c_library.horizon_binding import CHorizon
from softsoil.codegen.c_library.statuses import STATUSES
from softsoil.files.package_data import example_logs
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive

pytestmark = pytest.mark.compiler
SENSORS = (*STATE_CHANNELS, "steer", "a_x_imu", *WHEEL_CHANNELS)
NAMES = [name for name, _ in STATUSES]
REAL = ctypes.c_double


class Rows:
    """softsoil_rows_t in memory of Python's."""

    def __init__(self, dt=0.012, delay=0.1):
        self.c = library("tracks").c
        self.c.softsoil_rows_size.restype = ctypes.c_size_t
        self.memory = ctypes.create_string_buffer(int(self.c.softsoil_rows_size()))
        self.counts = np.frombuffer(self.memory, np.uint32)[1 : 2 * len(SENSORS) + 2]
        assert self.c.softsoil_rows_init(self.memory, REAL(dt), REAL(delay)) == 0

    def put(self, name, t, value):
        return NAMES[self.c.softsoil_rows_put(self.memory, SENSORS.index(name), REAL(t), REAL(value))]

    def next(self, now, filter_=None):
        t, u, y = REAL(), (REAL * 7)(), (REAL * 6)()
        state = None if filter_ is None else ctypes.byref(filter_.state)
        there = self.c.softsoil_rows_next(self.memory, REAL(now), state, ctypes.byref(t), u, y)
        return (t.value, np.array(u), np.array(y)) if there else None

    def all(self, now):
        rows = []
        while (row := self.next(now)) is not None:
            rows.append(row)
        return rows

    def around(self, t):
        y = (REAL * 6)()
        return self.c.softsoil_rows_around(self.memory, REAL(t), y), np.array(y)

    def late(self, name):
        return int(self.counts[SENSORS.index(name)])

    def refused(self, name):
        return int(self.counts[len(SENSORS) + SENSORS.index(name)])

    @property
    def restarts(self):
        return int(self.counts[-1])


def test_inputs_lie_on_lines_and_a_measurement_is_in_one_row():
    rows = Rows()
    for t in np.arange(0.0, 1.0, 0.05):
        rows.put("steer", t, 0.2 * t)
        rows.put("omega_rr", t, 3.0 + t)
    for t in np.arange(0.003, 1.0, 0.1):
        rows.put("x", t, 5.0 * t)
        rows.put("psi", t, (3.1 + t + np.pi) % (2 * np.pi) - np.pi)
        rows.put("omega_z", t, 1.0)
        rows.put("v", t, 0.3)
        rows.put("a_x_imu", t, 0.5)
    made = rows.all(0.9)
    t, u, y = (np.array(column) for column in zip(*made, strict=True))
    assert t == pytest.approx(np.arange(len(t)) * 0.012) and t[-1] <= 0.8 < t[-1] + 0.012
    assert u[:, 0] == pytest.approx(0.2 * t) and u[2:, 1] == pytest.approx(0.2) and u[:, 6] == pytest.approx(3.0 + t)
    assert u[1:, 2] == pytest.approx(0.8), "du/dt is what the accelerometer reads plus v omega_z"
    assert np.isnan(u[:, 3]).all(), "a wheel that nobody measures"
    seen = np.isfinite(y[:, 0])
    assert seen.sum() == 8 and y[seen, 0][1:] == pytest.approx(5.0 * t[seen][1:], abs=1e-9)
    assert y[0, 0] == pytest.approx(0.015), "nothing before it: as it was measured"
    assert np.angle(np.exp(1j * (y[seen, 2] - 3.1 - t[seen])))[1:] == pytest.approx(np.zeros(7), abs=1e-9)
    assert np.isnan(y[:, 1]).all()


def test_what_comes_out_of_order_is_sorted_and_what_comes_too_late_counted():
    rng, rows, sorted_ = np.random.default_rng(3), Rows(delay=0.1), Rows(delay=0.1)
    stamps = np.arange(0.0, 2.0, 0.02)
    arrival = stamps + rng.uniform(0.0, 0.06, len(stamps))
    made = []
    for k in np.argsort(arrival):
        made += rows.all(arrival[k])
        assert rows.put("steer", stamps[k], np.sin(stamps[k])) == "OK"
    for t in stamps:
        sorted_.put("steer", t, np.sin(t))
    wanted = sorted_.all(arrival.max())
    assert len(made) > 150 and rows.late("steer") == 0
    for one, other in zip(made, wanted, strict=False):
        assert one[0] == other[0] and one[1][:2] == pytest.approx(other[1][:2], nan_ok=True)
    assert rows.put("steer", made[-1][0] - 0.05, 0.0) == "MEASUREMENT_LATE" and rows.late("steer") == 1
    assert rows.put("steer", 0.0, 0.0) == "MEASUREMENT_LATE"
    assert rows.put("steer", np.nan, 0.0) == rows.put("steer", 2.0, np.inf) == "MEASUREMENT_NOT_FINITE"
    assert rows.put("steer", 1e4, 0.0) == "MEASUREMENT_NOT_FINITE" and rows.refused("steer") == 3


def test_a_dead_sensor_is_held_for_a_quarter_of_a_second():
    rows = Rows(delay=0.05)
    for t in np.arange(0.0, 2.0, 0.02):
        rows.put("u", t, 4.0)
        if t < 1.0:
            rows.put("steer", t, 0.1)
    steer = {t: u[0] for t, u, _ in rows.all(1.9)}
    held = [t for t, value in steer.items() if np.isfinite(value)]
    assert max(held) == pytest.approx(0.98 + 0.25, abs=0.012) and {steer[t] for t in held} == {0.1}


def test_without_an_accelerometer_it_is_the_slope_of_the_speed():
    rows = Rows(delay=0.1)
    for t in np.arange(0.0, 2.0, 0.05):
        rows.put("u", t, 3.0 + 0.7 * t)
    a_x = np.array([u[2] for _, u, _ in rows.all(1.8)])
    assert a_x[10:] == pytest.approx(0.7)


def test_a_clock_that_is_set_back_and_a_pause_begin_anew():
    rows = Rows()
    for t in (100.0, 100.02, 100.04):
        rows.put("u", t, 4.0)
    assert rows.all(100.13)
    assert rows.next(50.0) is None and rows.restarts == 1
    for t in (50.0, 50.02, 50.04):
        assert rows.put("u", t, 5.0) == "OK"
    assert [row[2][3] for row in rows.all(50.13)][:1] == [5.0]
    assert rows.next(500.0) is None and rows.restarts == 2
    rows.put("u", 500.0, 5.0)
    assert rows.next(500.2)[0] == 500.0


def test_a_first_state_is_made_of_what_was_measured_around():
    rows = Rows()
    for t in np.arange(0.0, 1.0, 0.1):
        for name, value in (("x", 5.0 * t), ("y", 0.0), ("u", 5.0)):
            rows.put(name, t + 0.01 * SENSORS.index(name), value)
    count, y = rows.around(0.5)
    assert count == 3 and np.isfinite(y).tolist() == [True, True, False, True, False, False]
    assert y[0] == pytest.approx(2.5)
    assert rows.around(3.0)[0] == 0


def test_arguments_out_of_range_are_refused():
    rows = Rows()
    for dt, delay in ((0.0, 0.1), (0.2, 0.1), (0.012, -0.1), (0.012, 2.0), (np.nan, 0.1)):
        assert NAMES[rows.c.softsoil_rows_init(rows.memory, REAL(dt), REAL(delay))] == "BAD_ARGUMENT"
    assert NAMES[rows.c.softsoil_rows_put(rows.memory, 12, REAL(0.0), REAL(0.0))] == "BAD_ARGUMENT"
    assert rows.c.softsoil_rows_init(None, REAL(0.01), REAL(0.1)) and rows.next(np.nan) is None


RATES = {"x": 10, "y": 10, "psi": 20, "u": 20, "v": 20, "omega_z": 80, "a_x_imu": 80, "steer": 40}
RATES |= dict.fromkeys(WHEEL_CHANNELS, 40)
"""Hz, of a robot's sensors."""


def messages(drive):
    """(arrival, stamp, sensor, value) of the sensors at their rates, each 5 to 60 ms late, by arrival."""
    rng, found = np.random.default_rng(7), []
    for name, rate in RATES.items():
        stamps = np.arange(drive.t[0] + rng.uniform(0.0, 1.0 / rate), drive.t[-1], 1.0 / rate)
        values = np.interp(stamps, drive.t, np.unwrap(drive[name]) if name == "psi" else drive[name])
        found += [(t + rng.uniform(0.005, 0.06), t, name, value) for t, value in zip(stamps, values, strict=True)]
    return sorted(found)


@pytest.mark.slow
@pytest.mark.parametrize("log", example_logs()[:2], ids=lambda path: path.name.split(".")[0])
def test_a_robots_messages_give_the_n_of_the_drive(log):
    drive = add_noise(read_drive(log), "good", 4)
    drive = drive.between(drive.t[0] + 2.0, drive.t[-1])
    n = float(log.name.split("_n")[1][:4])
    rows, own, held, horizon = Rows(delay=0.12), None, None, CHorizon(library("tracks"))
    horizon.options.dt, horizon.options.start_up, horizon.options.look = 0.012, 0.0, 0  # of the rows and the horizon alone
    for arrival, stamp, name, value in messages(drive):
        while (row := rows.next(arrival, own)) is not None:
            t, u, y = row
            if own is None:
                count, first = rows.around(t)
                if count < 6:
                    continue
                horizon.start(t)
                own = CFilter(library("tracks"), [*first, 0.7], [1.0, 1.0, 0.1, 1.0, 0.5, 0.2, 0.2], t=t)
            else:
                own.predict(held, t - own.state.t)
                own.update(y, t)
            held = u
            horizon.push(u, y, t)
            horizon.update()
        assert rows.put(name, stamp, value) in ("OK", "MEASUREMENT_LATE")
    assert own is not None and sum(rows.late(name) for name in SENSORS) < 5
    assert own.x[6] == pytest.approx(n, rel=0.1)
    assert horizon.verdict == "identified" and horizon.n[0] == pytest.approx(n, rel=0.06)


def test_fast_sensors_and_a_long_delay_fit():
    """200 Hz and 0.8 s: samples that rows still needed were thrown away, and every row was NaN."""
    rows, made = Rows(delay=0.8), []
    for k in range(600):
        t = 0.005 * k
        for name in ("steer", "omega_z", "a_x_imu", "omega_fl", "v", "u"):
            rows.put(name, t, np.sin(t))
        made += rows.all(t) if k % 2 == 0 else []
    at, inputs, seen = (np.array(column)[50:] for column in zip(*made, strict=True))
    assert len(at) > 100 and sum(rows.late(name) for name in SENSORS) == 0
    np.testing.assert_allclose(inputs[:, 0], np.sin(at), atol=1e-4)
    there = np.isfinite(seen[:, 5])
    assert there.mean() > 0.5  # samples thinned to 67 Hz, rows at 83 Hz
    np.testing.assert_allclose(seen[there, 5], np.sin(at[there]), atol=1e-4)


def test_a_first_stamp_of_another_clock_does_not_block_the_rows():
    rows, made = Rows(delay=0.1), []
    rows.put("x", 1.7e9, 1.0)
    for k in range(300):
        rows.put("steer", 0.01 * k, 0.1)
        rows.put("u", 0.01 * k, 5.0)
        made += rows.all(0.01 * k)
    assert len(made) > 200 and rows.restarts == 1


def test_the_slope_of_the_speed_stands_for_an_accelerometer_that_fell_silent():
    rows, made = Rows(delay=0.15), []
    for k in range(400):
        t = 0.01 * k
        for name, value in (("u", 3.0 + 0.7 * t), ("steer", 0.1), ("v", 0.0), ("omega_z", 0.0)):
            rows.put(name, t, value)
        if t < 1.0:
            rows.put("a_x_imu", t, 0.7)
        made += rows.all(t)
    late = np.array([inputs[2] for at, inputs, _ in made if at > 0.5])
    np.testing.assert_allclose(late, 0.7, atol=1e-6)
