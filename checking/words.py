"""The outcome of one check of channels, and the limits that all checks share."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One comparison of channels.

    name: what was compared; channel: the one that the cure is about; passed; found, expected: sentences with numbers and units;
    cure: what to change, empty where passed; beyond_doubt: whether a failed check is a contradiction that no effect of a
    vehicle explains.
    """

    name: str
    channel: str
    passed: bool
    found: str
    expected: str
    cure: str = ""
    beyond_doubt: bool = False

    def sentence(self) -> str:
        """The check in one line: channel, evidence, expectation, cure."""
        return f"{self.channel}: expected {self.expected}; found {self.found}" + (f"; {self.cure}" if self.cure else "")

    def as_json(self) -> dict[str, object]:
        """The entry of import.json."""
        return {
            "name": self.name, "channel": self.channel, "passed": self.passed, "found": self.found, "expected": self.expected,
            "cure": self.cure, "beyond_doubt": self.beyond_doubt,
        }  # fmt: skip


@dataclass(frozen=True)
class Limits:
    """Where a comparison is doubtful and where it is beyond doubt; `python benchmarks/hostile_logs.py` prints the evidence.

    scale, turn, lateral: doubtful departure of a scale from 1 (share), turn of the yaw rate against the heading, lateral
    for v; wrong_scale: (least, largest) scale that is no contradiction;
    sigmas: standard errors from expectation below which nothing is said; heading (rad): doubtful angle between heading and course
    beyond side slip; wrong_heading (rad): contradiction; gyro (rad/s), accelerometer (m/s^2): doubtful biases;
    reference (m): doubtful distance of the position from the front axle; sway (m per m/s^2): how far body roll moves a position
    sensor aside per lateral specific force, 0.03 rad/(m/s^2) half a metre above the axle; still (m/s): root mean
    square velocity that a position sensor makes by itself; clock, heading_clock (s): doubtful time offset, and that
    between heading and yaw rate, of which the latter makes n 7 % too low per 0.02 s;
    wheel (least, largest): rim speed over wheel-centre speed that slip can make; wheel_apart: doubtful ratio of a wheel to the
    median of all; steer_gain: (least, largest) front-axle course change over steering that is no contradiction;
    frozen (s): longest stretch without a change while the vehicle moves; saturated, clipped: doubtful and contradictory
    share of samples at one extreme.
    """

    scale: float = 0.05
    turn: float = 0.012
    lateral: float = 0.15
    wrong_scale: tuple[float, float] = (0.6, 1.6)
    sigmas: float = 5.0
    heading: float = 0.02
    wrong_heading: float = 0.35
    gyro: float = 0.005
    accelerometer: float = 0.2
    reference: float = 0.15
    sway: float = 0.015
    still: float = 0.005
    clock: float = 0.08
    heading_clock: float = 0.02
    wheel: tuple[float, float] = (0.5, 2.0)
    wheel_apart: float = 0.08
    steer_gain: tuple[float, float] = (0.2, 2.5)
    frozen: float = 1.0
    saturated: float = 0.02
    clipped: float = 0.1


LIMITS = Limits()
