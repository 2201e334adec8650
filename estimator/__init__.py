"""What consumes measurements: filter, terrain estimator, prediction windows."""
