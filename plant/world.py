"""The plant: a vehicle on soil that is stepped by commands, remembers its ruts, and can be saved and resumed."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softsoil.plant.contact import tiles_within_reach
from softsoil.plant.dynamics import EXTRA, INFO, step_vehicle
from softsoil.plant.effects import Effects
from softsoil.plant.grid import RutGrid
from softsoil.plant.ground import ground_of
from softsoil.plant.kernel import kernel
from softsoil.plant.machine import PlantVehicle, load_plant_vehicle
from softsoil.plant.observe import COLUMNS, observe
from softsoil.plant.soil_field import SoilField
from softsoil.plant.start import Start, start_state
from softsoil.plant.state import TIME
from softsoil.symbolic.soil import CLAY, Soil

Array = NDArray[np.float64]

STEP = 0.002
"""The plant's step (s), as in the paper."""
SPACING = 0.03
"""The soil grid's spacing (m), as in the reference drives."""


@kernel
def _advance(state, commands, machine, world, ground, dt, room, info, extra):
    """Run the steps in commands (N, 3); returns how many were run, short of N where the grid is full."""
    for k in range(commands.shape[0]):
        if ground.count[0] + room > ground.nodes.shape[0] or 2 * (ground.count[0] + room) > ground.keys.shape[0]:
            return k
        step_vehicle(state, commands[k], machine, world, ground, dt, info, extra)
    return commands.shape[0]


@dataclass(frozen=True)
class Sample:
    """One observation of the plant: values by name (`sample["u"]`), sensor channels first, then `true_*`."""

    row: Array

    def __getitem__(self, name: str) -> float:
        try:
            return float(self.row[COLUMNS.index(name)])
        except ValueError:
            raise KeyError(f"expected one of {', '.join(COLUMNS)}; found {name!r}") from None


class Plant:
    """A vehicle on deformable soil.

    vehicle: PlantVehicle (default: the reference vehicle); soil: a Soil or a SoilField; effects: what is switched on;
    start: where and how fast the vehicle begins; step: s; spacing: of the soil's grid (m); cast: find the wheels over the
    soil as the reference simulator does, up to 1 cm too low (`softsoil.plant.reference.raycast`), at a third of the speed.
    Deterministic: the same arguments and commands give the same numbers.
    """

    def __init__(
        self,
        soil: Soil | SoilField = CLAY,
        *,
        vehicle: PlantVehicle | None = None,
        effects: Effects | None = None,
        start: Start | None = None,
        step: float = STEP,
        spacing: float = SPACING,
        cast: bool = False,
    ) -> None:
        if not 0 < step <= 0.005:
            raise ValueError(f"plant: expected a step in (0, 0.005] s, found {step}")
        self.vehicle = vehicle or load_plant_vehicle()
        self.soil = SoilField.uniform(soil) if isinstance(soil, Soil) else soil
        self.effects = effects or Effects()
        self.dt = step
        self.grid = RutGrid(spacing)
        self.info = np.zeros((4, INFO))
        self.extra = np.zeros(EXTRA)
        machine = self.vehicle.machine
        self._world = self.effects.world(step, machine.origin, cast)
        widest = float(np.max(machine.width * self._world.width_factor))
        layers = 2 if self.effects.shears_anew else 1
        self._room = 4 * layers * tiles_within_reach(float(np.max(machine.radius)) * 1.2, widest, spacing)
        self.state = start_state(start or Start(), self.vehicle, self.soil)
        self._command = np.zeros(3)

    @property
    def time(self) -> float:
        """Time since the start (s)."""
        return float(self.state[TIME])

    def advance(self, commands: Array) -> None:
        """Run one plant step per row of commands (N, 3): steering (rad), throttle and brake in [0, 1]."""
        done = 0
        while done < len(commands):
            self.grid.reserve(4 * self._room)
            ground = ground_of(self.grid, self.soil)
            done += _advance(
                self.state, commands[done:], self.vehicle.machine, self._world, ground, self.dt, self._room, self.info,
                self.extra,
            )  # fmt: skip
        self._command = commands[-1].copy() if len(commands) else self._command
        if not np.all(np.isfinite(self.state)):
            raise FloatingPointError(f"plant: the state is no longer finite at t = {self.time:.3f} s")

    def step(self, command: Sequence[float] | ArrayLike, dt: float = 0.012) -> Sample:
        """Hold a command (steering in rad, throttle, brake) over dt (a multiple of the plant's step); what is then
        seen.

        Raises ValueError for a command that is not three finite numbers, a pedal outside [0, 1] or another dt.
        """
        held = np.asarray(command, dtype=float)
        if held.shape != (3,) or not np.all(np.isfinite(held)):
            raise ValueError(
                f"plant: expected a command (steer, throttle, brake), three finite numbers, found {command!r}"
            )
        if not (0 <= held[1] <= 1 and 0 <= held[2] <= 1):
            raise ValueError(f"plant: expected throttle and brake in [0, 1], found {held[1]} and {held[2]}")
        steps = round(dt / self.dt)
        if steps < 1 or abs(steps * self.dt - dt) > 1e-9:
            raise ValueError(f"plant: expected dt a multiple of {self.dt} s, found {dt}")
        self.advance(np.tile(held, (steps, 1)))
        return self.sample()

    def sample(self) -> Sample:
        """What is seen now: state and the forces of the last step."""
        row = np.zeros(len(COLUMNS))
        observe(self.state, self._command, self.vehicle.machine, self.info, self.extra, row)
        return Sample(row)

    def save(self, path: str | Path) -> None:
        """Write the whole state, soil memory and settings (not the vehicle) as an npz without pickles, at `path` whatever it ends
        in."""
        g = self.grid
        with Path(path).open("wb") as file:
            np.savez_compressed(
                file, state=self.state, command=self._command, info=self.info, extra=self.extra, step=self.dt,
                keys=g.keys, slots=g.slots, count=g.count, nodes=g.nodes, spacing=g.spacing, cast=self._world.cast,
                soil_values=self.soil.values, soil_meta=self.soil.meta, soil_name=self.soil.name,
                effects=json.dumps(asdict(self.effects)), vehicle=self.vehicle.name,
            )  # fmt: skip

    @classmethod
    def load(cls, path: str | Path, vehicle: PlantVehicle | None = None) -> Plant:
        """Resume from `save`, to the same bits; ValueError where the vehicle is another one."""
        with np.load(path, allow_pickle=False) as data:
            effects = Effects.from_table(json.loads(str(data["effects"])))
            meta = data["soil_meta"]
            name = str(data["soil_name"]) if "soil_name" in data else "field"
            soil = SoilField(data["soil_values"], (float(meta[0]), float(meta[1])), float(meta[2]), bool(meta[3]), name)
            plant = cls(
                soil, vehicle=vehicle, effects=effects, step=float(data["step"]), spacing=float(data["spacing"]),
                cast="cast" in data and bool(data["cast"]),
            )  # fmt: skip
            if plant.vehicle.name != str(data["vehicle"]):
                raise ValueError(f"{path}: expected the vehicle {data['vehicle']}, found {plant.vehicle.name}")
            plant.state, plant._command = data["state"], data["command"]
            plant.info, plant.extra = data["info"], data["extra"]
            plant.grid = RutGrid(plant.grid.spacing, data["keys"], data["slots"], data["count"], data["nodes"])
        return plant
