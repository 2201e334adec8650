"""A drive in whose middle the vehicle stops, reverses in a curve, and goes on."""

import numpy as np

from softsoil.checking.usable import mark_checked
from softsoil.recording.drive import STATE_CHANNELS, WHEEL_CHANNELS, Recording


def with_reversing(drive, at, back=4.0, speed=1.0, steer=0.2, l_f=1.546, l_r=1.175, radius=0.33):
    """The drive, stopped near `at` (s after its start) where it goes straight on, reversed for `back` s at `speed` (m/s) with the
    wheels at `steer` (rad), and gone on from where that ends; and the time at which it goes on.

    l_f, l_r, radius: of the vehicle (m), whose front axle is at (x, y). Its wheels roll without slip.
    """
    dt, channels = drive.dt, drive.channels
    near = np.arange(int((at - 1.5) / dt), int((at + 1.5) / dt))
    row = int(near[np.argmin(np.abs(drive["omega_z"][near]) + np.abs(drive["steer"][near]) + np.abs(drive["v"][near]))])
    before = float(drive["u"][row])

    def ramp(start, end, rate):
        return np.linspace(start, end, max(int(abs(end - start) / rate / dt), 2))

    stopping, reverse = ramp(before, 0.0, 2.0), [ramp(0.0, -speed, 1.0), np.full(int(back / dt), -speed), ramp(-speed, 0.0, 1.0)]
    u = np.concatenate([stopping, np.zeros(int(1.0 / dt)), *reverse, np.zeros(int(0.5 / dt)), ramp(0.0, before, 1.5)])
    turned = np.where(u < 0.0, steer, 0.0)
    omega = u * np.tan(turned) / (l_f + l_r)
    v, psi, aside = l_r * omega, drive["psi"][row] + np.cumsum(omega) * dt, (l_f + l_r) * omega
    x = drive["x"][row] + np.cumsum(u * np.cos(psi) - aside * np.sin(psi)) * dt
    y = drive["y"][row] + np.cumsum(u * np.sin(psi) + aside * np.cos(psi)) * dt
    between = dict.fromkeys(channels, np.zeros(len(u))) | {
        "x": x, "y": y, "psi": psi, "u": u, "v": v, "omega_z": omega, "steer": turned,
        "a_x_imu": np.gradient(u, dt) - v * omega, "a_y_imu": np.gradient(v, dt) + u * omega,
        **dict.fromkeys(WHEEL_CHANNELS, u / radius),
    }  # fmt: skip
    after = {name: values[row:].copy() for name, values in channels.items()}
    turn, (there_x, there_y) = psi[-1] - after["psi"][0], (after[name] - after[name][0] for name in STATE_CHANNELS[:2])
    after["psi"] += turn
    after["x"] = x[-1] + there_x * np.cos(turn) - there_y * np.sin(turn)
    after["y"] = y[-1] + there_x * np.sin(turn) + there_y * np.cos(turn)
    joined = {name: np.concatenate([channels[name][:row], between[name], after[name]]) for name in channels}
    joined["t"] = drive.t[0] + dt * np.arange(len(joined["u"]))
    return mark_checked(Recording("reversing", joined)), float(joined["t"][row + len(u)])
