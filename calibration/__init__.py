"""Force laws from single-wheel runs."""
