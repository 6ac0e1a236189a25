"""Standard output and error, which may be closed, full, left by their reader, or know few letters.

What a command has done does not depend on who listens: where nobody reads, nothing is written, and where a letter is
not known, its code is. Output that a full disk loses is a fault; a message on standard error that is lost is none.
"""

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout, suppress
from io import TextIOWrapper

import click


@contextmanager
def usable_streams() -> Iterator[None]:
    """While the block runs there are both streams, standard output takes every letter, and a warning is a line."""
    with ExitStack() as stack:
        _occupy()
        if sys.stdout is None:
            stack.enter_context(redirect_stdout(stack.enter_context(_nowhere())))
        if sys.stderr is None:
            stack.enter_context(redirect_stderr(stack.enter_context(_nowhere())))
        if isinstance(sys.stdout, TextIOWrapper):
            stack.callback(sys.stdout.reconfigure, errors=sys.stdout.errors)
            sys.stdout.reconfigure(errors="backslashreplace")
        stack.callback(_settle)
        stack.callback(setattr, warnings, "formatwarning", warnings.formatwarning)
        # where in the package a warning comes from is of no use here
        warnings.formatwarning = lambda message, *_: f"{message}\n"
        yield


def say(text: str) -> None:
    """Print a line of a result on standard output.

    Raises
    ------
    OSError
        If it cannot be written, but for a reader that has left.
    """
    try:
        click.echo(text)
    except BrokenPipeError:
        pass
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, "standard output") from fault


def tell(text: str) -> None:
    """Print a message on standard error, if that is possible."""
    with suppress(OSError):
        click.echo(text, err=True)


def _settle() -> None:
    """Have what could not be written not be tried once more at the end of the process."""
    try:
        sys.stdout.flush()
    except OSError:
        with suppress(OSError), _nowhere() as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _nowhere() -> TextIOWrapper:
    return open(os.devnull, "w", encoding="utf-8")


def _occupy() -> None:
    """Have no file that is opened later take the number of a standard stream that is closed."""
    while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(handle)
