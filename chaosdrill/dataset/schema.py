"""Declaration of the output variables of an analysis: their attributes, their checks, and how two runs are compared.

The tables stand with the analyses (``VARIABLES`` in each file of ``analysis/kinds``); ``SCHEMA`` has them by kind.

Some things depend on the system and the request at hand and stand in a table as placeholders: ``SWEEP`` (each swept
parameter, or each state that spans a grid of initial states, as a dimension and as its coordinate), ``QUADRATURE``
(each integral that the system carries along), ``ORBIT`` and ``RUN`` (the leading dimension ``orbit`` of a search, or
``run`` of several initial states, and nothing for one orbit or one run), and ``STARTS_OF_RUNS``
(``run``, or else what ``SWEEP`` stands for). States, seeds and transitions are dimensions with their names as the
index.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from chaosdrill.dataset.codes import Code
from chaosdrill.dataset.outcomes import Outcome
from chaosdrill.declared import ANALYSES, reserved

SWEEP = "{sweep}"
QUADRATURE = "{quadrature}"
ORBIT = "{orbit}"
RUN = "{run}"
STARTS_OF_RUNS = "{start}"

ORDER = (
    *("attractor_number", "point", "step", "side", "special", "block", "break", "crossing", "end", "orbit", "start"),
    *("quantity", "attractor", "run", "distance", "seed", "window", "eigenvalue", "multiplier", "iteration", "event"),
    *("path_point", "function", "time", "tangent", "method", "iterate", "exponent", "split", "tolerance", "state"),
    *("order", "bin", "parameter", "vector", "turn", "scale"),
)
"""Dimensions after those of ``SWEEP``, in an order that all tables have: a first picture need not wait for these."""

PENETRATION = "penetration"
"""Quadrature whose mean rate is the progression rate."""

_QUALITY = re.compile(r"(^|_)(error|residual|difference)(_|$)")


@dataclass(frozen=True)
class Variable:
    """Declaration of one variable."""

    name: str
    """Name in the dataset, or ``SWEEP`` / ``QUADRATURE`` for one that the system or the sweep names. ``QUADRATURE``
    within a name stands for each quadrature but ``PENETRATION``."""
    dims: tuple[str, ...]
    """Dimensions in order; ``SWEEP`` stands for all swept parameters, or states of a grid, in order, and ``ORBIT``
    for the dimension ``orbit`` where there may be many."""
    dtype: str
    """NumPy code that is stored; ``"str"`` for text."""
    units: str
    """UDUNITS text; ``"1"`` for dimensionless, which model time is too."""
    long_name: str
    doc: str
    """Name for axes, and one sentence of explanation (stored as the attribute ``comment``)."""
    flags: type[Code] | str = ""
    """What its codes stand for: a class, ``"mode"`` or ``"transition"`` of the system, or ``"truth"`` for no and yes;
    empty for none."""
    lacking: bool = False  # whether its code is -1 where there is nothing
    coordinate: bool = False  # whether it is stored as a coordinate
    required: bool = False  # whether every dataset of the kind has it
    clocked: bool = False  # whether it is a measured time, which differs in a second run and cannot be compared
    rule: str = ""
    """How two runs of a chaotic motion are compared: an average without its own error bar; a quantity that depends
    on the visited part of the attractor; an error, of which only the order of magnitude is meaningful. One of {"",
    "average", "sampled", "magnitude"}."""
    bar: str = ""  # variable that is the standard error of this one
    sample: str = ""  # dimension whose entries it counts (the attribute ``sample_dimension`` of CF)

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


def need(name: str, dims: str, dtype: str, long_name: str, doc: str, units: str = "1", **more: Any) -> Variable:
    """A variable that every dataset of the kind has; ``dims`` are separated by blanks."""
    return may(name, dims, dtype, long_name, doc, units, required=True, **more)


def may(name: str, dims: str, dtype: str, long_name: str, doc: str, units: str = "1", **more: Any) -> Variable:
    """A variable that a dataset of the kind may have; more: further fields of `Variable`."""
    return Variable(name, tuple(dims.split()), dtype, units, long_name, doc, **more)


def axis(name: str, dims: str, dtype: str, long_name: str, doc: str, required: bool = False) -> Variable:
    """A coordinate."""
    return may(name, dims, dtype, long_name, doc, coordinate=True, required=required)


def clocked(name: str, dims: str, long_name: str, doc: str) -> Variable:
    """A time that a clock measured, in seconds."""
    return need(name, dims, "f8", long_name, doc, "s", clocked=True)


def table(
    *variables: Variable,
    average: Iterable[str] = (),
    sampled: Iterable[str] = (),
    magnitude: Iterable[str] = (),
    bars: Mapping[str, str] | None = None,
) -> Table:
    """The variables of one kind, and by what two runs are compared in them: see ``rule`` and ``bar`` of `Variable`.

    The standard error of ``x`` is ``x_error``, unless ``bars`` names another one, or none by an empty text.
    """
    named = {"average": average, "sampled": sampled, "magnitude": magnitude}
    rules = {name: rule for rule, names in named.items() for name in names}
    errors, names = bars or {}, {one.name for one in variables}

    def completed(one: Variable) -> Variable:
        rule, own = rules.get(one.name, one.rule), f"{one.name}_error"
        measured = one.dtype == "f8" and not one.coordinate and not rule and own in names
        return replace(one, rule=rule, bar=errors.get(one.name, one.bar or (own if measured else "")))

    return tuple(map(completed, variables))


STATES: Table = (
    axis("state", "state", "str", "name of the state", "Order of the states, as in the system.", True),
    axis("state_long_name", "state", "str", "long name of the state", "Description of each state."),
    axis("state_scale_si", "state", "f8", "one unit of the state in SI units", "For scenes given in SI units."),
    axis("state_units_si", "state", "str", "SI unit of the state", "That of state_scale_si."),
)
RUN_NUMBER = axis("run", "run", "i4", "number of the run", "One for each initial state, in their order, from 1.")
INITIAL_STATE = may("initial_state", "run state", "f8", "initial state", "State from which each run starts.")
EXPONENT = axis("exponent", "exponent", "i4", "index of the exponent", "Exponents are in descending order, from 1.")
ITERATE = axis("iterate", "iterate", "i4", "index of the iterate", "Number of the crossing of the section, from 0.")
MULTIPLIER = axis(
    "multiplier", "multiplier", "i4", "index of the multiplier", "In descending order of modulus, from 1."
)
RETURN_TIME = may(
    "return_time", "", "f8", "mean return time", "Between two points of the section; on a cycle, over whole cycles."
)
_ORBIT_STATE = "At phase 0 or, without forcing, after an event, if there are any: a run can start there."
_ORBIT_SECTION = "Before its events, as in a Poincare section: over one period; without a section the orbit's state."
_GRAZING = "Smallest rate of a guard, as it is written, at an event; grazing at zero. Infinite without events."

SI = "For scenes given in SI units."
RANK_LOSS = "Per unit of model time; -inf is rank loss."
_BOUND = "A bound, from rounding, tangents and the error of the orbit."
COVERS = "Twice this error contains the true value in 95 % of cases."

_COUNTS = (
    ("events_per_period", "events per forcing period", "All state-changing events; on a cycle, over whole cycles."),
    ("impacts_per_period", "impacts per forcing period", "Events of the class impact; on a cycle, over whole cycles."),
    ("slips_per_period", "slip onsets per forcing period", "Events of the class slip; on a cycle, over whole cycles."),
    ("events_per_time", "events per unit of time", "For systems without a forcing period."),
    ("impacts_per_time", "impacts per unit of time", "For systems without a forcing period."),
    ("slips_per_time", "slip onsets per unit of time", "For systems without a forcing period."),
)


def forcing(dims: str = "", doc: str = "Period of the forcing, in units of model time.") -> Table:
    """The forcing period, and the same in SI units for scenes given in SI."""
    return (
        may("forcing_period", dims, "f8", "forcing period", doc),
        may("forcing_period_si", dims, "f8", "forcing period", SI, "s"),
    )


def outcome(dims: str, name: str = "outcome", long_name: str = "outcome") -> Variable:
    """How runs ended."""
    doc = "How the run ended; what each code means is in flag_meanings."
    return need(name, dims, "i1", long_name, doc, flags=Outcome)


def grazing(dims: str, name: str = "closest_grazing", *, required: bool = False) -> Variable:
    """The smallest normal speed."""
    return may(name, dims, "f8", "smallest normal speed", _GRAZING, required=required, rule="sampled")


def of_orbits(dims: str) -> Table:
    """What is known of each periodic orbit."""
    return (
        need("orbit_state", f"{dims} state", "f8", "state of the orbit", _ORBIT_STATE),
        need("section", f"{dims} iterate state", "f8", "state on the section", _ORBIT_SECTION),
        need("period_time", dims, "f8", "duration of one period", "In units of model time."),
        may("period_time_si", dims, "f8", "duration of one period", SI, "s"),
        need("multiplier_real", f"{dims} multiplier", "f8", "multiplier, real part", "Exactly 0 where rank is lost."),
        need("multiplier_imag", f"{dims} multiplier", "f8", "multiplier, imaginary part", "By descending modulus."),
        grazing(dims, "smallest_speed", required=True),
        need("residual", dims, "f8", "residual", "Largest difference after one period, in parts of the states' sizes."),
        may("drift", f"{dims} state", "f8", "shift in one period", "Of a state that need not return; whole turns."),
        may("drift_error", f"{dims} state", "f8", "error of the shift", "Estimated; 0 where nothing is shifted."),
        may("neutral", "", "i4", "neutral multipliers", "How many are 1 by the structure of the system."),
    )


def names_of_rate(quadrature: str, of: str = "") -> tuple[str, str]:
    """Names of the mean rate of a quadrature and of its standard error; ``of`` is "attractor" for an attractor."""
    if quadrature == PENETRATION:
        return (f"{of}_rate", f"{of}_rate_error") if of else ("progression_rate", "progression_error")
    whose = f"{of}_{quadrature}" if of else quadrature
    return f"{whose}_rate", f"{whose}_rate_error"


def names_of_errors(quadratures: Iterable[Any]) -> tuple[str, ...]:
    """Names of the standard errors of the mean rates of quadratures."""
    return tuple(names_of_rate(str(quadrature))[1] for quadrature in quadratures)


def rate_clash(quadratures: Iterable[Any], taken: Iterable[str]) -> str | None:
    """Why the names of the mean rates of quadratures clash with those ``taken``; None if they do not."""
    others = set(taken)
    for quadrature in map(str, quadratures):
        for name in (*names_of_rate(quadrature), *names_of_rate(quadrature, "attractor")):
            if quadrature != PENETRATION and (name in others or name in reserved()):
                return f"quadrature {quadrature!r} has the mean rate {name!r}, a name that is taken; rename one of them"
    return None


def mean_rate(quadrature: str, dims: str, of: str = "") -> Table:
    """The mean rate of a quadrature, or of each but the penetration, and its standard error, as `names_of_rate`."""
    rate, error = names_of_rate(quadrature, of)
    named, integral = f"mean rate of {quadrature}", "Quadrature"
    if quadrature == PENETRATION:
        named, integral = "mean progression rate", "Penetration"
    return (
        may(rate, dims, "f8", named, f"{integral} per unit of model time; on a cycle, over whole cycles.", bar=error),
        may(error, dims, "f8", f"standard error of the {named}", COVERS),
    )


def of_attractors(dims: str, kind: str = "As a code.", error: str = "Of random starts.") -> Table:
    """What is known of each attractor, and its share of the starts."""
    return (
        need("fraction", dims, "f8", "fraction of the basin", "Part of the starts that lead to the attractor."),
        need("fraction_error", dims, "f8", "standard error of the fraction", error),
        need("attractor_period", dims, "i2", "period of the attractor", "In iterates of the section, or 0."),
        need("attractor_outcome", dims, "i1", "kind of the attractor", kind, flags=Outcome, lacking=True),
        may("attractor_exponent", f"{dims} exponent", "f8", "Lyapunov exponent", "Per unit of model time."),
        may("attractor_error", f"{dims} exponent", "f8", "standard error of the exponent", "From blocks."),
        need("attractor_state", f"{dims} state", "f8", "state on the attractor", "A point of it on the section."),
    )


def rates_of_attractors(dims: str) -> Table:
    """Mean rates of each attractor."""
    return (
        *mean_rate(PENETRATION, dims, "attractor"),
        *mean_rate(QUADRATURE, dims, "attractor"),
        may("attractor_rate_si", dims, "f8", "mean progression rate", SI, "m h-1"),
    )


def rates(dims: str) -> Table:
    """The mean rates, one number per run, and the progression rate in SI units for scenes given in SI."""
    return (
        *mean_rate(PENETRATION, dims),
        *mean_rate(QUADRATURE, dims),
        *(may(name, dims, "f8", *texts, rule="average") for name, *texts in _COUNTS),
        may("progression_rate_si", dims, "f8", "mean progression rate", SI, "m h-1", rule="average"),
        may("progression_error_si", dims, "f8", "standard error of the progression rate", SI, "m h-1"),
    )


def derivatives(dims: str, *, events: bool) -> Table:
    """Derivatives of the numbers of an orbit with respect to parameters, each with its error, if they were requested.

    ``dims``: of one number an orbit. ``events``: whether the times of events are included, and all orbits belong to one
    system.
    """
    named = [
        ("orbit_state", "state", "state of the orbit", "Without events and forcing, in a plane across the flow."),
        ("period_time", "", "duration of one period", ""),
        ("multiplier_real", "multiplier", "multiplier, real part", "0 where it is 0 or 1 by structure."),
        ("multiplier_imag", "multiplier", "multiplier, imaginary part", ""),
        ("lyapunov_exponent", "multiplier", "Lyapunov exponent", "NaN where it is infinite."),
        (names_of_rate(PENETRATION)[0], "", "mean progression rate", ""),
        (names_of_rate(QUADRATURE)[0], "", f"mean rate of {QUADRATURE}", ""),
    ]
    if events:
        named.append(("event_time", "event", "time of the event", "From the orbit's state, which moves as well."))
    found = [
        axis("parameter", "parameter", "str", "name of the parameter", "Parameters of the derivatives."),
        axis(
            "parameter_value", "parameter" if events else f"{dims} parameter", "f8", "value of the parameter", "There."
        ),
    ]
    for name, over, words, doc in named:
        place, error = f"{dims} {over} parameter", f"{name}_derivative_error"
        doc = " ".join(filter(None, ("Total derivative, along the orbits that follow each parameter.", doc)))
        found += [
            may(f"{name}_derivative", place, "f8", f"derivative of the {words}", doc, bar=error),
            may(error, place, "f8", f"error of the derivative of the {words}", _BOUND, rule="magnitude"),
        ]
    return tuple(found)


def swept(forcing_doc: str) -> Table:
    """The variables of every point of a sweep over parameters, from every seed."""
    dims = f"{SWEEP} seed"
    return (
        axis(SWEEP, SWEEP, "f8", "swept parameter", "Values of the sweep.", True),
        *STATES,
        axis("seed", "seed", "str", "name of the seed", "Start of a point: fixed, random, forward, backward."),
        ITERATE,
        EXPONENT,
        need("period", dims, "i2", "period found", "In iterates of the section; 0 when none was found."),
        may("lyapunov_exponent", f"{dims} exponent", "f8", "Lyapunov exponent", RANK_LOSS, bar="lyapunov_error"),
        may("lyapunov_error", f"{dims} exponent", "f8", "standard error of the exponent", COVERS),
        *rates(dims),
        replace(RETURN_TIME, dims=tuple(dims.split()), rule="average"),
        grazing(dims),
        outcome(dims),
        may("initial_state", "seed state", "f8", "initial state", "State from which each seed starts."),
        *forcing(SWEEP, forcing_doc),
    )


def table_of(kind: str, names: Iterable[str]) -> dict[str, Variable]:
    """The declared variables of one kind, with those of the quadratures that these names mention."""
    table = dict(SCHEMA.get(kind, {}))
    for template in [one for name, one in table.items() if QUADRATURE in name and name != QUADRATURE]:
        before, behind = template.name.split(QUADRATURE)
        for name in names:
            if name not in table and name.startswith(before) and name.endswith(behind):
                quadrature = name.removeprefix(before).removesuffix(behind)
                table[name] = replace(template, name=name, bar=template.bar.replace(QUADRATURE, quadrature))
    return table


@cache
def _table_of(kind: str) -> dict[str, Variable]:
    return {variable.name: variable for variable in ANALYSES[kind].variables}


class _Schema(Mapping[str, dict[str, Variable]]):
    """The tables of all analyses: kind -> name -> variable; looked up on first use."""

    def __getitem__(self, kind: str) -> dict[str, Variable]:
        return _table_of(kind)

    def __iter__(self) -> Iterator[str]:
        return iter(ANALYSES)

    def __len__(self) -> int:
        return len(ANALYSES)


SCHEMA = _Schema()
