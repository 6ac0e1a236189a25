"""The table ``numerics`` of a scene."""

from typing import Annotated, Any

from pydantic import Field

from chaosdrill.scene.strict import Strict

Tolerance = Annotated[float, Field(ge=1e-16, le=1e-2)]
Steps = Annotated[int, Field(ge=4, le=10_000_000)]


class Numerics(Strict):
    """Method, its tolerance, and the steps a period of a method with a fixed step."""

    method: str = "taylor"
    tolerance: Tolerance = 1e-12
    steps: Steps | None = None

    def keywords(self) -> dict[str, Any]:
        """Arguments for an analysis function."""
        return self.model_dump()
