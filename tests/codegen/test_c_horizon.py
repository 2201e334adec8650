"""The moving horizon in C: the same numbers as the Python class, defined answers to whatever a sensor sends, and its verdict."""

from dataclasses import replace

import numpy as np
import pytest

from c_folders import SCALAR, declared, library
from softsoil.codegen.c_library.binding import CFilter, CLibrary
from softsoil.codegen.c_library.build import FLAGS
from softsoil.codegen.c_library.folder import write_library
from softsoil.codegen.c_library.horizon_binding import CHorizon
from softsoil.control.c_estimator import c_library_texts, c_parts
from softsoil.estimator.inertia import inertia_error
from softsoil.estimator.late_change import parts_of
from softsoil.estimator.moving_horizon import LEAST_NOISE, HorizonRules, MovingHorizon, drive_windows, exponents
from softsoil.estimator.soil_error import soil_error
from softsoil.files.package_data import example_logs
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.drive import STATE_CHANNELS, Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.recording.states import sensor_std
from softsoil.windows.inputs import measured_inputs
from softsoil.windows.parameters import Free
from softsoil.windows.shooting import shooting_drive

pytestmark = pytest.mark.compiler
START = 2.0
N_0 = 0.7


def spoiled(recording, seed=1):
    """Dropouts of 0.02 to 1.5 s and outliers of metres in every measured state."""
    rng = np.random.default_rng(seed)
    channels = {name: values.copy() for name, values in recording.channels.items()}
    for name in STATE_CHANNELS:
        for _ in range(4):
            first = rng.integers(300, len(recording) - 300)
            channels[name][first : first + rng.integers(2, 150)] = np.nan
        channels[name][rng.integers(300, len(recording) - 300, size=5)] += 3.0 * rng.normal(size=5)
    return replace(recording, channels=channels)


def jerked(recording):
    """A steering that jumps and comes back, as no actuator does: windows leave gaps there."""
    steer = recording["steer"].copy()
    for second in (6.0, 9.4, 12.9, 16.1):
        steer[(recording.t > second) & (recording.t < second + 0.3)] += 0.1
    return recording.with_channels(steer=steer)


def both(recording, model, free, c):
    """Estimates of Python and C after every window: n and its standard deviation (K, A), and both horizons."""
    windows = drive_windows(recording, model, START, HorizonRules())
    python, drive, rows = MovingHorizon(windows, free, N_0, HorizonRules()), windows.drive, []
    c.options.dt, c.options.start_up = drive.dt, START
    c.options.r_std[:] = sensor_std(recording, LEAST_NOISE)
    for k, name in enumerate(c.names):
        c.options.guess[k] = N_0 if name in ("n", "n_f", "n_r") else c.options.guess[k]
    c.start(drive.t[0])
    for t, u, y in zip(drive.t, drive.inputs, drive.measured, strict=True):
        c.push(u, y, t)
        if c.update():
            more = np.maximum(np.square(c.head.law_std) - np.square(HorizonRules().common_error * c.n), 0.0)
            rows.append((*python.update(len(rows)), c.n, np.sqrt(c.std**2 - more)))  # Python asks for the law's error at the end
    assert len(windows.rows) - len(rows) <= 1
    return [np.array(column) for column in zip(*rows, strict=True)], c, python


@pytest.mark.slow
@pytest.mark.parametrize("log", example_logs()[:3], ids=lambda path: path.name.split(".")[0])
@pytest.mark.parametrize("damage", (None, spoiled, jerked), ids=("whole", "spoiled", "jerked"))
def test_the_same_numbers_as_in_python_on_example_logs(log, damage):
    recording = add_noise(read_drive(log), "table5", 2)
    model, c = declared("tracks").build(), CHorizon(library("tracks", FLAGS))
    (n, std, c_n, c_std), c, python = both(recording if damage is None else damage(recording), model, exponents(True), c)
    assert np.abs(n - c_n).max() < 1e-7
    assert np.abs(std - c_std).max() < 1e-7
    assert c.head.changes == len(python.changes)
    parts, sigmas = parts_of(python.summary, python.since, python.share, len(n) - 1)
    assert np.array(c.head.parts) == pytest.approx(parts, abs=1e-5) and c.head.parts_sigmas == pytest.approx(sigmas, rel=1e-3)
    share, share_std = inertia_error(python.windows, python)  # linearises every window again at the end, C does not
    assert c.head.inertia == pytest.approx(share, abs=max(0.005, 2.0 * share_std))
    assert c.head.inertia_std == pytest.approx(share_std, rel=0.3)
    assert c.head.law_std[0] == pytest.approx(soil_error(python.windows, python).law_std * python.n[0], rel=0.2)


