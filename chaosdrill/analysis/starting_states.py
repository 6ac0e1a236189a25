"""Arguments that name states to begin from: initial values, seeds, boxes from which they are drawn."""

from collections.abc import Mapping
from typing import Any, ClassVar

from chaosdrill.analysis.arguments import LIMITS
from chaosdrill.names import key_text, remedy, shown
from chaosdrill.settings import Faults, Known, ListOf, Number, Text, Value, Whole, told, within

MOST_SEEDS = 10_000


class Start(Value):
    """Initial values of states, and ``mode``; what they do not name is the system's own."""

    type_name = "mapping"

    def plain(self, value: Any) -> Any:
        if not isinstance(value, Mapping):
            return value
        return {key_text(key): one if isinstance(one, str) else Number().plain(one) for key, one in value.items()}

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, Mapping):
            yield (), told("expected a table of initial values, as in {'x': 0.1}", value)
            return
        for name, one in value.items():
            if name == "mode" and not isinstance(one, str):
                yield (name,), f"expected the name of a mode, received {shown(one):.60}"
            elif name != "mode" and not isinstance(one, str):
                yield from within((name,), Number().faults(one))

    def misfits(self, value: Any, known: Known) -> Faults:
        if not isinstance(value, Mapping) or known.states is None:
            return
        for name, one in value.items():
            if name != "mode" and name not in known.states:
                yield (name,), f"unknown state; {remedy(name, ('mode', *known.states))}"
            elif name != "mode" and isinstance(one, str):
                yield (name,), f"expected a number, received {shown(one):.60}"

    def argument(self, value: Any) -> dict[str, Any]:
        return {name: one if isinstance(one, str) else float(one) for name, one in value.items()}


SEEDS = ListOf(Start(), hint=" of initial values, as in [{'x': 0.1}]")


class Region(Value):
    """A box of states: lower and upper ends of some of them, by name."""

    type_name = "mapping of state to (low, high)"
    _own: ClassVar[Mapping[str, Value]] = {}
    """What else the table holds, by name."""

    def plain(self, value: Any) -> Any:
        if not isinstance(value, Mapping):
            return value
        return {str(key): self._plain(str(key), one) for key, one in value.items()}

    def _plain(self, name: str, one: Any) -> Any:
        # a set has no order
        return self._own.get(name, LIMITS).plain(one) if name in self._own or hasattr(one, "__getitem__") else one

    def faults(self, value: Any) -> Faults:
        if not isinstance(value, Mapping):
            yield (), told("expected a table of ranges by name, as in x = [-1, 1]", value)
            return
        for name, one in value.items():
            found = list(within((name,), self._own.get(name, LIMITS).faults(one)))
            yield from found
            if not found and name not in self._own and not one[0] < one[1]:
                yield (name,), told("must increase: [low, high] with low < high", one)

    def misfits(self, value: Any, known: Known) -> Faults:
        if not isinstance(value, Mapping) or known.states is None:
            return
        for name in value:
            if name not in self._own and name not in known.states:
                yield (name,), f"unknown state; {remedy(name, known.states)}"

    def argument(self, value: Any) -> dict[str, Any]:
        return {name: one if name in self._own else [float(end) for end in one] for name, one in value.items()}


class Random(Region):
    """Random initial states: how many, the number of their generator, and the range of each state that is drawn."""

    type_name = "mapping"
    _own: ClassVar[Mapping[str, Value]] = {"count": Whole(1, MOST_SEEDS), "seed": Whole(0, 2**53), "mode": Text()}

    def faults(self, value: Any) -> Faults:
        yield from super().faults(value)
        if isinstance(value, Mapping):
            yield from (((key,), "missing; expected a whole number") for key in ("count", "seed") if key not in value)
            if not value.keys() - self._own.keys():
                yield (), "names no state; give the range of at least one, as in y = [-1, 1]"


RANDOM = Random()


FIXED_SEEDS = (
    "Initial values (and ``mode``) of each fixed seed; default: the system's own initial state, unless other seeds "
    "are requested."
)
RANDOM_SEEDS = (
    '``{"count": 4, "seed": 1, "y": (-1, 1)}``: ``count`` states drawn uniformly from the box, by a generator with '
    "this ``seed``; the same states at every point."
)
"""What the seeds of a sweep mean."""
