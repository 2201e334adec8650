"""Physical effects that a nominal model lacks."""
