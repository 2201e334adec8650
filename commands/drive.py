"""`softsoil drive`: NMPC on the plant with the estimator in the loop."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

from softsoil.commands.options import SeedOption
from softsoil.commands.options_model import (
    DEFAULT_LAW,
    LawOption,
    ModelOption,
    OutOption,
    VehicleOption,
    about_vehicle,
    noted,
    refuse_beside_model,
    say_vehicle,
)
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.control.declared import for_control
from softsoil.control.driver_types import DriverSettings
from softsoil.control.live_horizon import LiveHorizon
from softsoil.control.nmpc import Nmpc
from softsoil.control.ocp import Ocp
from softsoil.declaration.model_file import Declaration, load_declaration
from softsoil.figures.drive import animate, draw_drive
from softsoil.figures.labels import plain
from softsoil.files.package_data import PLANT_VEHICLE, VEHICLE_NAMES, plant_file, source_name
from softsoil.mpc_demo.closed_loop import CONTROLLERS, ESTIMATING, ClosedLoop, LoopLog
from softsoil.mpc_demo.closed_loop_parts import Faults
from softsoil.mpc_demo.scenarios import Scenario, scenarios, size_of
from softsoil.plant.drawn_vehicle import DrawnVehicle
from softsoil.plant.machine import load_plant_vehicle
from softsoil.symbolic.vehicle import Vehicle, load_vehicle


def drive(
    scenario: Annotated[
        list[str] | None,
        typer.Argument(
            help=f"Courses: {', '.join(scenarios())}, or all (default: lane_change_clay).", show_default=False
        ),
    ] = None,
    controllers: Annotated[
        str, typer.Option("--controllers", help=f"Of {', '.join(CONTROLLERS)}, with commas between.")
    ] = ",".join(CONTROLLERS),
    seeds: Annotated[int, typer.Option("--seeds", help="How many seeds of sensor noise.", min=1)] = 1,
    seed: SeedOption = 0,
    converged: Annotated[bool, typer.Option("--converged", help="Iterate every solve to convergence.")] = False,
    dropout: Annotated[
        float | None, typer.Option("--dropout", help="Time of a 3 s sensor dropout (s).", show_default=False)
    ] = None,
    burst: Annotated[
        float | None, typer.Option("--burst", help="Time of a 1 s burst of outliers (s).", show_default=False)
    ] = None,
    animation: Annotated[bool, typer.Option("--animation/--no-animation", help="Write an animation (GIF).")] = True,
    vehicle: VehicleOption = None,
    law: LawOption = None,
    model: ModelOption = None,
    out: OutOption = None,
) -> None:
    """Drive courses on the plant: model predictive control on what the estimator says, Table-5 sensor noise.

    The controllers' vehicle is that of --vehicle (or --model), by default vehicles/plant.toml. The simulated one is that of
    NAME_plant.toml beside its file, or the package's of that name, else the reference vehicle: the command says which.

    Example: softsoil drive lane_change_clay --seeds 3
    """
    if model is not None:
        refuse_beside_model(("--vehicle", vehicle), ("--law", law))
    driven = load_vehicle(vehicle or PLANT_VEHICLE) if model is None else load_declaration(model).vehicle
    courses, names = _courses(scenario or ["lane_change_clay"], size_of(driven)), _controllers(controllers)
    figures = [f"{name}{ending}" for name in scenarios() for ending in (".png", ".gif")]
    folder = output_folder(out, "drive", ("drive.json", *figures))
    say_vehicle(vehicle, model, PLANT_VEHICLE)
    simulated = _say_plant(driven)
    faults = Faults(
        dropout=None if dropout is None else (dropout, dropout + 3.0),
        burst=None if burst is None else (burst, burst + 1.0),
    )
    logs: list[LoopLog] = []
    loops: dict[str, ClosedLoop] = {}
    paths: list[Path] = []
    for course in courses:
        if course.believed.name not in loops:
            with progress(f"solver for {course.believed.name}"):
                loops[course.believed.name] = _loop(course, vehicle, law, model, converged)
        mine = []
        for name in names:
            for number in range(seed, seed + seeds):
                with progress(f"{course.name}, {name}, seed {number}"):
                    mine.append(loops[course.believed.name].run(course, name, number, faults))
        logs += mine
        paths.append(draw_drive(course, mine, folder / f"{course.name}.png"))
        if animation:
            shown = next((log for log in mine if log.controller == ESTIMATING), mine[0])
            paths.append(animate(course, shown, folder / f"{course.name}.gif"))
    _say(logs)
    content = {"plant": {"name": simulated.stem, "file": source_name(simulated)}, **as_json(logs)}
    say_written([write_result(folder / "drive.json", content, about_vehicle(vehicle or PLANT_VEHICLE, model)), *paths])


def _say_plant(driven: Vehicle) -> Path:
    """Say which vehicle is simulated, and that it is another one where there is none of the name; returns its file."""
    path = plant_file(driven.name, driven.source)
    _print(f"plant: {source_name(path)}")
    if path.stem != f"{driven.name}_plant" and driven.name not in VEHICLE_NAMES:
        mass = load_plant_vehicle(path).machine.total_mass
        words = f"warning: {driven.name}: found no {driven.name}_plant.toml beside its file: "
        words += f"the reference vehicle ({mass:.0f} kg) is simulated, driven with the numbers of one of {driven.mass:.0f} kg"
        _print(words, "yellow")
    return path


def _print(words: str, style: str | None = None) -> None:
    console.print(words, style=style, highlight=False, soft_wrap=True)


def _courses(asked: Sequence[str], size: float) -> list[Scenario]:
    known = scenarios(size)
    if "all" in asked:
        return list(known.values())
    for name in asked:
        if name not in known:
            raise ValueError(f"scenario: expected all or some of {', '.join(known)}; found {name!r}")
    return [known[name] for name in dict.fromkeys(asked)]


def _controllers(asked: str) -> list[str]:
    names = list(dict.fromkeys(name.strip() for name in asked.split(",") if name.strip()))
    for name in names:
        if name not in CONTROLLERS:
            raise ValueError(f"--controllers: expected some of {', '.join(CONTROLLERS)}; found {name!r}")
    if not names:
        raise ValueError(f"--controllers: expected some of {', '.join(CONTROLLERS)}; found none")
    return names


def _loop(course: Scenario, vehicle: Path | None, law: str | None, model: Path | None, converged: bool) -> ClosedLoop:
    """Solver and loop for the soil that the course's controllers believe in."""
    if model is not None:
        declared = load_declaration(model)
        declared = Declaration(declared.vehicle, course.believed, declared.law)
    else:
        declared = Declaration(load_vehicle(vehicle or PLANT_VEHICLE), course.believed, law or DEFAULT_LAW)
        declared = for_control(declared)
    return loop_for(noted(declared), converged)


