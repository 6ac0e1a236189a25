"""What a scene can name."""

from typing import Any

from chaosdrill.errors import SettingsError

TOPICS = ("systems", "effects", "analyses", "methods")


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
    from chaosdrill.analysis.registry import METHODS, analyses
    from chaosdrill.systems import EFFECTS, REGISTRY

    if topic not in TOPICS:
        raise SettingsError(f"topic: unknown topic {topic!r:.60}; choose from {', '.join(TOPICS)}")
    if topic == "effects":
        return {effect: dict(options) for effect, options in EFFECTS.items()}
    if topic == "methods":
        return dict(METHODS)
    return {name: entry.summary for name, entry in (REGISTRY if topic == "systems" else analyses()).items()}
