"""The filter against FilterPy's, on the full soft-soil model."""

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints
from filterpy.kalman import UnscentedKalmanFilter as FilterPy

from drives import clay_bicycle, clay_drive
from softsoil.codegen.discretize import discretize
from softsoil.estimator.terrain import terrain_model
from softsoil.estimator.ukf import UnscentedKalmanFilter
from softsoil.recording.noise import add_noise
from softsoil.recording.states import measured_states
from softsoil.windows.inputs import measured_inputs

TOLERANCE = 1e-10
"""Rounding of two orders of summation over some hundred steps."""
Q = np.array([0.02, 0.02, 0.002, 0.1, 0.05, 0.02, 0.002, 0.002]) ** 2 * 0.012
R = np.array([1.2, 1.2, 0.0175, 0.25, 0.25, 0.0175]) ** 2


def test_filter_equals_filterpy_on_the_soft_soil_bicycle():
    model = terrain_model(clay_bicycle(), tied=False)
    drive = add_noise(clay_drive(3.0), "table5", 1)
    u, y = measured_inputs(drive, model.external)[0], measured_states(drive)
    # A first guess sure enough of n that no sigma point meets its bounds, which FilterPy does not know.
    x0, p0 = np.concatenate([y[0], [0.6, 0.6]]), np.concatenate([R, [0.02**2, 0.02**2]])
    ours = UnscentedKalmanFilter(model, drive.dt, q=Q, r=R, x0=x0, p0=p0)
    step, p = discretize(model, drive.dt), model.p.nominal
    points = MerweScaledSigmaPoints(8, alpha=1.0, beta=2.0, kappa=0.0)

    def move(x, dt, u):
        return np.asarray(step(x, u, p))[:, 0]

    theirs = FilterPy(8, 6, drive.dt, hx=lambda x: x[:6], fx=move, points=points)
    theirs.x, theirs.P, theirs.Q, theirs.R = x0.copy(), np.diag(p0), np.diag(Q), np.diag(R)
    moved = 0.0
    for k in range(len(drive) - 1):
        ours.predict(u[k])
        theirs.predict(u=u[k])
        if k % 2:
            # Sigma points are redrawn between prediction and update, in FilterPy's older versions by hand.
            theirs.sigmas_f = points.sigma_points(theirs.x, theirs.P)
            ours.update(y[k + 1])
            theirs.update(y[k + 1])
        assert np.allclose(ours.x, theirs.x, rtol=0, atol=TOLERANCE)
        assert np.allclose(ours.P, theirs.P, rtol=0, atol=TOLERANCE)
        moved = max(moved, abs(ours["n_f"] - 0.6))
    assert moved > 1e-3  # the estimate was on its way, so the comparison meant something
