"""Leaning wheels: the law against the plant's soil, and the declared numbers against the plant's suspension."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
import scipy.integrate

from axles import axle_of
from benchmarks.judges.plant_vehicles import swing_of
from softsoil.mpc_demo.blind_test import PLANT_VEHICLE
from softsoil.plant.bed import SoilBed
from softsoil.plant.effects import Effects
from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Sine, Speed
from softsoil.plant.start import Start
from softsoil.plant.state import PITMAN, TRAVEL, rotation
from softsoil.plant.world import Plant
from softsoil.recording.rig import RIG_PATCH
from softsoil.symbolic.bicycle import Corner
from softsoil.symbolic.body_roll import GYRATION, body_roll
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.effect import add_effect
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.soil import CLAY, SANDY_LOAM
from softsoil.symbolic.vehicle import GRAVITY, load_vehicle
from softsoil.symbolic.wheel import Contact, Wheel, WheelForce

WHEEL = Wheel(0.330229, 0.2121)
SPEED, SPIN, LOAD = 5.0, 15.6, 3000.0
STEP, SPACING = 1e-3, 0.015


def on_the_plants_soil(soil, angle: float, lean: float) -> float:
    """Side force (N) along the ground across the wheel of one that rolls straight at a slip angle, leaning; settled mean."""
    bed, found, x, z, rise = SoilBed(soil, SPACING), [], 0.0, WHEEL.radius, 0.0
    axis = np.array([-np.sin(angle) * np.cos(lean), np.cos(angle) * np.cos(lean), np.sin(lean)])
    for _ in range(1000):
        touch = bed.touch((x, 0.0, z), axis=axis, velocity=(SPEED, 0.0, rise), rate=SPIN * axis, dt=STEP)
        rise = 0.98 * (rise + STEP * (touch.force[2] * GRAVITY / LOAD - GRAVITY))  # its bounce dies out
        x, z = x + STEP * SPEED, z + STEP * rise
        found.append(-touch.force[0] * np.sin(angle) + touch.force[1] * np.cos(angle))
    return float(np.mean(found[400:]))


def by_the_law(soil, angle: float, lean: float) -> float:
    contact = Contact(
        v_x=SPEED * np.cos(angle), v_y=-SPEED * np.sin(angle), omega=SPIN, load=LOAD, sweep=SPIN * np.sin(lean)
    )
    return float(ca.DM(TurnSlip(contact_step=STEP, patch_length=RIG_PATCH)(soil, WHEEL, contact).f_y))


@pytest.mark.parametrize("soil", [CLAY.with_(n=0.6), SANDY_LOAM.with_(n=0.7)], ids=lambda soil: soil.name)
@pytest.mark.parametrize("angle", [0.03, 0.1])
def test_a_leaning_wheels_rim_sweeps_as_a_yawing_ones_does(soil, angle):
    """What a lean of 0.06 to either side changes of the side force on the plant's soil, the law says without any fit."""
    true = on_the_plants_soil(soil, angle, 0.06) - on_the_plants_soil(soil, angle, -0.06)
    law = by_the_law(soil, angle, 0.06) - by_the_law(soil, angle, -0.06)
    assert abs(true) > 0.03 * LOAD * np.tan(soil.phi)
    assert law == pytest.approx(true, rel=0.25)


def test_the_declared_lean_with_the_steering_is_what_the_hardpoints_do():
    axles = np.array([[axle_of(wheel, 0.0, angle) for wheel in (0, 1)] for angle in np.linspace(-0.4, 0.4, 9)]).mean(
        axis=1
    )
    slope = np.polyfit(np.arctan2(-axles[:, 0], axles[:, 1]), axles[:, 2], 1)[0]
    assert load_vehicle(PLANT_VEHICLE).effects["wheel_lean"]["lean_steer"] == pytest.approx(slope, rel=0.05)


def test_the_declared_swing_of_the_trailing_arms_is_what_the_hardpoints_do():
    front, _, left, right = (swing_of(load_plant_vehicle(), wheel) for wheel in range(4))
    assert load_vehicle(PLANT_VEHICLE).swing_rear == pytest.approx(left, rel=0.02)
    assert left == pytest.approx(right) and abs(front) < 0.06  # wishbones in front


