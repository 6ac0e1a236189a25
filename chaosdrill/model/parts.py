"""Parts of a definition as they were given are read: names, tables, expressions, transitions; faults with their places.

They come from Python, from the table of a scene, or from an archive: expressions as text, numbers or sympy.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from numbers import Integral
from typing import Any, cast

import sympy
from sympy.concrete.expr_with_limits import ExprWithLimits
from sympy.core.relational import Relational
from sympy.logic.boolalg import Boolean, BooleanAtom, BooleanFunction

from chaosdrill.errors import ModelError
from chaosdrill.model.bounds import decided
from chaosdrill.model.gates import without_overflow
from chaosdrill.model.grammar import ExpressionError, parse
from chaosdrill.model.python import Called, Source, called, fault_of, is_python, reads_time
from chaosdrill.model.removable import with_factor
from chaosdrill.model.rules import folded, refused
from chaosdrill.model.special import CONDITION, FLOW, RESET
from chaosdrill.model.tables import MOST, finite
from chaosdrill.model.text import has_doubles, read_open_text, read_text, rejoined, unknown_name
from chaosdrill.model.touching import without_smooth_zeros
from chaosdrill.model.tuning import TUNING
from chaosdrill.names import remedy, shortened, shown
from chaosdrill.settings import KeyPath, is_masked

TIME = "t"
"""Default name of time, unless a state or parameter has it."""

PI = sympy.Symbol("pi", real=True)
"""What stands for the number, unless something is called so."""

NAMES = (
    "a name must not be empty, begin or end with a blank, or hold a slash, a line break or another sign that cannot be "
    "seen"
)

_UNDONE = (ExprWithLimits, sympy.Derivative, sympy.Subs, sympy.Limit, sympy.Order)

_NEEDED = ("name", "source", "target", "guard", "direction")
OF_TRANSITION = (*_NEEDED, "reset", "condition", "priority", "completes", "kind")


class TooManyFaults(Exception):
    """Nobody would read more of them."""


class PartReader:
    """Reads parts of a definition; without parameters those of one that is not known yet, and may name anything.

    ``parameters``: the names that expressions may hold besides states and time, and their values. ``faults``: all that
    is wrong: the keys that lead there, where a transition is its number, and what it is. ``states``: their names, if
    they can be told. ``used``: names of states, parameters and time that expressions hold.
    """

    def __init__(self, parameters: Any = None) -> None:
        self.faults: list[tuple[KeyPath, str]] = []
        self.states: tuple[str, ...] | None = None
        self.used: set[str] = set()
        self.open = parameters is None
        self.parameters = {} if self.open else self._table(("parameters",), parameters)
        self._letters = 0
        self._modes: tuple[str, ...] = ()
        self._transitions: list[str | None] = []
        # a guard of the drive alone may be a number in one of its pieces
        self._driven = False
        self._names: dict[str, Any] = {}
        # names with a rate that are no states, and whether that has been said: what else holds them is no other fault
        self._lacking: dict[str, bool | None] = {}
        self._moving: set[Any] = set()
        self._clock: Any = None
        self._hints: dict[str, str] = {}

    def told(self, of: str) -> str:
        """All faults, a line each; transitions go by their names."""

        def place(path: KeyPath) -> str:
            of_one = path[:1] == ("transitions",) and len(path) > 1
            name = self._transitions[int(path[1])] if of_one else None
            return ".".join(shortened(str(part)) for part in ((path[0], name, *path[2:]) if name else path))

        return "\n".join(": ".join(filter(None, (of, place(path), message))) for path, message in self.faults)

    def _fault(self, path: KeyPath, message: str) -> None:
        self.faults.append((path, message))
        if len(self.faults) >= TUNING.faults:
            raise TooManyFaults

    def _known(self, path: KeyPath, given: Mapping[str, Any], keys: tuple[str, ...]) -> None:
        for key in given:
            if key not in keys:
                self._fault((*path, key), f"unknown key; {remedy(key, keys)}")

    def _table(self, path: KeyPath, value: Any) -> dict[str, Any]:
        """A mapping of names, or of symbols, to anything."""
        if isinstance(value, Mapping) and all(isinstance(key, str | sympy.Symbol) for key in value):
            read = {str(getattr(key, "name", key)): entry for key, entry in value.items()}
            if len(read) == len(value):
                return read
        self._fault(path, f"expected a table of names (a dict in Python), received {shown(value):.60}")
        return {}

    def _text(self, path: KeyPath, value: Any, *, empty: bool = False) -> str | None:
        if isinstance(value, str) and (empty or value.strip()):
            return value
        self._fault(path, f"expected text in quotes, received {shown(value):.60}")
        return None

    def _whole(self, path: KeyPath, value: Any) -> int:
        if isinstance(value, Integral) and not isinstance(value, bool) and abs(int(value)) < 2**63:
            return int(value)
        self._fault(path, f"expected a whole number, received {shown(value):.60}")
        return 0

    def _name(self, path: KeyPath, value: Any) -> str | None:
        """The name of a state or of the time, given as text or as a symbol."""
        given = value.name if isinstance(value, sympy.Symbol) else value
        if isinstance(given, str) and is_name(given):
            return given
        what = NAMES if isinstance(given, str) else "expected a name, or a symbol of sympy"
        self._fault(path, f"received {shown(value):.60}; {what}")
        return None

    def _all_states(self, path: KeyPath, function: Any) -> dict[Any, Any]:
        """Values of a Python function by state."""
        # a transition whose system is not known yet has its function stand for one state
        states = self._moved_states() or (sympy.Symbol("x", real=True),)
        try:
            return dict(zip(states, self._from_python(function, len(states)), strict=True))
        except ExpressionError as fault:
            self._fault(path, str(fault))
            return {}

    def _moved_states(self) -> tuple[Any, ...]:
        return tuple(sympy.Symbol(one, real=True) for one in self.states or ())

    def _from_python(self, function: Any, count: int = 0) -> list[Any]:
        """Values of a Python function: one, or a tuple of ``count``."""
        if told := fault_of(function):
            raise ExpressionError(told)
        if self.open:
            return called(Source(function, (), (), count), [])
        reads = reads_time(function)
        if reads and self._clock is None:
            raise ExpressionError(f"reads the time, while {TIME!r} is a state or a parameter; name the time, as in "
                                  "time = 'tau'")  # fmt: skip
        names = [*(s.name for s in self._moved_states()), *self.parameters]
        found = called(
            Source(function, self.states or (), tuple(self.parameters), count),
            [self._clock if reads else sympy.Integer(0), *(self._names[one] for one in names)],
        )
        self.used |= {s.name for s in found[0].free_symbols}
        return found

    def _assignments(self, path: KeyPath, table: Mapping[str, Any], level: int) -> dict[Any, Any]:
        """Expressions by the state that each belongs to."""
        read = {}
        for state, value in table.items():
            if self.open or state in (self.states or ()):
                read[sympy.Symbol(state, real=True)] = self._expression((*path, state), value, level)
            else:
                self._stranger((*path, state), state)
        return read

    def _left_out(self, table: Mapping[str, Any]) -> list[str]:
        """The states that a table lacks; none if it has as many other names, since they are misspelt then."""
        missing = [state for state in self.states or () if state not in table]
        return missing if len(missing) != sum(name not in (self.states or ()) for name in table) else []

    def _stranger(self, path: KeyPath, state: str) -> None:
        """Record that a name is not a state."""
        if not self._lacking.get(state):
            self._fault(path, f"unknown state; {remedy(state, self.states or ())}")
        if state in self._lacking:
            self._lacking[state] = True

    def _by_mode(
        self,
        path: KeyPath,
        value: Mapping[Any, Any],
        modes: Iterable[str],
        lacks: str,
        read: Callable[[KeyPath, Any], Any],
    ) -> dict[str, Any]:
        """An entry for every one of some modes."""
        given = self._table(path, value)
        for mode in given:
            if mode not in modes:
                self._fault((*path, mode), f"unknown mode; {remedy(mode, modes)}")
        for mode in modes:
            if mode not in given:
                self._fault(path, f"gives nothing for mode {mode!r:.60}; {lacks}")
        return {mode: read((*path, mode), given[mode]) for mode in modes if mode in given}

    def transition(self, path: KeyPath, value: Any) -> dict[str, Any]:
        """The fields of a transition; what is missing among them is a fault."""
        if not isinstance(value, Mapping):
            self._fault(path, f"expected a Transition, or a table, received {shown(value):.60}")
            return {}
        before = len(self.faults)
        given = self._table(path, value)
        self._known(path, given, OF_TRANSITION)
        for key in _NEEDED if len(self.faults) == before or given else ():
            if key not in given:
                self._fault((*path, key), f"missing; each transition has {', '.join(_NEEDED)}")
        names = self._transitions
        read: dict[str, Any] = {
            key: self._text((*path, key), given[key]) for key in ("name", "target", "completes", "kind") if key in given
        }
        name, completes = read.get("name"), read.get("completes")
        if name and names[: int(path[-1]) if path else 0].count(name) == 1:
            self._fault((*path, "name"), f"two transitions are named {name!r:.60}")
        if completes and completes not in names and not self.open:
            self._fault((*path, "completes"), f"unknown transition; {remedy(completes, filter(None, names))}")
        read["kind"] = read.get("kind") or name
        read["source"] = self._source((*path, "source"), given["source"]) if "source" in given else ()
        if read.get("target") is not None:
            self._mode((*path, "target"), read["target"])
        if "direction" in given:
            read["direction"] = direction = given["direction"]
            if not isinstance(direction, Integral) or isinstance(direction, bool) or direction not in (-1, 0, 1):
                told = f"must be 1 (rises), -1 (falls) or 0 (either), received {shown(direction):.60}"
                self._fault((*path, "direction"), told)
            else:
                read["direction"] = int(direction)
        if "guard" in given:
            read["guard"] = guard = self._guard((*path, "guard"), given["guard"])
            if guard is not None and not (guard.free_symbols or self._driven or self.open):
                self._fault((*path, "guard"), "depends on no state and not on time")
        resets = given.get("reset", {})
        if is_python(resets):
            read["reset"] = self._all_states((*path, "reset"), resets)
        else:
            read["reset"] = self._assignments((*path, "reset"), self._table((*path, "reset"), resets), RESET)
        read["condition"] = self._condition((*path, "condition"), given.get("condition"), read["source"])
        read["priority"] = self._whole((*path, "priority"), given.get("priority", 0))
        return read

    def _guard(self, path: KeyPath, value: Any) -> Any:
        is_condition = isinstance(value, Relational)
        if isinstance(value, str):
            with suppress(ExpressionError):
                is_condition = parse(value).is_condition
        if is_condition:
            way = "a guard is a number that crosses zero: write the difference of the two sides, as in 'x - 0.3'"
            self._fault(path, f"{value!s:.60} is a comparison; {way}, and a direction")
            return None
        found = self._expression(path, value, FLOW)
        return found if found is None else with_factor(found, self._moving)

    def _source(self, path: KeyPath, value: Any) -> tuple[str, ...]:
        sources = [value] if isinstance(value, str) or not isinstance(value, list | tuple) else value
        if not sources:
            self._fault(path, "is empty; name the mode, or modes, in which the guard is watched")
        read = tuple(mode for mode in sources if self._text(path, mode) is not None)
        for mode in read:
            self._mode(path, mode)
        return read

    def _mode(self, path: KeyPath, mode: str) -> None:
        if self._modes and mode not in self._modes:
            self._fault(path, f"unknown mode {mode!r:.60}; {remedy(mode, self._modes)}")

    def _condition(self, path: KeyPath, value: Any, sources: tuple[str, ...]) -> Any:
        if value is None:
            return None
        if isinstance(value, Mapping):
            lacks = "every source needs its own, 'True' where the transition is always taken"
            read = self._by_mode(path, value, sources, lacks, self._relation)
            same = len(set(read.values())) == 1
            return next(iter(read.values())) if same else read
        return self._relation(path, value)

    def _relation(self, path: KeyPath, value: Any) -> Any:
        return self._expression(path, value, CONDITION, condition=True)

    def _expression(self, path: KeyPath, value: Any, level: int = CONDITION, *, condition: bool = False) -> Any:
        """The value as an expression of real symbols; None with a fault.

        ``level`` says what it is for, and so which functions of states and time it may hold.
        """
        try:
            if isinstance(value, str):
                found = self._from_text(path, value, condition)
            elif isinstance(value, int | float) and not isinstance(value, bool) and not condition:
                if not abs(value) <= MOST:
                    raise ExpressionError(f"must be a finite double, received {shown(value):.60}")
                found = self._from_text(path, repr(float(value) if isinstance(value, float) else int(value)), condition)
            elif is_python(value) and path:
                (found,) = self._from_python(value)
                # True and False are 1 and 0 as numbers
                found = sympy.Gt(found, 0) if condition else found
            else:
                found = self._from_sympy(value, condition)
            # what is made of an open expression is read again
            if not self.open:
                found = without_overflow(decided(found.replace(lambda e: isinstance(e, sympy.Heaviside), self._step)))
            if not self.open and level == FLOW:
                found = without_smooth_zeros(found, self._moving, self._values())
            if not self.open and (told := refused(found, self._moving, level)):
                raise ExpressionError(told)
            if not self.open and level == FLOW and (told := folded(found, self._moving, self._values())):
                raise ExpressionError(told)
        except ExpressionError as fault:
            if not str(fault).startswith(tuple(f"unknown name {one!r};" for one in self._lacking)):
                self._fault(path, str(fault))
            return None
        self.used |= {s.name for s in found.free_symbols}
        return found

    def _step(self, step: Any) -> Any:
        """A step of parameters alone, which does not move, by its branches; any other as it is."""
        g, middle = step.args
        return step if g.free_symbols & self._moving else sympy.Piecewise((1, g > 0), (0, g < 0), (middle, True))

    def _values(self) -> dict[str, float]:
        """Values of the parameters, those that are numbers."""
        values = ((name, finite(value)) for name, value in self.parameters.items())
        return {name: value for name, value in values if value is not None}

    def _from_text(self, path: KeyPath, text: str, condition: bool) -> Any:
        self._letters += len(text)
        if self._letters > TUNING.letters_together:
            self._fault(path, f"the definition has more than {TUNING.letters_together} letters of expressions")
            raise TooManyFaults
        if self.open:
            return read_open_text(text, condition=condition)
        clock = None if self._clock is None else self._clock.name
        return read_text(text, self._names, condition=condition, hints=self._hints, clock=clock)

    def _from_sympy(self, value: Any, condition: bool) -> Any:
        if getattr(value, "ndim", 0) or is_masked(value):
            raise ExpressionError(f"expected one number or expression, received {shown(value):.60}")
        try:
            found = sympy.sympify(value, strict=True)
        except (sympy.SympifyError, TypeError, ValueError, AttributeError):
            if callable(value) and not is_python(value):
                raise ExpressionError(
                    f"{shown(value):.60} can be called, but numba cannot read its code, of which derivatives are made; "
                    "pass a Python function, or what numba.njit or numba.cfunc has made of one"
                ) from None
            raise ExpressionError(
                f"expected an expression, as text in quotes or of sympy, received {shown(value):.60}"
            ) from None
        if getattr(found, "is_Matrix", False) or not isinstance(found, sympy.Expr | Boolean):
            raise ExpressionError(f"expected one number or expression, received {shown(value):.60}")
        is_relation = isinstance(found, BooleanFunction | BooleanAtom | Relational)
        if is_relation != condition:
            wanted = "a comparison, such as x > 0" if condition else "a number, not a comparison"
            raise ExpressionError(f"{shown(found):.60} must be {wanted}")
        if found.has(sympy.I):
            raise ExpressionError(f"{shown(found):.60} is complex; only real expressions can be simulated")
        if found.has(*_UNDONE):
            raise ExpressionError(
                f"{shown(found):.60} holds an integral, a derivative or a sum that is not carried out; write its value "
                "(doit()), or make it a state or a quadrature"
            )
        if found.has(sympy.zoo, sympy.nan, sympy.oo, -sympy.oo):
            raise ExpressionError(f"{shown(found):.60} divides by zero, or is not finite")
        found = rejoined(found)
        if not has_doubles(found):
            raise ExpressionError(f"{shown(found):.60} holds a number that is larger than any double, or nearer to 0")
        found = found.xreplace({s: sympy.Symbol(s.name, real=True) for s in found.free_symbols})
        if not self.open and PI.name not in self._names:
            found = found.xreplace({PI: sympy.pi})
        if not self.open and any(not one.numbers for one in found.atoms(Called)):
            raise ExpressionError("is the Python function of a transition alone; pass the function itself")
        unknown = [] if self.open else sorted(s.name for s in found.free_symbols if s.name not in self._names)
        if unknown:
            raise ExpressionError("; ".join(unknown_name(name, self._names, self._hints) for name in unknown[:10]))
        return found


def read_expression(where: str, value: Any, names: Collection[str] = ()) -> Any:
    """An expression that is given outside of a definition, and may name anything; errors begin with ``where``.

    ``pi`` is the number, unless it is one of the ``names``. Raises `ModelError` if the value is no expression.
    """
    found = _alone(where, lambda reader: reader._expression((), value))
    return found if PI.name in names else found.xreplace({PI: sympy.pi})


def read_of_states(where: str, value: Any, system: Any) -> Any:
    """An expression of the states and parameters of a system alone; errors as for `read_expression`."""
    known = {*system.states, *(sympy.Symbol(name, real=True) for name in system.parameters)}
    found = sympy.sympify(read_expression(where, value, {symbol.name for symbol in known}))
    if strange := sorted(symbol.name for symbol in found.free_symbols - known):
        raise ModelError(f"{where} = {found!s:.60} holds {strange[0]!r:.60}; give states and parameters")
    return found


def read_symbol(where: str, value: Any) -> Any:
    """The real symbol of a name or of a symbol; errors as for `read_expression`."""
    return sympy.Symbol(_alone(where, lambda reader: reader._name((), value)), real=True)


def read_table(where: str, value: Any) -> dict[str, Any]:
    """A mapping of names, or of symbols, to anything; errors as for `read_expression`."""
    return cast(dict[str, Any], _alone(where, lambda reader: reader._table((), value)))


def _alone(where: str, read: Callable[[PartReader], Any]) -> Any:
    reader = PartReader()
    found = read(reader)
    if reader.faults:
        raise ModelError(reader.told(where))
    return found


def is_name(name: str) -> bool:
    """Whether a state, a parameter or a quadrature may be called so."""
    return bool(name) and name == name.strip() and "/" not in name and name.isprintable()
