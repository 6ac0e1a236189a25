"""A scene in SI units, turned into the dimensionless one.

Displacements are in units of ``mu_e F_N / K`` and times in units of ``sqrt(m1 / K)``; the forces are divided by the
static friction force ``mu_e F_N``. Source: equations (6), (8) and (10) of the paper.
"""

import math
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from chaosdrill.names import remedy
from chaosdrill.units import ANGLE, ANGULAR_SPEED, FORCE, LENGTH, MASS, NONE, TIME, Dimension, parse_quantity

Fault = tuple[tuple[int | str, ...], str]

SECONDS_PER_HOUR = 3600.0

SMALLEST = sys.float_info.min
"""Below it a number has fewer digits."""


def _over(first: Dimension, second: Dimension, power: float = 1.0) -> Dimension:
    a, b, c, d = (one - power * other for one, other in zip(first, second, strict=True))
    return (a, b, c, d)


@dataclass(frozen=True)
class SIEntry:
    """One SI quantity: its meaning, dimension, unit as UDUNITS writes it, an example, and the parameters made of it.

    It is positive, or not negative, or ``signed``.
    """

    label: str
    dimension: Dimension
    units: str
    example: str
    makes: tuple[str, ...] = ()
    positive: bool = False
    signed: bool = False


QUANTITIES: dict[str, SIEntry] = {
    "m1": SIEntry("mass of the bit", MASS, "kg", "250 kg", positive=True),
    "m2": SIEntry("mass on the rock's side", MASS, "kg", "250 kg", ("eps",), positive=True),
    "K": SIEntry("stiffness of the spring", _over(FORCE, LENGTH), "N m-1", "4e6 N/m", positive=True),
    "C": SIEntry("damper", _over(FORCE, _over(LENGTH, TIME)), "N s m-1", "3.8 kN*s/m", ("xi",)),
    "A": SIEntry("amplitude of the dynamic load", FORCE, "N", "2 kN", ("a",)),
    "B": SIEntry("static load", FORCE, "N", "5.6 kN", ("b",), signed=True),
    "R": SIEntry("gap of the stop", LENGTH, "m", "2 mm", ("r",)),
    "omega": SIEntry("angular frequency of the load", ANGULAR_SPEED, "rad s-1", "100 rad/s", ("eta",), positive=True),
    "rpm": SIEntry("rotation speed", ANGULAR_SPEED, "rad s-1", "90 rpm", ("eta", "spin"), positive=True),
    "lobes": SIEntry("number of lobes", NONE, "1", "3", ("eta", "lobes"), positive=True),
    "F_N": SIEntry("normal force on the side of the rock", FORCE, "N", "10 kN", positive=True),
    "mu_e": SIEntry("static friction coefficient", NONE, "1", "0.8", positive=True),
    "mu_d": SIEntry("kinetic friction coefficient", NONE, "1", "0.48", ("mu",)),
    "gamma": SIEntry("decay of friction with speed", _over(TIME, LENGTH), "s m-1", "12 s/m", ("g",)),
    # a power of metres that is not whole is no unit of UDUNITS, but the force at a depth of one metre has one
    "k_c": SIEntry(
        "force of the contact at a depth of 1 m", _over(FORCE, LENGTH), "N", "4.8e12 N/m", ("k",), positive=True
    ),
    "lambda": SIEntry("damping of the contact", _over(TIME, LENGTH), "s m-1", "2.4 s/m", ("lam",)),
    "n": SIEntry("exponent of the contact force", NONE, "1", "1", ("n",), positive=True),
    "phi": SIEntry("phase of the dynamic load", ANGLE, "rad", "90 deg", ("phi",), signed=True),
}

IN_SI = ("percussive-drill", "percussive-drill-5d")
"""Systems whose parameters may be given as quantities with units."""

SCALES = ("m1", "K", "F_N", "mu_e")


@dataclass(frozen=True)
class Dimensionless:
    """A dimensionless parameter that follows from quantities."""

    takes: tuple[str, ...]  # what it needs besides the scales; eta takes omega, or what makes the lobes' frequency
    formula: str  # in words of the quantities
    value: Callable[[Mapping[str, float], float, float], float]
    """Of the quantities in kg, m, s, N, rad; sqrt(K/m1); and the unit of length."""


