"""The exceptions that users of chaosdrill meet."""

from chaosdrill.names import visible

__all__ = ["ArchiveError", "ChaosdrillError", "ModelError", "SceneError", "SettingsError", "StartWarning"]


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
