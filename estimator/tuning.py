"""The terrain filter's rules as numbers: the same in replay, in the loop and in the C library."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softsoil.declaration.driveline import turns_wheels
from softsoil.recording.forward import HELD_INPUTS
from softsoil.symbolic.model import Model
from softsoil.symbolic.signals import Layout
from softsoil.symbolic.vehicle import Vehicle

ABSENT_WHEELS_ERROR = 0.03
"""Share of n by which estimates with and without wheel speeds differ on the same drives (rms; vehicles 0 to 2 of the plant)."""
UNSTATED_ERROR = 0.05
"""Share of n by which a vehicle's numbers may put it off where its file does not state how well they are known: what `identify`
accepts at most of numbers that it has found (`identification.rules`). Those of scale and tape alone do worse, and every drive
contradicts them (`python -m benchmarks.hand_written`)."""
N_NAMES = ("n", "n_f", "n_r")
"""States that are the sinkage exponent: of both axles, or of each."""
POSE = ("x", "y", "psi")
KICKED = ("v", "omega_z")
"""Velocities that a kick of the steering moves."""
ByUnit = tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Tuning:
    """Numbers of the filter that the paper leaves open; the same for every soil, vehicle and log.

    model_error: what the equations miss, as densities per state: standard deviation after one second of accumulation (units of
    x, y, psi, u, v, omega_z); output_error: what a right model misses of each measurement whatever its sensor (same units; of v
    and omega_z as in the moving horizon), added to the sensor's variance; kick: of v and omega_z, densities beside model_error
    while the road wheels steer faster than `fastest` (rad/s), which no actuator follows, and in the first `run_in` (s), since
    histories start straight; common_error: share of n that an error common to all updates makes, which no number of them
    removes, beside the vehicle's own n_error; n_walk: of the sinkage exponent per square root of a second; n_std: of the first
    guess; extra_std, extra_walk: the same of states that an effect brings; sensor_floor: least standard deviation that a sensor
    is believed to have; gate: innovation in standard deviations; patience, patience_rates: updates in a row that a measurement
    of the pose (x, y, psi), or of another state, may fail the gate to the same side before the state is taken to have jumped
    there (0: never): a pose integrates velocities and leaps by a fault of its sensor only, a velocity by forces that the model
    misses; change_after, change_sigmas, change_std, change_error: where the innovations of up to change_after seconds say by
    more than change_sigmas that n has jumped (`estimator/soil_change.py`), jumps having the standard deviation change_std and
    what is measured of one an error of change_error, it is another soil: n is put there and change_std is added to its
    uncertainty, until the seconds after it say otherwise (`estimator/soil_trial.py`); standstill: m/s, below it the soil is
    held and the vehicle rolls without forces (`estimator/rolling.py`); held_inputs: s, for so long an input may be missing
    before velocities follow their sensors; fade: s, time in which slip velocities then go to those of rolling wheels;
    input_limit, output_limit: beyond these, by unit, a value is none of a vehicle; ceiling: of a
    standard deviation, by unit; update_every: predictions per update (the paper predicts every 12 ms
    and updates every 24 ms, which leaves out half of what a log of 12 ms has measured).
    `python -m benchmarks.estimate_nominal ../shared/data/chrono_vehicle` prints what they give.
    """

    model_error: tuple[float, ...] = (0.02, 0.02, 0.002, 0.04, 0.015, 0.05)
    output_error: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.015, 0.024)
    kick: tuple[float, float] = (2.0, 3.0)
    fastest: float = 1.5
    run_in: float = 0.6
    common_error: float = 0.02
    n_walk: float = 0.003
    n_std: float = 0.3
    extra_std: float = 0.01
    extra_walk: float = 1e-4
    sensor_floor: tuple[float, ...] = (0.05, 0.05, 0.003, 0.05, 0.05, 0.005)
    gate: float = 6.0
    patience: int = 12
    patience_rates: int = 2
    change_after: float = 5.0
    change_sigmas: float = 2.6
    change_std: float = 0.2
    change_error: float = 0.03
    standstill: float = 0.5
    held_inputs: float = HELD_INPUTS
    fade: float = 0.1
    input_limit: ByUnit = (("rad", 1.6), ("rad/s", 1e3), ("m/s^2", 200.0))
    output_limit: ByUnit = (("m", 1e8), ("rad", 1e5), ("m/s", 150.0), ("rad/s", 50.0))
    ceiling: ByUnit = (("m", 1e3), ("rad", 2.0), ("m/s", 20.0), ("rad/s", 5.0), ("", 1.0))
    update_every: int = 1

    def q_std(self, states: Layout) -> NDArray[np.float64]:
        """(n_x,) process noise at rest, standard deviation after one second, for the states of a terrain model."""
        extra = states.names[len(self.model_error) :]
        return np.array([*self.model_error, *(self.n_walk if name in N_NAMES else self.extra_walk for name in extra)])

    def std0(self, states: Layout, sensors: tuple[float, ...] | NDArray[np.float64]) -> NDArray[np.float64]:
        """(n_x,) standard deviations of a first state whose motion is known as well as its sensors (6,) say."""
        extra = states.names[len(self.model_error) :]
        return np.array([*sensors, *(self.n_std if name in N_NAMES else self.extra_std for name in extra)])

    def kick_std(self, states: Layout) -> NDArray[np.float64]:
        """(n_x,) process noise beside the usual one while histories or the steering are none of the model's, after one second."""
        return np.array([dict(zip(KICKED, self.kick, strict=True)).get(name, 0.0) for name in states.names])

    def patiences(self, outputs: Layout) -> NDArray[np.int_]:
        """(n_y,) patience with each measurement."""
        return np.array([self.patience if name in POSE else self.patience_rates for name in outputs.names])


LEAP = 10.0
"""Ceilings that a state may move by in a step: beyond them the equations diverge."""
WHEELS_TURN = 0.5
"""rad/s: a wheel that is faster turns, and a vehicle that was standing is about to drive."""
EXACT_MODEL = Tuning(
    model_error=(0.02, 0.02, 0.002, 0.1, 0.05, 0.02), output_error=(0.0,) * 6, common_error=0.0, n_walk=0.002
)
"""For drives of the model itself, whose equations miss nothing: what is left is rounding and the sampling of inputs."""


def common_error(own: float, model: Model) -> float:
    """Share of n that an error common to all measurements makes: root of the sum of squares of `own`, of what the model's vehicle
    makes (n_error of its file, UNSTATED_ERROR where that does not state how well its numbers are known), and of
    ABSENT_WHEELS_ERROR where the model turns its wheels itself.

    own: share by what the force law misses of any drive; 0, of a model's own drives: nothing but what the file states.
    """
    vehicle = model.geometry if isinstance(model.geometry, Vehicle) else None
    of_vehicle = 0.0 if vehicle is None else vehicle.n_error
    if vehicle is not None and own > 0.0 and not vehicle.states_errors:
        of_vehicle = UNSTATED_ERROR
    absent = ABSENT_WHEELS_ERROR if turns_wheels(model) else 0.0
    return float(np.linalg.norm([own, of_vehicle, absent]))


def by_unit(layout: Layout, numbers: ByUnit, default: float) -> NDArray[np.float64]:
    """(n,) number of each signal by its unit, `default` for a unit that is not named."""
    known = dict(numbers)
    return np.array([known.get(signal.unit, default) for signal in layout])
