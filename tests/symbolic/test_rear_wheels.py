"""Rear wheels of another size than the front ones: each axle meets the soil with its own, wherever a radius or width counts."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.checking.cross_check import check_channels
from softsoil.checking.geometry_check import beyond_doubt
from softsoil.control.ocp import Ocp, half_width
from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration
from softsoil.mpc_demo.synthetic import synthetic_drive
from softsoil.recording.derive import completed
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.geometry import radius_of
from softsoil.recording.noise import add_noise
from softsoil.refinement.known_vehicle import known_from_table
from softsoil.refinement.vehicle_numbers import vehicle_of
from softsoil.refinement.wheel_speeds import differential_shares
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.soil import CLAY

ONE = reference_vehicle().with_(uncertainty={}, joint_error=None)
LARGE, WIDE = 1.2 * ONE.radius, 1.4 * ONE.width
TWO = ONE.with_(radius_rear=LARGE, width_rear=WIDE)
STATE = [0.0, 0.0, 0.0, 5.0, 0.1, 0.3]


def rolled(vehicle, q):
    """Inputs of a weave in which every wheel slips alike, 5 %."""
    spin = {name: STATE[3] / (0.95 * radius_of(vehicle, name)) for name in WHEEL_CHANNELS}
    given = {"steer": 0.12, "steer_rate": 0.2, "a_x": 0.3, **spin}
    return [given.get(name, 0.0) for name in q.names]


def forces(vehicle, like=None, free=Layout()):  # noqa: B008
    """Wheel -> (F_x, F_y, sinkage) on clay, of a vehicle without effects beside load transfer, moving as the one that it is like.

    free: numbers that are parameters, with the values of that one.
    """
    like = like or vehicle
    effects = {"load_transfer": vehicle.effects["load_transfer"]}
    model = bicycle(vehicle, CLAY, "turn_slip", effects, free)

    def see(q):
        return {f"{what}_{w.name}": getattr(w.force, what) for w in q["wheels"] for what in ("f_x", "f_y", "sinkage")}

    names = [f"{what}_{c}" for c in ("fl", "fr", "rl", "rr") for what in ("f_x", "f_y", "sinkage")]
    probe = model.correct("forces", see).probe(*names)
    values = {name: getattr(like, name) for name in free.names}
    found = np.array(probe(STATE, rolled(like, model.u), model.p.pack(**values))).reshape(4, 3)
    return dict(zip(("fl", "fr", "rl", "rr"), found, strict=True))


def test_each_axle_has_the_forces_of_its_wheels():
    small, large, two = forces(ONE), forces(ONE.with_(radius=LARGE, width=WIDE)), forces(TWO)
    for wheel in ("fl", "fr"):
        np.testing.assert_allclose(two[wheel], small[wheel], rtol=1e-9)
    for wheel in ("rl", "rr"):
        np.testing.assert_allclose(two[wheel], large[wheel], rtol=1e-9)
        assert two[wheel][2] < 0.9 * small[wheel][2]


def test_a_radius_that_is_free_moves_both_axles():
    free = Layout.of(Signal("radius", "m", "of the wheels", ONE.radius, 0.005, 5.0))
    grown = TWO.with_(radius=1.1 * ONE.radius, radius_rear=1.1 * LARGE)
    found = forces(TWO, grown, free)
    for wheel, values in forces(grown).items():
        np.testing.assert_allclose(found[wheel], values, rtol=1e-9)


@pytest.mark.parametrize(("share", "most"), [(1.0, 1.0), (1.4, 1.0 / 1.4), (0.7, 1.0)])
@pytest.mark.parametrize("aside", [0.0, 0.08, 0.3])
def test_a_rear_wheel_runs_in_the_rut_with_the_part_that_fits(share, most, aside):
    """Two rectangles, one beside the other: the share of the rear one that lies in the front one."""
    vehicle = ONE.with_(width_rear=share * ONE.width, effects={"multipass": {"kappa": 1.0, "sheared": 1.0}})
    model = bicycle(vehicle, CLAY)
    probe = model.correct("contacts", lambda q: {"overlap": next(w for w in q["wheels"] if w.axle == "r").contact.overlap})
    ruts = {"rut_offset_l": aside, "rut_offset_r": aside, "rut_path_l": 0.0, "rut_path_r": 0.0}
    given = dict(zip(model.u.names, rolled(vehicle, model.u), strict=True)) | ruts
    found = float(probe.probe("overlap")(STATE, [given[name] for name in model.u.names], model.p.nominal))
    fits = (0.5 * (vehicle.width + vehicle.width_rear) - aside) / vehicle.width_rear
    assert found == pytest.approx(np.clip(fits, 0.0, most), abs=0.02)


def test_checks_and_derived_wheels_know_both_sizes():
    model = bicycle(TWO, CLAY)
    drive = add_noise(synthetic_drive(model, TWO.radius, seconds=20.0, speed=5.5), "good", 1)
    assert not [check.name for check in check_channels(drive, TWO) if not check.passed and "wheel" in check.name]
    assert any(check.name == "wheel_omega_rl" and not check.passed for check in check_channels(drive, ONE))
    assert beyond_doubt(drive, TWO) == "" and "expected wheels of radius" in beyond_doubt(drive, ONE.with_(radius=0.5 * LARGE))
    left = {name: values for name, values in drive.channels.items() if name not in WHEEL_CHANNELS}
    spins = completed(replace(drive, channels=left), TWO)
    assert np.median(spins["omega_fl"] / spins["omega_rl"]) == pytest.approx(1.2, rel=0.04)  # steered wheels go farther
    turning = differential_shares(drive.with_channels(omega_rr=drive["omega_rl"] + drive["omega_z"]), TWO)
    assert turning["rear"] == pytest.approx(LARGE / TWO.rear_track, rel=0.05)


def test_a_controller_turns_the_rims_of_both_axles_alike():
    ocp = Ocp(bicycle(TWO, CLAY), TWO)
    z, w, _, s = ocp.symbols()
    names = ocp.model.external.names
    inputs = ca.Function("inputs", [z, w, s], [ocp.external(z, w, s)])
    found = dict(zip(names, np.array(inputs(ocp.z.pack({"u": 5.0}), [0.0, 0.0], ocp.s.nominal)).ravel(), strict=True))
    assert found["omega_fl"] / found["omega_rl"] == pytest.approx(1.2, rel=1e-9)
    assert half_width(TWO) == pytest.approx(0.5 * max(TWO.track + TWO.width, TWO.rear_track + WIDE))


def test_files_keep_both_sizes_and_an_identified_radius_keeps_their_ratio(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(declaration_toml(Declaration(TWO, CLAY)), encoding="utf-8")
    again = load_declaration(path).vehicle
    assert (again.rear_radius, again.rear_width) == (TWO.radius_rear, TWO.width_rear)
    numbers = ("mass", "l_f", "l_r", "track", "radius", "width", "radius_rear", "width_rear")
    known = known_from_table({name: getattr(TWO, name) for name in numbers}, "known", "two")
    made = vehicle_of(known, {"radius": 1.01 * TWO.radius})
    assert made.radius_rear == pytest.approx(1.01 * LARGE) and made.rear_width == WIDE
    assert TWO.moved(radius=1.01 * TWO.radius).radius_rear == made.radius_rear and TWO.moved(track=1.3).radius_rear == LARGE
    single = known_from_table({name: getattr(TWO, name) for name in numbers[:6]}, "known", "one")
    assert vehicle_of(single, {}).rear_radius == ONE.radius
