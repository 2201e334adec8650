"""What consumes measurements: filter, moving horizon, verdict on n, prediction windows."""
