"""Invariant manifolds: the map of a section, curves that grow by it, where they cross."""
