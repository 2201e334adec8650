"""The generated controller: the same plan as Python's, its promises, and the folder as an engineer meets it."""

import ctypes
import os
import re
import shutil
import subprocess
from functools import lru_cache
from pathlib import Path as Folder
from tempfile import mkdtemp

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.judges import c_library as judge
from drives import PROJECT, reference_vehicle
from nmpc_problem import rut_ocp
from softsoil.codegen.c_library.folder import write_library
from softsoil.commands.cli import app
from softsoil.control.c_controller import controller_files
from softsoil.control.c_folder import controller_texts
from softsoil.control.c_statuses import STATUSES
from softsoil.control.courses import double_lane_change
from softsoil.control.follower import PlanFollower
from softsoil.control.horizon import reference, watched
from softsoil.control.nmpc import Nmpc
from softsoil.control.nmpc_binding import CController, Command
from softsoil.control.nmpc_settings import SETTINGS
from softsoil.control.ocp import Ocp, OcpSettings
from softsoil.control.ocp_examples import reference_along, straight_guess, tanh_bicycle
from softsoil.control.path import Path
from softsoil.declaration.model_file import Declaration
from softsoil.symbolic.soil import CLAY, SAND

pytestmark = pytest.mark.compiler
S = {name: value for value, (name, _) in enumerate(STATUSES)}
SAME = 1e-8
SCALAR = ("-O1", "-DSOFTSOIL_SCALAR", "-fPIC")
STRICT = ("-std=c99", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror")
OBSTACLES = np.array([[62.0, 1.6, 1.0], [90.0, 2.4, 1.0]])


@lru_cache(maxsize=4)
def problem(name: str) -> Ocp:
    """The plain bicycle, with ruts on a soil, or with all effects on hard ground, whose equations compile quickly."""
    vehicle = reference_vehicle()
    if name == "plain":
        return Ocp(tanh_bicycle(vehicle), vehicle, OcpSettings(obstacles=2))
    if name == "hard_ground":
        return Ocp(Declaration(vehicle, CLAY, name).build(), vehicle)
    return rut_ocp({soil.name: soil for soil in (CLAY, SAND)}[name])


@lru_cache(maxsize=2)
def folder() -> Folder:
    """Estimator and controller of the reference vehicle with its effects, on hard ground, whose equations compile quickly."""
    path = Folder(mkdtemp(prefix="softsoil_nmpc_"))
    write_library(path, controller_texts(Declaration(reference_vehicle(), CLAY, "hard_ground")))
    return path


@lru_cache(maxsize=1)
def controller_alone() -> Folder:
    """The controller of the plain bicycle."""
    path = Folder(mkdtemp(prefix="softsoil_nmpc_"))
    write_library(path, controller_files(problem("plain")))
    return path


def started(name: str = "plain", z0=None, hessian: str = "gauss_newton", **options) -> CController:
    """The generated files compiled as plain C99, started."""
    ocp = problem(name)
    controller = CController(ocp, controller_files(ocp, hessian), SCALAR)
    chosen = controller.Options()
    controller.c.softsoil_nmpc_defaults(ctypes.byref(chosen))
    for key, value in options.items():
        setattr(chosen, key, value)
    controller.call("init", ctypes.byref(chosen), ocp.z.pack(u=6.0) if z0 is None else z0)
    return controller


def refused(controller: CController, name: str, *arguments) -> str:
    with pytest.raises(ValueError, match="softsoil_nmpc_") as error:
        controller.call(name, *arguments)
    return str(error.value)


@pytest.mark.parametrize(
    ("name", "hessian"),
    [
        ("plain", "exact"), ("plain", "gauss_newton"),
        *(pytest.param(*one, marks=pytest.mark.study)
          for one in (("clay", "exact"), ("hard_ground", "exact"), ("sand", "gauss_newton"))),
    ],
)
def test_the_plan_is_pythons_along_a_drive_among_obstacles(name, hessian):
    """Plain C99 with the constants as written against vectors with all digits, histories and obstacles included.

    Solve by solve from the same memory: where a plan has to choose a side, rounding of solves long past may decide it.
    """
    ocp, speed = problem(name), 6.0
    path, h, s = double_lane_change(), ocp.settings.dt, ocp.s.nominal
    theirs, ours = Nmpc(ocp, hessian=hessian), started(name, hessian=hessian)
    guess = straight_guess(ocp, speed)
    theirs.set_initial_guess(*guess)
    ours.call("guess", *guess)
    z, m = ocp.z.pack(u=speed), np.zeros(len(ocp.model.cells))
    step, first, seen = ocp.step(), np.zeros(2), []
    r = np.zeros((ocp.settings.steps, max(len(ocp.r), 1)))
    places = np.zeros((ocp.settings.steps + 1, 2, 3))
    places[:] = OBSTACLES
    for k in range(230):
        magic = ours.head.magic
        ours.copy(theirs.controller)
        ours.head.magic = magic
        ref = reference_along(path, path.project(z[0], z[1])[0], speed, ocp)
        if k:
            theirs.shift(h)
            ours.call("shift", ctypes.c_double(h))
        theirs.set_parameters(s, theirs.histories(m, s), ref, OBSTACLES)
        if len(ocp.r):
            ours.call("histories", s, m, r)
        ours.call("parameters", s, r, ref, places)
        w = theirs.make_step(z)
        status = STATUSES[ours.call("step", np.ascontiguousarray(z), first)][0]
        assert status == theirs.stats.status.name
        np.testing.assert_allclose(ours.view("z"), theirs.z, atol=SAME)
        np.testing.assert_allclose(ours.view("w")[:-1], theirs.w, atol=SAME)
        np.testing.assert_allclose(first, w, atol=SAME)
        seen.append(theirs.stats.gap)
        z = np.array(step(z, w, r[0, : len(ocp.r)], s)).ravel()
    assert min(seen) < 1.0, "the obstacles are in the way"


def now_type(ocp: Ocp) -> type[ctypes.Structure]:
    """softsoil_nmpc_now_t."""
    real, n = ctypes.c_double, ocp.settings.steps + 1

    class Now(ctypes.Structure):
        _fields_ = [
            ("s", real * len(ocp.s)), ("m", real * max(len(ocp.model.cells), 1)), ("ref", real * 4 * n),
            ("obstacles", real * 3 * max(ocp.settings.obstacles, 1) * n), ("count", ctypes.c_int32), ("reserved", ctypes.c_int32),
        ]  # fmt: skip

    return Now


class CPath(ctypes.Structure):
    """softsoil_nmpc_path_t."""

    _fields_ = [("n", ctypes.c_size_t)] + [(name, ctypes.c_void_p) for name in ("x", "y", "s", "psi")]


TICK, EVERY, SPEED = 0.012, 4, 6.0
START = 1500.0
"""m: x where the drive begins: a place is no reason to overlook an obstacle."""
MOVING = np.array([[62.0, 1.6, 1.0, 0.0, 0.0], [200.0, 0.0, 1.0, 0.0, 0.0], [92.0, 2.4, 1.0, -0.1, 0.0]])
MOVING = np.array([*MOVING, *([x, -9.0, 1.0, 0.0, 0.0] for x in range(5, 100, 5))]) + [START, 0.0, 0.0, 0.0, 0.0]
"""Two on the path, one behind its end and a row beside it."""


def by_python(ocp: Ocp, path: Path, move) -> list[np.ndarray]:
    """States of a vehicle that `move` moves, driven by the parts of `Driver`."""
    solver, follower = Nmpc(ocp), PlanFollower(ocp.settings.dt, TICK)
    z, along, places = ocp.z.pack(x=START, u=SPEED), None, []
    guess, inputs = straight_guess(ocp, SPEED)
    guess[:, 0] += START
    solver.set_initial_guess(guess, inputs)
    for k in range(1500):
        steer, _, a_x = follower.command((k + 1) * TICK, z[-1])
        if k % EVERY == 0:
            along, _ = path.project(z[0], z[1], along)
            if k:
                solver.shift(EVERY * TICK)
            ref = reference(ocp, path, along, SPEED, z)
            near = watched(ocp, MOVING, k * TICK, z, ref)
            solver.set_parameters(ocp.s.nominal, np.zeros((ocp.settings.steps, 0)), ref, near)
            solver.make_step(z)
            follower.take(k * TICK, solver.z[:, -1], solver.z[:, 3], solver.w[:, 1], solver.stats.touch >= 0)
        z = move(z, steer, a_x)
        places.append(z)
    return places


def by_c(ocp: Ocp, path: Path, move) -> list[np.ndarray]:
    """The same, driven by the generated files."""
    controller = started(z0=ocp.z.pack(x=START, u=SPEED))
    c, now, command = controller.c, now_type(ocp)(), Command()
    columns = [np.ascontiguousarray(path.points[:, 0]), np.ascontiguousarray(path.points[:, 1])]
    columns += [np.zeros(len(path.points)) for _ in range(2)]
    course = CPath(len(path.points), *[column.ctypes.data for column in columns])
    assert c.softsoil_nmpc_path(ctypes.byref(course)) == S["OK"]
    np.testing.assert_allclose(columns[2:], [path.s, path.psi], atol=1e-12)
    now.s[:] = ocp.s.nominal
    z, along, since, places, first = ocp.z.pack(x=START, u=SPEED), ctypes.c_double(-1.0), 0.0, [], np.zeros(2)
    real, pointer = ctypes.c_double, ctypes.c_void_p
    for k in range(1500):
        t = k * TICK
        controller.call("follow", real(t + TICK - since), real(z[-1]), real(TICK), ctypes.byref(command))
        steer, a_x = command.steer, command.a_x
        if k % EVERY == 0:
            at = pointer(z.ctypes.data)
            c.softsoil_nmpc_reference(
                ctypes.byref(course), at, real(SPEED), ctypes.byref(along), None, ctypes.byref(now)
            )
            c.softsoil_nmpc_watch(pointer(MOVING.ctypes.data), ctypes.c_size_t(len(MOVING)), real(t), at, ctypes.byref(now))
            controller.call("prepare", ctypes.byref(now), real(EVERY * TICK if k else 0.0))
            controller.call("step", z, first)
            since = t
        z = move(z, steer, a_x)
        places.append(z)
    return places


def test_a_vehicle_drives_the_same_path_by_python_and_by_c():
    """Reference, obstacles, solves, plans followed and safe commands: position to 1e-6 m after 18 s."""
    ocp = problem("plain")
    rates, s = ocp.dynamics(), ocp.s.nominal

    def move(z: np.ndarray, steer: float, a_x: float) -> np.ndarray:
        w = np.array([(steer - z[-1]) / TICK, a_x])
        return z + TICK * np.array(rates(z, w, np.zeros(0), s)[0]).ravel()

    path = Path(double_lane_change().points + [START, 0.0])
    one, other = (np.array(drive(ocp, path, move)) for drive in (by_python, by_c))
    assert one[-1, 0] > START + 90.0, "both obstacles were met"
    np.testing.assert_allclose(other, one, atol=1e-6)
    gaps = [np.hypot(one[:, 0] - x - vx * TICK * np.arange(1500), one[:, 1] - y).min() - r for x, y, r, vx, _ in MOVING]
    assert 0.2 < min(gaps) < 2.0


def test_an_obstacle_that_is_no_number_is_refused_and_one_that_is_not_there_takes_no_place():
    ocp, controller, now = problem("plain"), started(), now_type(problem("plain"))()
    z, most = ocp.z.pack(u=SPEED), ocp.settings.obstacles

    def watch(*rows):
        given = np.array(rows, dtype=float)
        at = [ctypes.c_void_p(array.ctypes.data) for array in (given, z)]
        return controller.c.softsoil_nmpc_watch(at[0], ctypes.c_size_t(len(rows)), ctypes.c_double(0.0), at[1], ctypes.byref(now))

    there, absent = (7.0, 0.0, 1.0, 0.0, 0.0), (6.0, 0.0, -0.5, 0.0, 0.0)
    assert watch(*[absent] * most, there) == S["OK"] and now.count == 1
    assert watched(ocp, np.array([*[absent] * most, there]), 0.0, z, np.zeros((ocp.settings.steps + 1, 4))).shape[1] == 1
    for i in range(5):
        broken = [*there]
        broken[i] = np.nan
        assert watch(there, broken) == S["BAD_ARGUMENT"] and now.count == 1 and np.isnan(now.obstacles[0][0][0])
        assert np.isnan(watched(ocp, np.array([there, broken]), 0.0, z, np.zeros((ocp.settings.steps + 1, 4)))).any()


NORTH = np.column_stack([np.zeros(41), 0.5 * np.arange(41.0)])
CIRCLE = 20.0 * np.column_stack([np.sin(np.linspace(0.0, 2 * np.pi, 300)), 1.0 - np.cos(np.linspace(0.0, 2 * np.pi, 300))])


@pytest.mark.parametrize(
    ("points", "places"),
    [
        pytest.param(np.vstack([NORTH, [NORTH[-1]] * 5]), [(0.1, 19.0), (0.3, 24.0), (0.2, 33.0)], id="stops at its end"),
        pytest.param(np.vstack([[NORTH[0]] * 5, NORTH]), [(0.1, -3.0), (0.1, -1.2), (0.2, 2.0)], id="stands at its beginning"),
        pytest.param(np.vstack([NORTH[:20], [NORTH[19]] * 3, NORTH[20:]]), [(0.1, 8.0), (0.0, 9.6)], id="stands half-way"),
        pytest.param(np.vstack([NORTH, NORTH[-2::-1]]), [(0.1, 19.0)], id="turns back on the spot"),
        pytest.param(NORTH[::40], [(0.1, 3.0), (0.1, 9.8), (0.1, 12.0)], id="two points"),
        pytest.param(np.vstack([CIRCLE, CIRCLE[1:]]), [(-2.5, 0.4), (-1.0, 0.0), (1.0, 0.0)], id="two laps, from behind"),
        pytest.param(CIRCLE, [(-1.5, 0.0), (-0.5, 0.0), (2.0, 0.1)], id="closed, from behind its beginning"),
        pytest.param(NORTH, [(0.0, -3.0), (1.8, -3.2)], id="behind its beginning"),
    ],
)
def test_a_path_is_the_same_in_c(points, places):
    """Lengths, courses, and the reference of a vehicle that comes by places (x, y) one after the other."""
    ocp, path, controller, real = problem("plain"), Path(points), started(), ctypes.c_double
    columns = [*(np.ascontiguousarray(column) for column in points.T), np.zeros(len(points)), np.zeros(len(points))]
    course = CPath(len(points), *[column.ctypes.data for column in columns])
    assert controller.c.softsoil_nmpc_path(ctypes.byref(course)) == S["OK"]
    np.testing.assert_allclose(columns[2:], [path.s, path.psi], atol=1e-12)
    along, left, near, now = real(-1.0), real(), None, now_type(ocp)()
    for x, y in places:
        z = ocp.z.pack(x=x, y=y, psi=1.5, u=SPEED)
        out = (ctypes.byref(one) for one in (along, left, now))
        controller.c.softsoil_nmpc_reference(ctypes.byref(course), ctypes.c_void_p(z.ctypes.data), real(SPEED), *out)
        near, aside = path.project(x, y, near)
        assert (along.value, left.value) == pytest.approx((near, aside), abs=1e-9)
        found = np.ctypeslib.as_array(now.ref).reshape(-1, 4)
        np.testing.assert_allclose(found, reference(ocp, path, near, SPEED, z), atol=1e-9)


def test_a_path_of_one_place_is_none():
    columns = [np.zeros(3) for _ in range(4)]
    course = CPath(3, *[column.ctypes.data for column in columns])
    assert started().c.softsoil_nmpc_path(ctypes.byref(course)) == S["BAD_ARGUMENT"]
    with pytest.raises(ValueError, match="path: expected points of a path, found 3 times"):
        Path(np.zeros((3, 2)))


def test_wrong_calls_are_refused_and_change_nothing():
    ocp, controller = problem("plain"), started()
    z0, first = ocp.z.pack(u=6.0), np.zeros(2)
    controller.call("step", z0, first)
    before = controller.view("z").copy()
    assert "null" in refused(controller, "step", None, first)
    assert "out of its range" in refused(controller, "shift", ctypes.c_double(-1.0))
    assert "out of its range" in refused(controller, "shift", ctypes.c_double(np.nan))
    assert "out of its range" in refused(controller, "guess", np.full_like(before, np.inf), np.zeros((40, 2)))
    np.testing.assert_array_equal(controller.view("z"), before)
    controller.head.magic = 0
    assert "has not been called" in refused(controller, "step", z0, first)
    options = controller.Options()
    controller.c.softsoil_nmpc_defaults(ctypes.byref(options))
    options.limits[0][1] = np.nan
    assert "out of its range" in refused(controller, "init", ctypes.byref(options), z0)
    controller.c.softsoil_nmpc_defaults(ctypes.byref(options))
    options.patience = np.inf  # no plan at all would never be lost
    assert "out of its range" in refused(controller, "init", ctypes.byref(options), z0)
    assert "out of its range" in refused(controller, "init", None, ocp.z.pack(u=1e4))
    assert controller.c.softsoil_nmpc_status_text(-3).decode() == "not a status of this library"


def test_without_a_plan_the_command_is_safe():
    ocp, controller, command = problem("plain"), started(), Command()
    z0, first = ocp.z.pack(u=6.0), np.zeros(2)

    def follow(seconds: float, steer: float) -> Command:
        controller.call(
            "follow", ctypes.c_double(seconds), ctypes.c_double(steer), ctypes.c_double(0.01), ctypes.byref(command)
        )
        return command

    assert follow(0.0, 0.1).lost and command.a_x == SETTINGS.slowing, "no plan yet"
    assert controller.call("step", z0, first) == S["ITERATED"]
    assert not follow(0.01, 0.0).lost and command.speed == pytest.approx(6.0, abs=0.3)
    lost = np.full_like(z0, np.nan)
    for _ in range(10):
        controller.call("shift", ctypes.c_double(0.05))
        assert controller.call("step", lost, first) == S["BAD_STATE"]
    assert not follow(0.01, 0.1).lost, "half a second old"
    for _ in range(10):
        controller.call("shift", ctypes.c_double(0.05))
        controller.call("step", lost, first)
    assert follow(0.01, 0.1).lost and command.steer == pytest.approx(0.1 - 0.01 * SETTINGS.straighten)
    assert command.speed == 0.0 and command.a_x < 0 and follow(0.01, 0.001).steer == 0.0
    controller.call("step", z0, first)
    assert not follow(0.01, 0.1).lost


def test_before_what_it_cannot_pass_it_brakes_and_goes_on_when_clear():
    ocp, controller, command = problem("plain"), started(), Command()
    z0, first = ocp.z.pack(u=6.0), np.zeros(2)
    n, walls = ocp.settings.steps, 8
    ref = np.column_stack([6.0 * 0.0625 * np.arange(n + 1), np.zeros(n + 1), np.zeros(n + 1), np.full(n + 1, 6.0)])
    wall = np.full((n + 1, 2, 3), [1e3, 1e3, 0.0])
    wall[:, 0] = [12.0, 0.3, 9.0]
    halts = []
    for k in range(walls + SETTINGS.clear_steps + 4):
        controller.call("parameters", ocp.s.nominal, np.zeros(1), ref, wall if k < walls else None)
        status = controller.call("step", z0, first)
        assert status == (S["BLOCKED"] if k == walls - 1 else S["ITERATED"]) or k < walls - 1
        controller.call(
            "follow", ctypes.c_double(0.0), ctypes.c_double(0.0), ctypes.c_double(0.01), ctypes.byref(command)
        )
        halts.append(bool(command.halt))
        assert (command.a_x == SETTINGS.braking) == halts[-1]
    assert halts[walls - 1 :] == [True] * SETTINGS.clear_steps + [False] * 5


@pytest.mark.study
@pytest.mark.parametrize("target", ["storm", "fuzz"])
def test_storm_under_sanitizers(target, tmp_path):
    """Everything that can go wrong, from chance and from bytes; `benchmarks/clibrary_trust.py controller` runs longer."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    compiler, more = ["gcc", "-O1", *judge.SANITIZERS], ()
    if target == "fuzz":
        main = tmp_path / "bytes.c"
        main.write_text(BYTES, encoding="utf-8")
        more = ("-DFUZZ", str(main))
    if not judge.compiles(compiler):
        pytest.skip("the compiler has no sanitizers")
    program = judge.build(compiler, controller_alone(), "controller_storm.c", tmp_path / "storm", more)
    done = subprocess.run([str(program), "300", "1"], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "nothing broke" in done.stdout, done.stderr[-2000:]


BYTES = """
#include <stdint.h>
#include <stdio.h>
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int main(void) {
  static uint8_t bytes[400];
  uint32_t state = 12345u;
  for (int run = 0; run < 25; ++run) {
    for (unsigned i = 0; i < sizeof bytes; ++i) bytes[i] = (uint8_t)((state = state * 1664525u + 1013904223u) >> 24);
    if (LLVMFuzzerTestOneInput(bytes, sizeof bytes)) return 1;
  }
  return puts("nothing broke") < 0;
}
"""


@pytest.mark.parametrize(
    "more",
    (
        pytest.param((), marks=pytest.mark.study),
        ("-DSOFTSOIL_SCALAR",),
        pytest.param(("-O3", "-march=native"), marks=pytest.mark.study),
        ("-x", "c++"),
    ),
    ids=" ".join,
)
def test_compilers_have_nothing_to_say(more, tmp_path):
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    compiler = ["g++", "-fsyntax-only", "-Wall", "-Wextra", "-Werror"] if "c++" in more else ["gcc", *STRICT]
    for source in (*folder().glob("src/softsoil_nmpc*.c"), folder() / "example_drive.c"):
        command = [*compiler, *more, f"-I{folder() / 'include'}", "-c", str(source), "-o", str(tmp_path / "object.o")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{source.name}: {done.stderr[:2000]}"


@pytest.mark.study
def test_no_allocation_and_nothing_that_can_be_written_to(tmp_path):
    if shutil.which("gcc") is None or shutil.which("nm") is None:
        pytest.skip("gcc or nm is not installed")
    allowed = {
        "memset",
        "sincos",
        "memcpy",
        "memmove",
        "sqrt",
        "cos",
        "sin",
        "atan2",
        "exp",
        "floor",
        "log",
        "tan",
        "tanh",
        "atan",
        "pow",
    }
    for source in folder().glob("src/softsoil_nmpc*.c"):
        built = tmp_path / "object.o"
        subprocess.run(["gcc", "-O2", f"-I{folder() / 'include'}", "-c", str(source), "-o", str(built)], check=True)
        for line in subprocess.run(["nm", str(built)], capture_output=True, text=True, check=True).stdout.splitlines():
            kind, name = line.split()[-2:]
            assert kind not in "BbDdCGgSs", f"{source.name}: {name} can be written to"
            assert (
                kind != "U" or name in allowed or name.startswith("softsoil_nmpc_") or name == "_GLOBAL_OFFSET_TABLE_"
            ), name


def test_the_same_bytes_every_time_and_nothing_of_the_machine():
    texts = controller_texts(Declaration(reference_vehicle(), CLAY, "hard_ground"))
    assert {name: (folder() / name).read_text(encoding="utf-8") for name in texts} == texts
    for text in texts.values():
        assert not re.search(r"@[a-z_0-9]+@|/home/|/work/|/tmp/|20[2-9][0-9]-", text)
    named = set(re.findall(r"`((?:include|src)/[\w.]+|[\w.]+\.(?:c|json|txt))`", texts["CONTROLLER.md"]))
    assert named and named <= set(texts)


def test_the_example_closes_the_loop(tmp_path):
    if shutil.which("cc") is None:
        pytest.skip("cc is not installed")
    readme = (folder() / "CONTROLLER.md").read_text(encoding="utf-8")
    (line,) = [line for line in readme.splitlines() if line.startswith("cc ")]
    shutil.copytree(folder(), tmp_path / "c")
    done = subprocess.run(
        line.replace("-O3", "-O1"), shell=True, cwd=tmp_path / "c", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-1000:] + done.stderr[-1000:]
    rms, gap = re.search(r"off the path (\S+) m rms.*least gap (\S+) m", done.stdout).groups()
    assert float(rms) < 0.4 and float(gap) > 0.1
    n, std = map(float, re.search(r"n by the horizon (\S+) \+- (\S+), driven on", done.stdout).groups())
    true = float(re.search(r"of (\S+); off the path", done.stdout).group(1))
    assert abs(n - true) < 2.0 * std
    assert "previous plan goes on" not in done.stdout, "no solve failed"


@pytest.mark.study
def test_cmake_takes_it_as_a_subdirectory_and_as_a_package(tmp_path):
    """The filter as a subdirectory, filter and controller as a package, by CMake and by pkg-config."""
    if shutil.which("cmake") is None:
        pytest.skip("cmake is not installed")
    for name, text in (("added", FILTER), ("found", BOTH)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "main.c").write_text(text, encoding="utf-8")
    head = "cmake_minimum_required(VERSION 3.13)\nproject(own C)\n"
    link = "add_executable(own main.c)\ntarget_link_libraries(own PRIVATE softsoil::softsoil)\n"
    (tmp_path / "added" / "CMakeLists.txt").write_text(
        f'{head}add_subdirectory("{PROJECT / "generated"}" softsoil)\n{link}', encoding="utf-8"
    )
    (tmp_path / "found" / "CMakeLists.txt").write_text(
        f"{head}find_package(softsoil REQUIRED)\n{link}", encoding="utf-8"
    )
    quick = "-DCMAKE_BUILD_TYPE=Debug"

    def run(*command: str) -> None:
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-1500:] + done.stderr[-1500:]

    run("cmake", "-B", "own", "-S", str(folder()), f"-DCMAKE_INSTALL_PREFIX={tmp_path / 'installed'}", quick)
    run("cmake", "--build", "own", "-j2")
    flags = (tmp_path / "own" / "CMakeFiles" / "softsoil.dir" / "flags.make").read_text(encoding="utf-8")
    assert "-fno-math-errno" in flags and "-O3" not in flags, "a build type is the user's"
    run("cmake", "--install", "own")
    run("cmake", "-B", "one", "-S", "found", f"-DCMAKE_PREFIX_PATH={tmp_path / 'installed'}")
    run("cmake", "--build", "one")
    run("one/own")
    if shutil.which("pkg-config"):
        described = next((tmp_path / "installed").rglob("softsoil.pc"))
        asked, where = ["pkg-config", "--cflags", "--libs", "softsoil"], {"PKG_CONFIG_PATH": str(described.parent)}
        flags = subprocess.run(asked, capture_output=True, text=True, check=True, env={**os.environ, **where}).stdout.split()
        run("cc", "found/main.c", *flags, "-o", "three")
        run("./three")
    run("cmake", "-B", "two", "-S", "added", quick)
    run("cmake", "--build", "two", "-j2")
    run("two/own")


FILTER = """
#include "softsoil.h"
static softsoil_t filter;
int main(void) { return softsoil_init(&filter, 0, 0, 0, 0.0) || softsoil_size() != sizeof filter; }
"""


BOTH = """
#include "softsoil.h"
#include "softsoil_nmpc.h"
static softsoil_t filter;
static softsoil_nmpc_t controller;
int main(void) {
  double z0[SOFTSOIL_NMPC_NZ] = {0.0}, command[SOFTSOIL_NMPC_NW];
  z0[SOFTSOIL_NMPC_Z_u] = 5.0;
  if (softsoil_init(&filter, 0, 0, 0, 0.0) || softsoil_size() != sizeof filter) return 1;
  if (softsoil_nmpc_init(&controller, 0, z0) || softsoil_nmpc_size() != sizeof controller) return 2;
  return softsoil_nmpc_step(&controller, z0, command) == SOFTSOIL_NMPC_ITERATED ? 0 : 3;
}
"""


def test_an_unknown_hessian_is_refused():
    with pytest.raises(ValueError, match="expected a Hessian of gauss_newton, exact"):
        controller_files(problem("plain"), "bfgs")


def test_the_command_writes_the_folder_and_refuses_what_it_does_not_know(tmp_path):
    arguments = ["generate", str(tmp_path / "c"), "--soil", "clay", "--law", "hard_ground", "--controller"]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0 and "CONTROLLER.md" in done.output, done.output
    assert {str(p.relative_to(tmp_path / "c")) for p in (tmp_path / "c").rglob("*") if p.is_file()} >= {
        "include/softsoil.h", "include/softsoil_nmpc.h", "src/softsoil_nmpc.c", "example_drive.c",
    }  # fmt: skip
    refused = CliRunner().invoke(app, [*arguments, "--hessian", "bfgs"])
    assert refused.exit_code == 2 and "gauss_newton" in refused.output
