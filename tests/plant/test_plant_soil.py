"""The soil contact model against theory: static sinkage, compaction resistance, energy, symmetry, convergence, ruts."""

import os

import numpy as np
import pytest
from numba.core import config
from scipy.spatial import ConvexHull

from softsoil.plant import kernel
from softsoil.plant.bed import SoilBed, Touch
from softsoil.plant.footprint import hull_area_perimeter
from softsoil.plant.grid import RutGrid, add_tile, find_tile, tile_key
from softsoil.plant.rig import RigRun, run_rig
from softsoil.plant.soil_field import SoilField
from softsoil.symbolic.soil import CLAY, SAND, SANDY_LOAM

RADIUS, WIDTH = 0.330229, 0.2121
FRICTIONLESS = SANDY_LOAM.with_(k_c=0.0, c=0.0, phi=0.0, R=0.0)


def pressed(bed: SoilBed, h: float, x: float = 0.0, y: float = 0.0, **how: float) -> Touch:
    """A wheel standing at depth h."""
    return bed.touch((x, y, RADIUS - h), **how)


def rolled(bed: SoilBed, h: float, distance: float, *, v_y: float = 0.0, spin: float | None = None) -> list[Touch]:
    """A wheel at constant depth h, rolled along x at 5 m/s; touches of the second half of the way."""
    v = 5.0
    omega = v / RADIUS if spin is None else spin
    steps = int(distance / (v * 0.002))
    touches = [
        bed.touch((k * v * 0.002, 0.0131 + k * v_y * 0.002, RADIUS - h), velocity=(v, v_y, 0.0), rate=(0.0, omega, 0.0))
        for k in range(steps)
    ]
    return touches[steps // 2 :]


def test_static_sinkage() -> None:
    # F_z = b integral k_phi h(X)^n dX over the whole chord of a standing wheel.
    h, soil = 0.03, FRICTIONLESS
    chord = np.sqrt(RADIUS**2 - (RADIUS - h) ** 2)
    x = np.linspace(-chord, chord, 2001)
    theory = WIDTH * np.trapezoid(soil.k_phi * np.maximum(np.sqrt(RADIUS**2 - x**2) - RADIUS + h, 0) ** soil.n, x)
    offsets = np.linspace(0, 0.01, 7, endpoint=False)
    found = np.mean([pressed(SoilBed(soil, 0.01), h, a, b).force[2] for a in offsets for b in offsets])
    assert found == pytest.approx(theory, rel=0.02)


def test_compaction_resistance_and_energy() -> None:
    # Without shear, towing work per metre is the plastic work in the rut: b k_phi h^(n+1) / (n+1) (Bekker), less what the
    # soil's elasticity gives back.
    h, soil = 0.03, FRICTIONLESS
    touches = rolled(SoilBed(soil, 0.01), h, 1.0)
    towing = -np.mean([t.force[0] for t in touches])
    torque = np.mean([t.moment[1] for t in touches])
    plastic = WIDTH * soil.k_phi * h ** (soil.n + 1) / (soil.n + 1)
    # Normal forces on a wheel do no work on its spin; here the force acts on level nodes, so towing shows as a moment.
    power = towing * 5.0 - torque * 5.0 / RADIUS
    assert abs(towing) < 1e-9
    assert power / 5.0 == pytest.approx(plastic, rel=0.12)


def test_free_rolling_wheel_is_slower_than_its_towing() -> None:
    # A towed wheel turns freely where the soil's torque vanishes: at negative slip, and it drags.
    spins = np.linspace(0.6, 1.1, 26) * 5.0 / RADIUS
    results = [rolled(SoilBed(CLAY, 0.02), 0.02, 0.6, spin=float(spin)) for spin in spins]
    torque = np.array([np.mean([t.moment[1] for t in r]) for r in results])
    assert np.all(np.diff(torque) < 0) or torque[0] > 0 > torque[-1]
    free = int(np.argmin(np.abs(torque)))
    assert spins[free] < 5.0 / RADIUS
    assert np.mean([t.force[0] for t in results[free]]) < 0


def test_mirror() -> None:
    left, right = (rolled(SoilBed(CLAY, 0.02), 0.02, 0.8, v_y=v) for v in (0.7, -0.7))
    # The grid is not mirrored about the wheel's path, so only means over many nodes agree.
    for axis, sign in ((0, 1), (1, -1), (2, 1)):
        a, b = (np.mean([t.force[axis] for t in r]) for r in (left, right))
        assert a == pytest.approx(sign * b, rel=0.03)
    assert np.mean([t.force[1] for t in left]) < 0


def test_shear_stays_inside_the_mohr_circle() -> None:
    soil = SANDY_LOAM.with_(R=0.0)
    for touch in rolled(SoilBed(soil, 0.02), 0.03, 0.6, v_y=1.0, spin=20.0):
        area = 0.5 * WIDTH
        limit = soil.c * area + touch.force[2] * np.tan(soil.phi)
        assert np.hypot(touch.force[0], touch.force[1]) < limit


def test_grid_convergence() -> None:
    # The spread of the forces over the grid's offsets falls with the spacing.
    spread = []
    for spacing in (0.06, 0.03, 0.015, 0.0075):
        offsets = np.linspace(0, spacing, 6, endpoint=False)
        forces = [pressed(SoilBed(CLAY, spacing), 0.02, a, b).force[2] for a in offsets for b in offsets]
        spread.append(np.std(forces) / np.mean(forces))
    assert spread[0] > spread[1] > spread[2] > spread[3]
    assert spread[1] < 0.12
    assert spread[3] < 0.03


def test_second_pass_meets_compacted_soil() -> None:
    bed = SoilBed(CLAY, 0.02)
    first = rolled(bed, 0.02, 1.0)
    tiles = bed.grid.tiles
    second = rolled(bed, 0.02, 1.0)
    assert bed.grid.tiles == tiles, "the same rut costs no further memory"
    # Pushed to the same depth, the soil no longer resists ahead of the axle: less load, less drag.
    assert np.mean([t.force[2] for t in second]) < 0.3 * np.mean([t.force[2] for t in first])
    # A hair deeper, load comes back fast: the rut is stiffer than fresh soil.
    deeper = rolled(bed, 0.0215, 1.0)
    fresh = rolled(SoilBed(CLAY, 0.02), 0.0215, 1.0)
    loads = [np.mean([t.force[2] for t in touches]) for touches in (first, second, fresh, deeper)]
    gain, plain = loads[3] - loads[1], loads[2] - loads[0]
    assert gain > 2.5 * plain


def test_damping_raises_pressure_ahead() -> None:
    with_r, without = (rolled(SoilBed(CLAY, 0.02, damping=d), 0.02, 0.6) for d in (True, False))
    assert np.mean([t.force[2] for t in with_r]) > 1.1 * np.mean([t.force[2] for t in without])


def test_memory_grows_with_the_rut_only() -> None:
    bed = SoilBed(CLAY, 0.03)
    rolled(bed, 0.02, 6.0)
    one = bed.grid.tiles
    bed.touch((1e5, -2e5, RADIUS - 0.02))
    assert bed.grid.tiles - one < 10
    assert bed.grid.memory / 6.0 < 40e3


def test_tiles_are_found_again() -> None:
    rng = np.random.default_rng(0)
    grid = RutGrid(0.03)
    known = {}
    for _ in range(1000):
        place = (int(rng.integers(0, 5)), *(int(v) for v in rng.integers(-100, 100, 2)))
        key = tile_key(*place)
        grid.reserve(1)
        if place in known:
            assert find_tile(grid.keys, grid.slots, key) == known[place]
        else:
            assert find_tile(grid.keys, grid.slots, key) == -1
            known[place] = add_tile(grid.keys, grid.slots, grid.count, key)
    assert sorted(known.values()) == list(range(len(known)))


def test_footprint_is_the_convex_hull() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        low = rng.integers(0, 8, 12)
        high = low + rng.integers(-1, 8, 12)
        points = [(i, j) for i in range(12) for j in range(low[i], high[i] + 1)]
        area, perimeter = hull_area_perimeter(low, high, 0.5)
        hull = ConvexHull(np.array(points, dtype=float) * 0.5)
        assert area == pytest.approx(hull.volume)
        assert perimeter == pytest.approx(hull.area)


def test_soil_in_space() -> None:
    field = SoilField.change_at(CLAY, SAND, 3.0)
    before, after = (pressed(SoilBed(field, 0.02), 0.02, x).force[2] for x in (1.0, 5.0))
    assert before == pytest.approx(pressed(SoilBed(CLAY, 0.02), 0.02, 1.0).force[2])
    assert after == pytest.approx(pressed(SoilBed(SAND, 0.02), 0.02, 5.0).force[2])
    smooth = SoilField.along_x(lambda x: CLAY.with_(n=0.5 + 0.02 * x), 0.0, 10.0)
    middle = pressed(SoilBed(smooth, 0.02), 0.02, 5.0).force[2]
    assert middle == pytest.approx(pressed(SoilBed(CLAY.with_(n=0.6), 0.02), 0.02, 5.0).force[2], rel=0.03)
    with pytest.raises(ValueError, match="shape"):
        SoilField(np.zeros((3, 1, 1, 8)))


def test_rig_carries_its_load_and_steers() -> None:
    run = RigRun(SANDY_LOAM, load=2500.0, slip=0.1, speed=5.0, amplitude=0.35, frequency=1.0)
    t, values = run_rig(run, 2.6)
    kept = values[t > 1.0]
    assert np.mean(kept[:, 4]) == pytest.approx(2500.0 + 18.8 * 9.8, rel=0.02)
    assert np.corrcoef(kept[:, 0], kept[:, 3])[0, 1] > 0.8
    with pytest.raises(ValueError, match="slip"):
        RigRun(SANDY_LOAM, 2500.0, 1.2, 5.0, 0.35, 1.0)


def test_compiled_kernels_belong_to_these_sources() -> None:
    # numba does not see edits in the files that a kernel calls into: the cache is keyed by all of them.
    folder = os.environ.get("NUMBA_CACHE_DIR") or kernel.source_hash()
    assert folder in str(kernel.kernel_cache())
    run_rig(RigRun(SANDY_LOAM, load=2500.0, slip=0.1, speed=5.0, amplitude=0.35, frequency=1.0), 0.1)
    assert any(kernel.kernel_cache().rglob("*.nbi")), "kernels are not cached where they should be"
    assert str(kernel.kernel_cache()) != config.CACHE_DIR or os.environ.get("NUMBA_CACHE_DIR")
