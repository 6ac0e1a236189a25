"""The command line."""

from chaosdrill.cli.main import main

__all__ = ["main"]