@pytest.mark.parametrize(
    "flags", (pytest.param(SCALAR, id="scalar"), pytest.param(FLAGS, id="lanes", marks=pytest.mark.study))
)
def test_the_same_numbers_with_one_n_for_each_axle(flags):
    recording = add_noise(read_drive(example_logs()[0]), "table5", 2)
    c = CHorizon(library("plain", flags))
    (n, std, c_n, c_std), c, _ = both(recording.between(0.0, 15.0), declared("plain").build(), exponents(False), c)
    assert len(c.names) == 2
    assert np.abs(n - c_n).max() < 2e-6  # two numbers, one of them hardly determined
    assert np.abs(std - c_std).max() < 2e-6


@pytest.mark.study
def test_forces_that_build_up_run_from_window_to_window_as_in_python(tmp_path):
    """No sensor measures them: a window that began without them would take 0.3 m to have its side force."""
    vehicle = declared("tracks").vehicle
    vehicle = vehicle.with_(effects={**vehicle.effects, "relaxation": {"relaxation_length": 0.3}})
    own = replace(declared("tracks"), vehicle=vehicle)
    write_library(tmp_path, c_library_texts(own))
    recording = add_noise(read_drive(example_logs()[0]), "table5", 2).between(0.0, 15.0)
    (n, std, c_n, c_std), _, _ = both(recording, own.build(), exponents(True), CHorizon(CLibrary(tmp_path, SCALAR)))
    assert np.abs(n - c_n).max() < 1e-7
    assert np.abs(std - c_std).max() < 1e-7


@pytest.mark.study
@pytest.mark.slow
def test_the_same_numbers_with_four_parameters(tmp_path):
    """n and three parameters of effects, each with its own prior."""
    more = tuple(declared("tracks").build().p.names[-3:])
    write_library(tmp_path, c_library_texts(declared("tracks"), promote=more))
    c, states = CHorizon(CLibrary(tmp_path, SCALAR)), c_parts(declared("tracks"), more).model.x
    assert c.names == ["n", *more]
    free = [*exponents(True)]
    for k, name in enumerate(more, start=1):
        s, known = states[name], (c.options.guess[k], c.options.guess_std[k])
        free.append(Free(name, (name,), (s.upper - s.lower) / 10, s.lower, s.upper, known=known))
    recording = add_noise(read_drive(example_logs()[0]), "table5", 2).between(0.0, 20.0)
    (n, std, c_n, c_std), _, _ = both(recording, declared("tracks").build(), free, c)
    scale = np.array([f.scale for f in free])
    assert np.abs((n - c_n) / scale).max() < 1e-5
    assert np.abs((std - c_std) / scale).max() < 1e-5


def test_a_filter_far_off_is_corrected(drive):
    c = ran(drive)
    own = CFilter(library("tracks", FLAGS))
    own.state.x[6], before = 1.2, np.array(own.P)
    assert c.correct(own)
    assert own.x[6] == c.n[0] and own.std[6] == c.std[0]
    after = own.P
    common = own.state.options.common_error * c.n[0]  # which the filter adds to its root's at every step
    assert common > 0.01 and np.hypot(np.sqrt(after[6, 6]), common) == pytest.approx(c.std[0], rel=1e-6)
    assert np.allclose(after, after.T) and np.linalg.eigvalsh(after).min() > 0
    assert np.allclose(after[:6, :6], before[:6, :6])
    assert not c.correct(own)  # agreement corrects nothing
    c.head.verdict = c.words.index("not_excited")
    own.state.x[6] = 1.2
    assert not c.correct(own)


