"""Discrete maps: the next state in terms of the present one, a hybrid system that stands still between its iterates.

A map is a hybrid system with period 1, whose only event comes once a period and puts the image in the place of the
state. A strobe lies between any two of its events, so that the points of the section are the iterates.
"""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Unpack

from chaosdrill.model.system import HybridSystem, Words, arguments_of
from chaosdrill.model.tables import UNNAMED_MAP
from chaosdrill.model.values import LATE
from chaosdrill.typed import constructor

if TYPE_CHECKING:
    from chaosdrill.model.images import MapReader

PHASE = 0.25
"""Where in the period a map takes its iterate: where the guard of its reader, the cosine of a turn a period, falls
through zero."""


@constructor
class Map(HybridSystem):
    """A discrete map: states that are replaced by their images.

    It is a system like any other, with one difference: lengths (``periods``, ``transient``, ``period``) count iterates,
    and exponents are per iterate. Analyses that have no meaning for a map refuse it with the reason. Its Jacobian is
    derived from the images.

    Expressions are text, numbers or sympy, as for `HybridSystem`. Images may hold ``Piecewise``, ``Max``, ``Min``,
    ``Abs`` and ``sign``, beside all that resets may hold: each of their branches becomes an outcome of its own, with
    its own derivative.

    Parameters
    ----------
    states : str or sequence of str or sympy.Symbol
        The n states in order, as in ``"x y"``.
    parameters : mapping of str to float, optional
        Parameters and their values.
    images : mapping of state to expression, or sequence of n expressions, or a function
        The next value of every state, by name or symbol, or in the order of the states; a function ``f(t, x, p)`` as in
        `HybridSystem` returns a tuple of them; its argument ``t`` has no meaning.
    name : str, default "own-map"
        Name of the map.
    initial : mapping of state to float, optional
        Values of states at first; default 0.
    bounds : mapping of state to (low, high) or None, optional
        As in `HybridSystem`.
    **words : optional
        ``description``: one line. ``labels``: long names of states and parameters, by name.

    Raises
    ------
    ModelError
        With everything that is wrong, one fault a line, each with its place and the remedy.
    SettingsError
        If a parameter or an initial value is no finite number; if the map is changed after it was made.

    Examples
    --------
    >>> henon = Map("x y", {"a": 1.4, "b": 0.3}, {"x": "1 - a*x**2 + y", "y": "b*x"})
    >>> henon.images[henon.states[1]]
    b*x
    """

    images: Mapping[Any, Any]
    discrete = True
    phase = PHASE
    late = (*LATE, "images")

    def __init__(
        self,
        states: str | Iterable[Any],
        parameters: Mapping[str, float] | None = None,
        images: Any = None,
        *,
        name: str = UNNAMED_MAP,
        initial: Mapping[Any, Any] | None = None,
        bounds: Mapping[Any, Any] | None = None,
        **words: Unpack[Words],
    ) -> None:
        given = {"name": name, "states": states, "images": images, "bounds": bounds}
        self._read(given, words, parameters, initial)

    @staticmethod
    def reader(parameters: Any) -> "MapReader":
        """The reader of definitions of maps, with these parameters."""
        from chaosdrill.model.images import MapReader

        return MapReader(parameters)

    def remade(self, **other: Any) -> HybridSystem:
        """A map made of other arguments, or the flow between its iterates if they are those of a flow."""
        return self._remade(Map if other.keys() <= set(arguments_of(Map)) else HybridSystem, other)

    def _moved_with(self, rates: Mapping[Any, Any], fixed: Mapping[Any, float]) -> dict[str, Any]:
        if self.time in rates:
            return super()._moved_with(rates, fixed)
        return {"images": {**self.images, **{x: x for x in rates}}}

    def _content(self) -> tuple[Any, ...]:
        # the branches of different images may be the same
        return (*super()._content(), tuple(self.images.items()))

    def __repr__(self) -> str:
        return f"Map({self.name!r}, states={self.state_names}, parameters={tuple(self.parameters)})"
