"""Which wheels are driven, from logs without wheel speeds: a drive of the plant per driveline, and n beside it."""

from dataclasses import replace

import pytest

from drives import MULTI_LOG, reference_vehicle
from softsoil.estimator.driveline_choice import DRIVELINES, choose_driveline, undeclared
from softsoil.estimator.estimate import estimate
from softsoil.plant.effects import Effects
from softsoil.plant.machine import load_plant_vehicle
from softsoil.plant.simulate import simulate
from softsoil.recording.derive import completed
from softsoil.recording.drive import WHEEL_CHANNELS, Recording
from softsoil.recording.noise import add_noise
from softsoil.recording.read import read_drive
from softsoil.symbolic.catalogue import bicycle
from softsoil.symbolic.soil import CLAY, SANDY_LOAM
from softsoil.symbolic.vehicle import load_vehicle


def without_wheels(drive: Recording) -> Recording:
    """The drive without its wheel speeds, with the noise of good sensors."""
    bare = {name: values for name, values in drive.channels.items() if name not in WHEEL_CHANNELS}
    return add_noise(Recording(drive.name, bare), "good", 3)


@pytest.mark.study
@pytest.mark.parametrize("words", DRIVELINES)
def test_the_driveline_that_drove_is_taken(words):
    numbers, machine = DRIVELINES[words], load_plant_vehicle()
    driven = replace(machine, machine=machine.machine._replace(front_drive=numbers["front_drive"]))
    effects = Effects.from_table({"locked_centre": bool(numbers["centre_lock"])})
    soil = SANDY_LOAM.with_(n=0.7)
    drive = without_wheels(simulate("multi", soil, 25.0, effects=effects, vehicle=driven))
    vehicle = load_vehicle("plant").with_(driveline={})
    bare, model = completed(drive, vehicle), bicycle(vehicle, SANDY_LOAM)
    assert undeclared([bare], model) and not undeclared([bare], bicycle(load_vehicle("plant"), SANDY_LOAM))
    choice = choose_driveline([bare], [model], [0.6], 2.0)
    assert choice.words == words
    assert choice.n[words] == pytest.approx(0.7, rel=0.15)  # front wheels alone dig, of all drivelines the least certain


@pytest.mark.study
@pytest.mark.parametrize("declared", [True, False])
def test_n_is_identified_without_wheel_speeds(declared):
    drive = without_wheels(read_drive(MULTI_LOG))
    vehicle = reference_vehicle() if declared else reference_vehicle().with_(driveline={})
    found = estimate(drive, bicycle(vehicle, CLAY), 0.7)
    assert found.n_front[-1] == pytest.approx(0.5, rel=0.06)
    assert found.verdict is not None and found.verdict.word == "identified"
    assert ("centre locked, as the log says" in found.verdict.reason) is not declared
