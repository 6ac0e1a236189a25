"""Names for use in a scene, and a scene to start from."""

from collections.abc import Mapping
from typing import Any

from chaosdrill.declared import ANALYSES, METHODS
from chaosdrill.errors import ModelError, SettingsError
from chaosdrill.names import remedy
from chaosdrill.scene.changes import toml_value
from chaosdrill.systems import EFFECTS, REGISTRY, build
from chaosdrill.systems.drill.effects import PAPER
from chaosdrill.typed import TEXT, expecting

TOPICS = ("systems", "effects", "analyses", "methods")


def list_names(topic: str, name: str | None = None) -> dict[str, Any]:
    """Names that a scene may use, as ``chaosdrill list`` prints them.

    Parameters
    ----------
    topic : {"systems", "effects", "analyses", "methods"}
        Which names.
    name : str, optional
        An analysis; its settings are listed.

    Returns
    -------
    dict
        Name -> description; for effects: effect -> option -> description.

    Raises
    ------
    SettingsError
        If there is no such topic or analysis, or if a name is given with another topic.
    """
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


@expecting(ModelError, model=TEXT)
def new_scene(model: str) -> str:
    """Text of a scene with every parameter and state of a system of the library, a trajectory and its exponents.

    Parameters
    ----------
    model : str
        A name of ``chaosdrill.list_names("systems")``.

    Returns
    -------
    str
        A scene in TOML. All its numbers are the defaults.

    Raises
    ------
    ModelError
        If there is no such system.
    """
    system = build(model)
    length = "periods = 100" if system.forced else "duration = 200"
    transient = "transient = 100"

    def lines(values: Mapping[str, Any]) -> list[str]:
        rows = [(f"{name} = {toml_value(value, name)}", system.labels.get(name)) for name, value in values.items()]
        width = max((len(row) for row, _ in rows), default=0)
        return [row if label is None else f"{row:<{width}}  # {label}" for row, label in rows]

    return "\n".join(
        [
            f"title = {toml_value(REGISTRY[model].summary, 'title')}",
            *("", "[system]", f"model = {toml_value(model, 'model')}"),
            *(("", "[system.effects]", *lines(PAPER)) if REGISTRY[model].effects else ()),
            *(("", "[system.parameters]", *lines(system.parameters)) if system.parameters else ()),
            *("", "[system.initial]", *lines(system.start)),
            *("", "[analysis.run]", 'kind = "trajectory"', length),
            *("", "[analysis.spectrum]", 'kind = "lyapunov-spectrum"', length, transient, ""),
        ]
    )
