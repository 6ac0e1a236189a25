"""Periodic orbits of hybrid systems: found by shooting, followed in parameters, with what happens along the way."""
