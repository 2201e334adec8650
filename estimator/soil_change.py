"""The test for another soil: whether innovations of the last seconds say that n has jumped, and by how much.

Generalised likelihood ratio of a jump of one state (Willsky and Jones, IEEE Trans. Automatic Control 21, 1976), in scalar form.
An n that is wrong by D moves the innovation nu_i of measurement i by H_i D, H_i = P_in / P_nn before the update, as long as n
stays where it is. From each past time on, with W_i the variance of an innovation,

    N = sum H_i nu_i / W_i,   M = sum H_i^2 / W_i,   D = N / M with the variance v = 1 / M + e^2,

e being what the model's error adds to any D. A jump of standard deviation d is likelier than none by the statistic

    T^2 = D^2 / v - D^2 / (v + d^2) = N^2 d^2 / ((1 + e^2 M) (1 + (e^2 + d^2) M)).

In W what a right model always misses of a measurement (`output_error`) is left out: it is the same before a change and after.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from softsoil.estimator.tuning import Tuning

Array = NDArray[np.float64]
CHANGE_SAMPLES = 20
"""Times in the last `change_after` seconds at which n may have jumped."""
CHANGE_YOUNGEST = 5
"""Of these, the latest that do not decide whether, only from when: a second of innovations is noise and errors of one turn."""
CHANGE_CLIP = 2.0
"""Standard deviations of an innovation that count for a change of soil at most."""
CLOCK_SLACK = 1e-6
"""s: clocks that count in steps differ by rounding."""


class SoilChange:
    """Sums from each of CHANGE_SAMPLES past times on, for each n.

    tuning: change_after (s), change_sigmas, change_std, change_error; axles: how many n there are.
    """

    def __init__(self, tuning: Tuning, axles: int) -> None:
        self._every = tuning.change_after / CHANGE_SAMPLES
        self._limit, self._jump, self._error = tuning.change_sigmas**2, tuning.change_std**2, tuning.change_error**2
        self._score, self._information = np.zeros((axles, CHANGE_SAMPLES)), np.zeros((axles, CHANGE_SAMPLES))
        self.forget(0.0)

    def forget(self, begins: float) -> None:
        """Leave all sums behind; the first of the new ones begin at `begins` (s)."""
        self._kept, self._next, self._due = 0, 0, begins

    def stand(self, t: float, dt: float) -> None:
        """A vehicle stands from t (s) on for dt (s): what is not due yet is so much later."""
        if self._due > t:
            self._due += dt

    def see(self, t: float, score: Array, information: Array) -> Array:
        """(A,) jump of each n, 0 where there is none, after an update at t (s) with score, information (A,) from `evidence`."""
        if t > self._due - CLOCK_SLACK:
            self._score[:, self._next] = self._information[:, self._next] = 0.0
            self._next, self._kept = (self._next + 1) % CHANGE_SAMPLES, min(self._kept + 1, CHANGE_SAMPLES)
            self._due = max(self._due, t - self._every) + self._every
        n, m = self._score[:, : self._kept], self._information[:, : self._kept]
        if not self._kept:
            return np.zeros(len(n))
        n += score[:, None]
        m += information[:, None]
        spread = 1 + (self._error + self._jump) * m
        likelier = n**2 * self._jump / ((1 + self._error * m) * spread)
        old = (self._next - 1 - np.arange(self._kept)) % CHANGE_SAMPLES >= CHANGE_YOUNGEST
        jumped = (likelier[:, old] > self._limit).any(axis=1)
        best = np.arange(len(n)), likelier.argmax(axis=1)
        return np.where(jumped, self._jump * n[best] / spread[best], 0.0)


def evidence(innovation: Array, variance: Array, share: Array) -> tuple[Array, Array]:
    """(A,) score N and information M that one update adds.

    innovation, variance (I,): of each measurement in use; share (A, I): H. No innovation counts for more than CHANGE_CLIP
    standard deviations: an outlier is no soil.
    """
    most = CHANGE_CLIP * np.sqrt(variance)
    return share @ (np.clip(innovation, -most, most) / variance), share**2 @ (1 / variance)
