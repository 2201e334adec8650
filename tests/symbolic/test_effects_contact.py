"""Where the soil's stresses act: the plant's own aligning moments, axle loads and pitch."""

import numpy as np
import pytest
from scipy.signal import savgol_filter

from softsoil.codegen.predictor import Predictor
from softsoil.mpc_demo.blind_test import PLANT_VEHICLE
from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.manoeuvres import Manoeuvre, MultiSine, Speed
from softsoil.plant.simulate import recording_of
from softsoil.plant.start import Start
from softsoil.plant.world import Plant
from softsoil.recording.drive import Recording
from softsoil.recording.states import measured_states
from softsoil.symbolic.catalogue import bicycle, catalogue
from softsoil.symbolic.effect import Corner, add_effect
from softsoil.symbolic.model import Model
from softsoil.symbolic.soil import CLAY, SANDY_LOAM, Soil
from softsoil.symbolic.vehicle import load_vehicle
from softsoil.symbolic.wheel import Contact
from softsoil.windows.inputs import measured_inputs

START = 200
"""Rows left out at the beginning."""
REST = 0.0096
"""rad: how far the plant's body leans back at rest on hard ground, where l_f and l_r are measured."""


@pytest.fixture(scope="module")
def vehicle():
    return load_vehicle(PLANT_VEHICLE)


@pytest.fixture(scope="module", params=[CLAY.with_(n=0.65), SANDY_LOAM.with_(n=0.6)], ids=lambda soil: soil.name)
def turns(request) -> tuple[Soil, Recording, np.ndarray]:
    """Soil, a turning drive of the plant, and the soil's moment about each wheel's vertical, (N, 4) N m."""
    soil = request.param
    plant, rows, moments = Plant(soil, start=Start(u=5.0)), [], []
    driver, seen = Manoeuvre("turns", MultiSine(seed=4), Speed(5.0, 1.0, 9.0)), plant.sample()
    within = np.arange(6) * plant.dt
    for _ in range(1666):
        plant.advance(np.ascontiguousarray(driver(plant.time + within, seen)))
        seen = plant.sample()
        rows.append(seen.row.copy())
        moments.append(plant.info[:, 5].copy())
    return soil, recording_of(np.array(rows), "turns"), np.array(moments)


@pytest.fixture(scope="module")
def drive(turns) -> tuple[Soil, Recording]:
    return turns[:2]


def along(model: Model, drive: Recording, *names: str) -> np.ndarray:
    """(len(names), N) quantities of the model on the recorded states, smoothed, without the start."""
    states, (inputs, _) = measured_states(drive), measured_inputs(drive, model.external)
    _, full = Predictor(model, drive.dt).track_memory(states, inputs, model.p.nominal)
    found = model.probe(*names).map(len(states))(states.T, full.T, model.p.nominal).full()
    return savgol_filter(found, 21, 2, axis=1)[:, START:]


def test_the_aligning_moment_is_the_plants_own(vehicle, turns):
    """What the soil turns all wheels back with: the law's moments at the plant's motion, nothing fitted."""
    soil, log, moments = turns
    model = bicycle(vehicle, soil)
    model = model.correct("balance", lambda q: {"aligning": sum(w.count * w.force.m_z for w in q["wheels"])})
    told = along(model, log, "aligning")[0]
    true = savgol_filter(moments.sum(axis=1), 21, 2)[START:]
    assert told @ true / (true @ true) == pytest.approx(1.0, abs=0.1)
    assert np.std(told - true) < 0.4 * np.std(true)


def test_the_declared_vehicle_is_the_plants_bodies(vehicle):
    """Mass and yaw inertia of all bodies together."""
    machine = load_plant_vehicle().machine
    mass = np.r_[machine.sprung_mass, machine.unsprung_mass]
    place = np.vstack([np.zeros(2), machine.paths[:, :2, 0, 0]])
    place -= mass @ place / mass.sum()
    inertia = machine.sprung_inertia[2, 2] + mass @ (place**2).sum(axis=1)
    assert vehicle.mass == pytest.approx(mass.sum(), rel=1e-3)
    assert vehicle.yaw_inertia == pytest.approx(inertia, rel=0.005)


def test_the_shares_scale_what_the_yaw_balance_gets(vehicle):
    bare = bicycle(vehicle.with_(effects={}), CLAY)
    x = bare.x.pack(u=5.0, v=0.2, omega_z=0.3)
    u = bare.u.pack(steer=0.2, omega_fl=15.0, omega_fr=15.5, omega_rl=15, omega_rr=15)
    moments = []
    for front, rear in ((0.0, 0.0), (0.5, 0.0), (0.0, 1.0)):
        model = add_effect(bare, catalogue(vehicle)["aligning_moment"], {"aligning_f": front, "aligning_r": rear})
        model = model.correct("forces", lambda q: {f"of_{w.axle}": w.count * w.force.m_z for w in q["wheels"]})
        moment, of_front, of_rear = model.probe("moment_z", "of_f", "of_r")(x, u, model.p.nominal).full()[:, 0]
        moments.append(moment - front * of_front - rear * of_rear)
        assert min(abs(of_front), abs(of_rear)) > 5.0
    plain = bare.probe("moment_z")(x, u, bare.p.nominal).full()[0, 0]
    assert moments == pytest.approx([plain] * 3, rel=1e-12)


