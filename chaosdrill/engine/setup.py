"""What a system and its numerics put into the engine's arrays, whatever the point at which it is run."""

from collections.abc import Collection, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.formulas import function_of
from chaosdrill.codegen.layout import Shape
from chaosdrill.codegen.signatures import event_places
from chaosdrill.dataset import Outcome
from chaosdrill.engine import layout as at
from chaosdrill.engine.dop853_tables import stage_rows
from chaosdrill.engine.lanes import LANES, aligned
from chaosdrill.engine.methods import METHODS, Method
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.radau_tables import MOST_STAGES
from chaosdrill.engine.tuning import LANE, ROOTS, RUNS
from chaosdrill.errors import SettingsError
from chaosdrill.model.regions import UNTOLD, modes_at
from chaosdrill.model.tables import DEFAULT_BOUNDS

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem


def settings_of(
    system: "HybridSystem", numerics: Numerics, order: int, *, samples: int = 1, orthonormalise: bool
) -> np.ndarray:
    """Settings of runs, one record; ``order`` is that of a guard's polynomial."""
    if numerics.traits.series and (found := system.sources):
        place, one = next(iter(found.items()))
        others = [repr(name) for name, method in METHODS.items() if not method.series]
        raise SettingsError(
            f"method is {numerics.method!r}, which takes series of expressions, but {system.name} has a Python "
            f"function, {one.name!r:.60} at {place:.200}; pass method={' or '.join(others)}"
        )
    settings = np.zeros(1, dtype=at.SETTINGS)
    settings["stepping"] = _stepping(numerics.traits)
    settings["order"] = order
    settings["quadratures"] = len(system.quadratures)
    settings["samples"] = samples
    settings["orthonormalise"] = int(orthonormalise)
    settings["absolute_time"] = int(not system.forced)
    settings["own_jacobian"] = int(kernels_of(system).layout.own_jacobian)
    settings["max_events"] = numerics.max_events or (10_000 if system.forced else 10_000_000)
    settings["max_stalls"] = numerics.max_stalls
    settings["max_steps"] = RUNS.most_steps
    settings["tolerance"] = numerics.tolerance
    settings["phase"] = system.phase
    settings["dense_noise"] = getattr(import_module(f"chaosdrill.engine.{numerics.method}"), "DENSE_NOISE", 0.0)
    # at this part of the radius of convergence the last term is a quarter of the tolerance
    settings["reach"] = (numerics.tolerance / 4) ** (1 / order)
    return settings


def _stepping(method: Method) -> int:
    if method.series:
        return at.BY_SERIES
    return at.FIXED if method.fixed_step else at.ADAPTIVE


def tables_of(
    system: "HybridSystem", deficient: Collection[int], symmetries: np.ndarray, through: Collection[tuple[int, int]]
) -> at.Tables:
    """Tables of a system.

    Rank may be lost at the transitions in ``deficient``; ``symmetries`` are rows (k, n); ``through`` is what
    `chaosdrill.engine.structure.passes` says.
    """
    kernels, fences = kernels_of(system), fences_of(system)
    transitions = np.zeros((len(kernels.transition_table), 5), dtype=np.int64)
    transitions[:, [at.TO_MODE, at.MARKS_ONLY]] = kernels.transition_table
    transitions[sorted(deficient), at.RANK_DEFICIENT] = 1
    completed = {t.completes for t in system.transitions} - {None}
    transitions[[k for k, t in enumerate(system.transitions) if t.completes is not None], at.COMPLETES] = 1
    transitions[[k for k, t in enumerate(system.transitions) if t.name in completed], at.COMPLETED] = 1
    watched = np.zeros((len(kernels.layout.events), kernels.moves_table.shape[1]), dtype=np.int64)
    for row, events in zip(watched, kernels.layout.events, strict=True):
        row[[e.key for e in events]] = 1
    return at.Tables(
        active=kernels.mode_table,
        keys=kernels.key_table,
        surfaces=kernels.surface_table,
        watched=watched,
        marks=_marks(system, deficient, through),
        transitions=transitions,
        moves=kernels.moves_table,
        returns=np.array(kernels.layout.returns, dtype=np.int64).reshape(-1, 2),
        bounds=bounds_at_ends(system, fences),
        fences=fences,
        symmetries=np.array(symmetries, dtype=float),
        constrained=constrained_states(system),
        feeds=np.array(kernels.layout.feeds, dtype=np.int64),
        proportional=_listed(kernels.layout.proportional),
        held=np.array(kernels.layout.held, dtype=np.int64),
        slack=np.zeros(len(system.state_names)),
        **_steep(system),
    )


