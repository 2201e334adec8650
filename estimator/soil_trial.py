"""The second look at a change of soil: whether the seconds after a jump of n bear it out.

A jump (`soil_change.py`) opens n by the standard deviation d of jumps, so that n is then what the seconds after it say. As soon
as these determine it to d / 3, its distance D from the n before the jump is judged. Without a jump D has the variance

    v = v_new + v_old + e^2,

e being what the model's error adds to any D, with one v + d^2. Where none is likelier,

    D^2 / v - D^2 / (v + d^2) < ln(1 + d^2 / v),

what was known of n before counts again: as a measurement of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.tuning import Tuning

Array = NDArray[np.float64]
DETERMINED = 1 / 3
"""Standard deviation of n, as a share of change_std, at which the trial of a jump ends."""


class SoilTrial:
    """The last jump's old n, for as long as it is on trial.

    tuning: change_std, change_error; walk (A,): variance that each n gains in a second.
    """

    def __init__(self, tuning: Tuning, walk: Array) -> None:
        self._jump, self._error, self._walk = tuning.change_std**2, tuning.change_error**2, walk
        self.end()

    def end(self) -> None:
        """Nothing is on trial."""
        self.t, self.stands = 0.0, False
        self.n, self._variance = np.zeros(len(self._walk)), np.zeros(len(self._walk))

    def begin(self, t: float, n: Array, variance: Array, jumped: NDArray[np.bool_]) -> None:
        """n (A,), variance (A,): known at t (s) just before those n `jumped` (A,) were put elsewhere."""
        self.t, self.stands = t, False
        self.n, self._variance = n, np.where(jumped, variance, 0.0)

    def judge(self, t: float, n: Array, variance: Array) -> Array:
        """(A,) variance with which the old n counts again, 0 where it does not; n (A,), variance (A,): known at t (s)."""
        due = (self._variance > 0) & (variance <= DETERMINED**2 * self._jump)
        old, away = self._variance + self._walk * (t - self.t), (n - self.n) ** 2
        v = variance + old + self._error
        revoked = due & (away * self._jump < v * (v + self._jump) * np.log(1 + self._jump / v))
        self.stands = self.stands or bool(np.any(due & ~revoked))
        self._variance[due] = 0.0
        return np.where(revoked, old, 0.0)

    @property
    def over(self) -> bool:
        """Whether nothing is on trial."""
        return not self._variance.any()
