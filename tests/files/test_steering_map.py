"""Steering maps of vehicle files: read back as written, inverted, refused where they have no inverse."""

import numpy as np
import pytest

from drives import reference_vehicle
from softsoil.declaration.model_file import Declaration, declaration_toml, load_declaration
from softsoil.files.steering_map import SteeringMap, steering_from_table
from softsoil.refinement.known_vehicle import known_from_table
from softsoil.refinement.vehicle_numbers import declared_vehicle, vehicle_of
from softsoil.symbolic.soil import CLAY

BENT = SteeringMap((-2.0, -0.5, 1.0, 3.0), (0.5, 0.2, -0.1, -0.45))


def test_angle_and_command_are_inverse_of_each_other_and_end_where_the_map_ends():
    angles = np.linspace(-0.45, 0.5, 40)
    np.testing.assert_allclose(BENT.angle_of(BENT.command_of(angles)), angles, atol=1e-12)
    assert BENT.command_of(2.0) == -2.0 and BENT.angle_of(9.0) == -0.45


def test_a_model_file_keeps_the_map(tmp_path):
    vehicle = reference_vehicle().with_(steering=BENT)
    path = tmp_path / "model.toml"
    path.write_text(declaration_toml(Declaration(vehicle, CLAY)), encoding="utf-8")
    assert load_declaration(path).vehicle.steering == BENT
    path.write_text(declaration_toml(Declaration(reference_vehicle(), CLAY)), encoding="utf-8")
    assert load_declaration(path).vehicle.steering is None


def test_an_identified_vehicle_has_the_map_that_its_owner_gave():
    numbers = {"mass": 900.0, "l_f": 1.1, "l_r": 1.0, "track": 1.1, "radius": 0.3, "width": 0.15}
    table = {"command": list(BENT.command), "angle": list(BENT.angle)}
    known = known_from_table({**numbers, "steering": table}, "known.toml", "mine")
    assert declared_vehicle(known).steering == vehicle_of(known, {"max_steer": 0.5}).steering == BENT


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"command": [0.0], "angle": [0.0]}, "two pairs"),
        ({"command": [0.0, 0.0], "angle": [0.0, 0.1]}, "increasing finite commands"),
        ({"command": [0.0, 1.0, 2.0], "angle": [0.0, 0.1, 0.1]}, "grow, or fall"),
        ({"command": [0.0, 1.0]}, "lists command and angle"),
        ({"command": [0.0, "x"], "angle": [0.0, 0.1]}, "steering.command: expected a finite number"),
        ({"command": 1.0, "angle": [0.0, 0.1]}, "expected a list of numbers"),
    ],
)
def test_a_map_without_inverse_is_refused_naming_the_file(table, said):
    with pytest.raises(ValueError, match=rf"my\.toml.*{said}"):
        steering_from_table(table, "my.toml")
