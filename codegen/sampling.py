"""Sampling times shared by estimator, generated code and example drives."""

STEP = 0.012
"""s: time step of the paper's filter (section V); nominal step of a generated library."""
LONGEST_STEP = 1.5 * STEP
"""s: longest step of a terrain filter's model; a longer prediction is divided into equal steps."""
