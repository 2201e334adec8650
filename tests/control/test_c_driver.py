"""The generated driver: the same commands as Python's on the same measurements, and what it promises."""

import ctypes
import importlib.util
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from benchmarks.judges import c_library as judge
from drives import PROJECT, reference_vehicle
from softsoil.codegen.c_library.folder import write_library
from softsoil.control.c_folder import controller_texts
from softsoil.control.c_statuses import STATUSES
from softsoil.control.courses import double_lane_change
from softsoil.control.driver import Driver
from softsoil.control.driver_binding import CDriver
from softsoil.control.driver_types import DriverSettings
from softsoil.control.live_estimator import LiveEstimator
from softsoil.control.nmpc import Nmpc
from softsoil.control.nmpc_status import Status
from softsoil.control.ocp import Ocp, OcpSettings
from softsoil.declaration.model_file import Declaration
from softsoil.estimator.tuning import Tuning
from softsoil.symbolic.soil import CLAY

pytestmark = [pytest.mark.compiler, pytest.mark.slow]
SENSORS = DriverSettings(sensor_std=(0.05, 0.05, 0.003, 0.05, 0.05, 0.005))
DECLARED = Declaration(reference_vehicle().with_(radius=0.45, radius_rear=0.48), CLAY, "hard_ground")
"""Wheels like those of the vehicle that is driven, or their slip is none; the rear ones are larger, as both have to know."""
OBSTACLES = np.array([[62.0, 1.6, 1.0, 0.0, 0.0], [92.0, 2.4, 1.0, -0.1, 0.0]])
TICK, SPEED, N0 = SENSORS.tick, 6.0, 0.7
STRICT = ["gcc", "-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-Wconversion", "-Wpedantic"]
BYTES = """
#include <stdint.h>
#include <stdio.h>
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int main(void) {
  static uint8_t bytes[4000];
  uint32_t state = 12345u;
  for (int run = 0; run < 12; ++run) {
    for (unsigned i = 0; i < sizeof bytes; ++i) bytes[i] = (uint8_t)((state = state * 1664525u + 1013904223u) >> 24);
    if (LLVMFuzzerTestOneInput(bytes, sizeof bytes)) return 1;
  }
  return puts("nothing broke") < 0;
}
"""
COMPARED = (
    "steer", "steer_rate", "speed", "a_x", "a_asked", "n", "n_std", "n_used", "slip", "along", "left", "lost", "halt", "finished",
    "stopped", "solved", "position_std", "dead_reckoned", "actuator_lag",
)  # fmt: skip


@lru_cache(maxsize=1)
def problem() -> Ocp:
    """The reference vehicle on hard ground, whose equations compile quickly, with its effects and histories."""
    return Ocp(DECLARED.build(), DECLARED.vehicle)


@lru_cache(maxsize=1)
def in_c() -> CDriver:
    return CDriver(controller_texts(DECLARED, driver=SENSORS), len(problem().z))


@lru_cache(maxsize=1)
def parts() -> tuple[Nmpc, LiveEstimator]:
    return Nmpc(problem()), LiveEstimator(problem().model, SENSORS.sensor_std)


def in_python(**more) -> Driver:
    solver, estimator = parts()
    given = {"obstacles": OBSTACLES, "n0": N0, "settings": SENSORS, "solver": solver, "estimator": estimator, **more}
    return Driver(problem(), double_lane_change(), SPEED, **given)


def started(**more) -> CDriver:
    given = {"obstacles": OBSTACLES, "n0": N0, **more}
    in_c().start(double_lane_change(), SPEED, **given)
    return in_c()


def strangers_vehicle():
    """The vehicle of examples/bring_your_own_vehicle.py, in a process of its own."""
    file = PROJECT / "examples" / "bring_your_own_vehicle.py"
    spec = importlib.util.spec_from_file_location("bring_your_own_vehicle", file)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    return example.LineVehicle([sys.executable, str(file), "vehicle"])


