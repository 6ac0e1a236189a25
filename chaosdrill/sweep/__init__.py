"""Many independent runs: divided into chunks, computed anywhere, and stored as they finish."""

from chaosdrill.sweep.parts import Parts
from chaosdrill.sweep.schedule import execute
from chaosdrill.sweep.task import Task

__all__ = ["Parts", "Task", "execute"]