def driven(seconds=20.0, **more):
    """A noisy drive of the two-track model itself on its own soil."""
    own = declared("tracks")
    return add_noise(synthetic_drive(own.build(), own.vehicle.radius, seconds=seconds, **more), "good", 3)


def ran(recording, change=None):
    """A C horizon after a drive; change(k, u, y, t) -> (u, y, t) or None for a sample that never came."""
    drive = shooting_drive(recording, declared("tracks").build(), 1.0)
    c = CHorizon(library("tracks", FLAGS))
    c.options.dt, c.options.start_up, c.options.look = drive.dt, 1.0, 0  # of the horizon alone
    c.options.r_std[:] = sensor_std(recording, LEAST_NOISE)
    c.options.guess[:] = [N_0]
    c.start(drive.t[0])
    for k, (t, u, y) in enumerate(zip(drive.t, drive.inputs, drive.measured, strict=True)):
        sample = (u, y, t) if change is None else change(k, u.copy(), y.copy(), t)
        if sample is not None:
            c.push(*sample)
            c.update()
        assert np.isfinite([*c.n, *c.std, c.head.t, c.head.cost, c.head.motion]).all()
    return c


@pytest.fixture(scope="module")
def drive():
    return driven()


def test_an_exciting_drive_is_identified_and_its_n_is_right(drive):
    c = ran(drive)
    assert c.verdict == "identified"
    assert c.n[0] == pytest.approx(declared("tracks").soil.n, abs=3 * c.std[0])


@pytest.mark.parametrize(("factor", "asked"), ((1.4, -0.29), (0.65, 0.54)))
def test_a_vehicle_of_another_yaw_inertia_is_not_identified(factor, asked):
    own = declared("tracks")
    other = replace(own.vehicle, yaw_inertia=own.vehicle.yaw_inertia / factor)
    log = synthetic_drive(replace(own, vehicle=other).build(), other.radius, seconds=20.0)
    head = (c := ran(add_noise(log, "good", 3))).head
    assert c.verdict == "inconsistent"
    assert 0.5 < head.inertia / asked < 1.3 and abs(head.inertia) > 3.0 * head.inertia_std  # one step, not the minimum


def test_the_declared_yaw_inertia_is_not_doubted(drive):
    head = ran(drive).head
    assert abs(head.inertia) < max(0.03, 2.0 * head.inertia_std)


def test_a_vehicle_that_stands_identifies_nothing(drive):
    def still(k, u, y, t):
        y[:] = [1.0, 2.0, 0.3, 0.0, 0.0, 0.0]
        return 0.0 * u, y, t

    c = ran(drive, still)
    assert c.verdict == "not_excited"
    assert c.n[0] == N_0
    assert c.counts["STANDSTILL"] > 1000
    assert c.head.windows == 0


def test_reversing_is_said_and_its_windows_are_left_out(drive):
    def back(k, u, y, t):
        y[3] = -2.0
        return u, y, t

    c = ran(drive, back)
    assert c.counts["NEGATIVE_SPEED"] > 1000
    assert c.head.windows == 0


@pytest.mark.parametrize("absent", (["v"], ["x", "y"], ["psi"], ["u"]), ids=",".join)
def test_channels_that_are_absent_leave_a_finite_answer(drive, absent):
    columns = [STATE_CHANNELS.index(name) for name in absent]

    def without(k, u, y, t):
        y[columns] = np.nan
        return u, y, t

    c = ran(drive, without)
    assert c.head.windows > 30
    assert c.verdict != "identified" or c.n[0] == pytest.approx(declared("tracks").soil.n, rel=0.1)


def test_samples_that_never_come_start_windows_anew(drive):
    c = ran(drive, lambda k, u, y, t: None if 400 < k < 600 or k % 50 == 0 else (u, y, t))
    assert c.verdict == "identified"
    assert c.n[0] == pytest.approx(declared("tracks").soil.n, abs=4 * c.std[0])


