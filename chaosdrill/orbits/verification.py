"""Verification of an orbit by ordinary simulation, exponents and volume contraction.

Volume contraction follows from the expressions alone: divergence of the fields, determinants at events.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen.formulas import function_of
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout
from chaosdrill.engine import shooting as at
from chaosdrill.engine.structure import examine
from chaosdrill.orbits.derivatives import derived_of
from chaosdrill.orbits.guess import run_from, standpoint
from chaosdrill.orbits.marks import Marks, section_of
from chaosdrill.orbits.multipliers import graded, structural_rank
from chaosdrill.orbits.path import path
from chaosdrill.orbits.results import Checks, FoundOrbit
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from chaosdrill.model import HybridSystem, Transition
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem, Shot


NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)
"""Of the Gauss-Legendre quadrature of one piece of a segment."""


def volume_contraction(problem: "Problem", orbit: "Orbit") -> float:
    """Logarithm of |det| of the tangent map around an orbit.

    The integral of the divergence of the fields (Liouville) plus the logarithms of the determinants of the saltation
    matrices (Aizerman and Gantmakher, On the stability of periodic motions, J. Appl. Math. Mech. 22, 1065 (1958),
    doi:10.1016/0021-8928(58)90033-9), which are derived and evaluated as expressions: no tangent is followed.
    """
    system = problem.plain
    values = np.array(list(system.parameters.values()))
    total = 0.0
    for one, before in problem.segment_by_segment(orbit):
        mode, end, transition = one.segments[0].tolist()
        divergence = _divergence(system, mode)
        if divergence is not None:
            total += _integral(problem, one, divergence, values)
        if end >= 0:
            matrix = _saltation(system, transition, mode)(one.phase + one.durations[0], *before, *values)
            total += float(np.linalg.slogdet(np.array(matrix, dtype=float))[1])
    return total


def _integral(problem: "Problem", one: "Orbit", divergence: Any, values: np.ndarray) -> float:
    """Integral of the divergence along a segment, in pieces that are halved where a jump makes it uneven."""
    length = float(one.durations[0])
    ends = np.linspace(0.0, length, TUNING.quadrature_pieces + 1)

    def pieces(starts: np.ndarray, halves: np.ndarray) -> np.ndarray:
        instants = (starts[:, np.newaxis] + halves[:, np.newaxis] * (1 + NODES)).ravel()
        states = problem.at([one], instants[np.newaxis])[0][0]
        rates = [divergence(one.phase + s, *x, *values) for s, x in zip(instants, states.tolist(), strict=True)]
        return np.asarray(halves * (np.array(rates).reshape(len(starts), -1) @ WEIGHTS))

    starts, halves = ends[:-1], np.diff(ends) / 2
    whole, total = pieces(starts, halves), 0.0
    for _ in range(TUNING.quadrature_halvings):
        starts, halves = np.column_stack([starts, starts + halves]).ravel(), np.repeat(halves / 2, 2)
        parts = pieces(starts, halves)
        sums = parts.reshape(-1, 2).sum(axis=1)
        # NaN stays NaN
        uneven = np.abs(sums - whole) > TUNING.quadrature_error * max(1.0, abs(total + sums.sum()))
        total += float(sums[~uneven].sum())
        again = np.repeat(uneven, 2)
        starts, halves, whole = starts[again], halves[again], parts[again]
        if not len(whole):
            break
    return total + float(whole.sum())


def _divergence(system: "HybridSystem", mode: int) -> Any:
    """Divergence of the field of a mode as a function; None where it is zero."""

    def derive(placed: "HybridSystem") -> Any:
        from chaosdrill.model.derive import jacobian

        trace = jacobian(placed, placed.mode_names[mode]).trace()
        return None if trace == 0 else trace

    return function_of(system, f"divergence {mode}", derive)


def _saltation(system: "HybridSystem", transition: int, mode: int) -> Any:
    def derive(placed: "HybridSystem") -> Any:
        from chaosdrill.model.derive import saltation

        return saltation(placed, placed.transitions[transition], placed.mode_names[mode]).tolist()

    return function_of(system, f"saltation {transition} {mode}", derive)


@dataclass(frozen=True)
class Repeated:
    """Results of runs around an orbit."""

    outcome: Outcome  # ``Outcome.OK``, or what ended the run
    residual: float  # largest difference after one period, relative to the sizes of the states
    recurrence: float  # the same after two periods
    growth: float  # largest factor by which a small deviation, relative to these, grows over a period
    differs: str  # how the events differ from those of the orbit, in words; empty if they do not

    def explained(self, tolerance: float, rounds: int = 1) -> float:
        """Difference that round-off and the tolerance explain after this many rounds."""
        return min(TUNING.slack * (TUNING.step_error + tolerance) * max(1.0, self.growth) ** rounds, TUNING.closed)


def verify(problem: "Problem", orbit: "Orbit") -> Repeated:
    """Go around an orbit twice with the ordinary engine, which searches for events and knows nothing of segments.

    Where small deviations grow too much over a period for that to say anything, the state is put back onto the orbit
    after parts of it, and the differences are those of the parts.
    """
    repeated = _repeated(problem, orbit, 1)
    parts = 2
    while repeated.outcome == Outcome.OK and repeated.growth > TUNING.fast_growth and parts <= TUNING.most_parts:
        repeated = _repeated(problem, orbit, parts)
        parts *= 2
    return repeated


def _repeated(problem: "Problem", orbit: "Orbit", parts: int) -> Repeated:
    """The result of two rounds, each in this number of parts."""
    segment, time, state = standpoint(problem, orbit)
    d, total = problem.states, float(orbit.durations.sum())
    run = run_from(problem, orbit, segment, time, state, parts, tangents=np.eye(d), orthonormalise=False)
    forcing = problem.period_at(orbit)
    instants = (time + np.arange(1, parts + 1) / parts * total) % total
    order = np.argsort(instants)
    ends = np.zeros((parts, d))
    ends[order] = problem.at([orbit], instants[np.newaxis, order])[0][0]
    ends[-1] = state
    laps = np.diff(np.floor((time + np.arange(parts + 1) / parts * total) / total))
    sizes = np.maximum(problem.sizes, np.abs(ends).max(axis=0))
    units = orbit.periods if forcing and parts == 1 else 1
    buffer = np.zeros((8 * len(orbit) + 64, layout.EVENT_COLUMNS + 2 * d))
    differences, rows = np.zeros((2, parts)), []
    growth, differs = 0.0, ""
    for turn in range(2):
        for part in range(parts):
            outcome, full = run.advance(units, events=buffer)
            if outcome != Outcome.OK:
                return Repeated(outcome, np.inf, np.inf, np.inf, f"the run ends: {outcome.advice}")
            if full:
                return Repeated(outcome, np.inf, np.inf, np.inf, "many more events than the orbit has")
            rows.append(buffer[: run.filled()[1]].copy())
            away = run.x - ends[part]
            if orbit.drift is not None:
                away -= (laps[part] if parts > 1 else turn + 1) * orbit.drift
            differences[turn, part] = (np.abs(away) / sizes).max()
            if turn == 0:
                growth = max(growth, float(np.linalg.norm(run.vectors * sizes[:, np.newaxis] / sizes, 2)))
            if parts > 1:
                run.put(ends[part], np.eye(d))
                if forcing:
                    run.begin_at((orbit.phase + time + (part + 1) / parts * total) % forcing)
        if turn == 0:
            differs = _compare(problem, orbit, segment, np.concatenate(rows))
    return Repeated(Outcome.OK, float(differences[0].max()), float(differences[1].max()), growth, differs)


def _agree(met: list[tuple[int, int]], expected: list[tuple[int, int]], transitions: "Sequence[Transition]") -> bool:
    """Whether modes and events agree, but for one rebound before a rest: rounding decides which is the last."""
    longer, shorter = sorted((met, expected), key=len, reverse=True)
    longer = list(longer)
    for k, event in enumerate(shorter):
        if longer[k] != event and transitions[longer[k][1]].name == transitions[event[1]].completes:
            del longer[k]
            break
    return longer == shorter


def _compare(problem: "Problem", orbit: "Orbit", segment: int, rows: np.ndarray) -> str:
    """How the events of a run that began on a segment differ from those of the orbit, in words."""
    transitions = problem.plain.transitions
    met = [(int(row[layout.EVENT_MODE]), int(row[layout.EVENT_KIND])) for row in rows]
    met = [(mode, kind) for mode, kind in met if not transitions[kind].marks_only()]
    turned = np.roll(orbit.segments, -segment, axis=0)
    expected = [(int(mode), int(kind)) for mode, end, kind in turned if end >= 0]
    if _agree(met, expected, transitions):
        return ""
    names = [[transitions[kind].name for _, kind in events] for events in (met, expected)]
    if max(map(len, names)) <= TUNING.named_events:
        went, said = (" ".join(events) or "no event" for events in names)
        return f"{went} instead of {said}"
    first = next((k for k, (a, b) in enumerate(zip(met, expected, strict=False)) if a != b), min(map(len, names)))
    went, said = (events[first] if first < len(events) else "nothing" for events in names)
    return f"event {first + 1} of {len(expected)} is {went} instead of {said}"


def check(problem: "Problem", orbit: "Orbit", found: FoundOrbit, repeated: Repeated) -> Checks:
    """Compare multipliers with exponents and contraction, and the start with the state two periods later.

    ``found``: what is said of it. ``repeated``: runs around it.
    """
    moduli = np.abs(found.multipliers)
    tolerance = problem.numerics.tolerance
    # the speed at a guard is the less certain the smaller it is, and with it the saltation
    slowest = float(np.abs(problem.shoot(orbit, False).speeds / problem.paces(orbit)).min(initial=1.0))
    limit = TUNING.same_logarithm + repeated.explained(tolerance) + 10 * (TUNING.step_error + tolerance) / slowest**2
    if problem.numerics.traits.fixed_step:
        limit += problem.numerics.angle**4 * max(1.0, repeated.growth)
    disagreements = []
    exponents, ends = exponents_of(problem, orbit, moduli, found.rank)
    contraction = volume_contraction(problem, orbit) if found.rank == problem.states else np.nan
    with np.errstate(divide="ignore"):
        logs = np.log(moduli)
    # so small that no double holds it: only its exponent is known
    beyond = (
        (moduli == 0)
        & (exponents * found.duration < TUNING.smallest_logarithm)
        & (np.arange(problem.states) < found.rank)
    )
    logs[beyond] = exponents[beyond] * found.duration
    difference = _difference(logs, exponents * found.duration, ends) / found.duration
    allowed = limit / found.duration
    if not difference <= allowed:
        disagreements.append(
            f"exponents and logarithms of the multipliers differ by {difference:.1e} (explained: {allowed:.1e})"
        )
    determinant = float("nan")
    if found.rank == problem.states and not beyond.any():
        product, expected = float(logs.sum()), contraction
        determinant = float(-np.expm1(-abs(product - expected)))
        if not determinant <= limit:
            disagreements.append(
                f"product of the multipliers and product of all contractions differ by {determinant:.1e} of the larger"
            )
    if not repeated.recurrence <= repeated.explained(tolerance, 2):
        disagreements.append(f"after a second period the state is off by {repeated.recurrence:.1e}")
    return Checks(
        exponents=exponents,
        exponent_difference=difference,
        determinant_difference=determinant,
        recurrence_difference=repeated.recurrence,
        consistent=not disagreements,
        disagreements="; ".join(disagreements),
    )


def exponents_of(problem: "Problem", orbit: "Orbit", moduli: np.ndarray, rank: int) -> tuple[np.ndarray, list[int]]:
    """Lyapunov exponents of the orbit by the engine's QR, and where groups of nearly equal ones end.

    The state is put back onto the orbit after every round, so that an unstable one is not left. Multipliers of nearly
    the same modulus, as complex pairs, rotate about each other; only the mean of their exponents is that of one round.

    Returns: ``exponents``, shape (d,): descending; -inf for directions that events remove; members of a group lie about
    its mean as their multipliers do. ``ends``: index of the first exponent after each group.
    """
    d, duration = problem.states, float(orbit.durations.sum())
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(moduli[:rank])
        falls = -np.diff(logs)
        apart = falls * TUNING.exponent_rounds >= -np.log(TUNING.exponent_turned)
    # a tangent that turns gains what units are apart: decay must exceed that, too, before growth tells the order
    turned = np.ptp(np.log(problem.sizes)) - np.log(TUNING.exponent_turned)
    rounds = int(np.ceil(max(turned / falls[apart], default=1.0))) + d
    ends = [*(np.flatnonzero(apart) + 1).tolist(), rank]
    segment, time, state = standpoint(problem, orbit)
    structure = examine(problem.plain)
    frame, symmetries = structure.tangents(d)
    run = run_from(
        problem, orbit, segment, time, state, tangents=frame, symmetries=symmetries, deficient=structure.deficient
    )
    outcome = Outcome.OK
    begun = before = np.zeros(d)
    for turn in range(rounds + 1):
        before = run.logs.copy()
        begun = before if turn == 1 else begun
        outcome = run.advance(orbit.periods)[0] if outcome == Outcome.OK else outcome
        run.x[:] = state
    values = np.full(d, np.nan)
    if outcome == Outcome.OK:
        found = (run.logs - before) / duration
        found[run.lost == 1] = -np.inf
        # one round says nothing of the order: those of a pair go up and down by more than pairs are apart; the first
        # holds the decay of what begins across slower directions
        order = np.argsort(-np.where(np.isneginf(found), found, run.logs - begun), kind="stable")
        values = found[order]
        # growth alone tells multipliers apart that no double holds
        grown = -np.diff((run.logs - begun)[order][:rank]) / rounds
        apart |= np.isnan(falls) & (grown * TUNING.exponent_rounds >= -np.log(TUNING.exponent_turned))
        ends = [*(np.flatnonzero(apart) + 1).tolist(), rank]
        for first, end in zip([0, *ends[:-1]], ends, strict=True):
            if end > first:
                about = logs[first:end] - logs[first:end].mean() if np.isfinite(logs[first:end]).all() else 0.0
                values[first:end] = values[first:end].mean() + about / duration
    return values, ends


def _difference(logs: np.ndarray, exponents: np.ndarray, ends: list[int]) -> float:
    """Largest difference between the means of groups; infinite if not the same ones are -inf."""
    lost = np.isneginf(logs)
    if not np.array_equal(lost, np.isneginf(exponents)):
        return float("inf")
    logs, exponents = (np.where(lost, 0.0, values) for values in (logs, exponents))
    pairs = zip([0, *ends[:-1]], ends, strict=True)
    return max((abs(float(logs[a:b].mean() - exponents[a:b].mean())) for a, b in pairs if b > a), default=0.0)


def describe(
    problem: "Problem",
    orbit: "Orbit",
    shot: "Shot",
    residuals: np.ndarray,
    message: str = "",
    marks: Marks | None = None,
    derive: "Sequence[str]" = (),
) -> FoundOrbit:
    """The verified orbit; a result without an orbit if an ordinary simulation does not follow it.

    ``orbit``: a solution of the equations. ``shot``: what shooting around it showed. ``residuals``: of Newton's method.
    ``message``: what there is to say of it. ``marks``: the section on which its points are given; default: the strobe,
    or where the orbit starts. ``derive``: parameters by which the results are differentiated.
    """
    repeated = verify(problem, orbit)
    if repeated.differs:
        text = f"the equations close, but a run of the system from there differs: {repeated.differs}"
        return no_orbit(problem.plain, Outcome.INADMISSIBLE, text, orbit.periods, residuals)
    if not repeated.residual <= repeated.explained(problem.numerics.tolerance):
        text = f"the equations close, but a run of the system from there misses its start by {repeated.residual:.1e}"
        return no_orbit(problem.plain, Outcome.INADMISSIBLE, text, orbit.periods, residuals)
    if not np.isfinite(shot.monodromy).all():
        text = "the orbit meets a guard at zero speed, where small deviations grow without bound: it has no multipliers"
        return no_orbit(problem.plain, Outcome.NONFINITE, text, orbit.periods, residuals)
    rank = structural_rank(problem, orbit)
    strobes, modes = problem.strobes([orbit])
    found = FoundOrbit(
        outcome=Outcome.PERIODIC,
        message=message,
        period=orbit.periods,
        duration=float(orbit.durations.sum()),
        states=strobes[0],
        section=section_of(problem, orbit, marks),
        mode=int(modes[0, 0]),
        multipliers=graded(problem, orbit, shot.monodromy, rank),
        rank=rank,
        residual=repeated.residual,
        newton=residuals,
        **_events(problem, orbit, shot),
        **dict(zip(("path_times", "path_states"), path(problem, orbit), strict=True)),
        checks=_nothing_to_check(problem.states),
        neutral=problem.neutral.count,
        derived=None,
        solved=(problem, orbit, shot),
    )
    derived = derived_of(problem, derive, [(orbit, found.multipliers, rank)])[0] if derive else None
    return replace(found, checks=check(problem, orbit, found, repeated), derived=derived)


def no_orbit(
    system: "HybridSystem", outcome: Outcome, message: str, period: int, residuals: np.ndarray | None
) -> FoundOrbit:
    """Why there is no orbit."""
    d = len(system.state_names)
    nothing = float("nan")
    return FoundOrbit(
        outcome=outcome,
        message=message,
        period=period,
        duration=nothing,
        states=np.zeros((0, d)),
        section=np.zeros((0, d)),
        mode=-1,
        multipliers=np.full(d, complex(nothing, nothing)),
        rank=0,
        residual=nothing,
        newton=np.zeros(0) if residuals is None else residuals,
        event_times=np.zeros(0),
        event_speeds=np.zeros(0),
        event_transitions=np.zeros(0, dtype=np.int64),
        event_states_before=np.zeros((0, d)),
        event_states_after=np.zeros((0, d)),
        checks=_nothing_to_check(d),
        path_times=np.zeros(0),
        path_states=np.zeros((0, d)),
    )


def _nothing_to_check(d: int) -> Checks:
    nothing = float("nan")
    return Checks(np.full(d, nothing), nothing, nothing, nothing, False)


def _events(problem: "Problem", orbit: "Orbit", shot: "Shot") -> dict[str, Any]:
    """Events in the order in which they come from the first strobe on, as fields of a `FoundOrbit`."""
    d = problem.states
    before = np.array([state for _, state in problem.segment_by_segment(orbit)])
    ends = np.cumsum(orbit.durations)
    times = (ends - problem.first_strobe(orbit)) % ends[-1] if problem.forced else ends
    times, order = orbit.in_order(times)
    after = np.roll(orbit.starts[:, :d], -1, axis=0)
    if orbit.drift is not None:
        after[-1] += orbit.drift
        again = np.rint((times - ends + problem.first_strobe(orbit)) / ends[-1])[:, np.newaxis]
        before, after = before + again * orbit.drift, after + again * orbit.drift
    return {
        "event_times": times[order],
        "event_speeds": shot.rates[order],
        "event_transitions": orbit.segments[order, at.SEGMENT_OUTCOME],
        "event_states_before": before[order],
        "event_states_after": after[order],
    }
