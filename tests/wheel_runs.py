"""Single-wheel runs made for tests: a yaw sine, and forces that a law gives."""

from dataclasses import replace

import numpy as np

from softsoil.calibration.single_wheel import predict
from softsoil.recording.rig import SOIL_KEYS, WheelRun
from softsoil.symbolic.soil import CLAY

SOIL = {key: float(getattr(CLAY, key)) for key in SOIL_KEYS}


def sine_run(amplitude=0.3, n=0.6, slip=0.1, load=2500.0):
    """A run with zero forces: speed 5 m/s, yaw sine of 1 Hz."""
    t = np.arange(0, 1.5, 0.005)
    yaw = amplitude * np.sin(2 * np.pi * t)
    rate = np.gradient(yaw, 0.005)
    v_y = -5 * np.sin(yaw)
    return WheelRun(
        "sine", "clay", {**SOIL, "n": n}, 0.35, 0.21, slip, 0.005,
        v_x=5 * np.cos(yaw), v_y=v_y, omega=np.full(len(t), 5 / 0.35 / (1 - slip)), yaw_rate=rate, steer_rate=rate,
        dv_y=np.gradient(v_y, 0.005), load=np.full(len(t), load), f_x=0 * t, f_y=0 * t, yaw=yaw,
    )  # fmt: skip


def own_data(runs, law):
    """The runs with the forces that `law` gives them."""
    outs = predict(law, runs)
    return [replace(run, f_x=out[0], f_y=out[1], sinkage=out[3]) for run, out in zip(runs, outs, strict=True)]
