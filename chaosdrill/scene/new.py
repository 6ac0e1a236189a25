"""A scene to start from."""

from collections.abc import Mapping
from typing import Any

from chaosdrill.errors import ModelError
from chaosdrill.scene.changes import toml_value
from chaosdrill.typed import TEXT, expecting


@expecting(ModelError, model=TEXT)
def new_scene(model: str) -> str:
    """Text of a scene with every parameter and state of a system of the shelf, a trajectory and its exponents.

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
    from chaosdrill.systems import REGISTRY, build
    from chaosdrill.systems.drill.effects import PAPER

    system = build(model)
    length = "duration = 200" if system.period is None else "periods = 100"
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
            *("", "[system.initial]", *lines(system.initial)),
            *("", "[analysis.run]", 'kind = "trajectory"', length),
            *("", "[analysis.spectrum]", 'kind = "lyapunov-spectrum"', length, transient, ""),
        ]
    )
