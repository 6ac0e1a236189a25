"""What analyses, methods and systems declare, for the rooms below them; none is known by name here."""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from threading import RLock
from typing import Any
from unicodedata import is_normalized

from chaosdrill.files import signals_wait

MOST_BYTES = 256
"""Of a name in NetCDF."""

ADDED_BYTES = 56
"""By which results lengthen the names of users, at most."""

# one for all, since those who look up analyses look up methods meanwhile; a process that is forked then would find it
# held for ever, and some of the entries
_completing = RLock()
os.register_at_fork(before=_completing.acquire, after_in_parent=_completing.release, after_in_child=_completing.release)


class Declared(Mapping[str, Any]):
    """Entries by name; a function imports all of them and returns their order, once one is sought that is not there."""

    def __init__(self) -> None:
        self._entries: dict[str, Any] = {}
        self._complete: Callable[[], Iterable[str]] | None = None

    def enter(self, name: str, entry: Any) -> None:
        """Declare one."""
        self._entries[name] = entry

    def completed_by(self, complete: Callable[[], Iterable[str]]) -> None:
        """Say how all of them come to be declared, and what their order is, whatever was imported first."""
        self._complete = complete

    def _all(self) -> dict[str, Any]:
        with _completing:
            if self._complete is not None:
                # what Ctrl-C raises while a class is made comes out as another error
                with signals_wait():
                    complete, self._complete = self._complete, None
                    try:
                        self._entries = {name: self._entries[name] for name in complete()}
                    except BaseException:
                        # such as too many open files: they may be fewer the next time
                        self._complete = complete
                        raise
        return self._entries

    def __getitem__(self, name: str) -> Any:
        known = self._entries
        return known[name] if name in known else self._all()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())


ANALYSES = Declared()
"""By kind, of the class `chaosdrill.analysis.base.Analysis`."""

METHODS = Declared()
"""By name, of the class `chaosdrill.engine.methods.Method`."""

DISPLAYS: dict[str, Callable[[Any], str | None]] = {}
"""How a system is displayed, as "html" and "latex": pages are made far above the model."""

Event = tuple[tuple[Any, ...], dict[str, Any]]


def event(*arguments: Any, **keywords: Any) -> Event:
    """An event of a system of the library: arguments of `Transition`, which is made when the system is built."""
    return arguments, keywords


KEPT: dict[str, Callable[[Any], Any]] = {}
"""How to "recall" what earlier processes have kept of a system: files are kept above the model."""


def unfit(name: str) -> str | None:
    """Why no quadrature, swept parameter or state of a grid can have a name; None if it can.

    They become variables of results and so of archives.
    """
    return "is reserved for results" if name in reserved() else unstorable(name, MOST_BYTES - ADDED_BYTES)


def unstorable(name: str, most: int = MOST_BYTES) -> str | None:
    """Why nothing in an archive can have a name; None if it can. ``most``: bytes that it may take."""
    if not name or (name[0].isascii() and not (name[0].isalnum() or name[0] == "_")):
        return f"begins with {name[:1]!r}, which no name in an archive can"
    if name.endswith(" ") or any(letter < " " or letter in "/\x7f" for letter in name):
        return "holds '/' or a control character, or ends with a blank, which no name in an archive can"
    if len(name.encode(errors="replace")) > most:
        return f"takes more than the {most} bytes that a name in an archive may take"
    if not is_normalized("NFC", name):
        return "would be written otherwise in an archive, in Unicode's composed form"
    return None


@cache
def reserved() -> frozenset[str]:
    """Names of the variables and dimensions of results, which no quadrature and no swept parameter can have.

    Only results that hold names of users count: they alone have placeholders.
    """
    entries = (entry for entry in ANALYSES.values() if entry.settings.reserves)
    tables = (entry.variables for entry in entries if any("{" in one.name for one in entry.variables))
    variables = (variable for table in tables for variable in table)
    names = {name for variable in variables for name in (variable.name, *variable.dims)}
    # placeholders stand in braces
    return frozenset(name for name in names if not name.startswith("{"))
