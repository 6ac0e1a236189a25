"""The table ``numerics`` of a scene."""

from typing import Annotated, Any

from pydantic import Field

from chaosdrill.scene.strict import Strict

Tolerance = Annotated[float, Field(ge=1e-16, le=1e-2)]
Steps = Annotated[int, Field(ge=4, le=10_000_000)]
Limit = Annotated[int, Field(ge=1, le=1_000_000_000)]


class Numerics(Strict):
    """Method, its tolerance, the steps a period of a method with a fixed step, and the limits of its events."""

    method: str | None = None
    tolerance: Tolerance | None = None
    steps: Steps | None = None
    max_events: Limit | None = None
    max_stalls: Limit | None = None

    def keywords(self) -> dict[str, Any]:
        """Arguments of the analysis functions that the scene gives; the rest is their defaults."""
        return self.model_dump(exclude_unset=True)
