"""What the engine is told of a system beside its functions: plain data, which knows no expression."""

from typing import Any, NamedTuple

UNIT = 2.0**-53
"""The rounding unit."""

EPSILON = 2 * UNIT
"""Distance from 1 to the next larger double."""

ROUNDING = 4 * EPSILON
"""Rounding unit of the bounds of guards: twice that of doubles for the state itself, twice that for fused operations
that the bounds know nothing of."""

CROSSED, ONE_SIDED, AT_SERIES, AT_ALL = range(4)
"""Whether the argument of an operation may pass through zero: it may; not in a series, and methods that need none go on
with zero behind it; not in a series; never."""


class Shape(NamedTuple):
    """How far the argument w of an operation may move in a step before the operation is looked at.

    That is ``orders`` times the order of the series, or ``part * abs(w) - dead``, whichever is larger. Between two
    looks it may move by ``unit``, or by ``finer`` of how far it is beyond ``dead``, or of ``floor`` times its largest
    value in the step.
    """

    orders: float
    part: float
    dead: float
    unit: float
    finer: float
    floor: float
    through: float
    """CROSSED, ONE_SIDED, AT_SERIES or AT_ALL"""


class Watched(NamedTuple):
    """A surface that one mode watches: its outcomes are transitions in the order in which they are tried."""

    direction: int
    outcomes: tuple[int, ...]
    affine: bool
    """Whether it is linear in the states and free of time."""
    steep: bool
    """Whether it has operations that may hide something from a step."""
    timed: bool
    """Whether it depends on time alone."""
    still: bool
    """Whether no motion of the mode leads it to zero, so that only a reset can carry it across."""
    key: int
    """Number of the guard with its direction, the same in all modes that watch it."""
    surface: int
    """Number of the surface on which it is zero, the same for both directions."""


class Layout(NamedTuple):
    """The layout of what the functions of a system fill, and what is known of them."""

    events: tuple[tuple[Watched, ...], ...]
    """Guards that each mode watches."""
    rows: int
    """Workspace rows before those of the tangents."""
    own_jacobian: bool
    """Whether the Jacobian needs series that the jet does not hold."""
    constants: int
    held: tuple[int, ...]
    """How many surfaces each mode holds; ``guard`` numbers them behind the guards."""
    steep: tuple[tuple[Shape, ...], ...]
    """Operations of each mode that are watched; ``watch`` gives what they are applied to."""
    watched: tuple[tuple[int, ...], ...]
    """Rows of what they are applied to; none without series."""
    returns: tuple[tuple[int, int], ...]
    """See `codegen.events.returns`."""
    moves: tuple[tuple[int, ...], ...]
    """By transition and key: 1 where the transition resets a state that the guard depends on."""
    targets: tuple[tuple[int, int], ...]
    """By transition: target mode; 1 if the transition only marks a section."""
    feeds: tuple[tuple[int, ...], ...]
    """By mode and state: 1 where rates in the mode depend on the state."""
    proportional: tuple[tuple[int, ...], ...]
    """By mode and state: 1 where the state stays zero if it is, and leaves zero at a rate that changes."""

    @classmethod
    def of(cls, plain: Any) -> "Layout":
        """A layout from lists of lists, as JSON has it."""
        found = cls(*plain)
        return found._replace(
            events=tuple(tuple(_watched(one) for one in events) for events in found.events),
            steep=tuple(tuple(Shape(*map(float, one)) for one in shapes) for shapes in found.steep),
            **{name: _rows(getattr(found, name)) for name in ("watched", "returns", "moves", "targets")},
            **{name: _rows(getattr(found, name)) for name in ("feeds", "proportional")},
            held=tuple(found.held),
        )


def _watched(plain: Any) -> Watched:
    found = Watched(*plain)
    return found._replace(outcomes=tuple(found.outcomes))


def _rows(plain: Any) -> tuple[Any, ...]:
    return tuple(map(tuple, plain))
