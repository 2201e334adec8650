"""Logs in and out: drives as named channels in SI units, on one clock. No model, no estimate."""
