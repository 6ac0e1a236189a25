"""Transient chaos: lifetimes, escape rate, and the chaotic saddle."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import At, misfits_of_duration, misfits_of_section, section_fault
from chaosdrill.analysis.base import AnalysisSettings, Dataset, HybridSystem, Job, analysis
from chaosdrill.analysis.starting_states import RANDOM
from chaosdrill.analysis.starts import STARTS
from chaosdrill.dataset.schema import COVERS, EXPONENT, RANK_LOSS, STATES, axis, forcing, need, outcome, table
from chaosdrill.names import event_words
from chaosdrill.settings import Amount, Choice, Faults, Whole, setting, told

VARIABLES = table(
    axis("start", "start", "i4", "number of the start", "In their order, from 1.", True),
    axis("age", "age", "f8", "age", "Time since the start.", True),
    *STATES,
    EXPONENT,
    need("initial_state", "start state", "f8", "initial state", "State from which each run starts."),
    need("lifetime", "start", "f8", "lifetime", "Until the run leaves, or the record ends; of a map iterates."),
    outcome("start"),
    need("surviving", "age", "f8", "surviving share", "Share of the runs that reached this age."),
    need("escape_rate", "", "f8", "escape rate", "Per unit of model time."),
    need("escape_rate_error", "", "f8", "standard error of the escape rate", COVERS),
    need("escapes", "", "i8", "number of escapes", "After the transient."),
    need("least_age", "", "f8", "age from which lifetimes count", "In units of model time."),
    need(
        "drift",
        "",
        "f8",
        "change of the escape rate",
        "Of late escapes against early ones, in standard errors; NaN with fewer than 20 of either.",
    ),
    need(
        "saddle_age",
        "",
        "f8",
        "age that runs near the saddle reach",
        "From where they are taken; NaN without a saddle.",
    ),
    need("saddle_rate", "", "f8", "escape rate by stagger-and-step", "Per unit of model time; NaN without walkers."),
    need("saddle_rate_error", "", "f8", "standard error of the escape rate by stagger-and-step", COVERS),
    need("staggers", "", "i8", "number of displacements", "Of walkers near the saddle; 0 without any."),
    need(
        "stagger_size",
        "",
        "f8",
        "size of displacements",
        "From which on they fail; in parts of the extent. NaN without walkers.",
    ),
    need("saddle_state", "point state", "f8", "state near the saddle", "In the middle of long lifetimes."),
    need("lyapunov_exponent", "exponent", "f8", "Lyapunov exponent of the saddle", RANK_LOSS),
    need("lyapunov_error", "exponent", "f8", "standard error of the exponent", COVERS),
    need(
        "saddle_dimension", "", "f8", "information dimension of the saddle", "From its exponents and the escape rate."
    ),
    need("saddle_dimension_error", "", "f8", "standard error of the dimension", COVERS),
    *forcing(),
    bars={"lyapunov_exponent": "lyapunov_error"},
    sampled=("lifetime", "surviving", "escapes", "least_age", "drift", "saddle_state"),
)


@dataclass(frozen=True, kw_only=True)
class TransientChaos(AnalysisSettings):
    """Settings of `transient_chaos`."""

    without_noise: ClassVar[str] = ""
    meanings: ClassVar[Mapping[str, str]] = {
        "system": "System with its parameters; its initial state supplies the states that the starts do not name."
    }

    periods: int | None = setting(Whole(1), None, doc="Longest time for which a run is followed, in forcing periods.")
    duration: float | None = setting(
        Amount(above=0),
        None,
        doc="Longest time for which a run is followed, for systems without forcing.",
    )
    transient: float | None = setting(
        Amount(least=0),
        None,
        doc="Age from which lifetimes count: forcing periods, or time; before it runs are still approaching the "
        "saddle, or leave directly from their start. Default: the median lifetime, or a quarter of the longest "
        "time if that is less.",
    )
    random: dict[str, Any] | None = setting(
        RANDOM, None, doc='Starts drawn uniformly from a box: ``{"count": 5000, "seed": 1, "x": (0, 1)}``.'
    )
    initial: Any = setting(STARTS, None, doc="Starts in place of ``random``, in any form that `basins` takes.")
    until: str | None = setting(
        At(),
        None,
        doc="What ends a lifetime besides an escape from the bounds: the name or kind of an event, or a comparison "
        'such as ``"x > 2"``, met where it becomes true, in a map at the first iterate for which it is; starts beyond '
        "it are invalid.",
    )
    saddle: str | None = setting(
        Choice(("sprinkler", "stagger")),
        None,
        doc="How points on the saddle are found: from runs that stay long, or by stagger-and-step. Default: the "
        "first, and where these stay for less than 2 forcing periods or iterates between the margins, the second.",
    )

    @classmethod
    def beside(cls, table: Mapping[str, Any]) -> Faults:
        """One length, and one kind of starts."""
        for one, other, words in (
            ("periods", "duration", "give either periods (of the forcing) or duration (units of time)"),
            ("random", "initial", "give starts: random, a box from which they are drawn, or initial, a list"),
        ):
            if one in table and other in table:
                yield (other,), told(f"{one} is given, too; leave one of them out", table[other])
            elif one not in table and other not in table:
                yield (), words

    @classmethod
    def misfits(cls, table: Mapping[str, Any], system: HybridSystem) -> Faults:
        """A length in a unit that the system lacks, and an end of lifetimes that it does not have."""
        yield from misfits_of_section(table, system)
        until = table.get("until")
        if until == "strobe":
            yield ("until",), told("expected an event, or a comparison of states", until)
        elif until is not None and (fault := section_fault(system, until, ends=True)):
            yield ("until",), told(fault, until)
        if table.get("saddle") == "stagger" and system.noise:
            yield ("saddle",), told("under noise the time to stay is one of chance; leave it out", "stagger")
        if table.get("saddle") == "stagger" and until in event_words(system.transitions):
            words = "a displacement may lead beyond the guard, where no event is met; give a comparison, or bounds"
            yield ("saddle",), told(words, "stagger")
        yield from misfits_of_duration(table, system)
        if "periods" in table and not system.forced:
            words = f"{system.name} has no forcing period; give duration, in units of time"
            yield ("periods",), told(words, table["periods"])


@analysis(
    "transient-chaos",
    TransientChaos,
    "lifetimes from many starts, the escape rate, and the saddle's points and exponents",
    VARIABLES,
    cites=("kantz1985", "lai2011", "hunt1996", "sweet2001"),
)
def transient_chaos(system: HybridSystem, given: TransientChaos, job: Job) -> Dataset:
    """Lifetimes of runs from many starts, the rate at which they leave, and the chaotic saddle.

    A run leaves when it escapes from the bounds of the system's states, or meets ``until`` for the first time. If lives
    end by chance alone, those beyond the transient are distributed exponentially. With forcing lifetimes count whole
    periods, and the rate is the maximum-likelihood estimate, in which runs that have not left count with the length of
    the record. Without forcing it is the logarithm of the ratio of two integrals of the number of runs that are left,
    over stretches whose starts differ by the difference of two lifetimes, so that lives may end at any time, or only at
    multiples of a time. Its standard error is that of independent starts; with fewer than ten escapes, twice the error
    covers only 87 %. ``drift`` compares the later half of the escapes with the earlier one: beyond 3, lifetimes are not
    exponential, and a longer transient is needed. Under noise each start has its own, and the rate is that of the
    average over it.

    Points on the saddle are up to ten states of each run in the middle of a long lifetime (the sprinkler method: Kantz
    and Grassberger 1985, doi:10.1016/0167-2789(85)90135-6; Lai and Tel 2011, doi:10.1007/978-1-4419-6987-3), taken
    from the runs that reach the greatest age reached by 100 runs. A quarter of this age, and at least the transient, is
    left out at both ends; over the rest their tangents grow at the exponents of the saddle. Their error is that of
    independent runs, plus the difference between the mean over all of this age and that over its first half.

    Where runs leave sooner, walkers step along the saddle by stagger-and-step (Sweet, Nusse and Yorke 2001,
    doi:10.1103/PhysRevLett.86.2261): 1024 where ``saddle`` asks for them, else one for two starts, 256 at most, and
    these for no more than 200 times as long as the starts. A walker that would leave within a set time goes where
    another one is, drawn at random, and small displacements of all orders of size part the two; one is taken where the
    time to stay remains long enough. Beyond a comparison ``until`` none stays. The share of walkers that could stay
    gives the rate at which the saddle is left, ``saddle_rate``, and the dimension. Errors are those of 16 pictures.
    Walkers find an attractor within the bounds, however few starts lead to it: where ever more stay, or none leave,
    there is a ``reason`` alone. So there is of the sprinkler where runs leave more slowly later on, as where some of
    them come to an attractor.

    The entropy of the saddle, the sum of its positive exponents less the escape rate, fills its directions, those of
    slowest growth and of slowest decay first: together this is its information dimension (Hunt, Ott and Yorke 1996,
    doi:10.1103/PhysRevE.54.4819), in which the direction of a flow, and each neutral one, counts 1. Of a
    flow without an exponent 0, as at a rest, it is NaN. In systems made of uncoupled parts it may be smaller.

    Returns
    -------
    xarray.Dataset
        ``lifetime``, of a map the number of iterates before the one that leaves (a clock that applies it shows 3.5 or
        so where this is 3), and ``outcome`` (start), ``escaped``
        where a run has left and ``ok`` where it has not, with ``initial_state`` (start, state); ``surviving`` (age);
        ``escape_rate`` and ``escape_rate_error``, per unit of time, ``escapes``, ``least_age`` and ``drift``, NaN with
        fewer than 40 escapes; ``saddle_state`` (point, state), ``lyapunov_exponent`` and ``lyapunov_error`` (exponent),
        ``saddle_dimension`` and ``saddle_dimension_error``, NaN where too few runs live long, as ``reason`` says then;
        ``saddle_age``, to which these runs stay; ``staggers``, the number of displacements, 0 with the sprinkler
        method, and ``stagger_size``, from which on they fail, in parts of its extent. Without an escape the rate is 0,
        and twice its error is the largest that would have shown no escape in 5 % of all cases. It is NaN, and
        ``reason`` says why, if all leave at one age, or soon after each other, or none is watched beyond the least age.
    """
    from chaosdrill.analysis.measures.escapes import transients

    return transients(system, given, job)
