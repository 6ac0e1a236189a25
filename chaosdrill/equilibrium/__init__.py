"""Equilibria of modes: where they are, what they are, and what becomes of them along a parameter."""