MADE: dict[str, Dimensionless] = {
    "eps": Dimensionless(("m2",), "m1/m2", lambda si, w, x: si["m1"] / si["m2"]),
    "xi": Dimensionless(("C",), "C/(2 sqrt(K m1))", lambda si, w, x: si["C"] / (2 * si["m1"] * w)),
    "a": Dimensionless(("A",), "A/(mu_e F_N)", lambda si, w, x: si["A"] / _friction(si)),
    "b": Dimensionless(("B",), "B/(mu_e F_N)", lambda si, w, x: si["B"] / _friction(si)),
    "r": Dimensionless(("R",), "K R/(mu_e F_N)", lambda si, w, x: si["R"] / x),
    "eta": Dimensionless(
        ("omega",),
        "omega sqrt(m1/K), omega = lobes rpm of a load that the lobes make",
        lambda si, w, x: (si["omega"] if "omega" in si else si["lobes"] * si["rpm"]) / w,
    ),
    "spin": Dimensionless(("rpm",), "rpm sqrt(m1/K)", lambda si, w, x: si["rpm"] / w),
    "lobes": Dimensionless(("lobes",), "lobes", lambda si, w, x: si["lobes"]),
    "mu": Dimensionless(("mu_d",), "mu_d/mu_e", lambda si, w, x: si["mu_d"] / si["mu_e"]),
    "g": Dimensionless(("gamma",), "gamma mu_e F_N/sqrt(K m1)", lambda si, w, x: si["gamma"] * (x * w)),
    "k": Dimensionless(
        ("k_c", "n"),
        "k_c (mu_e F_N/K)^n/(mu_e F_N)",
        lambda si, w, x: si["k_c"] * x ** si["n"] / _friction(si),
    ),
    "lam": Dimensionless(("lambda",), "lambda mu_e F_N/sqrt(K m1)", lambda si, w, x: si["lambda"] * (x * w)),
    "n": Dimensionless(("n",), "n", lambda si, w, x: si["n"]),
    "phi": Dimensionless((), "phi", lambda si, w, x: si["phi"]),
}


def _friction(si: Mapping[str, float]) -> float:
    return si["mu_e"] * si["F_N"]


UNITS = {
    "time_s": ("s", "time", "sqrt(m1/K)"),
    "length_m": ("m", "length", "mu_e F_N/K"),
    "force_N": ("N", "force", "mu_e F_N, the static friction"),
}
"""What one dimensionless unit is, by the scales of a scene: its unit, what it measures, and how it follows."""


STATE_UNITS = {"y": "m", "u": "m s-1", "w": "m s-1", "timer": "s", "depth": "m"}
"""The SI unit of each state that a drill may have."""


def si_to_dimensionless(si: Mapping[str, float]) -> tuple[dict[str, float], dict[str, float]]:
    """Dimensionless parameters and scales of a drill given in SI units.

    ``si``: quantities in kg, m, s, N, rad by the names of ``QUANTITIES``: at least m1, K, F_N and mu_e; ``rpm`` is in
    rad/s, ``k_c`` in N/m^n.

    Returns: those of a b xi eps eta spin lobes mu g r lam phi n k for which there are quantities; ``time_s`` (seconds),
    ``length_m`` (metres) and ``force_N`` (newtons) of one dimensionless unit. ``k`` is per unit of bit mass: the force
    ``k_c d^n`` over ``mu_e F_N`` with the depth in dimensionless units. With n = 1 that is ``k_c / K``.
    """
    frequency = math.sqrt(si["K"] / si["m1"])
    length = _friction(si) / si["K"]
    parameters = {}
    for name, made in MADE.items():
        try:
            parameters[name] = made.value(si, frequency, length)
        except KeyError:
            continue
    return parameters, {"time_s": 1 / frequency, "length_m": length, "force_N": _friction(si)}


def metres_per_hour(scales: Mapping[str, float]) -> float:
    """Speed in m/h of one dimensionless unit of speed."""
    return scales["length_m"] / scales["time_s"] * SECONDS_PER_HOUR


@dataclass(frozen=True)
class ReadSI:
    """The table ``system.si`` of a scene, read."""

    values: dict[str, float] = field(default_factory=dict)  # the quantities in kg, m, s, N, rad
    parameters: dict[str, float] = field(default_factory=dict)  # the parameters made of them
    scales: dict[str, float] = field(default_factory=dict)
    """What one dimensionless unit is, as `si_to_dimensionless` gives it."""


def read_si(
    raw: Mapping[str, Any], parameters: Mapping[str, Any], known: Mapping[str, float]
) -> tuple[ReadSI, list[Fault]]:
    """Read the table ``system.si`` of a scene.

    ``raw``: the table as written. ``parameters``: the table ``system.parameters``: what is given there is not made from
    SI quantities. ``known``: the parameters that the scene's system has.

    Returns: what was read, empty if there are faults, and the faults, whose paths are those of a scene.
    """
    values, faults = _values(raw)
    faults += _surplus(raw, parameters, known) + _missing(raw, parameters, known)
    if faults:
        return ReadSI(), faults
    try:
        made, scales = si_to_dimensionless(values)
    except (ZeroDivisionError, OverflowError):
        made, scales = {}, {"time_s": math.nan}
    if faults := _extreme(values, raw, made | scales):
        return ReadSI(), faults
    ordered = {name: values[name] for name in raw}
    return ReadSI(ordered, {name: value for name, value in made.items() if name in known}, scales), []


