"""Drives with corners and jumps: every mode of a system is divided at the corners, which are events."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from operator import methodcaller
from typing import Any

import sympy

from chaosdrill.errors import ModelError
from chaosdrill.model.crossings import crossings
from chaosdrill.model.derive import pinned_values
from chaosdrill.model.parts import read_expression, read_symbol
from chaosdrill.model.period import value_of
from chaosdrill.model.places import parameter, rewritten
from chaosdrill.model.system import SYSTEM, HybridSystem
from chaosdrill.model.transition import CORNER, Transition
from chaosdrill.names import remedy, shown
from chaosdrill.settings import real
from chaosdrill.typed import TEXT, expecting

SHAPES: dict[str, dict[str, str]] = {
    "square": {"0": "1", "1/2": "-1"},
    "sawtooth": {"0": "2*phase - 1"},
    "triangle": {"0": "4*phase - 1", "1/2": "3 - 4*phase"},
}
"""Drives between -1 and 1 by name; they begin as those of scipy.signal."""

PHASE = parameter("phase")

UNDRIVEN = "a map has no time, and so no drive; drive it by a state of its own, as in phase = 'Mod(phase + w, 1)'"
"""What is said of a map with a drive."""

Piece = tuple[Any, Any]
"""The phase at which a piece begins, and the drive from there."""

Part = tuple[Any, Any, Any]
"""The phases at which a piece, or a half of it, begins and ends, and the drive between them."""


@expecting(ModelError, system=SYSTEM, drive=TEXT)
def driven(
    system: "HybridSystem",
    drive: str,
    pieces: str | Mapping[Any, Any] | None = None,
    *,
    table: Sequence[float] | Mapping[float, float] | None = None,
    period: Any = None,
    time: Any = "t",
) -> "HybridSystem":
    """The system with one of its parameters replaced by a periodic drive that is given piece by piece.

    Every mode becomes one mode a piece, named ``free-0``, ``free-1``, ...; the transitions are those of the system in
    every piece. At the end of a piece there is an event of the kind ``corner``, at its exact time. The system starts
    at phase 0. At parameters that put the phases out of their order a run is refused.

    Parameters
    ----------
    system : HybridSystem
        The system, with the drive as a parameter.
    drive : str
        The parameter that stands for the drive.
    pieces : str or mapping, optional
        ``"square"``, ``"sawtooth"`` or ``"triangle"``, between -1 and 1; or a mapping of the phase at which a piece
        begins, from 0 to 1, to the drive in it: an expression of ``phase``, states and parameters. A phase may be an
        expression of parameters: ``{0: "1", "duty": "-1"}``. Where a piece holds the end of the period, ``phase`` goes
        on beyond 1 in it. A piece that is longer than half a period, or may be at other parameters, counts as two
        halves.
    table : sequence of float, or mapping of float to float, optional
        Values of the drive at equal steps of the phase from 0, or at the phases given. Between them it is the periodic
        cubic spline. Give either ``pieces`` or ``table``.
    period : expression, optional
        Period of the drive; default: that of the system. It is the system's, if that has none.
    time : sympy.Symbol or str, optional
        The symbol that stands for time, if the system has none.

    Returns
    -------
    HybridSystem
        With the period by which it is strobed, and without the parameter.

    Raises
    ------
    ModelError
        If the system has no such parameter, or takes it for a constant where it holds a
        state; if there is no period, or the phases are not between 0 and 1; if there are more modes or transitions than
        a system may have.
    """
    if system.discrete:
        raise ModelError(f"{system.name}: {UNDRIVEN}")
    if drive not in system.parameters:
        raise ModelError(f"{system.name}: there is no parameter {drive!r} to drive; {remedy(drive, system.parameters)}")
    symbol = parameter(drive)
    _check_modes(system, symbol)
    own = system.period
    names = system.parameters
    length = own if period is None else read_expression(f"{system.name}: period of the drive", period, names)
    if length is None:
        raise ModelError(f"{system.name} has no period, and the drive needs one; give period=")
    values = {key: value for key, value in system.parameters.items() if key != drive}
    named = read_symbol(f"{system.name}: time", time)
    clock = system.time or named
    turn = 2 * sympy.pi * clock / length
    if (pieces is None) == (table is None):
        raise ModelError(f"{system.name}: the drive {drive!r} is given by pieces or by a table; give one of them")
    given = _pieces(system.name, pieces, values) if table is None else _spline(system.name, table)
    found = list(_parts(given))
    puts = [
        {symbol: shape.xreplace({PHASE: (start + end) / 2 + _turns(sympy.expand(turn - sympy.pi * (start + end)))})}
        for start, end, shape in found
    ]
    each = [rewritten(system, methodcaller("xreplace", put)) for put in puts]
    corners = [sympy.sin(sympy.expand(turn - 2 * sympy.pi * end)) for _, end, _ in found]
    regions = _regions(system, symbol, given, found)
    start = {name: value for name, value in system.initial.items() if name != "mode"}
    if list(regions.values()) == [sympy.true]:
        start, regions = {**start, "mode": next(iter(regions))}, {}
    made = system.remade(
        time=clock,
        parameters=values,
        modes={f"{mode}-{k}": field for k, one in enumerate(each) for mode, field in one.modes.items()},
        transitions=_transitions(system, drive, each, corners, puts),
        period=length if own is None else own,
        initial=start,
        regions=regions,
        quadratures={
            name: {f"{mode}-{k}": rate for k, one in enumerate(each) for mode, rate in one.quadratures[name].items()}
            for name in system.quadratures
        },
        labels={key: label for key, label in system.labels.items() if key != drive},
    )
    return made.limited(system.limits)


def _transitions(
    system: "HybridSystem",
    drive: str,
    each: Sequence["HybridSystem"],
    corners: Sequence[Any],
    puts: Sequence[Mapping[Any, Any]],
) -> list[Transition]:
    """The transitions of the system in every piece, then the corners.

    ``each``: the system in every piece. ``corners``: what is zero, and rises, at its end. ``puts``: the drive in it.
    """
    # what a mode holds is held in the next piece too
    held = {mode: pinned_values(system, mode) for mode in system.modes}
    found: list[Transition] = []
    ends: list[Transition] = []
    for k, (one, guard) in enumerate(zip(each, corners, strict=True)):
        following = (k + 1) % len(each)
        resets = {
            mode: {system.states[i]: value.xreplace(puts[following]) for i, value in states.items()}
            for mode, states in held.items()
        }
        turns = {
            mode: Transition(f"corner-{drive}-{mode}-{k}", f"{mode}-{k}", f"{mode}-{following}", guard, +1, reset,
                             kind=CORNER)
            for mode, reset in resets.items()
        }  # fmt: skip
        pieces = [_in_piece(t, k) for t in one.transitions]
        corner, *ways = crossings((next(iter(turns.values())), *pieces))
        for t, piece, way in zip(system.transitions, pieces, ways, strict=True):
            if way == corner:
                # what happens at the corner leads into the next piece
                piece = replace(piece, target=f"{t.target}-{following}", reset={**piece.reset, **resets[t.target]})
                if not piece.conditions:
                    turns = {mode: one for mode, one in turns.items() if mode not in t.source}
            found.append(piece)
        ends += turns.values()
    return [*found, *ends]


def _check_modes(system: "HybridSystem", drive: Any) -> None:
    """Refuse a drive that modes take for a constant."""
    for mode in system.modes:
        if any(drive in value.free_symbols for value in pinned_values(system, mode).values()):
            raise ModelError(
                f"{system.name}: mode {mode!r} holds a state where the drive {drive.name!r} is, as if that did not "
                "move; drive something else"
            )
        ways_in = [t for t in system.transitions if t.target == mode and t.condition is not None]
        ways_out = [t for t in system.transitions if mode in t.source and t.target != mode]
        allowed = any(drive in one.free_symbols for t in ways_in for one in t.conditions.values())
        if allowed and not any(drive in t.guard.free_symbols for t in ways_out):
            raise ModelError(
                f"{system.name}: mode {mode!r} is entered if the drive {drive.name!r} allows it, and no guard of it "
                "sees when that ends; name a state or time in what holds it"
            )


def _turns(angle: Any) -> Any:
    """The part of a turn from -1/2 to 1/2 that an angle is, as a function with a Taylor series between these."""
    return sympy.atan(sympy.sin(angle) / (1 + sympy.cos(angle))) / sympy.pi


def _in_piece(t: "Transition", k: int) -> "Transition":
    """A transition of the system in a piece of the drive."""
    return replace(
        t,
        name=f"{t.name}-{k}",
        source=tuple(f"{mode}-{k}" for mode in t.source),
        target=f"{t.target}-{k}",
        condition={f"{mode}-{k}": one for mode, one in t.conditions.items()} or None,
        completes=None if t.completes is None else f"{t.completes}-{k}",
    )


def _pieces(name: str, pieces: Any, values: Mapping[str, float]) -> list[Piece]:
    """The pieces in the order of their beginnings."""
    if isinstance(pieces, str):
        if pieces not in SHAPES:
            raise ModelError(f"{name}: unknown drive {pieces!r}; {remedy(pieces, SHAPES)}")
        pieces = SHAPES[pieces]
    if not isinstance(pieces, Mapping) or not pieces:
        raise ModelError(
            f"{name}: pieces is {pieces!r}; it must be one of {list(SHAPES)} or a mapping, as in {{0: '1', 0.5: '-1'}}"
        )
    if PHASE.name in values:
        raise ModelError(f"{name}: a parameter is named 'phase', which stands for the phase of the drive; rename it")
    read = [
        tuple(
            read_expression(f"{name}: {what}", given, values)
            for what, given in (("beginning of a piece", start), (f"piece at {start}", shape))
        )
        for start, shape in pieces.items()
    ]
    return sorted(_checked(name, read, values), key=lambda piece: value_of(piece[0], values))


def _spline(name: str, table: Any) -> list[Piece]:
    """The periodic cubic spline through a table, each piece around its middle."""
    from scipy.interpolate import CubicSpline

    fault = ModelError(
        f"{name}: table is {shown(table):.100}; it must be at least three numbers, or a mapping of phases from 0 to 1 "
        "to them"
    )
    try:
        if isinstance(table, Mapping):
            where = f"{name}: phase of the table"
            knots = sorted((read_expression(where, key), real(v)) for key, v in table.items())
        elif isinstance(table, Iterable) and not isinstance(table, str):
            numbers = [real(v) for v in table]
            knots = [(sympy.Rational(k, len(numbers)), v) for k, v in enumerate(numbers)]
        else:
            raise fault
    except (TypeError, ValueError):
        raise fault from None
    if len(knots) < 3 or not all(abs(v) < float("inf") for _, v in knots):
        raise fault
    starts = _checked(name, knots, {})
    ends = [*(start for start, _ in starts[1:]), starts[0][0] + 1]
    at = [float(start) for start, _ in starts]
    spline = CubicSpline([*at, at[0] + 1], [v for _, v in [*starts, starts[0]]], bc_type="periodic")
    found = []
    for (start, _), end in zip(starts, ends, strict=True):
        middle = (start + end) / 2
        slopes = (float(spline(float(middle), order)) / (1, 1, 2, 6)[order] for order in range(4))
        found.append((start, sum(c * (PHASE - middle) ** order for order, c in enumerate(slopes))))
    return found


def _checked(name: str, pieces: list[Piece], values: Mapping[str, float]) -> list[Piece]:
    """The pieces, if they begin at different phases from 0 to 1."""
    starts = [
        value_of(start, values) if start.free_symbols <= set(map(parameter, values)) else -1 for start, _ in pieces
    ]
    if not all(0 <= start < 1 for start in starts) or len(set(starts)) < len(starts):
        raise ModelError(
            f"{name}: pieces of the drive begin at {[str(start) for start, _ in pieces]}; these must be different "
            "phases from 0 to less than 1, numbers or expressions of parameters"
        )
    return pieces


def _parts(pieces: list[Piece]) -> Iterator[Part]:
    """The pieces with their ends, halved if they may be longer than half a period.

    So the sine that is zero at the end is below zero all the way there, and rises at full speed.
    """
    ends = [*(start for start, _ in pieces[1:]), pieces[0][0] + 1]
    for (start, shape), end in zip(pieces, ends, strict=True):
        if (sympy.expand(end - start) <= sympy.Rational(1, 2)) == sympy.true:
            yield start, end, shape
        else:
            middle = sympy.expand((start + end) / 2)
            yield start, middle, shape
            yield middle, end, shape


def _regions(system: "HybridSystem", drive: Any, pieces: list[Piece], parts: list[Part]) -> dict[str, Any]:
    """Where a start is in each mode: in the first part if it begins at phase 0, else in the last piece, at phase 1."""
    starts = [start for start, _ in pieces]
    order = sympy.And(starts[0] >= 0, *(one < other for one, other in pairwise(starts)), starts[-1] < 1)
    last = len(parts) - 1
    halved = parts[last][0] != starts[-1]
    late, middle = starts[0] > 0, parts[last][0]
    in_last = [(last - 1, middle > 1), (last, middle <= 1)] if halved else [(last, sympy.true)]
    tries = [(0, 0, starts[0] <= 0), *((k, 1, sympy.And(late, here)) for k, here in in_last)]
    known = system.start
    bases = {known["mode"]: sympy.true} if "mode" in known else system.regions
    found: dict[str, Any] = {}
    for k, phase, here in tries:
        put = {drive: parts[k][2].xreplace({PHASE: sympy.Integer(phase)})}
        for mode, region in bases.items():
            name, condition = f"{mode}-{k}", sympy.And(region.xreplace(put), here)
            found[name] = sympy.Or(found.get(name, sympy.false), condition)
    return {mode: sympy.And(region, order) for mode, region in found.items() if region != sympy.false}