def _listed(rows: Sequence[Sequence[int]]) -> np.ndarray:
    """Of rows of flags, how many are set and which."""
    found = np.zeros((len(rows), 1 + max(map(sum, rows))), dtype=np.int64)
    for row, flags in zip(found, rows, strict=True):
        places = np.flatnonzero(flags)
        row[: 1 + len(places)] = [len(places), *places]
    return found


def _steep(system: "HybridSystem") -> dict[str, np.ndarray]:
    """What is known of the operations that are watched."""
    kernels = kernels_of(system)
    most = max(map(len, kernels.layout.steep))
    rows = np.full((len(kernels.layout.steep), 1 + most), -1, dtype=np.int64)
    shapes = np.zeros((len(kernels.layout.steep), most, len(Shape._fields)))
    for mode, watched in enumerate(kernels.layout.steep):
        rows[mode, 0] = len(watched)
        shapes[mode, : len(watched)] = watched or shapes[mode, :0]
    for mode, found in enumerate(kernels.layout.watched):
        rows[mode, 1 : 1 + len(found)] = found
    return {"steep": rows, "shapes": shapes}


def _marks(system: "HybridSystem", deficient: Collection[int], through: Collection[tuple[int, int]]) -> np.ndarray:
    """What the guards of every mode are, in bits."""
    kernels = kernels_of(system)
    marks = np.zeros(kernels.key_table.shape, dtype=np.int64)
    for mode, events in enumerate(kernels.layout.events):
        for j, event in enumerate(events):
            only = all(kernels.transition_table[k, 1] for k in event.outcomes)
            kicks = all(kernels.transition_table[k, 0] == mode for k in event.outcomes)
            on = event.timed or (mode, j) in through
            marks[mode, j] = (
                at.MARKS * only
                + at.LOSES_RANK * any(k in deficient for k in event.outcomes)
                + at.AFFINE * event.affine
                + at.STEEP * event.steep
                + at.TIMED * event.timed
                + at.OPEN * (only or (kicks and on))
                + at.PASSES * on
                + at.STILL * event.still
            )
    return marks


def bounds_of(system: "HybridSystem") -> np.ndarray:
    """Lower and upper bounds of the states, shape (2, n)."""
    limits = system.escapes
    return np.array([limits[s] for s in system.state_names]).T.copy()


def bounds_at_ends(system: "HybridSystem", fences: np.ndarray) -> np.ndarray:
    """The same of those that are looked at where steps end: infinite for states that have fences."""
    bounds = bounds_of(system)
    bounds[:, fences[:, 0].astype(np.int64)] = [[-np.inf], [np.inf]]
    return bounds


def fences_of(system: "HybridSystem") -> np.ndarray:
    """What lies just beyond the bounds that a system was given, as `engine.layout.Tables` has it; of a map nothing."""
    found = []
    for i, name in enumerate(system.state_names):
        low, high = system.bounds[name]
        if not system.discrete and (low, high) not in (DEFAULT_BOUNDS, (-np.inf, np.inf)):
            found.append((i, np.nextafter(low, -np.inf), np.nextafter(high, np.inf)))
    return np.array(found, dtype=float).reshape(-1, 3)


def constrained_states(system: "HybridSystem") -> np.ndarray:
    """Which states each mode leaves no freedom, shape (modes, n)."""
    if "pins" not in system.shared:
        from chaosdrill.model.derive import pinned_states

        placed = system.placed
        system.shared["pins"] = [
            [int(i in pinned) for i in range(len(placed.states))]
            for pinned in (pinned_states(placed, mode) for mode in placed.modes)
        ]
    return np.array(system.shared["pins"], dtype=np.int64)