def _values(raw: Mapping[str, Any]) -> tuple[dict[str, float], list[Fault]]:
    values: dict[str, float] = {}
    faults: list[Fault] = []
    # n comes first: the unit of the contact's stiffness is N/m^n
    for name in sorted(raw, key=lambda name: name != "n"):
        try:
            values[name] = _value(name, raw[name], values.get("n", 1.0))
        except ValueError as fault:
            faults.append((("system", "si", name), str(fault)))
    return values, faults


def _value(name: str, given: Any, exponent: float) -> float:
    if name not in QUANTITIES:
        raise ValueError(f"unknown quantity; {remedy(name, QUANTITIES)}")
    entry = QUANTITIES[name]
    if isinstance(given, bool) or not isinstance(given, str | int | float):
        raise ValueError(f"expected a quantity such as {entry.example!r}, received {given!r:.60}")
    quantity = parse_quantity(given if isinstance(given, str) else repr(given))
    dimension = _over(FORCE, LENGTH, exponent) if name == "k_c" else entry.dimension
    if quantity.dimension == NONE and dimension != NONE:
        raise ValueError(f"needs a unit, as in {entry.example!r}; received {given!r}")
    if not all(math.isclose(a, b, abs_tol=1e-9) for a, b in zip(quantity.dimension, dimension, strict=True)):
        raise ValueError(f"has the wrong dimension, received {given!r}; expected one such as {entry.example!r}")
    if entry.positive and quantity.value <= 0:
        raise ValueError(f"must be greater than 0, received {given!r}")
    if not entry.signed and quantity.value < 0:
        raise ValueError(f"must not be negative, received {given!r}")
    return quantity.value


def _extreme(values: Mapping[str, float], raw: Mapping[str, Any], made: Mapping[str, float]) -> list[Fault]:
    """The quantity to blame for the first number that is made of them and has no square, as a double, to compute with.

    What is given as zero is zero.
    """
    formulas = {name: one.formula for name, one in MADE.items()} | {
        name: formula for name, (_, _, formula) in UNITS.items()
    }
    for name, value in made.items():
        used = [word for word in re.findall(r"\w+", formulas[name]) if word in values]
        square = value * value
        if math.isfinite(square) and (square >= SMALLEST or not all(values[word] for word in used)):
            continue
        blamed = max((word for word in used if values[word]), key=lambda word: abs(math.log10(abs(values[word]))))
        told = f" ({value:.3g})" if math.isfinite(value) else ""
        text = f"received {raw[blamed]!r}, which makes {formulas[name]}{told} too large or too small to compute with"
        return [(("system", "si", blamed), f"{text}; look for a slip in its unit")]
    return []


def _surplus(raw: Mapping[str, Any], parameters: Mapping[str, Any], known: Mapping[str, float]) -> list[Fault]:
    """Quantities that are redundant, or belong to effects that the scene does not simulate."""
    faults: list[Fault] = []
    for name in raw:
        if name not in QUANTITIES or name in SCALES:
            continue
        makes = [parameter for parameter in QUANTITIES[name].makes if parameter in known]
        twice = [parameter for parameter in makes if parameter in parameters]
        if not makes:
            text = "no chosen effect uses it; leave it out or choose the effect that does"
        elif twice:
            text = f"system.parameters.{twice[0]} is given too; leave one of them out"
        elif name == "omega" and "rpm" in raw:
            text = "rpm is given too; leave one of them out"
        else:
            continue
        faults.append((("system", "si", name), text))
    return faults


def _missing(raw: Mapping[str, Any], parameters: Mapping[str, Any], known: Mapping[str, float]) -> list[Fault]:
    needed = dict.fromkeys(SCALES)
    for parameter in known:
        if parameter in parameters or parameter not in MADE:
            continue
        if parameter == "eta" and ("rpm" in raw or "lobes" in raw):
            needed |= dict.fromkeys(("rpm", "lobes"))
        else:
            needed |= dict.fromkeys(MADE[parameter].takes)
    return [
        (("system", "si", name), f"missing; a scene in SI units needs it, as in {QUANTITIES[name].example!r}")
        for name in needed
        if name not in raw
    ]
