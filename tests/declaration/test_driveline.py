"""Wheels that turn as the balance of forces asks: the balance itself, and the speeds that a drive measured."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.codegen.discretize import advance_memory, read_memory, start_memory, step_with_memory
from softsoil.declaration.driveline import with_driveline
from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration
from softsoil.recording.drive import WHEEL_CHANNELS
from softsoil.recording.geometry import corners
from softsoil.recording.read import read_drive
from softsoil.symbolic.bicycle import body_force, nominal_bicycle, radius_of
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.model import Model, Quantities
from softsoil.symbolic.soil import CLAY
from softsoil.symbolic.vehicle import NUMBERS, vehicle_from_table
from softsoil.windows.shooting import shooting_drive

DT = 0.01
STATE = np.array([0.0, 0.0, 0.1, 5.0, 0.05, 0.2])
INPUTS = np.array([0.08, 0.0, -0.3, *4 * [15.0]])  # slower: on clay front wheels alone would dig at a steady speed
WHEELS = ("fl", "fr", "rl", "rr")
LOCKED, OPEN, FRONT, REAR = (1.0, 0.5), (0.0, 0.5), (0.0, 1.0), (0.0, 0.0)


def balanced(model: Model, centre: tuple[float, float], steps: int = 300) -> dict[str, float]:
    """Force that is missing over the weight, torques and speeds of the wheels, once the slips of a held motion have settled."""

    def see(q: Quantities) -> Quantities:
        wheels = {w.name: w for w in q["wheels"]}
        force = sum(w.count * body_force(w)[0] for w in wheels.values())
        seen = {"missing": (q["mass"] * q["specific_x"] - force) / (q["load_f"] + q["load_r"])}
        seen |= {f"torque_{c}": -w.force.m_y / radius_of(q, w) for c, w in wheels.items()}
        return seen | {f"turns_{c}": w.contact.omega for c, w in wheels.items()}

    p = model.p.pack(centre_lock=centre[0], front_drive=centre[1])
    advance, read = advance_memory(model, DT), read_memory(model)
    memory = start_memory(model)(STATE, INPUTS, p)
    for _ in range(steps):
        memory = advance(STATE, read(STATE, INPUTS, p, memory), p, memory)
    names = ["missing", *(f"{what}_{c}" for what in ("torque", "turns") for c in ("fl", "fr", "rl", "rr"))]
    values = model.correct("forces", see).probe(*names)(STATE, read(STATE, INPUTS, p, memory), p)
    return dict(zip(names, ca.DM(values).full()[:, 0], strict=True))


@pytest.mark.parametrize("centre", [LOCKED, OPEN, FRONT, REAR])
@pytest.mark.parametrize("share", [1.0, 1.2])
def test_forces_and_torques_are_in_balance_whatever_is_driven(centre, share):
    """share: radius of the rear wheels over that of the front ones, whose final drives are made for it."""
    vehicle = reference_vehicle().with_(radius_rear=share * reference_vehicle().radius)
    seen = balanced(with_driveline(bicycle(vehicle, CLAY), WHEELS), centre)
    weight = vehicle.mass * 9.81
    assert abs(seen["missing"]) < 1e-4
    for axle in "fr":
        assert seen[f"torque_{axle}l"] == pytest.approx(seen[f"torque_{axle}r"], abs=1e-4 * weight)
    front, rear = (seen[f"torque_{axle}l"] + seen[f"torque_{axle}r"] for axle in "fr")
    if centre == LOCKED:
        turns = [seen[f"turns_{axle}l"] + seen[f"turns_{axle}r"] for axle in "fr"]
        assert turns[0] == pytest.approx(share * turns[1], rel=1e-4)
    else:
        assert front == pytest.approx(centre[1] * (front + rear), abs=1e-4 * weight)


def test_an_axle_whose_wheels_are_measured_keeps_their_speeds():
    seen = balanced(with_driveline(bicycle(reference_vehicle(), CLAY), ("rl", "rr")), LOCKED)
    assert seen["turns_fl"] == seen["turns_fr"] == 15.0 and abs(seen["missing"]) < 1e-4


@pytest.mark.parametrize("absent", [("rr",), ("fl", "rr"), ("fl", "fr", "rl")])
def test_the_other_wheel_of_an_axle_has_the_torque_of_the_measured_one(absent):
    seen = balanced(with_driveline(bicycle(reference_vehicle(), CLAY), absent), LOCKED, 1000)
    weight = reference_vehicle().mass * 9.81
    assert all(seen[f"turns_{c}"] == 15.0 for c in WHEELS if c not in absent)
    for axle in {c[0] for c in absent}:
        assert seen[f"torque_{axle}l"] == pytest.approx(seen[f"torque_{axle}r"], abs=1e-4 * weight)
    assert {"fl", "fr"} - {*absent} or abs(seen["missing"]) < 1e-4


def test_where_both_wheels_of_an_axle_are_one_the_measured_one_is_taken():
    model = with_driveline(nominal_bicycle(reference_vehicle(), CLAY), ("fl", "rr"))
    seen = model.correct("forces", lambda q: {f"turns_{w.name}": w.contact.omega for w in q["wheels"]})
    p, given = model.p.nominal, [*INPUTS[:3], 99.0, 14.0, 16.0, 99.0]
    inputs = read_memory(model)(STATE, given, p, start_memory(model)(STATE, given, p))
    assert ca.DM(seen.probe("turns_f", "turns_r")(STATE, inputs, p)).full().ravel() == pytest.approx([14.0, 16.0])


def test_a_model_without_absent_wheels_is_left_as_it_is_and_no_driveline_is_added_twice():
    model = bicycle(reference_vehicle(), CLAY)
    assert with_driveline(model, ()) is model
    once = with_driveline(model, WHEELS)
    assert with_driveline(once, WHEELS) is once
    assert once.external == model.external and once.effects == model.effects


def test_the_speeds_are_those_that_the_drive_measured():
    """Along the recorded states with the true n; the log's wheels serve to compare only."""
    drive = read_drive(MULTI_LOG).between(0.0, 16.0)
    vehicle = reference_vehicle()
    model = with_driveline(bicycle(vehicle, CLAY.with_(n=0.5)), WHEELS)
    ready = shooting_drive(drive, model, 0.0)
    step, extra, p = step_with_memory(model, ready.dt), model.x.nominal[6:], model.p.nominal
    where = [model.cells.index(f"kept_slip_{name[-2:]}") for name in WHEEL_CHANNELS]
    memory = start_memory(model)(np.r_[ready.smooth[0], extra], ready.inputs[0], p)
    slips = []
    for state, inputs in zip(ready.smooth, ready.inputs, strict=True):
        slips.append(memory.full()[where, 0])
        memory = step(np.r_[state, extra], memory, inputs, p)[1]
    u, v, omega_z, steer = (drive[name] for name in ("u", "v", "omega_z", "steer"))
    for name, slip in zip(WHEEL_CHANNELS, np.array(slips).T, strict=True):
        x, y, steered = corners(vehicle)[name]
        angle = steer if steered else 0.0
        centre = (u - y * omega_z) * np.cos(angle) + (v + x * omega_z) * np.sin(angle)
        rows = slice(round(2.0 / drive.dt), None)
        measured = (drive[name] * vehicle.radius / centre - 1.0)[rows]
        assert np.corrcoef(slip[rows], measured)[0, 1] > 0.95
        assert abs(np.mean(slip[rows] - measured)) < 0.01


def test_a_vehicle_file_declares_its_driveline(tmp_path):
    vehicle = replace(reference_vehicle(), driveline={"centre_lock": 0.0, "front_drive": 1.0})
    assert with_driveline(bicycle(vehicle, CLAY), WHEELS).p["front_drive"].nominal == 1.0
    path = tmp_path / "model.toml"
    path.write_text(declaration_toml(Declaration(vehicle, CLAY)), encoding="utf-8")
    assert load_declaration(path).vehicle.driveline == vehicle.driveline


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"front": 1.0}, "expected keys centre_lock, front_drive; found 'front'"),
        ({"front_drive": 1.5}, "expected 0 to 1, found 1.5"),
    ],
)
def test_a_driveline_that_is_none_is_refused(table, words):
    numbers = {n.name: getattr(reference_vehicle(), n.name) for n in NUMBERS}
    with pytest.raises(ValueError, match=words):
        vehicle_from_table({**numbers, "driveline": table}, "car.toml", "car")
