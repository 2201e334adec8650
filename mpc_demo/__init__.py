"""The demonstration: scenarios, closed loop, studies."""