@pytest.fixture(scope="module")
def turning():
    """(N, 6) of a turning drive: lean of the front wheels less the steering's part, the rear wheels' lean, how far left of the
    centre of gravity the rear contacts stand (m), the rear wheels' lateral velocity in their own frames beyond v - l_r omega_z
    (m/s), the speed, and the roll; the rear wheels' mean toe (rad)."""
    plant, rows, toes, turn = Plant(CLAY.with_(n=0.6), start=Start(u=5.0)), list[list[float]](), [], np.empty((3, 3))
    driver, seen, within = (
        Manoeuvre("turns", MultiSine(seed=5), Speed(5.5, 1.2, 10.0)),
        plant.sample(),
        np.arange(6) * plant.dt,
    )
    vehicle = load_vehicle(PLANT_VEHICLE)
    by_steering = vehicle.effects["wheel_lean"]["lean_steer"]
    for step in range(1500):
        plant.advance(np.ascontiguousarray(driver(plant.time + within, seen)))
        seen = plant.sample()
        rotation(plant.state, turn)
        axles = [axle_of(wheel, plant.state[TRAVEL + wheel], plant.state[PITMAN]) for wheel in range(4)]
        front, rear = np.mean(axles[:2], axis=0), np.mean(axles[2:], axis=0)
        if step > 200:
            left = np.array([-np.sin(seen["psi"]), np.cos(seen["psi"])])
            centre = plant.info[2:, 6:8].mean(axis=0) - (seen["true_x_cg"], seen["true_y_cg"])
            lean = turn[2] @ rear
            toes.append(np.subtract(*[np.arctan2(-axle[0], axle[1]) for axle in axles[2:]]))
            across = plant.info[2:, 12:14] / np.linalg.norm(plant.info[2:, 12:14], axis=1)[:, None]
            slid = np.mean(np.sum(across * plant.info[2:, 9:11], axis=1)) - (seen["v"] - vehicle.l_r * seen["omega_z"])
            aside = left @ centre + WHEEL.radius * lean
            rows.append(
                [turn[2] @ front - by_steering * seen["steer"], lean, aside, slid, seen["u"], seen["true_roll"]]
            )
    return np.array(rows), float(np.mean(toes))


@pytest.mark.parametrize(
    ("column", "effect", "name"),
    [(0, "wheel_lean", "lean_roll"), (1, "wheel_lean", "lean_rear"), (2, "load_transfer", "roll_sweep")],
)
def test_what_is_declared_to_go_with_the_roll_is_what_the_plant_does(turning, column, effect, name):
    slope = np.polyfit(turning[0][:, 5], turning[0][:, column], 1)[0]
    assert load_vehicle(PLANT_VEHICLE).effects[effect][name] == pytest.approx(slope, rel=0.15)


def test_the_rear_wheels_steer_with_the_roll_as_declared(turning):
    """What they slide sideways beyond the vehicle's motion, with roll times speed; their centres swing with the roll's rate."""
    _, _, _, slid, u, roll = turning[0].T
    columns = np.stack([roll * u, np.gradient(roll, 0.012), u, np.ones(len(u))], axis=1)
    slope = np.linalg.lstsq(columns, slid, rcond=None)[0][0]
    assert load_vehicle(PLANT_VEHICLE).effects["wheel_lean"]["steer_rear"] == pytest.approx(-slope, rel=0.15)


def test_the_declared_rear_toe_is_what_the_plants_wheels_have(turning):
    assert load_vehicle(PLANT_VEHICLE).toe_rear == pytest.approx(turning[1], rel=0.2)


@pytest.fixture(scope="module")
def bare():
    return bicycle(load_vehicle(PLANT_VEHICLE).with_(effects={}), CLAY)


def test_the_rear_toe_goes_with_the_load_as_declared():
    """Driving straight with a load and without: the hardpoints' toe at the suspension's travel, per what the axle bears."""
    vehicle, toes, loads = load_vehicle(PLANT_VEHICLE), [], []
    for payload in (0.0, 350.0):
        plant = Plant(CLAY.with_(n=0.6), start=Start(u=5.0), effects=Effects(payload=payload, payload_at=(-2.4, 0.0, 0.9)))
        seen, within, rows = plant.sample(), np.arange(6) * plant.dt, []
        for _ in range(500):
            plant.advance(np.ascontiguousarray(Manoeuvre("straight", Sine(0.0), Speed(5.0))(plant.time + within, seen)))
            seen = plant.sample()
            left, right = (axle_of(wheel, plant.state[TRAVEL + wheel], plant.state[PITMAN]) for wheel in (2, 3))
            rows.append([np.arctan2(-left[0], left[1]) - np.arctan2(-right[0], right[1]), *plant.info[2:, 2]])
        toe, *load = np.mean(rows[300:], axis=0)
        toes.append(toe)
        loads.append(sum(load))
    at_rest = vehicle.mass * 9.81 * vehicle.l_f / vehicle.wheelbase
    declared = [vehicle.toe_rear + vehicle.toe_rear_load * (load - at_rest) for load in loads]
    assert declared == pytest.approx(toes, abs=8e-4)