def loop_for(
    declared: Declaration, converged: bool = False, hessian: str | None = None, noisy: str = "states",
    drawn: DrawnVehicle | None = None,
) -> ClosedLoop:  # fmt: skip
    """Loop, solver and judge of n for a declared model; converged: iterate every solve to convergence; hessian: of `Nmpc`;
    noisy: of `ClosedLoop`; drawn: the plant's vehicle, default the one of `plant_file`."""
    ocp = Ocp(declared.build(), declared.vehicle)
    solver = Nmpc(ocp, "converged" if converged else "rti", hessian=hessian)
    judge = LiveHorizon(declared, DriverSettings().sensor_std)
    if drawn is not None:
        return ClosedLoop(ocp, solver, machine=drawn.vehicle, noisy=noisy, judge=judge, spacing=drawn.spacing)
    machine = load_plant_vehicle(plant_file(declared.vehicle.name, declared.vehicle.source))
    return ClosedLoop(ocp, solver, machine=machine, noisy=noisy, judge=judge)


def as_json(logs: Sequence[LoopLog]) -> dict:
    """The content of drive.json: over all runs by controller, then by scenario and controller, then each run."""
    by_scenario: dict[str, dict] = {}
    for name in dict.fromkeys(log.scenario for log in logs):
        mine = [log for log in logs if log.scenario == name]
        table: dict = {c: summary([log for log in mine if log.controller == c]) for c in controllers_of(mine)}
        table["recovered"] = recovered(table)
        by_scenario[name] = table
    runs = [
        {
            "scenario": log.scenario, "controller": log.controller, "seed": log.seed, "finished": log.finished,
            "tracking_rms": log.tracking_rms, "max_error": log.max_error, "clearance": log.clearance,
            "n_end": log.column("n")[-1], "n_std": log.column("n_std")[-1], "verdict": log.verdict,
            "late": log.late, "failures": log.failures, "gated": log.gated,
        }
        for log in logs
    ]  # fmt: skip
    controllers = {c: summary([log for log in logs if log.controller == c]) for c in controllers_of(logs)}
    return {"controllers": controllers, "scenarios": by_scenario, "runs": runs}


