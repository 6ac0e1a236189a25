"""The command line."""

import os
import sys
from collections.abc import Sequence
from contextlib import suppress

__all__ = ["main"]

_INTERRUPTED = 130
_DOCUMENT = '{"error": {"exit_code": 130, "kind": "KeyboardInterrupt", "message": "interrupted"}}\n'


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    ``arguments`` are by default those of the process.

    Returns: the exit code.
    """
    try:
        # Ctrl-C may come while the commands are imported
        from chaosdrill.cli.program import main as program

        return program(arguments)
    except KeyboardInterrupt:
        with suppress(OSError):
            if "--json" in (sys.argv[1:] if arguments is None else arguments):
                os.write(1, _DOCUMENT.encode())
            os.write(2, b"\ninterrupted\n")
        return _INTERRUPTED
