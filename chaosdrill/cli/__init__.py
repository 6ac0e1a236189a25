"""The command line: one file a command."""

from chaosdrill.cli.main import main

__all__ = ["main"]