def test_the_centre_of_pressure_gives_the_plants_axle_loads(vehicle, drive):
    """The mean front load within 0.3 % on both soils, and its swing; without it 2 to 5 % too much."""
    soil, log = drive
    true = savgol_filter(log.truth["true_fz_fl"] + log.truth["true_fz_fr"], 21, 2)[START:]
    told = along(bicycle(vehicle, soil), log, "load_f")[0]
    without = {name: values for name, values in vehicle.effects.items() if name != "pressure_offset"}
    plain = along(bicycle(vehicle.with_(effects=without), soil), log, "load_f")[0]
    assert told.mean() == pytest.approx(true.mean(), rel=0.003)
    assert plain.mean() > 1.015 * true.mean()
    assert np.corrcoef(told, true)[0, 1] > 0.95


def test_the_body_leans_back_as_the_plants_does(vehicle, drive):
    """The rear axle's place: as far behind the centre of gravity as the plant's is, from what both are at rest."""
    soil, log = drive
    model = bicycle(vehicle, soil)
    model = model.correct("forces", lambda q: {"pitch": q["ground_pitch"] + vehicle.pitch_gain * q["pressure_moment"]})
    pitch, l_f, l_r = along(model, log, "pitch", "l_f", "l_r")
    nose_up = -(savgol_filter(log.truth["true_pitch"], 21, 2)[START:])
    assert (pitch + REST).mean() == pytest.approx(nose_up.mean(), abs=1.5e-3)
    assert vehicle.l_r - l_r == pytest.approx((vehicle.h_cg - vehicle.radius) * pitch, rel=1e-9)
    assert l_f + l_r == pytest.approx(vehicle.wheelbase, rel=1e-12)


def test_a_share_of_pressure_offset_moves_load_and_loses_none(vehicle):
    model = bicycle(vehicle, CLAY)
    x = model.x.pack(u=5.0)
    u = model.u.pack(omega_fl=15.2, omega_fr=15.2, omega_rl=15.2, omega_rr=15.2, pressure_moment=800.0)
    front, rear = model.probe("load_f", "load_r")(x, u, model.p.nominal).full()[:, 0]
    plain = add_effect(bicycle(vehicle.with_(effects={}), CLAY), catalogue(vehicle)["pressure_offset"])
    p = plain.p.nominal
    p[plain.p.index("pressure_share")] = 0.0
    static, _ = plain.probe("load_f", "load_r")(x[: len(plain.x)], plain.u.pack(pressure_moment=800.0), p).full()[:, 0]
    assert front + rear == pytest.approx(vehicle.mass * 9.81, rel=1e-3)
    back = (vehicle.h_cg - vehicle.radius) * vehicle.pitch_gain * 800.0
    moved = (800.0 + vehicle.mass * 9.81 * back) / vehicle.wheelbase
    assert static - front == pytest.approx(moved, rel=1e-4)


def test_the_centre_of_pressure_takes_the_place_of_a_declared_offset(vehicle):
    """All of its share: the declared offset no longer counts; none of it: it stands."""
    loads = {}
    for offset in (0.0, 0.05):
        for share in (0.0, 1.0):
            bare = bicycle(vehicle.with_(effects={}, load_offset=offset), CLAY)
            model = add_effect(bare, catalogue(vehicle)["pressure_offset"], {"pressure_share": share})
            u = model.u.pack(pressure_moment=800.0)
            loads[offset, share] = model.probe("load_f")(model.x.pack(u=5.0), u, model.p.nominal).full()[0, 0]
    assert loads[0.05, 1.0] == pytest.approx(loads[0.0, 1.0], rel=1e-12)
    assert loads[0.0, 0.0] - loads[0.05, 0.0] == pytest.approx(vehicle.mass * 9.81 * 0.05 / vehicle.wheelbase, rel=1e-9)


@pytest.mark.parametrize("slip", (-0.5, -0.1, 0.05, 0.3, 0.9))
def test_a_wheel_digs_itself_in_by_its_slip(slip):
    """|s| over the faster of rim and travel, as the law's own."""
    (correction,) = catalogue(load_vehicle("reference"))["slip_sinkage"].corrections.values()
    speed, radius = 5.0, 0.33
    omega = speed / (radius * (1.0 - slip)) if slip > 0 else speed * (1.0 + slip) / radius
    contact = Contact(v_x=speed, v_y=0.0, omega=omega, load=3000.0)
    corner = Corner("f", 0, 2, 0.0, 3000.0, 0.0, omega, soil=CLAY, contact=contact)
    (found,) = correction.compute({"radius": radius, "slip_sinkage": 1.0, "wheels": (corner,)})["wheels"]
    assert float(found.soil.k_phi / CLAY.k_phi) ** (-1.0 / CLAY.n) - 1.0 == pytest.approx(abs(slip), rel=0.02)
