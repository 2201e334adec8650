"""The loop closed with data: residual, missing effect, refined model."""
