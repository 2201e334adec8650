"""Case studies on measured data."""
