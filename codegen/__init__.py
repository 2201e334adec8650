"""A Model becomes C: compile and call, lanes, instruction order, C library."""
