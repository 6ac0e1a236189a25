"""Periodic orbits of hybrid systems: shooting, continuation in parameters, and bifurcations along the way."""
