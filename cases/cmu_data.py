"""Single-wheel and sinkage tests as the Carnegie Mellon robomechanics laboratory publishes them, read into wheel runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from softsoil.recording.rig import WheelRun
from softsoil.recording.table import numbers, read_table

Array = NDArray[np.float64]

RADIUS, WIDTH = 0.058, 0.050
"""m, of the smooth wheel."""
SINKAGE_FILE = "pressure_sinkage_plates_wheels.csv.gz"
WHEEL_FILE = "wheel_smooth.csv"


@dataclass(frozen=True)
class SinkageTest:
    """One penetration test: body ("plate" or the wheel's name), diameter of the plate (m, 0 for a wheel), and while the body
    goes down: sinkage (m) and force (N), each (N,).
    """

    name: str
    body: str
    diameter: float
    sinkage: Array
    force: Array


def read_sinkage_tests(path: str | Path) -> list[SinkageTest]:
    """Every penetration test of the file, up to its deepest point; ValueError for a file without the columns."""
    table = read_table(path)
    values = {
        name: numbers(table, name, path) for name in ("plate_diam_mm", "t_s", "sinkage_m", "Fz_N") if name in table
    }
    for name in ("box", "trial", "body", "plate_diam_mm", "t_s", "sinkage_m", "Fz_N"):
        if name not in table:
            raise ValueError(f"{path}: expected column {name!r}, found {', '.join(table.columns)}")
    labels = (table["box"].astype(str) + "/" + table["trial"].astype(str)).to_numpy()
    tests = []
    for label in dict.fromkeys(labels):
        rows = np.flatnonzero(labels == label)
        rows = rows[np.argsort(values["t_s"][rows], kind="stable")]
        rows = rows[: int(np.argmax(values["sinkage_m"][rows])) + 1]
        body, diameter = str(table["body"].iloc[rows[0]]), float(values["plate_diam_mm"][rows[0]]) / 1e3
        tests.append(SinkageTest(label, body, diameter, values["sinkage_m"][rows], values["Fz_N"][rows]))
    return tests


@dataclass(frozen=True)
class SteadyWheel:
    """Steady rows of one wheel: run (all rows as one, in the wheel frame), angle (N,): commanded slip angle (degrees, to
    group by), trial (N,): repeat, rim_speed (N,): commanded, mm/s.
    """

    run: WheelRun
    angle: NDArray[np.int_]
    trial: NDArray[np.int_]
    rim_speed: NDArray[np.int_]

    def __len__(self) -> int:
        return len(self.angle)


def read_steady_wheel(path: str | Path, soil: Mapping[str, float], grouser: float = 0.0) -> SteadyWheel:
    """Steady rows of a wheel table (`wheel_smooth.csv` and its like).

    The wheel points left of its course by the slip angle, so that v_y = -v sin(alpha); soil: parameters by name (SI);
    grouser: height of grousers (m), added to the radius, while the rim speed stays that of the smooth rim.
    Raises ValueError for a missing column, or rows without a number.
    """
    table = read_table(path)
    columns = (
        "beta_deg",
        "angle_deg",
        "Vry_cmd_mm_s",
        "trial",
        "Vx_mm_s",
        "Vry_mm_s",
        "Fx_tractive_N",
        "Fy_side_N",
        "Fz_load_N",
    )
    ch = {name: numbers(table, name, path) for name in columns}
    for name, values in ch.items():
        if not np.all(np.isfinite(values)):
            row = int(np.argmin(np.isfinite(values)))
            raise ValueError(f"{path}: column {name!r}, row {row + 1}: expected a number, found none")
    angle, speed = np.deg2rad(ch["angle_deg"]), ch["Vx_mm_s"] / 1e3
    still = np.zeros(len(angle))
    sinkage = numbers(table, "sinkage_mm", path) / 1e3 if "sinkage_mm" in table else None
    run = WheelRun(
        Path(path).stem, "sand", MappingProxyType(dict(soil)), RADIUS + grouser, WIDTH, 0.0, None,
        v_x=np.maximum(speed * np.cos(angle), 0.0), v_y=-speed * np.sin(angle), omega=ch["Vry_mm_s"] / 1e3 / RADIUS,
        yaw_rate=still, steer_rate=still, dv_y=still, load=ch["Fz_load_N"],
        f_x=ch["Fx_tractive_N"], f_y=ch["Fy_side_N"], yaw=still, sinkage=sinkage,
    )  # fmt: skip
    whole = (ch[name].astype(int) for name in ("beta_deg", "trial", "Vry_cmd_mm_s"))
    return SteadyWheel(run, *whole)