def controllers_of(logs: Sequence[LoopLog]) -> list[str]:
    """Controllers that drove, in the usual order."""
    return [name for name in CONTROLLERS if any(log.controller == name for log in logs)]


def summary(logs: Sequence[LoopLog]) -> dict:
    """One controller's figures over some runs: rms over all of them, worst error, touched obstacles, solve times."""
    solve = np.concatenate([log.column("solve_ms") for log in logs])
    gaps = [log.clearance for log in logs]
    return {
        "tracking_rms": float(np.sqrt(np.mean([log.tracking_rms**2 for log in logs]))),
        "max_error": max(log.max_error for log in logs),
        "collisions": sum(log.collided for log in logs),
        "solve_ms": {"median": float(np.median(solve)), "p99": float(np.percentile(solve, 99))},
        "failures": sum(log.failures for log in logs),
        "late": sum(log.late for log in logs),
        "clearance": min(gaps),
        "finished": sum(log.finished for log in logs),
        "runs": len(logs),
    }


def recovered(table: dict) -> float | None:
    """Share of what knowing n is worth in tracking rms that the estimate recovers; None where it is worth less than 5 %."""
    if not all(name in table for name in CONTROLLERS):
        return None
    guess, true, found = (table[name]["tracking_rms"] for name in CONTROLLERS)
    return (guess - found) / (guess - true) if guess - true > 0.05 * true else None


def verdicts_in_words(logs: Sequence[LoopLog]) -> str:
    """The verdict on n at the end of each drive, with its number of drives where they differ; "" where n is not estimated."""
    words = [log.verdict for log in logs if log.controller == ESTIMATING]
    kinds = list(dict.fromkeys(words))
    return "".join(kinds) if len(kinds) < 2 else ", ".join(f"{words.count(kind)} x {kind}" for kind in kinds)


def _say(logs: Sequence[LoopLog]) -> None:
    table = Table(title="Closed loop on the plant: distance to the path, least gap to an obstacle, times", title_justify="left")
    for heading in (
        "course",
        "controller",
        "rms, m",
        "worst, m",
        "gap, m",
        "touched",
        "solve, ms",
        "p99, ms",
        "failed",
        "late",
        "verdict on n",
        "n",
    ):
        table.add_column(heading)
    for name in dict.fromkeys(log.scenario for log in logs):
        for controller in controllers_of(logs):
            mine = [log for log in logs if log.scenario == name and log.controller == controller]
            if not mine:
                continue
            s = summary(mine)
            clear = f"{s['clearance']:.2f}" if np.isfinite(s["clearance"]) else ""
            n = f"{np.mean([log.column('n')[-1] for log in mine]):.2f}"
            n += f" ± {np.mean([log.column('n_std')[-1] for log in mine]):.2f}" if controller == ESTIMATING else ""
            table.add_row(
                plain(name), plain(controller), f"{s['tracking_rms']:.3f}", f"{s['max_error']:.2f}", clear, f"{s['collisions']}",
                f"{s['solve_ms']['median']:.2f}", f"{s['solve_ms']['p99']:.2f}", f"{s['failures']}", f"{s['late']}",
                plain(verdicts_in_words(mine)), n,
            )  # fmt: skip
    console.print(table)
    for log in logs:
        bad = [name for name in dict.fromkeys(log.column("status")) if name not in ("ITERATED", "CONVERGED")]
        for name in bad:
            count = int(np.count_nonzero(log.column("status") == name))
            _print(f"{log.scenario}, {log.controller}, seed {log.seed}: {count} x {name}")
