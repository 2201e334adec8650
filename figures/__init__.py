"""Plots, reports and animations."""
