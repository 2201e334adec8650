"""Numbers of a vehicle from its own logs: windows, wheel balances, fit, standard errors, judgement."""