@pytest.mark.parametrize("first", (700, 1130))
def test_no_window_runs_across_samples_that_never_came(drive, first):
    """0.8 s of them, in which it steered on: inputs that are held so long are not the drive's, and said its mass had changed."""
    whole, c = ran(drive).head, ran(drive, lambda k, u, y, t: None if first <= k < first + 80 else (u, y, t))
    assert c.verdict == "identified"
    assert c.n[0] == pytest.approx(declared("tracks").soil.n, abs=3 * c.std[0])
    assert whole.windows - 4 <= c.head.windows < whole.windows
    assert c.head.unexplained[1] < whole.unexplained[1] + 0.01


def test_absurd_samples_and_times_are_named(drive):
    rng = np.random.default_rng(5)

    def absurd(k, u, y, t):
        if k % 7 == 0:
            y[rng.integers(6)] = rng.choice([np.nan, np.inf, 1e300, -1e9, 5e-324])
        if k % 11 == 0:
            u[rng.integers(len(u))] = rng.choice([np.nan, -np.inf, 1e300])
        if k % 101 == 0:
            t = rng.choice([np.nan, np.inf, t - 1.0])
        return u, y, t

    counts = ran(drive, absurd).counts
    for name in (
        "MEASUREMENT_NOT_FINITE",
        "MEASUREMENT_OUT_OF_RANGE",
        "INPUT_NOT_FINITE",
        "TIME_NOT_FINITE",
        "MEASUREMENT_LATE",
    ):
        assert counts[name] > 0


def test_options_out_of_range_are_refused():
    c = CHorizon(library("tracks", FLAGS))
    for name, value in (("dt", 1e-4), ("dt", 1.0), ("start_up", -1.0)):
        kept = getattr(c.options, name)
        setattr(c.options, name, value)
        with pytest.raises(ValueError, match="out of its range"):
            c.start(0.0)
        setattr(c.options, name, kept)
    c.options.guess[0] = 3.0
    with pytest.raises(ValueError, match="out of its range"):
        c.start(0.0)


def along(recording, c, silent=()):
    """The horizon in C after the samples of a drive as they are, steering missing within `silent` (s)."""
    model, names = declared("tracks").build(), STATE_CHANNELS
    inputs, _ = measured_inputs(recording, model.external)
    c.options.dt, c.options.start_up = recording.dt, START
    c.options.r_std[:] = sensor_std(recording, LEAST_NOISE)
    c.options.guess[0] = N_0
    c.start(recording.t[0])
    steer = model.external.names.index("steer")
    for k, t in enumerate(recording.t):
        u = inputs[k].copy()
        if silent and silent[0] < t - recording.t[0] < silent[1]:
            u[steer] = np.nan
        c.push(u, np.array([recording[name][k] for name in names]), t)
        c.update()
    return float(c.n[0]), int(c.head.windows)


@pytest.mark.slow
def test_at_40_hertz_the_inputs_do_not_lag():
    """Inputs held from row to row make n 1.5 % lower there."""
    drive = read_drive(example_logs()[2])  # whose steering is the fastest
    t = np.arange(drive.t[0], drive.t[-1], 0.025)
    values = {k: t if k == "t" else np.interp(t, drive.t, np.unwrap(v) if k == "psi" else v) for k, v in drive.channels.items()}
    c = CHorizon(library("tracks", FLAGS))
    fast, _ = along(drive, c)
    slow, _ = along(Recording("slow", values), c)
    assert slow == pytest.approx(fast, rel=0.007)


@pytest.mark.slow
def test_no_window_runs_where_an_input_is_missing():
    drive, c = read_drive(example_logs()[1]), CHorizon(library("tracks", FLAGS))
    whole, windows = along(drive, c)
    holed, fewer = along(drive, c, silent=(15.0, 17.0))
    assert 3 <= windows - fewer <= 8
    assert holed == pytest.approx(whole, rel=0.01)
