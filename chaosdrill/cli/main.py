"""The command ``chaosdrill``: its commands, and what its exit codes mean."""

import os
import sys
from collections.abc import Sequence

import click

from chaosdrill import __version__
from chaosdrill.cli.check import check
from chaosdrill.cli.info import info
from chaosdrill.cli.list import list_names
from chaosdrill.cli.plot import plot
from chaosdrill.cli.run import run
from chaosdrill.cli.verify import verify
from chaosdrill.errors import ChaosdrillError, ModelError, SceneError, SettingsError

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="chaosdrill")
def chaosdrill() -> None:
    """Chaos in systems that flow, hit, stick and slip.

    A scene (a TOML file) goes in, an archive (NetCDF) comes out.

    Exit codes: 0 done, whatever the outcome of the runs; 1 an archive cannot be read or written, memory is short,
    or a comparison differs; 2 the scene or the command line is wrong; 130 interrupted.
    """


for command in (run, check, plot, verify, info, list_names):
    chaosdrill.add_command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments : sequence of str, optional
        Default: those of the process.

    Returns
    -------
    int
        The exit code.
    """
    try:
        code = chaosdrill.main(arguments, prog_name="chaosdrill", standalone_mode=False)
        sys.stdout.flush()
        return code or DONE
    except click.ClickException as fault:
        fault.show()
        return fault.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("\ninterrupted", err=True)
        return INTERRUPTED
    except BrokenPipeError:
        # whoever read the output has left; what is still buffered must not raise once more at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except MemoryError as fault:
        click.echo(f"not enough memory for the result; ask for fewer periods, samples or points ({fault})", err=True)
        return FAILED
    except ChaosdrillError as fault:
        click.echo(str(fault), err=True)
        return WRONG_INPUT if isinstance(fault, SceneError | SettingsError | ModelError) else FAILED
