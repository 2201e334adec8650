"""Signals, soils and vehicles: what is declared is checked where it is declared."""

import math

import numpy as np
import pytest

from drives import PROJECT, reference_vehicle
from softsoil.codegen.idle import idle_numbers
from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration
from softsoil.symbolic.bicycle import vehicle_law
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.laws.bekker import Bekker
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.signals import Layout, Signal
from softsoil.symbolic.soil import CLAY, SOILS, load_soil
from softsoil.symbolic.vehicle import NUMBERS, load_vehicle

LAYOUT = Layout.of(Signal("a", "m", "length", 1.0, 0.0, 2.0), Signal("b", "rad", "angle"))


@pytest.mark.parametrize("name", ["", "1a", "a b", "ä", "a-b", "_a", "a\n"])
def test_signal_name_is_an_identifier(name):
    with pytest.raises(ValueError, match="expected a C identifier"):
        Signal(name, "m", "")


@pytest.mark.parametrize("bounds", [(2.0, 1.0), (-math.inf, 0.5), (math.nan, 2.0)])
def test_signal_bounds_hold_its_nominal_value(bounds):
    with pytest.raises(ValueError, match="expected lower <= nominal <= upper"):
        Signal("a", "m", "", 1.0, *bounds)


def test_layout_packs_by_name():
    assert np.array_equal(LAYOUT.pack(b=3.0), [1.0, 3.0])
    assert LAYOUT["b"].unit == "rad" and "b" in LAYOUT and LAYOUT.without("a").names == ("b",)
    assert LAYOUT.with_nominal(a=2.0).nominal[0] == 2.0


def test_layout_faults_are_named():
    with pytest.raises(ValueError, match="distinct names, found 'a' twice"):
        Layout.of(Signal("a", "m", ""), Signal("a", "m", ""))
    with pytest.raises(KeyError, match="expected one of a, b; found 'c'"):
        LAYOUT.pack(c=1.0)
    with pytest.raises(KeyError, match="'c'"):
        LAYOUT.without("c")


def test_built_in_soils_load_by_name():
    for name, soil in SOILS.items():
        assert load_soil(name) is soil and soil.name == name


def soil_text(**changes):
    values = {**CLAY.parameters(), **changes}
    return "".join(f"{key} = {value}\n" for key, value in values.items() if value is not None)


def test_soil_from_toml(tmp_path):
    path = tmp_path / "marsh.toml"
    path.write_text(soil_text(K=None, R=None, n=0.8), encoding="utf-8")
    soil = load_soil(path)
    assert soil.name == "marsh" and soil.n == 0.8 and soil.K == 2e8 and soil.R == 3e4


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"n": None}, "expected key 'n'"),
        ({"n": 5.0}, r"expected n in \[0.2, 1.6\]"),
        ({"phi": 13.0}, r"degrees\?"),
        ({"c": '"soft"'}, "key 'c': expected a finite number, found 'soft'"),
        ({"k": "true"}, "key 'k': expected a finite number"),
        ({"k_phi": "nan"}, "key 'k_phi': expected a finite number"),
        ({"depth": 1.0}, "found 'depth'"),
        ({"n": "0.5 0.6"}, "expected TOML"),
    ],
)
def test_soil_faults_name_file_and_key(tmp_path, changes, words):
    path = tmp_path / "marsh.toml"
    path.write_text(soil_text(**changes), encoding="utf-8")
    with pytest.raises(ValueError, match=words) as fault:
        load_soil(path)
    assert "marsh.toml" in str(fault.value)


def test_soil_that_is_nowhere_is_named():
    with pytest.raises(ValueError, match="expected one of clay, sandy_loam, sand or a TOML file, found 'mud'"):
        load_soil("mud")


def vehicle_text(**changes):
    keys = ["name", *(number.name for number in NUMBERS)]
    values = {key: getattr(reference_vehicle(), key) for key in keys} | changes
    quoted = {key: f'"{value}"' if key == "name" else value for key, value in values.items()}
    return "".join(f"{key} = {value}\n" for key, value in quoted.items() if value is not None)