def driven(driver) -> np.ndarray:
    """(K, 4) x, y, psi, u of the stranger's vehicle, driven to the end of the course."""
    rows = []
    with strangers_vehicle() as vehicle:
        for k in range(3000):
            measured = vehicle.measure()
            command = driver.tick(k * TICK, measured)
            rows.append([measured[name] for name in ("x", "y", "psi", "u")])
            if command.finished:
                break
            vehicle.apply(command, TICK)
    return np.array(rows)


@pytest.mark.study
def test_a_strangers_vehicle_drives_the_same_path_by_python_and_by_c():
    """Filter, histories, solves and following of plans, from a first state that is measured: position to 1e-6 m."""
    one, other = driven(in_python()), driven(started())
    assert len(one) == len(other) and one[-1, 0] > 100.0
    np.testing.assert_allclose(other, one, atol=1e-6)


def faulty(k: int, measured: dict[str, float]) -> dict[str, float]:
    """Channels that are missing for a while, absurd once, or heading wrapped elsewhere."""
    lost = {"x", "y", "u"} if 200 < k < 260 else {"omega_fl"} if 300 < k < 330 else {"a_x_imu"} if 340 < k < 360 else set()
    out = {name: value for name, value in measured.items() if name not in lost}
    out["psi"] = measured["psi"] + 2 * np.pi * (k // 100)
    if k == 400:
        out["y"] += 30.0
    if k == 410:
        out["steer"] = 1e300
    return out


@pytest.mark.parametrize(("learn", "start"), ((True, None), (False, None), (True, [0.0, 0.0, 0.0, 5.5, 0.0, 0.0])))
def test_every_command_is_pythons(learn, start):
    """Tick by tick on the same measurements, dropouts and outliers among them; the first ones come without a speed."""
    one, other = in_python(learn=learn, start=start), started(learn=learn, start=start)
    with strangers_vehicle() as vehicle:
        for k in range(600):
            measured = faulty(k, vehicle.measure())
            if k < 5:
                del measured["u"]
            ours, theirs = other.tick(k * TICK, measured), one.tick(k * TICK, measured)
            for name in COMPARED:
                assert getattr(ours, name) == pytest.approx(float(getattr(theirs, name)), abs=1e-6, nan_ok=True), (k, name)
            if ours.started:
                np.testing.assert_allclose(ours.z, theirs.state, atol=1e-6)
            vehicle.apply(theirs, TICK)
    assert ours.solved == 0 and ours.started == 1 and ours.n_used <= ours.n + SENSORS.most


def test_a_stamp_far_ahead_does_not_stop_a_vehicle_for_good():
    """Every tick after it was refused. The drive begins anew with the clock that is set back, in both alike."""
    one, other = in_python(), started()
    with strangers_vehicle() as vehicle:
        for k in range(240):
            t, measured = k * TICK + (1e6 if k == 120 else 0.0), vehicle.measure()
            ours, theirs = other.tick(t, measured), one.tick(t, measured)
            for name in COMPARED:
                assert getattr(ours, name) == pytest.approx(float(getattr(theirs, name)), abs=1e-6, nan_ok=True), (k, name)
            vehicle.apply(theirs, TICK)
    assert ours.started and not ours.lost and ours.along > 5.0


def test_obstacles_go_on_where_the_clock_is_set_back():
    """One that drives ahead, at half the speed: taken back to where it was at first, it had both brake."""
    ahead = np.array([[40.0, 0.0, 1.0, 3.0, 0.0]])
    one, other = in_python(obstacles=ahead), started(obstacles=ahead)
    for k in range(580):
        t, x = k * TICK + (1000.0 if k < 500 else 994.0), 6.0 * k * TICK
        ours, theirs = other.tick(t, rolling(x)), one.tick(t, rolling(x))
        assert STATUSES[ours.status][0] == theirs.status.name, k
        assert not ours.halt and not theirs.halt, k
    assert ours.started and ours.speed == pytest.approx(theirs.speed, abs=1e-6) and theirs.speed > 5.0


@pytest.mark.study
def test_wheel_speeds_that_are_assumed_are_the_same_in_both():
    """Those of the front wheels follow from the steering angle now, in C from that of a step ago; on soil, where slip counts."""
    declared = Declaration(reference_vehicle(), CLAY)
    ocp = Ocp(declared.build(), declared.vehicle)
    one, other = Driver(ocp, double_lane_change(), SPEED, n0=N0), CDriver(controller_texts(declared), len(ocp.z))
    other.start(double_lane_change(), SPEED, n0=N0)
    for k in range(80):
        t = k * TICK
        measured = rolling(6.0 * t) | {"steer": 0.1 * np.sin(3.0 * t)}
        ours, theirs = other.tick(t, measured), one.tick(t, measured)
        np.testing.assert_allclose(list(ours.z), theirs.state, rtol=0.0, atol=1e-8)


def test_the_first_command_is_where_the_wheels_are():
    """Wheels at 0.3 rad were commanded to straight on at once, 25 rad/s."""
    one, other = in_python(obstacles=()), started(obstacles=np.zeros((0, 5)))
    for pause in (0.0, 60.0):
        at = pause, rolling(pause) | {"steer": 0.3}
        assert one.tick(*at).steer == pytest.approx(0.3)
        assert other.tick(*at).steer == pytest.approx(0.3)


class Sure:
    """A judge that is sure of its n after a second and a half."""

    n, n_std, verdict = 0.55, 0.02, "not_excited"

    def start(self, t, n0) -> None:
        self.verdict = "not_excited"

    def tick(self, t, inputs, y) -> None:
        self.verdict = "identified" if t > 1.5 else "not_excited"


def test_an_identified_n_is_driven_on_by_both():
    one, other, judge = in_python(judge=Sure()), started(), Sure()
    with strangers_vehicle() as vehicle:
        for k in range(300):
            measured = vehicle.measure()
            judge.tick(k * TICK, {}, None)
            other.judge(judge.verdict == "identified", judge.n, judge.n_std)
            ours, theirs = other.tick(k * TICK, measured), one.tick(k * TICK, measured)
            for name in COMPARED:
                assert getattr(ours, name) == pytest.approx(float(getattr(theirs, name)), abs=1e-6), (k, name)
            vehicle.apply(theirs, TICK)
    assert ours.n == ours.n_used == 0.55 and ours.n_std == 0.02
    with pytest.raises(ValueError, match="out of its range"):
        other.judge(True, 5.0)


def test_it_stops_before_what_it_cannot_pass_and_without_measurements():
    wall = [[86.0, 0.2, 25.0, 0.0, 0.0]]
    driver, stood = started(obstacles=wall), None
    with strangers_vehicle() as vehicle:
        for k in range(2000):
            measured = vehicle.measure()
            command = driver.tick(k * TICK, measured)
            stood = k if command.stopped else None
            if stood:
                break
            vehicle.apply(command, TICK)
    assert stood and command.halt and not command.finished and measured["x"] < 61.0
    driver = started()
    for k in range(200):
        command = driver.tick(k * TICK, {})
        assert not command.stopped, "no speed is known"
    assert command.lost and command.steer == 0.0 and command.a_asked < 0.0 and not command.started
    assert np.isnan(command.position_std) and np.isnan(command.dead_reckoned)


def test_both_halt_where_nothing_is_measured_any_more_and_go_on_when_it_is():
    """From 1 s on nothing is measured for 5.5 s: braked after 4 s of it, and driven on after plans that are clear."""
    one, other, halted = in_python(), started(), []
    with strangers_vehicle() as vehicle:
        for k in range(800):
            measured = vehicle.measure()
            if 84 <= k < 540:
                measured = {}
            ours, theirs = other.tick(k * TICK, measured), one.tick(k * TICK, measured)
            for name in COMPARED:
                assert getattr(ours, name) == pytest.approx(float(getattr(theirs, name)), abs=1e-6, nan_ok=True), (k, name)
            unknown = STATUSES[ours.status][0] == "POSITION_UNKNOWN"
            assert unknown == (theirs.status is Status.POSITION_UNKNOWN)
            halted.append((ours.halt, unknown))
            vehicle.apply(theirs, TICK)
    first = halted.index((1, 1))
    assert 4.0 < first * TICK - 83 * TICK < 4.0 + 2 * SENSORS.period and (1, 0) in halted[540:]
    assert halted[-1] == (0, 0)


def test_late_calls_and_pauses_are_the_same_in_both():
    """Calls that come early and late, with sensors of different rates; pauses of 0.5 s, and of 5 s, in which somebody else drives
    straight on and brakes: there both begin anew."""
    one, other, rng, t, restarted = in_python(), started(), np.random.default_rng(7), 0.0, False
    with strangers_vehicle() as vehicle:
        measured = vehicle.measure()
        for k in range(500):
            kept = {name: value for i, (name, value) in enumerate(measured.items()) if (k + i) % 3 == 0}
            ours, theirs = other.tick(t, kept), one.tick(t, kept)
            for name in COMPARED:
                assert getattr(ours, name) == pytest.approx(float(getattr(theirs, name)), abs=1e-6, nan_ok=True), (k, name)
            assert STATUSES[ours.status][0] == ("ITERATED" if theirs.status is Status.LATE else theirs.status.name)
            restarted = restarted or (k > 350 and not ours.started)
            pause = {200: 0.5, 350: 5.0}.get(k, TICK * float(rng.uniform(0.3, 2.0)))
            pieces = round(pause / TICK) if pause > 0.1 else 1
            driven_by = replace(theirs, steer=0.0, a_asked=-0.8) if pause > 4.0 else theirs
            for _ in range(pieces):
                vehicle.apply(driven_by, pause / pieces)
                measured = vehicle.measure()
            t += pause
    assert restarted and ours.started and theirs.dead_reckoned < 0.2


def rolling(x: float, u: float = 6.0) -> dict[str, float]:
    return {"x": x, "y": 0.0, "psi": 0.0, "u": u, "v": 0.0, "omega_z": 0.0, "steer": 0.0}


def test_a_plan_that_calls_came_too_late_for_is_lost_in_both():
    """The solves fail from some tick on, and the next call comes two seconds later: the plan is older than is followed."""
    one, other = (make(obstacles=np.array([[20.0, 30.0, 1.0, 0.0, 0.0]])) for make in (in_python, started))
    for k in range(60):
        t = k * TICK
        ours, theirs = other.tick(t, rolling(6.0 * t)), one.tick(t, rolling(6.0 * t))
    assert not ours.lost and not theirs.lost
    one.obstacles[0, 2] = other._kept[4][0, 2] = np.nan  # memory of the caller's
    for j in range(8):
        late = t + 2.0 + j * TICK
        ours, theirs = other.tick(late, rolling(6.0 * late)), one.tick(late, rolling(6.0 * late))
    assert theirs.lost and ours.lost and ours.a_x == pytest.approx(theirs.a_x) == pytest.approx(-1.5)


def test_a_verdict_of_before_a_pause_does_not_count_in_either():
    one, other = in_python(judge=Sure(), obstacles=()), started(obstacles=np.zeros((0, 5)))
    for k in range(200):
        if k * TICK > 1.5:
            other.judge(True, Sure.n, Sure.n_std)
        ours, theirs = (driver.tick(k * TICK, rolling(6.0 * k * TICK)) for driver in (other, one))
    assert ours.n_used == theirs.n_used == Sure.n
    one.judge.verdict = "not_excited"
    one.judge.tick = lambda *_: None  # its windows begin anew
    for k in range(6):
        ours, theirs = (driver.tick(600.0 + k * TICK, rolling(5.0 + 6.0 * k * TICK)) for driver in (other, one))
    assert theirs.verdict != "identified" and ours.n_std == pytest.approx(theirs.n_std, rel=1e-6) and ours.n_std > 0.1
    assert ours.n_used == pytest.approx(theirs.n_used, abs=1e-6)


def test_wheels_of_a_vehicle_that_stands_do_not_slip():
    one, other = in_python(obstacles=()), started(obstacles=np.zeros((0, 5)))
    stands = {**rolling(1.0, 0.0), "a_x_imu": 0.0, **dict.fromkeys(("omega_fl", "omega_fr", "omega_rl", "omega_rr"), 0.0)}
    for k in range(200):
        theirs, ours = one.tick(k * TICK, stands), other.tick(k * TICK, stands)
    assert ours.slip == theirs.slip == problem().settings.slip


@pytest.mark.parametrize("phase", (0, 1))
def test_what_is_measured_between_updates_waits(phase):
    """An estimator that updates at every second tick, sensors at every eighth: of one phase all was lost, and it halted."""
    estimator = LiveEstimator(problem().model, SENSORS.sensor_std, tuning=Tuning(update_every=2))
    driver = in_python(obstacles=(), estimator=estimator)
    for k in range(120):
        last = driver.tick(k * TICK, rolling(6.0 * k * TICK) if k == 0 or k % 8 == phase else {"steer": 0.0})
    assert last.dead_reckoned < 10 * TICK and last.status is not Status.POSITION_UNKNOWN


def test_both_learn_the_lag_of_a_steering_and_halt_where_it_is_stuck():
    """A sensor that is read at one tick in four sees a lag of 0.15 s, and stays where it was from 3.6 s on."""
    one, other, angle = in_python(), started(), 0.0
    with strangers_vehicle() as vehicle:
        for k in range(700):
            measured = vehicle.measure() | {"steer": angle if k % 4 == 0 else float("nan")}
            ours, theirs = other.tick(k * TICK, measured), one.tick(k * TICK, measured)
            for name in COMPARED:
                assert getattr(ours, name) == pytest.approx(float(getattr(theirs, name)), abs=1e-6), (k, name)
            assert (STATUSES[ours.status][0] == "STEERING_STUCK") == (theirs.status is Status.STEERING_STUCK)
            if k < 300:
                angle += (1.0 - np.exp(-TICK / 0.15)) * (theirs.steer - angle)
            if k == 300:
                assert ours.actuator_lag == pytest.approx(0.15, abs=0.03)
            vehicle.apply(theirs, TICK)
    assert theirs.status is Status.STEERING_STUCK and ours.halt


@pytest.mark.parametrize(
    ("wrong", "kind", "bit"), (({"u": 3.6}, "course", 1), ({"psi": -1.0}, "heading", 2), ({"steer": -1.0}, "steering", 4))
)
def test_both_halt_where_measurements_contradict_each_other(wrong, kind, bit):
    """A unit or a sign that is wrong: both see it at the same tick, brake, and do not take n as identified any more."""
    one, other, seen = in_python(judge=Sure(), obstacles=()), started(obstacles=np.zeros((0, 5))), None
    for k in range(500):
        t = k * TICK
        psi = 0.35 * t if t < 3.0 else 1.05 - 0.35 * (t - 3.0)
        omega = 0.35 if t < 3.0 else -0.35
        measured = rolling(6.0 * t) | {"y": 2.0 * t, "psi": psi, "omega_z": omega, "steer": 0.4 * omega}
        measured |= {name: factor * measured[name] for name, factor in wrong.items()}
        other.judge(t > 1.5, Sure.n, Sure.n_std)
        ours, theirs = other.tick(t, measured), one.tick(t, measured)
        assert STATUSES[ours.status][0] == theirs.status.name and ours.halt == theirs.halt, k
        if seen is None and theirs.disagree:
            seen = k
        assert bool(ours.disagreement & bit) == (kind in theirs.disagree), k
    assert seen is not None and kind in theirs.disagree and ours.halt
    assert theirs.status is Status.SENSORS_DISAGREE
    assert theirs.verdict == "inconsistent" and ours.n_used != Sure.n


@lru_cache(maxsize=1)
def folder():
    """The driver of a shorter horizon, written to a folder."""
    from pathlib import Path
    from tempfile import mkdtemp

    path = Path(mkdtemp(prefix="softsoil_driver_"))
    write_library(path, controller_texts(DECLARED, settings=OcpSettings(steps=20, dt=0.1)))
    return path


@pytest.mark.study
def test_plain_c99_and_vectors_drive_alike(tmp_path):
    """200 ticks in closed loop with the library's own model: whatever the processor has."""
    plain = judge.numbers(["gcc", "-O1", "-DSOFTSOIL_SCALAR"], folder(), "driver_arm.c", tmp_path / "plain")
    fast = judge.numbers(["gcc", "-O2", "-march=native"], folder(), "driver_arm.c", tmp_path / "fast")
    np.testing.assert_allclose(plain, fast, atol=1e-7)
    assert plain[5] > 10.0, "the vehicle went on"


def test_the_same_commands_on_arm(tmp_path):
    if any(shutil.which(tool) is None for tool in ("gcc", judge.ARM[0], "qemu-arm")):
        pytest.skip("gcc, the ARM compiler or qemu-arm is not installed")
    here, there = judge.arm_numbers(folder(), tmp_path, "driver_arm.c")
    np.testing.assert_allclose(there, here, atol=1e-7)


@pytest.mark.study
@pytest.mark.parametrize("target", ("storm", "fuzz"))
def test_storm_under_sanitizers(target, tmp_path):
    """Everything that can go wrong, from chance and from bytes; `benchmarks/clibrary_trust.py driver` runs longer."""
    more: tuple[str, ...] = ()
    if target == "fuzz":
        main = tmp_path / "bytes.c"
        main.write_text(BYTES, encoding="utf-8")
        more = ("-DFUZZ", str(main))
    compiler = ["gcc", "-O1", "-DSOFTSOIL_SCALAR", *judge.SANITIZERS]
    if not judge.compiles(compiler):
        pytest.skip("the compiler has no sanitizers")
    program = judge.build(compiler, folder(), "driver_storm.c", tmp_path / "storm", more)
    done = subprocess.run([str(program), "1500", "1"], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "nothing broke" in done.stdout, done.stderr[-2000:]


@pytest.mark.parametrize("compiler", (STRICT, [*STRICT, "-DSOFTSOIL_SCALAR"], ["g++", "-x", "c++", *STRICT[2:6]]))
def test_compilers_have_nothing_to_say(compiler, tmp_path):
    if shutil.which(compiler[0]) is None:
        pytest.skip(f"{compiler[0]} is not installed")
    for source in (folder() / "src" / "softsoil_driver.c", folder() / "example_drive.c"):
        command = [*compiler, f"-I{folder() / 'include'}", "-c", str(source), "-o", str(tmp_path / "object.o")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr[:2000]


FAULTS = """
#include <math.h>
#include <stdio.h>
#include "softsoil_driver.h"
static void say(const softsoil_driver_settings_t *s, softsoil_driver_task_t *task) {
  static softsoil_driver_t driver;
  const char *fault = softsoil_driver_fault(s, task);
  printf("%d %s\\n", softsoil_driver_init(&driver, s, task) == SOFTSOIL_NMPC_OK, fault ? fault : "none");
}
int main(void) {
  double x[3] = {0.0, 1.0, 2.0}, y[3] = {0.0, 0.0, 0.0}, s[3] = {0.0}, psi[3] = {0.0};
  softsoil_driver_settings_t good, bad;
  softsoil_driver_task_t task = {{3, x, y, s, psi}, 5.0, NULL, 0, 0.7, 1, 0, {0.0}};
  softsoil_driver_defaults(&good);
  say(&good, &task); /* softsoil_nmpc_path was forgotten */
  softsoil_nmpc_path(&task.path);
  say(&good, &task);
  bad = good; bad.tick = 0.0; say(&bad, &task);
  bad = good; bad.actuator_lag = 0.7; say(&bad, &task);
  bad = good; bad.plan_every = 100; say(&bad, &task);
  bad = good; bad.end = NAN; say(&bad, &task);
  bad = good; bad.nmpc.limits[0][0] = bad.nmpc.limits[0][1]; say(&bad, &task);
  bad = good; bad.filter.r_std[4] = HUGE_VAL; say(&bad, &task);
  bad = good; bad.filter.r_std[0] = 0.0; say(&bad, &task);
  return 0;
}
"""


@pytest.mark.study
def test_what_a_library_refuses_is_named(tmp_path):
    """Nothing is refused that `softsoil_driver_fault` has no word for, and nothing taken that it objects to."""
    main, program = tmp_path / "faults.c", tmp_path / "faults"
    main.write_text(FAULTS, encoding="utf-8")
    sources = [str(path) for path in (folder() / "src").glob("*.c")]
    subprocess.run(["gcc", "-O0", f"-I{folder() / 'include'}", *sources, str(main), "-lm", "-o", str(program)], check=True)
    lines = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout.splitlines()
    words = (
        "path: expected s that grow", "none", "settings.tick:", "settings.actuator_lag:", "settings.plan_every: expected plans",
        "settings.end:", "settings.nmpc.limits:", "settings.filter.r_std:", "settings.filter.r_std:",
    )  # fmt: skip
    assert len(lines) == len(words)
    for line, word in zip(lines, words, strict=True):
        taken, said = line.split(" ", 1)
        assert said.startswith(word) and (taken == "1") == (word == "none"), line


def test_a_driver_ticks_as_its_estimator_steps():
    """`softsoil generate --controller --dt 0.02`: one step for filter, driver and example."""
    texts = controller_texts(DECLARED, 0.02, fmi=True)
    driver = texts["src/softsoil_driver.c"]
    assert "settings->tick = 0.02;" in driver and "settings->plan_every = 2;" in driver
    assert "#define SOFTSOIL_STEP 0.02" in texts["include/softsoil.h"]
    assert 'stepSize="0.02"' in texts["fmi/driverDescription.xml"]
    asked = controller_texts(DECLARED, 0.02, driver=DriverSettings(tick=0.01))
    assert "settings->tick = 0.01" in asked["src/softsoil_driver.c"]


def test_wrong_tasks_are_refused():
    for wrong, word in (
        ({"n0": 3.0}, "n0: expected"), ({"obstacles": [[np.nan, 0.0, 1.0, 0.0, 0.0]]}, "obstacles: expected finite"),
        ({"obstacles": [[9.0, 0.0, -1.0, 0.0, 0.0]]}, "radius >= 0"),
        ({"start": [np.inf, 0.0, 0.0, 5.0, 0.0, 0.0]}, "start: expected"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=word):
            started(**wrong)
    for speed in (0.0, -3.0, 20.0, np.nan):
        with pytest.raises(ValueError, match=r"speed: expected .* 0.5 to 12 m/s .*brake"):
            in_c().start(double_lane_change(), speed)
    in_c().self, kept = ctypes.create_string_buffer(len(in_c()._memory)), in_c().self
    with pytest.raises(ValueError, match="has not been called"):
        in_c().tick(0.0, {})
    in_c().self = kept
    driver = started()
    with pytest.raises(ValueError, match=r"out of its range.*expected a finite t.*found nan"):
        driver.tick(float("nan"), {})
    driver.tick(0.0, {})
    with pytest.raises(ValueError, match=r"not before the last tick's .*, found -1.0 s"):
        driver.tick(-1.0, {})
    with pytest.raises(ValueError, match=r"measured: expected names .*found 'speed'"):
        driver.tick(0.1, {"speed": 5.0})
