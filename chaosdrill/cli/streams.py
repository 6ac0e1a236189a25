"""Code shared by commands: options, results as JSON, and standard output and error.

The streams may be closed, full, abandoned by their reader, or limited in encoding. The work of a command does not
depend on its reader: without one, nothing is written, and a letter that the output cannot encode is escaped. Output
lost to a full disk is an error; a lost message on standard error is not.
"""

import json
import math
import os
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout, suppress
from io import TextIOWrapper
from typing import Any

import click

from chaosdrill.names import visible, visible_json
from chaosdrill.scene.changes import parse_change

json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON document, also for errors.")


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
        warnings.formatwarning = lambda message, *_: f"{visible(str(message))}\n"
        yield


def say(text: str) -> None:
    """Print a line of a result on standard output.

    Raises `OSError` if it cannot be written, unless the reader has left.
    """
    try:
        click.echo(visible(text))
    except BrokenPipeError:
        pass
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, "standard output") from fault


def tell(text: str) -> None:
    """Print a message on standard error, if that is possible."""
    with suppress(OSError):
        click.echo(visible(text), err=True)


def _settle() -> None:
    """Discard unwritten output, so that it is not retried when the process exits."""
    try:
        sys.stdout.flush()
    except OSError:
        with suppress(OSError), _nowhere() as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _nowhere() -> TextIOWrapper:
    return open(os.devnull, "w", encoding="utf-8")


def _occupy() -> None:
    """Occupy the numbers of closed standard streams, so that no file opened later takes them."""
    while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass
    os.close(handle)


def answer(as_json: bool, document: Mapping[str, Any], text: str) -> None:
    """Print the result of a command on standard output: the document as JSON, or its text for people."""
    if as_json:
        emit(document)
    else:
        say(text)


def emit(document: Mapping[str, Any]) -> None:
    """Print a result as JSON, with letters of all alphabets as far as the output's encoding allows."""
    plain = strict(document)
    text = json.dumps(plain, indent=2, allow_nan=False, ensure_ascii=False)
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    # names of files need not be text
    except UnicodeEncodeError:
        text = json.dumps(plain, indent=2, allow_nan=False)
    say(visible_json(text))


def emit_error(code: int, kind: str, message: str, problems: Sequence[Mapping[str, Any]] | None) -> None:
    """Print an error as JSON, with all problems of an invalid scene.

    ``kind`` is ``UsageError``, the name of a class of `chaosdrill.errors`, ``OSError``, ``MemoryError`` or
    ``KeyboardInterrupt``.
    """
    document: dict[str, Any] = {"error": {"exit_code": code, "kind": kind, "message": message.strip()}}
    if problems is not None:
        document = {"valid": False, **document, "problems": problems}
    emit(document)


def strict(value: Any) -> Any:
    """Plain values for every JSON reader: NaN becomes null, infinities the texts ``"inf"`` and ``"-inf"``."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): strict(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [strict(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else str(value)
    return value


def given_text(text: str) -> str:
    """Text of the command line, which is UTF-8 whatever the locale."""
    try:
        return text.encode("utf-8", "surrogateescape").decode("utf-8")
    except UnicodeError:
        return text


def _changes(_context: click.Context, _option: click.Parameter, given: tuple[str, ...]) -> dict[str, Any]:
    return dict(parse_change(given_text(text)) for text in given)


changes_option = click.option(
    "--set",
    "changes",
    multiple=True,
    metavar="KEY=VALUE",
    callback=_changes,
    help="Set a value of the scene, as in system.parameters.eta=0.5; may be repeated.",
)
