"""Front-axle lateral force of the laws on the reference simulator's drives: `python -m benchmarks.force_front_axle`.

Nothing is fitted on these drives; the true_* columns judge, and in the first two of three ways also give motion and load:
- "own load": each wheel's true angle, velocity and load: the law alone;
- "own load, lean": the same, and the wheels lean with the true roll as the vehicle's `wheel_lean` declares;
- "model load": velocities from u, v, omega_z, angles from the steering, loads static + longitudinal + lateral transfer.
Printed: rms error over the peak force, rms over rms, and the gain of measured on predicted force. Then by how much the front
wheels sink more than turn_slip says under their own loads (mm), and how that depends on their spin (mm per rad/s).
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
from scipy.signal import savgol_filter

from benchmarks.judges.front_axle import SIDES, force, judge
from benchmarks.judges.true_soil import true_soil
from softsoil.recording.drive import Recording
from softsoil.recording.read import read_drive
from softsoil.symbolic.bicycle import vehicle_law
from softsoil.symbolic.laws.bekker import Bekker
from softsoil.symbolic.laws.turn_slip import TurnSlip
from softsoil.symbolic.laws.turn_slip_calibrated import TurnSlipCalibrated
from softsoil.symbolic.vehicle import Vehicle, load_vehicle
from softsoil.symbolic.wheel import Contact, ForceLaw

PROJECT = Path(__file__).resolve().parents[1]
DRIVES = PROJECT.parent / "shared" / "data" / "chrono_vehicle"
LEANING = "turn_slip"
"""The law that is also tried on leaning wheels."""
WAYS = {"own load": (True,), "own load, lean": (True, True), "model load": (False,)}
START = 2.0
"""s: the start-up transient before is left out."""
def sinks(log: Recording, vehicle: Vehicle) -> tuple[float, float]:
    """What the front wheels sink beyond turn_slip's sinkage, mean (mm) and slope with the spin (mm per rad/s)."""
    wheel, soil = vehicle.wheel, true_soil(log.name)
    load, spin = ca.SX.sym("load"), ca.SX.sym("spin")
    law = ca.Function("h", [load, spin], [vehicle_law(vehicle, "turn_slip")(soil, wheel, Contact(5.0, 0.0, spin, load)).sinkage])
    apart, spins = [], []
    for side, _ in SIDES:
        carried, height = (savgol_filter(log.truth[f"true_{key}_{side}"], 21, 2) for key in ("fz", "z"))
        spins.append(log[f"omega_{side}"])
        told = law.map(len(log))(carried[None, :], spins[-1][None, :]).full()[0]
        apart.append(1e3 * (wheel.radius - height - told))
    return float(np.mean(apart)), float(np.polyfit(np.concatenate(spins), np.concatenate(apart), 1)[0])


def table(folder: Path, laws: dict[str, ForceLaw]) -> list[tuple[str, dict[str, tuple[float, float, float]]]]:
    """Per nominal drive: figures by law and kind of load."""
    vehicle = load_vehicle(PROJECT / "vehicles" / "reference.toml")
    functions = {name: force(law, vehicle) for name, law in laws.items()}
    rows = []
    for kind in ("paper", "multi", "steps"):
        for path in sorted(folder.glob(f"{kind}_*.csv.gz")):
            log = read_drive(path)
            log = log.between(START, log.t[-1])
            row = {
                f"{name}, {way}": judge(log, function, vehicle, *how)
                for name, function in functions.items()
                for way, how in WAYS.items()
                if name == LEANING or way in ("own load", "model load")
            }
            rows.append((log.name, row))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=DRIVES, help="drives with true_* columns")
    folder = parser.parse_args().folder
    base: TurnSlip = vehicle_law(load_vehicle(PROJECT / "vehicles" / "reference.toml"), "turn_slip")  # type: ignore
    laws: dict[str, ForceLaw] = {
        "bekker": Bekker(),
        LEANING: base,
        "without contact step": replace(base, contact_step=0.0),
        "with the rig's factors": TurnSlipCalibrated(base, on_reference_rig=True),
    }
    rows = table(folder, laws)
    if not rows:
        raise SystemExit(f"expected drives paper_*, multi_*, steps_* (.csv.gz) in {folder}, found none")
    heads = list(rows[0][1])
    print("front axle: rms error over peak %, over rms %, gain")
    print(f"{'drive':24s}" + "".join(f"{head:>36s}" for head in heads))
    for name, row in rows:
        print(f"{name:24s}" + "".join(f"{100 * p:22.1f} {100 * r:6.1f} {g:6.3f}" for p, r, g in row.values()))
    for kind in ("paper", "multi", "steps"):
        values = [np.array(list(row.values())) for name, row in rows if name.startswith(kind)]
        worst = np.max(values, axis=0) if values else []
        print(f"{'worst ' + kind:24s}" + "".join(f"{100 * p:22.1f} {100 * r:6.1f}       " for p, r, _ in worst))
    vehicle = load_vehicle(PROJECT / "vehicles" / "reference.toml")
    print("front wheels' sinkage beyond the law's: mm, mm per rad/s of spin")
    for name, _ in rows:
        log = read_drive(folder / f"{name}.csv.gz")
        print(f"{name:24s}" + "{:8.2f}{:8.3f}".format(*sinks(log.between(START, log.t[-1]), vehicle)))


if __name__ == "__main__":
    main()