def test_lean_turns_and_sweeps_the_contacts_of_the_front_wheels(bare):
    effect = catalogue(load_vehicle(PLANT_VEHICLE))["wheel_lean"]
    model = add_effect(bare, effect, {"lean_steer": -0.15, "lean_roll": 0.8, "lean_rear": 0.0, "steer_rear": 0.0})

    def seen(model):
        def contacts(q):
            return {f"{key}_{w.axle}": getattr(w.contact, key) for w in q["wheels"] for key in ("sweep", "v_y")}

        return model.correct("contacts", contacts).probe("sweep_f", "v_y_f", "sweep_r", "v_y_r")

    x = bare.x.pack(u=5.0)
    signals = {"steer": 0.2, "steer_rate": 0.4, "omega_fl": 15.0, "omega_fr": 15.0, "omega_rl": 15.0, "omega_rr": 15.0}
    before = seen(bare)(x, bare.u.pack(**signals), bare.p.nominal).full()[:, 0]
    u = model.u.pack(**signals, roll_a=1.5, roll_a_rate=2.0, roll_tilt=0.01, roll_tilt_rate=0.02)
    turned, swept, *rear = seen(model)(x, u, model.p.nominal).full()[:, 0] - before
    gain = load_vehicle(PLANT_VEHICLE).roll_gain
    assert turned == pytest.approx(15.0 * (0.8 * (gain * 1.5 + 0.01) - 0.15 * 0.2))
    assert swept == pytest.approx(WHEEL.radius * (0.8 * (gain * 2.0 + 0.02) - 0.15 * 0.4))
    assert rear == [0.0, 0.0]


def test_a_moment_on_the_body_leans_all_wheels_and_steers_the_rear_ones():
    """By a_m = moment/(M h_cg); a vehicle that declares no height of its centre of gravity still gets numbers."""
    vehicle = load_vehicle(PLANT_VEHICLE)
    values = {"lean_steer": -0.15, "lean_roll": 0.8, "lean_rear": 0.9, "steer_rear": 0.1}
    names = ("sweep_f", "v_y_f", "sweep_r", "v_y_r")

    def contacts(q):
        return {f"{key}_{w.axle}": getattr(w.contact, key) for w in q["wheels"] for key in ("sweep", "v_y")}

    def seen(moment, h_cg):
        model = bicycle(vehicle.with_(effects={}, h_cg=h_cg), CLAY)
        model = add_effect(model, catalogue(vehicle)["wheel_lean"], values)
        model = model.correct("vehicle", lambda q: {"body_moment": moment}).correct("contacts", contacts)
        u = model.u.pack(omega_fl=15.0, omega_fr=15.0, omega_rl=15.0, omega_rr=15.0)
        return model.probe(*names)(model.x.pack(u=5.0), u, model.p.nominal).full()[:, 0]

    roll = vehicle.roll_gain * -400.0 / (vehicle.mass * vehicle.h_cg)
    moved = seen(-400.0, vehicle.h_cg) - seen(0.0, vehicle.h_cg)
    assert moved == pytest.approx([15.0 * 0.8 * roll, 0.0, 15.0 * 0.9 * roll, -5.0 * 0.1 * roll])
    assert np.isfinite(seen(-400.0, 0.0)).all()


