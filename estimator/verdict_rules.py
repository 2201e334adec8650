"""The limits of a verdict on n, as numbers."""

from __future__ import annotations

from dataclasses import dataclass, replace

from softsoil.checking.clocks import FILTERED
from softsoil.estimator.late_change import PARTS, PARTS_SIGMAS
from softsoil.symbolic.model import Model

OWN_MARGIN, OWN_MOST = 1.3, 2.0
"""What a vehicle's model leaves of other drives over what it leaves of its own logs, at most; the most that may be, over what a
right model leaves."""
STATED_SIGMAS, MOST_STATED = 4.0, 0.2
"""Standard deviations of the joint error by which an identified yaw inertia may be off: two of those that `identify` prints,
which count four of the fit's for one, and the joint error two; and the share of it that this is at most."""


@dataclass(frozen=True)
class VerdictRules:
    """Limits of the verdict; `python -m benchmarks.verdicts` prints how often each is right.

    excited: largest standard deviation of n by noise and model error alone, over n (two of them are `same`); same: largest
    difference of the final n between initial guesses, or between the filter and the windows, over n; bound: distance from a
    bound of n within which it is one; apart, apart_sigmas: difference of the axles' n over their mean, and in standard
    deviations, from which they disagree; unexplained: of yaw rate and lateral velocity, share of their motion (root mean square)
    that a right model leaves at most; unexplained_sigmas: standard errors beyond that by which it must be exceeded; inertia,
    inertia_sigmas: share by which the drive contradicts the declared yaw inertia, and in standard deviations, from which n is
    not trusted; inertia_known: largest standard deviation with which it can, as a circle hardly shows an inertia; inertia_stated:
    share by which an identified one may be off by its own error, which n's includes, without that; strain: of the
    numbers of an identified vehicle, from which it has changed; load, load_sigmas: share of its mass by which it is heavier or
    lighter than declared, and in standard deviations, from which it has; load_seen: largest standard deviation of that share
    with which a drive shows a load that n would take up; steering, steering_sigmas: share by which road wheels turn farther or
    less than the log says, and in standard deviations, from which they do; parts, parts_sigmas: the same of n in the earlier and
    the later part of the drive, over n; least_motion: root mean square lateral specific force (m/s^2) below which nothing is
    said of the model; road: coefficient of friction from which a drive that hard ground fits better than soil, by `road_sigmas`
    standard errors, was on hard ground; of_class: largest standard deviation of n, over n, by the errors that the soil's file
    states of its class; of_law: the same by what a right law misses of the axles' forces; late: seconds by which a low-pass may
    have made the yaw rate late; contradicted: the declared things whose numbers their own logs contradict ("vehicle", "soil").
    """

    excited: float = 0.05
    same: float = 0.10
    bound: float = 0.02
    apart: float = 0.13
    apart_sigmas: float = 2.5
    unexplained: tuple[tuple[str, float], ...] = (("omega_z", 0.022), ("v", 0.10))
    unexplained_sigmas: float = 2.0
    inertia: float = 0.12
    inertia_sigmas: float = 3.0
    inertia_known: float = 0.2
    inertia_stated: float = 0.0
    strain: float = 3.5
    load: float = 0.08
    load_sigmas: float = 2.5
    load_seen: float = 0.06
    steering: float = 0.04
    steering_sigmas: float = 2.5
    parts: float = PARTS
    parts_sigmas: float = PARTS_SIGMAS
    least_motion: float = 0.2
    road: float = 0.4
    road_sigmas: float = 1.0
    of_class: float = 0.10
    of_law: float = 0.04
    late: float = FILTERED
    contradicted: tuple[str, ...] = ()

    def of(self, model: Model) -> VerdictRules:
        """The limits for a vehicle whose file states what its numbers leave unexplained of its own logs (`OWN_MARGIN`), and the
        error of its yaw inertia (`STATED_SIGMAS`).

        model: of the vehicle.
        """
        own: dict[str, float] = getattr(model.geometry, "unexplained", {})
        limits = [(name, OWN_MARGIN * own.get(name, 0.0), limit) for name, limit in self.unexplained]
        wider = tuple((name, min(max(mine, limit), OWN_MOST * limit)) for name, mine, limit in limits)
        joint = getattr(model.geometry, "joint_error", None)
        stds = {} if joint is None else dict(zip(joint.names, joint.std, strict=True))
        stated = STATED_SIGMAS * stds.get("yaw_inertia", 0.0) / getattr(model.geometry, "yaw_inertia", 1.0)
        return replace(self, unexplained=wider, inertia_stated=min(stated, MOST_STATED), contradicted=model.doubted)

    def another_mass(self, load: float, std: float) -> bool:
        """Whether a vehicle is heavier or lighter than declared.

        load, std: share of its mass by which it is heavier, and the standard deviation of that.
        """
        return abs(load) > max(self.load, self.load_sigmas * std)
