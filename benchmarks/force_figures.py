"""The paper's Figs. 2-6 drawn again, on the plant's soil contact model: `python -m benchmarks.force_figures [FOLDER]`.

Sand of Table 2, the inputs of Table 3 (2500 N, s = 0.2, 5.5 m/s), slip angle swept 20 deg at 1 Hz: the soil contact model
(black) with the Bekker law (Fig. 2), with the paper's surrogate refitted and the turn-slip law (Fig. 3), and the effects
of load, slip and speed (Figs. 4-6) with the turn-slip law over them. Nothing is fitted to these runs.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from softsoil.calibration.rig_judge import wheel_run
from softsoil.calibration.single_wheel import law_for, predict
from softsoil.plant.rig import Rig, RigRun, run_rig
from softsoil.recording.rig import WheelRun
from softsoil.symbolic.soil import SAND

TABLE_3 = {"load": 2500.0, "slip": 0.2, "speed": 5.5}
COLOURS = {"bekker": "C0", "dallas_refit": "C2", "turn_slip": "C3"}


def rig_run(**changes: float) -> WheelRun:
    """One run of the plant's rig with the inputs of Table 3, or others."""
    told = {**TABLE_3, **changes}
    rig = Rig()
    run = RigRun(SAND, told["load"], told["slip"], told["speed"], np.radians(20.0), 1.0)
    t, series = run_rig(run, 2.6, rig, every=5)
    point = {"soil": "sand", **{key: float(value) for key, value in SAND.parameters().items()}, **told}
    return wheel_run(point, t, series, rig)


def draw(axis: Axes, run: WheelRun, laws: tuple[str, ...], label: str, style: str = "k") -> None:
    """Lateral force against slip angle: measured, and by law."""
    alpha = np.degrees(np.arctan2(-run.v_y, run.v_x))
    axis.plot(alpha, run.smooth(run.lateral(run.f_x, run.f_y)), style, lw=2.2, label=label)
    for name in laws:
        out = predict(law_for(name, [run]), [run])[0]
        axis.plot(alpha, run.smooth(run.lateral(out[0], out[1])), COLOURS[name], lw=1.1, label=name)


def main(folder: Path) -> Path:
    figure = Figure(figsize=(14, 7.5))
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 3)
    base = rig_run()
    draw(axes[0, 0], base, ("bekker",), "soil contact model")
    axes[0, 0].set_title("Fig. 2: Bekker law", fontsize=10)
    draw(axes[0, 1], base, ("dallas_refit", "turn_slip"), "soil contact model")
    axes[0, 1].set_title("Fig. 3: surrogate refitted, turn slip", fontsize=10)
    effects = (
        (axes[1, 0], "Fig. 4: load (s = -0.5)", [({"load": f, "slip": -0.5}, f"{f:.0f} N") for f in (2000.0, 3000.0)]),
        (axes[1, 1], "Fig. 5: slip", [({"slip": s}, f"s = {s:g}") for s in (0.2, 0.4, 0.6)]),
        (axes[1, 2], "Fig. 6: speed (s = 0.5)", [({"speed": v, "slip": 0.5}, f"{v:g} m/s") for v in (2.5, 4.5)]),
    )
    for axis, title, cases in effects:
        for (changes, label), grey in zip(cases, ("k", "0.45", "0.7"), strict=False):
            draw(axis, rig_run(**changes), ("turn_slip",), label, grey)
        axis.set_title(title, fontsize=10)
    axes[0, 2].set_axis_off()
    for axis in (*axes[0, :2], *axes[1]):
        axis.set_xlabel("slip angle (deg)")
        axis.set_ylabel("lateral force (N)")
        axis.grid(alpha=0.3)
        handles, labels = axis.get_legend_handles_labels()
        unique = dict(zip(labels, handles, strict=True))
        axis.legend(unique.values(), unique.keys(), fontsize=7)
    figure.tight_layout()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "force-paper-figures.png"
    figure.savefig(path, dpi=80)
    return path


if __name__ == "__main__":
    print(main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[1] / "docs"))
