"""Many independent runs: cut into chunks, computed anywhere, kept on disk as they finish."""

from chaosdrill.sweep.parts import Parts
from chaosdrill.sweep.schedule import execute
from chaosdrill.sweep.task import Task

__all__ = ["Parts", "Task", "execute"]