def values_of_constrained(
    system: "HybridSystem", parameters: Mapping[str, Any], mode: int, time: float = 0.0
) -> dict[int, Any]:
    """What a mode pins its states to, by default at the strobe: index -> value, an array if a parameter is one."""

    def derive(placed: "HybridSystem") -> Any:
        from chaosdrill.model.derive import pinned_values

        values = pinned_values(placed, placed.mode_names[mode])
        return (list(values), list(values.values())) if values else None

    function = function_of(system, f"pinned {mode}", derive, arrays=True)
    if function is None:
        return {}
    numbers = [parameters.get(name, own) for name, own in system.parameters.items()]
    # they depend on no state
    return dict(zip(*function(time, *[np.nan] * len(system.state_names), *numbers), strict=True))


def modes_of_starts(
    system: "HybridSystem", parameters: Mapping[str, np.ndarray], starts: np.ndarray, modes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The modes in which P runs begin, and `Outcome.OK` or why they cannot.

    ``parameters``, shape (P,), are those that differ from the system's own; ``starts`` has shape (P, n), and ``modes``,
    shape (P,), is `UNTOLD` where the region of the state tells it.
    """
    outcomes = np.full(len(starts), int(Outcome.OK))
    if system.regions:
        found, possible = modes_at(system, parameters, starts)
        modes = np.where(modes == UNTOLD, found, modes)
        outcomes[modes == UNTOLD] = Outcome.INVALID_START
        outcomes[~possible] = Outcome.FAILED
    return np.maximum(modes, 0), outcomes


def states_of(
    system: "HybridSystem",
    constants: np.ndarray,
    starts: np.ndarray,
    modes: np.ndarray,
    periods: np.ndarray,
    tangents: np.ndarray,
    numerics: Numerics,
    *,
    with_shares: bool = False,
) -> at.States:
    """The states of P runs that are to begin.

    Shapes are (P, constants), (P, n) of ``starts``, (P,) of ``modes`` and of ``periods``, the times between strobes,
    and (m, n) of ``tangents``, the initial ones of each run. ``with_shares`` keeps of which tangents each was made.
    """
    kernels = kernels_of(system)
    points, n = starts.shape
    m, q, keys, kinds = len(tangents), len(system.quadratures), kernels.moves_table.shape[1], len(kernels.moves_table)
    run = np.zeros(points, dtype=at.RUN)
    run["mode"] = modes
    run["live"] = m
    run["fresh"] = at.BEGIN
    run["fired"] = run["surface"] = run["moved_by"] = run["blocked"] = run["waiting"] = -1
    run["qr_wait"], run["rank_check"] = 1, at.CHECKED
    run["period"] = periods
    run["fixed_step"] = periods / numerics.steps_a_period
    scale = np.zeros((points, n + q))
    return at.States(
        run=run,
        c=constants,
        x=np.array(starts, dtype=float),
        scale=scale,
        span=np.zeros_like(scale) if any(map(any, kernels.layout.proportional)) else scale,
        sums=np.zeros((points, 3, q)),
        vectors=np.repeat(tangents[np.newaxis], points, axis=0),
        exponent_of=np.repeat(np.arange(max(m, 1))[np.newaxis], points, axis=0),
        lost=np.zeros((points, max(m, 1)), dtype=np.int64),
        logs=np.zeros((points, max(m, 1))),
        grown=np.ones((points, max(m, 1))),
        sooner=np.zeros((points, max(m, 1))),
        shares=np.zeros((points, m, m) if with_shares else (points, 0, 0)),
        sides=np.zeros((points, keys), dtype=np.int64),
        counts=np.zeros((points, kinds), dtype=np.int64),
        grazing=np.full((points, kinds), np.inf),
        hardest=np.zeros((points, keys)),
        extent=np.abs(starts),
        doubt=np.zeros((points, n)),
        leeway=np.zeros((points, n)),
        normal=np.zeros((points, n + 1)),
    )


def scratch_of(system: "HybridSystem", m: int, method: str) -> at.Scratch:
    """Scratch arrays of the engine for a system with m tangents and a method."""
    n, q, guards = len(system.state_names), len(system.quadratures), kernels_of(system).key_table.shape[1]
    return at.Scratch(
        workspace=aligned(kernels_of(system).layout.rows + (m + m % 2) * n, at.COLUMNS),
        polynomial=np.zeros(at.COLUMNS),
        shifted=np.zeros(at.COLUMNS),
        stack=aligned(ROOTS.depth, at.COLUMNS),
        ends=np.zeros((ROOTS.depth, 2)),
        times=np.zeros(guards),
        backs=np.full(guards, -1.0),
        orders=np.zeros(guards, dtype=np.int64),
        gradient=np.zeros(n + 1),
        errors=np.zeros(2),
        weights=np.zeros(n),
        metric=np.zeros(n),
        none=np.zeros(n + q),
        before=np.zeros(n + q),
        after=np.zeros(n + q),
        out=np.zeros(n + q),
        image=np.zeros(n),
        whole=np.zeros(n),
        event=np.zeros(event_places(n).size),
        jump=np.zeros(n),
        stages=np.zeros((stage_rows(m), n + q)),
        normals=np.zeros((max(kernels_of(system).layout.held), n + 2)),
        implicit=_implicit(n, m) if METHODS[method].implicit else _implicit(0, 0),
        doubt=np.zeros(n + q),
        watched=np.zeros((4, max(map(len, kernels_of(system).layout.steep)))),
    )


def _implicit(n: int, m: int) -> at.Implicit:
    s = MOST_STAGES
    return at.Implicit(
        at_start=np.zeros((n, n)),
        jacobians=np.zeros((s, n, n)),
        matrix=np.zeros((s * n, s * n)),
        filter=np.zeros((n, n)),
        changes=np.zeros((s + 1, n)),
        right=np.zeros(s * n),
        spare=np.zeros((2, n)),
        frame=np.zeros((m, n)),
        decay=np.zeros((6, m)),
        pivots=np.zeros(s * n, dtype=np.int64),
        filter_pivots=np.zeros(n, dtype=np.int64),
        active=np.zeros(n, dtype=np.int64),
    )


def _block(system: "HybridSystem", m: int, constants: np.ndarray) -> at.Block:
    """Arrays of a block of lanes for a system with m tangents and the constants of one point; what varies from point
    to point is filled in later."""
    n, q, guards = len(system.state_names), len(system.quadratures), kernels_of(system).key_table.shape[1]
    in_lanes = aligned(len(constants), LANES)
    in_lanes[:] = constants[:, np.newaxis]
    rows = kernels_of(system).layout.rows + (m + m % 2) * n
    # one more column than is used: of rows whose length is a power of two, few would find room in the cache together
    columns = at.COLUMNS + 1
    return at.Block(
        t=aligned(LANES),
        c=in_lanes,
        x=aligned(n, LANES),
        v=aligned(m, n, LANES),
        ws=aligned(rows, columns, LANES),
        scale=aligned(n, LANES),
        span=aligned(n if any(map(any, kernels_of(system).layout.proportional)) else 0, LANES),
        weights=aligned(n, LANES),
        metric=aligned(n, LANES),
        h=aligned(LANES),
        reach=aligned(LANES),
        gap=aligned(3, LANES),
        out=aligned(n + q, LANES),
        period=aligned(LANES),
        scaled=aligned(guards, at.COLUMNS, LANES),
        total=aligned(guards, LANES),
        later=aligned(guards, LANES),
        wanted=aligned(guards, LANES),
        alone=aligned(LANES),
        which=aligned(LANES),
        sign=aligned(guards, LANES),
        shift=aligned(guards, LANES),
        times=aligned(guards, LANES),
        backs=aligned(guards, LANES),
        polynomial=aligned(at.COLUMNS, LANES),
        bernstein=aligned(at.BERNSTEIN, LANES),
    )


def room_of(system: "HybridSystem", m: int, constants: np.ndarray, row: np.ndarray, spare: np.ndarray) -> at.LaneRoom:
    """What ``lane_flow`` works in for a system with m tangents; see `chaosdrill.engine.layout.LaneRoom`."""
    return at.LaneRoom(
        queues=np.zeros((len(system.modes) * (m + 1), 2 + LANE.active), dtype=np.int64),
        ends=np.zeros((LANES + 1, LANES), dtype=np.int64),
        row=row,
        spare=spare,
        block=_block(system, m, constants),
    )
