"""Sampling times shared by estimator, generated code and example drives."""

STEP = 0.012
"""s: time step of the paper's filter (section V); nominal step of a generated library."""
