"""The model as mathematics."""
