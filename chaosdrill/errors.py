"""The exceptions that users of chaosdrill meet."""

from collections.abc import Iterable
from difflib import get_close_matches


class ChaosdrillError(Exception):
    """Base of every error that chaosdrill raises on purpose; its text names the field, the value and the remedy."""


class ModelError(ChaosdrillError):
    """A hybrid system that cannot be compiled, with the reason."""


class SettingsError(ChaosdrillError):
    """An argument of an analysis or a number of a model that cannot be used."""


class SceneError(ChaosdrillError):
    """A scene file that cannot be run."""


class ArchiveError(ChaosdrillError):
    """An archive that cannot be read, written or compared."""


def remedy(word: str, known: Iterable[str]) -> str:
    """The likely fix of an unknown name: the nearest known one, or all of them."""
    known = list(known)
    lowered = {name.lower(): name for name in known}
    close = get_close_matches(word[:100].lower(), lowered, n=1)
    if close:
        return f"did you mean {lowered[close[0]]!r}?"
    return f"known here: {', '.join(known)}" if known else "there are none here"
