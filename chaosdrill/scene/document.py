"""The tables of a scene as they stand in the file, before their names are looked up."""

from typing import Any

from pydantic import Field

from chaosdrill.scene.strict import Strict


class Document(Strict):
    """The whole file; the inner tables are validated one by one, so that no fault hides another."""

    title: str | None = None
    system: dict[str, Any]
    numerics: dict[str, Any] = Field(default_factory=dict)
    analysis: dict[str, dict[str, Any]] = Field(default_factory=dict)


class SystemTable(Strict):
    """The table ``system``."""

    model: str | None = None
    definition: dict[str, Any] | None = None
    effects: dict[str, str] = Field(default_factory=dict)
    parameters: dict[str, float] = Field(default_factory=dict)
    initial: dict[str, float | str] = Field(default_factory=dict)
    si: dict[str, Any] = Field(default_factory=dict)
