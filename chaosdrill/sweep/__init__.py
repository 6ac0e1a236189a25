"""Many independent runs: cut into chunks, computed anywhere, kept on disk as they finish."""

from chaosdrill.sweep.schedule import execute
from chaosdrill.sweep.task import Task

__all__ = ["Task", "execute"]
