"""Logs in and out: drives as named channels in SI units, with their checks. No model, no estimate."""
