"""The exceptions that users of chaosdrill meet."""

import os

from chaosdrill.names import visible

__all__ = ["ArchiveError", "ChaosdrillError", "ModelError", "SceneError", "SettingsError", "StartWarning"]

_LAST_SECOND = 253402300799


class ChaosdrillError(Exception):
    """Base of every error that chaosdrill raises on purpose; its text names the field, the value and the remedy."""

    def __str__(self) -> str:
        # it may show what a stranger has written, and a traceback is read on a terminal
        return visible(super().__str__())


class ModelError(ChaosdrillError):
    """A hybrid system that cannot be compiled, with the reason."""


class SettingsError(ChaosdrillError):
    """An argument of an analysis or a number of a model that cannot be used."""


class SceneError(ChaosdrillError):
    """A scene file that cannot be run."""


class StartWarning(UserWarning):
    """No run could begin: every start is beyond a guard of its mode."""


class ArchiveError(ChaosdrillError):
    """An archive that cannot be read, written or compared."""


def check_environment() -> None:
    """Refuse a time of files that numpy or matplotlib would stop at later, in the midst of other work.

    Raises `SettingsError` if ``SOURCE_DATE_EPOCH`` is set and is no whole number of seconds of a year up to 9999.
    """
    given = os.environ.get("SOURCE_DATE_EPOCH")
    if given is None or (given.isascii() and given.isdigit() and len(given) <= 12 and int(given) <= _LAST_SECOND):
        return
    raise SettingsError(
        f"the environment variable SOURCE_DATE_EPOCH is {given[:40]!r}; it must be the whole number of seconds since "
        "1970 that files are to be dated with, such as 1700000000: correct it, or remove it by: unset SOURCE_DATE_EPOCH"
    )
