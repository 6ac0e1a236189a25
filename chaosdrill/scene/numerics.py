"""The table ``numerics`` of a scene."""

from typing import Annotated, Any

from pydantic import Field

from chaosdrill.scene.strict import Strict

Tolerance = Annotated[float, Field(ge=1e-16, le=1e-2)]
Steps = Annotated[int, Field(ge=4, le=10_000_000)]


class Numerics(Strict):
    """Method, its tolerance, and the steps a period of a method with a fixed step."""

    method: str | None = None
    tolerance: Tolerance | None = None
    steps: Steps | None = None

    def keywords(self) -> dict[str, Any]:
        """Arguments of the analysis functions that the scene gives; the rest is their defaults."""
        return self.model_dump(exclude_unset=True)