@pytest.mark.parametrize("gain", [0.0, 0.01, 0.03], ids=("rigid", "damped", "swinging"))
@pytest.mark.parametrize("dt", [0.002, 0.01, 0.1])
def test_the_body_follows_its_lateral_force_and_the_ground_late(gain, dt):
    """A step of force and of sinkages against I phi'' + c phi' + k phi = M h a integrated finely, and steady at the end of long
    steps, however stiff the body is."""
    memory, time, said = body_roll(), 0.08, []
    force = WheelForce(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    corner = Corner("f", 1, 1, 0.0, 0.0, 0.0, 0.0)
    wheels = [
        corner.with_(axle=axle, side=side, force=replace(force, sinkage=0.02 - 0.012 * side))
        for axle in "fr"
        for side in (1, -1)
    ]
    q = {
        "u": 5.0,
        "omega_z": 0.2,
        "mass": 2.0,
        "force_y": 6.0,
        "track": 1.2,
        "track_rear": 1.2,
        "wheels": wheels,
        "roll_time": time,
        "roll_gain": gain,
        "burden": 1.1,
        "h_cg": 0.7,
        "dt": dt,
    }
    inert = gain * 1.1 * (GYRATION * 1.2) ** 2 / 0.7  # I/k, s^2
    span = max(0.16, 10.0 * dt)
    fine = scipy.integrate.solve_ivp(
        lambda t, s: (s[1], (1.0 - s[0] - time * s[1]) / max(inert, 1e-6)), (0.0, span), (0.0, 0.0), method="Radau", rtol=1e-8
    )
    cells = memory.start(q)
    still = {"kept_roll_a_rate": 0.0, "kept_roll_tilt_rate": 0.0}
    assert cells == pytest.approx({"kept_roll_a": 1.0, "kept_roll_tilt": 0.02, **still})
    cells["kept_roll_tilt"] = 0.0
    for _ in range(round(span / dt)):
        before = cells
        cells = {key: float(value) for key, value in memory.advance({**q, "memory": cells}).items()}
        assert cells["kept_roll_a_rate"] == pytest.approx((cells["kept_roll_a"] - before["kept_roll_a"]) / dt)
        said.append(memory.read({"memory": cells}))
    way = fine.y[0, -1]
    assert [said[-1]["roll_a"], 50.0 * said[-1]["roll_tilt"]] == pytest.approx([1.0 + 2.0 * way, way], abs=max(3.0 * dt, 0.01))
    assert max(abs(one["roll_a"]) for one in said) < 4.0


def test_a_roll_moment_loads_one_side(bare):
    """To the right positive: it leaves the axles' loads and moves M/T from the left wheels to the right ones, by share."""

    def by_side(q):
        return {f"side_{side}": sum(w.load for w in q["wheels"] if w.side == side) for side in (1, -1)}

    vehicle, sides = load_vehicle(PLANT_VEHICLE), {}
    for moment in (0.0, 300.0):
        values = {"transfer_height": 0.8, "roll_sweep": 0.0, "roll_moment": moment}
        model = add_effect(bare, catalogue(vehicle)["load_transfer"], values).correct("contacts", by_side)
        u = model.u.pack(omega_fl=15.0, omega_fr=15.0, omega_rl=15.0, omega_rr=15.0)
        sides[moment] = model.probe("side_1", "side_-1")(model.x.pack(u=5.0), u, model.p.nominal).full()[:, 0]
    share = vehicle.roll_stiffness_front
    moved = 300.0 * (share / vehicle.track + (1.0 - share) / vehicle.rear_track)
    assert sides[300.0] - sides[0.0] == pytest.approx([-moved, moved], rel=1e-3)


def test_trailing_arms_roll_the_rims_on_as_the_body_rolls(bare):
    """While it rolls to the right, the right wheel travels up at half the track times the rate of roll on the springs, and its
    rim runs faster than its sensor says by swing_rear times that; the left one slower, the front ones as measured."""

    def spins(q):
        return {f"omega_{w.axle}{w.side}": w.contact.omega for w in q["wheels"]}

    vehicle = load_vehicle(PLANT_VEHICLE)
    model = add_effect(bare, catalogue(vehicle)["load_transfer"], {"transfer_height": 0.8}).correct("contacts", spins)
    u = model.u.pack(omega_fl=15.0, omega_fr=15.0, omega_rl=15.0, omega_rr=15.0, roll_a_rate=4.0)
    found = model.probe("omega_f1", "omega_f-1", "omega_r1", "omega_r-1")(model.x.pack(u=5.0), u, model.p.nominal).full()[:, 0]
    more = vehicle.swing_rear * vehicle.roll_gain * 4.0 * vehicle.rear_track / 2 / vehicle.radius
    assert found - 15.0 == pytest.approx([0.0, 0.0, -more, more], abs=1e-9)
