"""The paper's Figs. 2-6 drawn again, on the plant's soil contact model: `python -m benchmarks.force_figures [--out FOLDER]`.

Sand of Table 2, the inputs of Table 3 (2500 N, s = 0.2, 5.5 m/s), slip angle swept 20 deg at 1 Hz: the soil contact model
(black) with the Bekker law (Fig. 2), with the paper's surrogate refitted and the turn-slip law (Fig. 3), and the effects
of load, slip and speed (Figs. 4-6) with the turn-slip law over them. Nothing is fitted to these runs.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from softsoil.calibration.rig_judge import wheel_run
from softsoil.calibration.single_wheel import law_for, predict
from softsoil.figures.labels import LAWS, law_words
from softsoil.figures.style import ESTIMATED, INITIAL, REAR, TRUE, page
from softsoil.plant.rig import Rig, RigRun, run_rig
from softsoil.recording.rig import WheelRun
from softsoil.symbolic.soil import SAND

TABLE_3 = {"load": 2500.0, "slip": 0.2, "speed": 5.5}
COLOURS = {"bekker": ESTIMATED, "dallas_refit": REAR, "turn_slip": INITIAL}
MEASURED = "soil contact model"
WORDS = (
    "Sand, 2500 N, s = 0.2, 5.5 m/s where\nnothing else is said; slip angle swept\n20 deg at 1 Hz.\n\n"
    "Thick, black to grey: soil contact model.\nThin: force laws, fitted to none of it."
)


def rig_run(**changes: float) -> WheelRun:
    """One run of the plant's rig with the inputs of Table 3, or others."""
    given = {**TABLE_3, **changes}
    rig = Rig()
    run = RigRun(SAND, given["load"], given["slip"], given["speed"], np.radians(20.0), 1.0)
    t, series = run_rig(run, 2.6, rig, every=5)
    point = {"soil": "sand", **{key: float(value) for key, value in SAND.parameters().items()}, **given}
    return wheel_run(point, t, series, rig)


def draw(axis: Axes, run: WheelRun, laws: tuple[str, ...], label: str, color: str = TRUE) -> None:
    """Lateral force against slip angle: measured, and by law."""
    alpha = np.degrees(np.arctan2(-run.v_y, run.v_x))
    axis.plot(alpha, run.smooth(run.lateral(run.f_x, run.f_y)), color=color, lw=2.2, label=label)
    for name in laws:
        out = predict(law_for(name, [run]), [run])[0]
        axis.plot(alpha, run.smooth(run.lateral(out[0], out[1])), color=COLOURS[name], lw=1.1, label=law_words(name))


def main() -> None:
    """Write the page of figures and print its path."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--out", type=Path, default=Path("docs/pictures"))
    folder = options.parse_args().out
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "force-paper-figures.png"
    mosaic = [["2", "3", "4"], ["5", "6", "words"]]
    with page(path, "The paper's Figs. 2 to 6 on the plant's soil contact model", 10, 6.6, mosaic=mosaic) as axes:
        base = rig_run()
        draw(axes["2"], base, ("bekker",), MEASURED)
        draw(axes["3"], base, ("dallas_refit", "turn_slip"), MEASURED)
        changes = {
            "4": [({"load": f, "slip": -0.5}, f"{f:.0f} N") for f in (2000.0, 3000.0)],
            "5": [({"slip": s}, f"s = {s:g}") for s in (0.2, 0.4, 0.6)],
            "6": [({"speed": v, "slip": 0.5}, f"{v:g} m/s") for v in (2.5, 4.5)],
        }
        for number, cases in changes.items():
            for (change, label), grey in zip(cases, (TRUE, "0.45", "0.7"), strict=False):
                draw(axes[number], rig_run(**change), ("turn_slip",), label, grey)
        titles = (
            "Fig. 2: Bekker", "Fig. 3: surrogate", "Fig. 4: load, s = -0.5", "Fig. 5: slip", "Fig. 6: speed, s = 0.5",
        )  # fmt: skip
        for axis, title in zip(list(axes.values())[:5], titles, strict=True):
            axis.set(title=title, xlabel="slip angle, deg", ylabel="lateral force, N")
            handles, labels = axis.get_legend_handles_labels()
            unique = sorted(dict(zip(labels, handles, strict=True)).items(), key=lambda one: one[0] in LAWS.values())
            axis.legend([handle for _, handle in unique], [label for label, _ in unique], loc="upper left")
        axes["words"].set_axis_off()
        axes["words"].text(0.0, 0.95, WORDS, va="top", linespacing=1.5)
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
