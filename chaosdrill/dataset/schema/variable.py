"""What is declared of a variable, and the placeholders for what depends on the system at hand."""

import re
from dataclasses import dataclass

SWEEP = "{sweep}"
QUADRATURE = "{quadrature}"
ORBIT = "{orbit}"

PLACEHOLDERS = frozenset({SWEEP, QUADRATURE, ORBIT})

_QUALITY = re.compile(r"(^|_)(error|residual|difference)(_|$)")


@dataclass(frozen=True)
class Variable:
    """Declaration of one variable.

    Parameters
    ----------
    name : str
        Name in the dataset, or ``SWEEP`` / ``QUADRATURE`` for one that the system or the sweep names.
    dims : tuple of str
        Dimensions in order; ``SWEEP`` stands for all swept parameters, or states of a grid, in order, and ``ORBIT`` for
        the dimension ``orbit`` where there may be many.
    dtype : str
        NumPy code that is stored; ``"str"`` for text.
    units : str
        UDUNITS text; ``"1"`` for dimensionless, which model time is too.
    long_name, doc : str
        Name for axes, and one sentence of explanation (stored as the attribute ``comment``).
    flags : {"", "outcome", "mode", "transition", "special", "branch_end", "truth"}
        Whose names the codes stand for.
    coordinate : bool
        Whether it is stored as a coordinate.
    required : bool
        Whether every dataset of the kind has it.
    clocked : bool
        Whether a clock measured it, so that a second run gives other values and no comparison can ask for the same.
    """

    name: str
    dims: tuple[str, ...]
    dtype: str
    units: str
    long_name: str
    doc: str
    flags: str = ""
    coordinate: bool = False
    required: bool = False
    clocked: bool = False

    @property
    def content(self) -> str:
        """What the values are, as a code of ISO 19115-1 (for ACDD-1.3)."""
        if self.coordinate:
            return "coordinate"
        if self.flags:
            return "thematicClassification"
        if self.clocked:
            return "auxiliaryInformation"
        return "qualityInformation" if _QUALITY.search(self.name) else "modelResult"


Table = tuple[Variable, ...]


def need(name: str, dims: str, dtype: str, long_name: str, doc: str, units: str = "1", flags: str = "") -> Variable:
    """A variable that every dataset of the kind has; ``dims`` are separated by blanks."""
    return Variable(name, tuple(dims.split()), dtype, units, long_name, doc, flags, required=True)


def may(name: str, dims: str, dtype: str, long_name: str, doc: str, units: str = "1", flags: str = "") -> Variable:
    """A variable that a dataset of the kind may have."""
    return Variable(name, tuple(dims.split()), dtype, units, long_name, doc, flags)


def axis(name: str, dims: str, dtype: str, long_name: str, doc: str, required: bool = False) -> Variable:
    """A coordinate."""
    return Variable(name, tuple(dims.split()), dtype, "1", long_name, doc, coordinate=True, required=required)


def clocked(name: str, dims: str, long_name: str, doc: str) -> Variable:
    """A time that a clock measured, in seconds."""
    return Variable(name, tuple(dims.split()), "f8", "s", long_name, doc, required=True, clocked=True)
