"""Optimal control problem, NMPC, and plugs for other controllers."""
