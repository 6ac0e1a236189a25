"""Single runs, and the comparison of methods on one."""

from typing import Annotated, ClassVar

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from chaosdrill.scene.kinds.base import Amount, Analysis, Count, Periods, Transient, all_different
from chaosdrill.scene.numerics import Steps, Tolerance


class Record(Analysis):
    """A run of one length: in forcing periods, or in time units for a system without a period."""

    periods: Periods | None = None
    duration: Amount | None = None
    transient: Transient = 0

    @model_validator(mode="after")
    def _one_length(self) -> "Record":
        if (self.periods is None) == (self.duration is None):
            raise PydanticCustomError("length", "give either periods (forcing periods) or duration (time units)")
        return self


class Trajectory(Record):
    """Keywords of `trajectory`."""

    samples: Count | None = None


class PoincareSection(Record):
    """Keywords of `poincare_section`."""

    at: str = "strobe"
    max_period: Count | None = None


class LyapunovSpectrum(Record):
    """Keywords of `lyapunov_spectrum`."""

    exponents: Count | None = None
    blocks: Count | None = None


class WorkPrecision(Record):
    """Keywords of `work_precision`."""

    own_numerics: ClassVar[bool] = True

    methods: Annotated[list[str], Field(min_length=1), AfterValidator(all_different)] | None = None
    tolerances: Annotated[list[Tolerance], Field(min_length=1), AfterValidator(all_different)] | None = None
    steps: Annotated[list[Steps], Field(min_length=1)] | None = None
    repeats: Annotated[int, Field(ge=1, le=1000)] | None = None
