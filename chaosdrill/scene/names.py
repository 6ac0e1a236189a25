"""What a scene can name."""

from typing import Any

from chaosdrill.errors import SettingsError


def _systems() -> dict[str, Any]:
    from chaosdrill.systems import REGISTRY

    return {name: entry.summary for name, entry in REGISTRY.items()}


def _effects() -> dict[str, Any]:
    from chaosdrill.systems import EFFECTS

    return {effect: dict(options) for effect, options in EFFECTS.items()}


def _analyses() -> dict[str, Any]:
    from chaosdrill.analysis.registry import ANALYSES

    return {kind: entry.summary for kind, entry in ANALYSES.items()}


def _methods() -> dict[str, Any]:
    from chaosdrill.analysis.registry import METHODS

    return dict(METHODS)


_TOPICS = {"systems": _systems, "effects": _effects, "analyses": _analyses, "methods": _methods}

TOPICS = tuple(_TOPICS)


def list_names(topic: str) -> dict[str, Any]:
    """Names that a scene may use, as ``chaosdrill list`` prints them.

    Parameters
    ----------
    topic : {"systems", "effects", "analyses", "methods"}
        Which names.

    Returns
    -------
    dict
        Name -> a line about it; of effects: effect -> option -> line.

    Raises
    ------
    SettingsError
        If there is no such topic.
    """
    if topic not in TOPICS:
        raise SettingsError(f"topic: {topic!r:.60} is none; choose from {', '.join(TOPICS)}")
    return _TOPICS[topic]()
