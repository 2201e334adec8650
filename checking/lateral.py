"""Lateral velocity against the lateral accelerometer, a_y = dv/dt + u omega_z, and what a disagreement looks most like."""

from __future__ import annotations

import numpy as np

from softsoil.checking.scale import scale_check
from softsoil.checking.words import LIMITS, Check
from softsoil.recording.drive import Array
from softsoil.recording.evidence import Line, Motion, regress

NAME, EXPECTED = "lateral_velocity_rate", "a rate of v of a_y - u omega_z (scale 1)"
STEP, REACH = 0.02, 0.5
"""s: steps and range of the shifts between velocities and accelerometer that are tried."""
FAR, NEAR = 0.6, 0.05
"""m between the places of velocity and accelerometer: beyond the first it is the velocity that is not of the centre of gravity,
below it may be either, and below the second neither is a cause worth naming."""
GRAVITY, STEEPEST = 9.81, 0.4
"""m/s^2, and the largest slope of ground that a vehicle drives on."""
AROUND = 0.7
"""rad: spread of the heading from which on a slope is seen from both sides."""
AS_WELL = 1.15
"""Misfit of a cause, another scale among them, over that of the best, up to which it explains as well."""


def lateral_rate_checks(m: Motion, force: Array, u: Array, v: Array, omega: Array) -> list[Check]:
    """The rate of v by the accelerometer: its scale; where that is wrong, another place or another clock if either explains it.

    force (windows,): mean lateral specific force of each window (m/s^2); u, v (m/s), omega (rad/s), each (N,): velocities.
    """
    line, reverse = _lines(m, force, u, v, omega)
    if line is None or reverse is None:
        return []
    line = line.bracketed(0, reverse)  # whatever the noise of v: a filter's is not white
    if not line.std[0] < 0.15:
        return []
    check = scale_check(NAME, "v", line.only(0), 0, EXPECTED, "correct sign or unit of v", LIMITS.lateral)
    if check.passed:
        return [check]
    # Other causes leave the noise of both sides, as a scale of 1 does.
    causes = [(max(line.scale, reverse.scale), "", check.cure)]
    causes += [c for cause in (_elsewhere, _late, _sloped) if (c := cause(m, force, u, v, omega)) is not None]
    best = min(causes)[0]
    causes = [c for c in causes if c[0] <= AS_WELL * best]
    found = ", or ".join(c[1] for c in causes if c[1])
    found = f"{check.found}; {found} would explain it" if found else check.found
    return [Check(NAME, "v", False, found, EXPECTED, "; or ".join(c[2] for c in causes), check.beyond_doubt)]


def _lines(m: Motion, force: Array, u: Array, v: Array, omega: Array) -> tuple[Line | None, Line | None]:
    """force (windows,) on the rate of v, on what turning makes and a constant; and the rate of v on force and these."""
    force, rate, rest = m.driven(force), m.driven(m.slope(v)), (_turning(m, u, omega), np.ones(m.windows))
    return regress(force, rate, *rest), regress(rate, force, *rest)


def _right(m: Motion, force: Array, u: Array, v: Array, omega: Array, *more: Array) -> Line | None:
    """The same with a v of scale 1, on `more` features (windows,); None where the turning then has a wrong scale."""
    line = regress(m.driven(force - m.slope(v)), _turning(m, u, omega), np.ones(m.windows), *more)
    return line if line is not None and abs(line.value[0] - 1.0) < LIMITS.lateral else None


def _turning(m: Motion, u: Array, omega: Array) -> Array:
    return m.driven(m.slope(m.integral(u * omega)))


def _elsewhere(m: Motion, force: Array, u: Array, v: Array, omega: Array) -> tuple[float, str, str] | None:
    """v of another point of the vehicle, v + x omega_z: misfit (m/s^2), words and cure; None where that is no cause."""
    line = _right(m, force, u, v, omega, m.driven(m.slope(omega)))
    if line is None:
        return None
    x, std = -float(line.value[2]), float(line.std[2])
    if abs(x) < max(NEAR, LIMITS.sigmas * std):
        return None
    side = "ahead of" if x > 0 else "behind"
    if abs(x) < FAR:
        found = f"v of a point {abs(x):.2f} ± {std:.2f} m {side} the accelerometer's in [mount]"
        return line.scale, found, "check the places of the sources of v and of a_y_imu in [mount]"
    found = f"v of a point {abs(x):.1f} ± {std:.1f} m {side} the centre of gravity"
    return line.scale, found, f"give the place of its source in [mount], x = {x:.1f}"


def _late(m: Motion, force: Array, u: Array, v: Array, omega: Array) -> tuple[float, str, str] | None:
    """Velocities, or the yaw rate alone, on another clock than the accelerometer: misfit, words and cure; None for no cause."""
    reach = round(REACH / m.log.dt)
    best: tuple[float, int, str] | None = None
    for lag in range(-reach, reach + 1, max(round(STEP / m.log.dt), 1)):
        late_u, late_v, late_omega = (_shifted(values, lag) for values in (u, v, omega))
        shifted = {"the velocities": (late_u, late_v, late_omega), "the yaw rate": (u, v, late_omega)}
        for words, line in ((source, _right(m, force, *channels)) for source, channels in shifted.items()):
            if line is not None and (best is None or line.scale < best[0]):
                best = line.scale, lag, words
    if best is None or abs(best[1]) * m.log.dt < LIMITS.clock:
        return None
    late = best[1] * m.log.dt
    found = f"{best[2]} {abs(late):.2f} s {'late' if late > 0 else 'early'} against the accelerometer"
    return best[0], found, f"shift the source of {best[2]}, or leave the accelerometer out"


def _sloped(m: Motion, force: Array, u: Array, v: Array, omega: Array) -> tuple[float, str, str] | None:
    """Ground that slopes one way, which the accelerometer sees by the heading: misfit, words and cure; None for no cause."""
    heading = m.mean(m.channel("psi"))
    if not np.isfinite(heading).any():
        return None
    heading = heading - np.nanmean(heading)
    turned = [np.sin(heading)] + ([np.cos(heading)] if np.nanstd(heading) > AROUND else [])  # else that is the constant
    line = _right(m, force, u, v, omega, *turned)
    if line is None:
        return None
    slope, std = np.linalg.norm(line.value[2:]) / GRAVITY, np.max(line.std[2:]) / GRAVITY
    if not LIMITS.sigmas * std < slope < STEEPEST:
        return None
    return line.scale, f"ground that slopes by {100 * slope:.1f} ± {100 * std:.1f} %", "nothing is wrong with v on such ground"


def _shifted(values: Array, lag: int) -> Array:
    """(N,) values (N,) `lag` samples earlier, NaN where nothing is known."""
    out = np.full(len(values), np.nan)
    if lag >= 0:
        out[: len(values) - lag] = values[lag:]
    else:
        out[-lag:] = values[:lag]
    return out
