"""The command ``chaosdrill``: its commands, and what its exit codes mean."""

import io
import os
import sys
from collections.abc import Sequence
from contextlib import suppress

import click

from chaosdrill.cli.commands import check, cite, info, list_names, new, plot, report, verify, warm
from chaosdrill.cli.interrupts import second_one_ends
from chaosdrill.cli.run import run
from chaosdrill.cli.streams import emit_error, tell, usable_streams
from chaosdrill.errors import ChaosdrillError, ModelError, SceneError, SettingsError, check_environment
from chaosdrill.version import __version__

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="chaosdrill")
def chaosdrill() -> None:
    """Simulate and analyse hybrid systems: impacts, stick-slip and jumps.

    The input is a scene (a TOML file), the output an archive (NetCDF).

    A first result:

    \b
      chaosdrill new lorenz > scene.toml
      chaosdrill run scene.toml -o lorenz.nc
      chaosdrill report lorenz.nc

    Exit codes: 0 success, whatever the outcome of the runs; 1 an archive cannot be read or written, memory ran out,
    or a comparison failed; 2 the scene or the command line is invalid; 130 interrupted.

    With --json every command prints one JSON document to stdout; an error is {"error": {...}}.
    """


for command in (new, run, check, plot, report, verify, info, cite, warm, list_names):
    chaosdrill.add_command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line, as `chaosdrill.cli.main`."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    if arguments is None and os.environ.get("MPLBACKEND", "").startswith("module://"):
        # a notebook's own backend, which another environment than that of its kernel lacks; commands open no window
        os.environ["MPLBACKEND"] = "agg"
    with usable_streams(), second_one_ends(INTERRUPTED, last=arguments is None):
        try:
            check_environment()
            return chaosdrill.main(given, prog_name="chaosdrill", standalone_mode=False) or DONE
        except (Exception, KeyboardInterrupt) as fault:
            if (told := _told(fault)) is None:
                raise
            code, kind, message = told
            if code == INTERRUPTED:
                # Python ends by the signal if the interrupt has passed through code that was given as text, as those
                # of numba and sympy, unless such code has run since
                exec("")
            with suppress(OSError):
                if "--json" in given:
                    emit_error(code, kind, message, getattr(fault, "problems", None))
            if isinstance(fault, click.ClickException):
                shown = io.StringIO()
                fault.show(shown)
                tell(shown.getvalue().rstrip("\n"))
            else:
                tell(message)
            return code


def _told(fault: BaseException) -> tuple[int, str, str] | None:
    """Exit code, kind and text of an exception; None for a bug of the program."""
    if isinstance(fault, click.ClickException):
        return fault.exit_code, "UsageError", fault.format_message()
    if isinstance(fault, click.Abort | KeyboardInterrupt):
        return INTERRUPTED, "KeyboardInterrupt", "\ninterrupted"
    if isinstance(fault, FileNotFoundError | SceneError):
        try:
            os.getcwd()
        except FileNotFoundError:
            # its name still leads to it
            return FAILED, "OSError", "the working directory has been removed; change to another one"
    if isinstance(fault, OSError):
        # the fault lies in the file, not in the program
        return FAILED, "OSError", f"{fault.filename}: {fault.strerror}" if fault.filename else str(fault)
    if isinstance(fault, MemoryError):
        text = f"not enough memory for the result; reduce the number of periods, samples or points ({fault})"
        return FAILED, "MemoryError", text
    if isinstance(fault, ChaosdrillError):
        code = WRONG_INPUT if isinstance(fault, SceneError | SettingsError | ModelError) else FAILED
        kind = next(base for base in type(fault).__mro__ if base.__module__ == ChaosdrillError.__module__)
        return code, kind.__name__, str(fault)
    return None
