"""Channels of a drive against each other and against the vehicle: what may be used, what is wrong, and how to mend it."""
