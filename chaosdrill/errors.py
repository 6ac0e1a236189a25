"""The exceptions that users of chaosdrill meet."""

from collections.abc import Mapping
from typing import Any


class ChaosdrillError(Exception):
    """Base of every error that chaosdrill raises on purpose; its text names the field, the value and the remedy."""


class ModelError(ChaosdrillError):
    """A hybrid system that cannot be compiled, with the reason."""


class UnsupportedError(ModelError):
    """An expression of which no code can be made.

    Parameters
    ----------
    *parts : str or sympy expression
        The reason, and the expressions in it, whose symbols are named by their places.
    """

    def __init__(self, *parts: Any) -> None:
        super().__init__("".join(map(str, parts)))
        self.parts = parts

    def told(self, names: Mapping[Any, Any]) -> str:
        """The reason with other symbols in its expressions."""
        return "".join(part if isinstance(part, str) else str(part.xreplace(names)) for part in self.parts)


class SettingsError(ChaosdrillError):
    """An argument of an analysis or a number of a model that cannot be used."""


class SceneError(ChaosdrillError):
    """A scene file that cannot be run."""


class ArchiveError(ChaosdrillError):
    """An archive that cannot be read, written or compared."""
