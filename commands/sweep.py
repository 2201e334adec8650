"""softsoil sweep: thousands of runs of the plant's single-wheel rig, the force laws judged on each."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from softsoil.calibration.rig_judge import LAWS, draw_points, judge_point, summary
from softsoil.commands.invocation import current
from softsoil.commands.options_model import WorkersOption
from softsoil.commands.output import console, output_folder, progress, say_written, write_result
from softsoil.figures.labels import law_words
from softsoil.mpc_demo.sweep import RESULTS, run_sweep


def sweep(
    runs: Annotated[int, typer.Option("--runs", min=1, help="How many runs.")] = 1200,
    seed: Annotated[int, typer.Option("--seed", help="Seed of the conditions.")] = 1,
    any_soil: Annotated[
        bool, typer.Option("--any-soil", help="Soil parameters and wheel size drawn freely too.")
    ] = False,
    spacing: Annotated[float, typer.Option("--spacing", min=1e-3, max=0.1, help="Grid of the soil, m.")] = 0.025,
    step: Annotated[float, typer.Option("--step", min=1e-5, max=5e-3, help="Time step of the rig, s.")] = 1e-3,
    workers: WorkersOption = -1,
    scheduler: Annotated[
        str | None, typer.Option("--scheduler", help="Dask scheduler, e.g. tcp://host:8786.", show_default=False)
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder (default: runs/sweep).", show_default=False)] = None,
) -> None:
    """Validate the force laws on runs of the plant's own single-wheel rig; resumes where it stopped.

    Example: softsoil sweep --runs 1200 --out runs/sweep
    On a cluster: softsoil sweep --runs 100000 --scheduler tcp://10.0.0.1:8786
    """
    folder = output_folder(out, "sweep")
    current().resumes = folder.path / RESULTS
    points = draw_points(runs, seed, any_soil, spacing, step)
    with progress(f"{runs} runs of the rig") as tell:
        done = run_sweep(judge_point, points, folder.path, workers, scheduler, lambda k, total: tell(k / total))
    results = [result for result in done.results if result is not None]
    if not results:
        raise RuntimeError(f"all {len(points)} runs failed, the first: {next(iter(done.failures.values()))}")
    laws = {law: summary(results, law) for law in LAWS}
    content = {
        "runs": len(results),
        "resumed": done.resumed,
        "failures": {str(k): reason for k, reason in done.failures.items()},
        "laws": laws,
        "longitudinal": {law: summary(results, law, "longitudinal") for law in LAWS},
        "by_soil": {
            soil: {law: summary([r for r in results if r["soil"] == soil], law) for law in LAWS}
            for soil in dict.fromkeys(str(result["soil"]) for result in results)
        },
        "plant_us_per_wheel_step": float(np.median([result["plant_us"] for result in results])),
    }
    console.print(f"{len(results)} runs ({done.resumed} from before), {len(done.failures)} failed", highlight=False)
    console.print("Rms error of the lateral force over the run's peak force, median and 95th percentile over the runs:")
    for law in LAWS:
        error = laws[law]
        console.print(f"{law_words(law)}: {100 * error['median']:.2f} %, {100 * error['p95']:.2f} %", highlight=False)
    say_written([write_result(folder / "sweep.json", content), folder / RESULTS])