def test_vehicle_round_trip_and_declared_effects(tmp_path):
    path = tmp_path / "car.toml"
    path.write_text(vehicle_text() + "[effects.payload]\npayload_mass = 200.0\n", encoding="utf-8")
    vehicle = load_vehicle(path)
    assert vehicle.effects == {"payload": {"payload_mass": 200.0}}
    assert vehicle.with_(effects={}) == reference_vehicle().with_(effects={}, simulator={}, driveline={}, uncertainty={})
    assert vehicle.wheelbase == pytest.approx(2.721)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mass": None, "h_cg": None}, r"expected keys mass \(kg: mass\); h_cg \(m: .*found none of these"),
        ({"mass": -5.0}, "expected mass in"),
        ({"radius": '"big"'}, "key 'radius': expected a finite number"),
        ({"colour": 3}, "found 'colour'"),
        ({"effects": 3}, "expected .effects.<name>. tables"),
        ({"unexplained": 3}, "expected a table .unexplained. of numbers"),
        ({"unexplained": "{omega_z = 1.5}"}, "unexplained.omega_z: expected 0 to 1, found 1.5"),
        ({"unexplained": "{psi = 0.5}"}, "unexplained: expected keys v, omega_z; found 'psi'"),
    ],
)
def test_vehicle_faults_name_file_and_key(tmp_path, changes, words):
    path = tmp_path / "car.toml"
    path.write_text(vehicle_text(**changes), encoding="utf-8")
    with pytest.raises(ValueError, match=words) as fault:
        load_vehicle(path)
    assert "car.toml" in str(fault.value)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("[effects.wings]\nspan = 3.0\n", "car.toml: effects: expected names of .*found 'wings'"),
        ("[effects.payload]\nmass = 200.0\n", "car.toml: effects.payload: expected parameters payload_mass.*found 'mass'"),
        ("[effects.payload]\npayload_mass = -2\n", r"payload.payload_mass: expected a number in \[0, 3000\] kg, found -2"),
        ("[simulator]\nstep = 0.002\n", "car.toml: simulator: expected keys contact_step.*found 'step'"),
        ("[simulator]\ncontact_step = 2.0\n", "simulator.contact_step: expected 0 to 0.1, found 2"),
    ],
)
def test_unknown_effects_and_options_name_file_and_key(tmp_path, table, words):
    path = tmp_path / "car.toml"
    path.write_text(vehicle_text() + table, encoding="utf-8")
    with pytest.raises(ValueError, match=words):
        bicycle(load_vehicle(path), CLAY)


def test_a_byte_order_mark_is_no_fault(tmp_path):
    path = tmp_path / "car.toml"
    path.write_text(vehicle_text(), encoding="utf-8-sig")
    assert load_vehicle(path).mass == reference_vehicle().mass


def test_a_declaration_reads_back_as_it_was_written(tmp_path):
    declared, path = Declaration(reference_vehicle(), CLAY), tmp_path / "model.toml"
    path.write_text(declaration_toml(declared, ("a note",)), encoding="utf-8")
    assert load_declaration(path) == declared


def test_a_users_vehicle_is_on_real_soil_and_a_simulated_one_says_so():
    vehicle = reference_vehicle()
    assert vehicle_law(vehicle.with_(simulator={}), "turn_slip") == TurnSlip() and TurnSlip().contact_step == 0.0
    step = vehicle.simulator["contact_step"]
    assert vehicle_law(vehicle, "turn_slip").contact_step == step == 0.002
    assert vehicle_law(vehicle, "turn_slip_calibrated").base.contact_step == step
    assert vehicle_law(vehicle, "bekker") == Bekker()


def test_numbers_that_do_nothing_are_named():
    vehicle = reference_vehicle()
    assert idle_numbers(Declaration(vehicle, CLAY)) == ()
    bare = idle_numbers(Declaration(vehicle.with_(effects={}), CLAY))
    assert {"scrub", "toe", "ackermann", "track_rear", "roll_gain"} <= set(bare) and "load_offset" not in bare


def test_every_number_says_how_it_is_measured_and_how_well():
    for number in NUMBERS:
        assert number.measured and number.doc and number.unit and number.prior(1.0) > 0, number.name


def test_vehicle_that_is_nowhere_is_named(tmp_path):
    with pytest.raises(ValueError, match="found none"):
        load_vehicle(tmp_path / "none.toml")
    with pytest.raises(ValueError, match="found a folder"):
        load_vehicle(PROJECT)
