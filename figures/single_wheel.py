"""Figures of single-wheel data: force against slip angle, and each law's error and cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from softsoil.calibration.single_wheel import law_for, predict
from softsoil.calibration.wheel_report import applies
from softsoil.figures.labels import law_words, plain
from softsoil.figures.style import ESTIMATED, INITIAL, REAR, SOFT, TRUE, page
from softsoil.recording.rig import WheelRun
from softsoil.symbolic.wheel import ForceLaw

COLOURS: Mapping[str, str] = MappingProxyType(
    {"bekker": ESTIMATED, "dallas": SOFT, "dallas_refit": REAR, "turn_slip": INITIAL, "turn_slip_calibrated": "#7b4ea3"}
)
SHOWN = 6
"""Runs drawn in the figure of force against slip angle."""


def draw_force_against_slip(
    runs: Sequence[WheelRun],
    path: Path,
    laws: Sequence[str] = ("bekker", "dallas_refit", "turn_slip_calibrated"),
    extra: tuple[ForceLaw, Sequence[WheelRun]] | None = None,
) -> Path:
    """Lateral force against slip angle, measured and by law, on runs spread over the data (the paper's Figs. 2, 3).

    extra: a law of its own with the runs as it sees them, drawn in place of the packaged law of its name.
    """
    picked = np.linspace(0, len(runs) - 1, min(SHOWN, len(runs))).astype(int)
    chosen = [runs[i] for i in picked]
    names = [name for name in laws if applies(name, chosen)]
    outs = {name: predict(law_for(name, chosen), chosen) for name in names}
    if extra is not None:
        outs[extra[0].name] = predict(extra[0], [extra[1][i] for i in picked])
    columns = min(3, len(chosen))
    rows = -(-len(chosen) // columns)
    title = "Lateral force over the slip angle, single wheel"
    with page(path, title, 3.5 * columns, 3.0 * rows + 0.4, rows, columns, squeeze=False) as axes:
        for k, (run, axis) in enumerate(zip(chosen, axes.flat, strict=False)):
            alpha = np.degrees(np.arctan2(-run.v_y, np.maximum(run.v_x, 1e-9)))
            style = "-" if run.dt is not None else "."
            axis.plot(alpha, run.smooth(run.lateral(run.f_x, run.f_y)), style, color=TRUE, lw=2, ms=4, label="measured")
            for name, out in outs.items():
                force = run.smooth(run.lateral(out[k][0], out[k][1]))
                axis.plot(alpha, force, style, color=COLOURS[name], lw=1, ms=4, label=law_words(name))
            words = f"{plain(run.group)}, n {run.soil['n']:.2f}, s {run.slip:.2f}, {run.load.mean():.0f} N"
            axis.set_title(words, fontsize=9)
            axis.set_xlabel("slip angle, deg")
            axis.set_ylabel("lateral force, N")
        for axis in list(axes.flat)[len(chosen) :]:
            axis.set_axis_off()
        shown = axes.flat[0].get_legend_handles_labels()
        axes.flat[0].figure.legend(*shown, loc="outside lower left", ncols=len(outs) + 1)
    return path


def draw_errors(report: dict[str, Any], path: Path) -> Path:
    """Error by law as bars (median) with the 95th percentile, and the cost of a call beside it."""
    names = [name for name, values in report["laws"].items() if values["median"] is not None]
    with page(path, "Force laws on single-wheel runs", 10, 4, 1, 2) as (left, right):
        for k, name in enumerate(names):
            values = report["laws"][name]
            left.bar(k, 100 * values["median"], color=COLOURS[name])
            left.plot([k, k], [100 * values["median"], 100 * values["p95"]], "k-")
            left.plot(k, 100 * values["p95"], "k_", ms=12)
            right.bar(k, report["cost_us"][name], color=COLOURS[name])
        for axis, label in ((left, "lateral force error over peak, %"), (right, "cost of a call in C, µs")):
            axis.set_xticks(range(len(names)), [law_words(name) for name in names], rotation=20, fontsize=8)
            axis.set_ylabel(label)
        left.set_yscale("log")
        left.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        left.set_title("median, and 95th percentile over the runs", fontsize=9)
    return path
