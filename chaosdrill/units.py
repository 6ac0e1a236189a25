"""Quantities with units, as ``"250 kg"`` or ``"12 kN*s/m"``: read, checked for dimension, turned into SI."""

import math
import re
from dataclasses import dataclass

# Exponents of kilogram, metre, second and radian. The angle counts as a dimension of its own, so that 1/s is never
# taken for rad/s, nor a frequency in Hz for one without its 2 pi.
Dimension = tuple[float, float, float, float]

NONE: Dimension = (0, 0, 0, 0)
MASS: Dimension = (1, 0, 0, 0)
LENGTH: Dimension = (0, 1, 0, 0)
TIME: Dimension = (0, 0, 1, 0)
ANGLE: Dimension = (0, 0, 0, 1)
FORCE: Dimension = (1, 1, -2, 0)
ANGULAR_SPEED: Dimension = (0, 0, -1, 1)

_UNITS: dict[str, tuple[float, Dimension]] = {
    "1": (1.0, NONE),
    "kg": (1.0, MASS),
    "g": (1e-3, MASS),
    "t": (1e3, MASS),
    "m": (1.0, LENGTH),
    "cm": (1e-2, LENGTH),
    "mm": (1e-3, LENGTH),
    "um": (1e-6, LENGTH),
    "km": (1e3, LENGTH),
    "s": (1.0, TIME),
    "ms": (1e-3, TIME),
    "min": (60.0, TIME),
    "h": (3600.0, TIME),
    "N": (1.0, FORCE),
    "kN": (1e3, FORCE),
    "MN": (1e6, FORCE),
    "rad": (1.0, ANGLE),
    "deg": (math.pi / 180, ANGLE),
    "rpm": (2 * math.pi / 60, ANGULAR_SPEED),
    "Hz": (2 * math.pi, ANGULAR_SPEED),
}

_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*?)?\s*", re.ASCII)
_FACTOR = re.compile(r"\s*([*/·]?)\s*(?:([A-Za-z]+)(?:(?:\^|\*\*)?([+-]?\d(?:\.\d+)?(?!\d)))?|1(?!\d))", re.ASCII)


@dataclass(frozen=True)
class Quantity:
    """A number in SI base units, with its dimension."""

    value: float
    dimension: Dimension


VANISHES = "is nearer to 0 than any double; write 0, or take another unit"


def vanishes(digits: str) -> bool:
    """Whether a decimal number that is not 0 is nearer to it than any double."""
    return float(digits) == 0 and re.match("[^1-9eE]*[1-9]", digits) is not None


def parse_quantity(text: str) -> Quantity:
    """Read a number with its unit.

    ``text``: a number, then factors of units: ``"40 kN/m"``, ``"1.2e6 N/m^1.5"``, ``"90 rpm"``, ``"3 kN s/m"``. A slash
    divides by the one factor behind it.

    Returns: in kg, m, s, rad.

    Raises `ValueError` if it is not a number with known units, with the reason.
    """
    if len(text) > 100 or not (found := _QUANTITY.fullmatch(text)):
        raise ValueError(f"{text[:40]!r} is not a number with its unit, as in '250 kg'")
    given = value = float(found[1])
    units = found[2] or ""
    exponents = [0.0, 0.0, 0.0, 0.0]
    at = 0
    while at < len(units):
        factor = _FACTOR.match(units, at)
        if factor is None or (at == 0 and factor[1] not in ("", "/")):
            raise ValueError(f"cannot read the unit {units!r}; write it as in 'kN/m' or 'N*s/m'")
        sign, name, power = factor[1], factor[2] or "1", factor[3]
        if name not in _UNITS:
            raise ValueError(f"unknown unit {name!r}; known are {', '.join(_UNITS)}")
        exponent = float(power or 1) * (-1 if sign == "/" else 1)
        size, dimension = _UNITS[name]
        value *= size**exponent
        exponents = [total + exponent * part for total, part in zip(exponents, dimension, strict=True)]
        at = factor.end()
    if not math.isfinite(value) or vanishes(found[1]) or (given and not value):
        raise ValueError(f"{text!r} is beyond all doubles, or nearer to 0 than any; take another unit")
    return Quantity(value, (exponents[0], exponents[1], exponents[2], exponents[3]))
