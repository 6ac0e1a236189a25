"""Many independent runs: divided into chunks, computed anywhere, and stored as they finish."""

from chaosdrill.sweep.parts import Parts
from chaosdrill.sweep.schedule import execute

__all__ = ["Parts", "execute"]
