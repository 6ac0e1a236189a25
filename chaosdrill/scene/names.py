"""What a scene can name."""

from typing import Any

from chaosdrill.errors import SettingsError
from chaosdrill.names import remedy

TOPICS = ("systems", "effects", "analyses", "methods")


def list_names(topic: str, name: str | None = None) -> dict[str, Any]:
    """Names that a scene may use, as ``chaosdrill list`` prints them.

    Parameters
    ----------
    topic : {"systems", "effects", "analyses", "methods"}
        Which names.
    name : str, optional
        One of the analyses, whose settings are to be listed.

    Returns
    -------
    dict
        Name -> a line about it; of effects: effect -> option -> line.

    Raises
    ------
    SettingsError
        If there is no such topic or analysis, or if a name is given with another topic.
    """
    from chaosdrill.declared import ANALYSES, METHODS
    from chaosdrill.systems import EFFECTS, REGISTRY

    if topic not in TOPICS:
        raise SettingsError(f"topic: unknown topic {topic!r:.60}; choose from {', '.join(TOPICS)}")
    if name is not None:
        if topic != "analyses":
            raise SettingsError(f"name is {name!r:.60}, but only analyses have settings to list; leave it out")
        if name not in ANALYSES:
            raise SettingsError(f"name: unknown analysis {name!r:.60}; {remedy(name, ANALYSES)}")
        return ANALYSES[name].described()
    if topic == "effects":
        return {effect: dict(options) for effect, options in EFFECTS.items()}
    entries = {"systems": REGISTRY, "analyses": ANALYSES, "methods": METHODS}[topic]
    return {key: entry.summary for key, entry in entries.items()}
