"""Two fields that meet at a surface: the sliding mode, its entries and its exits.

Where both fields point to the surface h = 0 the motion stays on it, along the convex combination of the fields that is
tangent to it (Filippov 1988, doi:10.1007/978-94-015-7793-9), or under the equivalent control, the value of an input
that keeps it there (Utkin 1977, doi:10.1109/TAC.1977.1101446). Both are the same where the input enters linearly.

The surface is a coordinate of the system: a state that the surface alone determines, or the distance h itself in the
place of a state. So the sliding mode pins it, and the tangents lose that direction wherever a record begins.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

import sympy

from chaosdrill.errors import ModelError
from chaosdrill.model.crossings import crossings, stripped
from chaosdrill.model.derive import differentiate
from chaosdrill.model.parts import read_expression, read_symbol, read_table
from chaosdrill.model.places import parameter
from chaosdrill.model.tables import UNNAMED
from chaosdrill.model.transition import Transition
from chaosdrill.model.tuning import TUNING
from chaosdrill.names import names_in
from chaosdrill.typed import expecting

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

ABOVE, BELOW, SLIDING = "above", "below", "sliding"

Field = dict[Any, Any]


class More(TypedDict, total=False):
    """Arguments passed on to `HybridSystem`."""

    period: Any
    quadratures: Mapping[str, Any] | None
    bounds: Mapping[Any, Any] | None
    description: str
    labels: Mapping[str, str] | None


@expecting(ModelError)
def filippov(
    *,
    name: str = UNNAMED,
    states: Iterable[Any],
    parameters: Mapping[str, float] | None = None,
    surface: Any,
    above: Mapping[Any, Any],
    below: Mapping[Any, Any],
    time: Any = None,
    initial: Mapping[Any, Any] | None = None,
    **more: Unpack[More],
) -> "HybridSystem":
    """A system of two fields on the two sides of a surface, with the sliding motion that Filippov gives it.

    Modes are ``above`` (h > 0), ``below`` (h < 0) and ``sliding`` (h = 0). With the rates of h along the fields, u
    above and d below:

    - A motion that reaches h = 0 slides if both fields point to the surface, u <= 0 <= d, and crosses otherwise.
    - It slides along (d F_above - u F_below) / (d - u). It leaves upward where u rises through zero, and downward
      where d falls through zero; where both happen at once, upward.
    - Where both fields point away, u > 0 > d, nothing slides: a motion that starts there leaves, upward unless
      ``initial`` names ``below`` as its mode.

    Events are of the kinds ``slide``, ``cross`` and ``leave``. A start that names no mode is in that of its state, at
    its parameters, in every analysis. If the fields have the same rate of h everywhere, all motions cross, and there is
    no sliding mode.

    Parameters
    ----------
    name : str
        Name of the system.
    states : sequence of sympy.Symbol or str
        The states, as for `HybridSystem`.
    parameters : mapping of str to float, optional
        Parameters and their values.
    surface : expression, or mapping of str to expression
        The expression h that is zero on the surface. It has to be linear in a state, with a coefficient of parameters
        alone, or to have the sign of such a one, which stands for it, as x for ``tanh(x)``. If it names other states
        too, it becomes a state, under the name given: with ``{"s": "x + tau*v"}`` or ``{"s": "(x + tau*v)**3"}`` the
        system has the state s = x + tau*v in the place of v, the last state in which it is linear. Its initial value
        follows from that of v at the parameters given here, and stays where these are changed.
    above, below : mapping of state to expression
        Time derivative of every state where h > 0, and where h < 0.
    time : sympy.Symbol or str, optional
        The symbol that stands for time; default: ``t``, unless a state or a parameter has this name.
    initial : mapping, optional
        ``"mode"`` and values of states, also of the one that the surface replaces.
    **more : optional
        ``period``, ``quadratures``, ``bounds``, ``description`` and ``labels``, as for `HybridSystem`.

    Returns
    -------
    HybridSystem
        With the states given, or with that of the surface among them.

    Raises
    ------
    ModelError
        If there are several surfaces, if the surface is linear in no state, or if the system cannot be compiled, with
        the reason.

    References
    ----------
    Filippov 1988, doi:10.1007/978-94-015-7793-9; di Bernardo et al. 2008, doi:10.1007/978-1-84628-708-4.
    """
    written = Written.read(name, states, time, parameters, more)
    given = TwoSided.beside(written, surface)
    upper, lower = (given.read_field(side, field) for side, field in ((ABOVE, above), (BELOW, below)))
    parts = given.combined(upper, lower)
    return given.system(parts.modes, parts.transitions, given.regions(parts)).with_initial(**given.start(initial))


@expecting(ModelError)
def equivalent_control(
    *,
    name: str = UNNAMED,
    states: Iterable[Any],
    parameters: Mapping[str, float] | None = None,
    surface: Any,
    field: Mapping[Any, Any],
    control: Mapping[Any, Sequence[Any]],
    time: Any = None,
    initial: Mapping[Any, Any] | None = None,
    **more: Unpack[More],
) -> "HybridSystem":
    """A system under a control that switches at a surface, with the sliding motion under Utkin's equivalent control.

    The sliding mode has the value of the control that keeps h at zero. The rate of h has to be linear in the control;
    the rates of the states need not be, and where they are not the sliding motion is not Filippov's. Entries, exits and
    all else are those of `filippov`.

    Parameters
    ----------
    name, states, parameters, surface : str, iterable, mapping, expression
        As for `filippov`.
    field : mapping of state to expression
        Time derivative of every state, in which the control is named.
    control : mapping of str to (expression, expression)
        The control, and its values above and below the surface: ``{"u": ("-U", "U")}``.
    time, initial : optional
        As for `filippov`.
    **more : optional
        As for `filippov`.

    Returns
    -------
    HybridSystem
        As that of `filippov`.

    Raises
    ------
    ModelError
        If the control does not act on the rate of h, or not linearly, and as for `filippov`.

    References
    ----------
    Utkin 1977, doi:10.1109/TAC.1977.1101446.
    """
    written = Written.read(name, states, time, parameters, more)
    given = TwoSided.beside(written, surface)
    u, values = _read_control(name, control, written.names)
    if u in (*given.states, given.time) or u.name in given.parameters:
        raise ModelError(f"{name}: the control is named {u}, which names something else; rename it")
    rates = given.read_field("field", field)
    upper, lower = ({state: rate.xreplace({u: value}) for state, rate in rates.items()} for value in values)
    speed = sympy.expand(given.on(given.speed(rates)))
    slope = differentiate(speed, u)
    if vanishes(slope):
        raise ModelError(
            f"{name}: the control {u} does not act on the rate of {given.surface}, so no value of it keeps the "
            "motion on the surface; choose a surface whose rate names it"
        )
    if u in slope.free_symbols:
        raise ModelError(
            f"{name}: the rate {speed} of {given.surface} is not linear in the control {u}, so that its equivalent "
            "value is not unique; write the two fields, and use filippov"
        )
    equivalent = given.reduced(-speed.xreplace({u: sympy.Integer(0)}) / slope)
    sliding = {state: given.on(rate).xreplace({u: equivalent}) for state, rate in rates.items()}
    parts = given.parts(upper, lower, sliding)
    return given.system(parts.modes, parts.transitions, given.regions(parts)).with_initial(**given.start(initial))


@dataclass(frozen=True)
class Combined:
    """Modes and transitions on the two sides of a surface and on it."""

    modes: dict[str, Field]
    transitions: "list[Transition]"
    up: Any  # rate of h on the surface, along the field above
    down: Any  # and along the field below
    slides: bool  # whether there is a sliding mode


@dataclass(frozen=True)
class Written:
    """A system without its modes and transitions, as read."""

    name: str
    states: tuple[Any, ...]  # as the fields name them
    time: Any
    parameters: Mapping[str, float]
    quadratures: dict[str, Any]  # by mode; the mode "" stands for all
    more: dict[str, Any]  # other arguments of the system

    @staticmethod
    def read(name: str, states: Any, time: Any, parameters: Any, more: More) -> "Written":
        listed = names_in(states)
        if not isinstance(listed, Iterable):
            raise ModelError(f"{name}: states is {states!r}; expected names in order, as in 'x v' or ['x', 'v']")
        symbols = tuple(read_symbol(f"{name}: state {place}", s) for place, s in enumerate(listed))
        clock = None if time is None else read_symbol(f"{name}: time", time)
        known = read_table(f"{name}: parameters", {} if parameters is None else parameters)
        if clock is None and "t" not in {*(symbol.name for symbol in symbols), *known}:
            clock = read_symbol(f"{name}: time", "t")  # as in `HybridSystem`
        others = {key: value for key, value in more.items() if key != "quadratures"}
        written = Written(name, symbols, clock, known, {}, others)
        table = read_table(f"{name}: quadratures", more.get("quadratures") or {})
        integrals = {
            key: _integrands(f"{name}: quadrature {key}", given, written.names) for key, given in table.items()
        }
        return replace(written, quadratures=integrals)

    @property
    def names(self) -> set[str]:
        """What states, time and parameters are called."""
        return {*(symbol.name for symbol in (*self.states, self.time) if symbol is not None), *self.parameters}

    @property
    def places(self) -> dict[Any, Any]:
        """Symbols by which forms and orders do not depend on names."""
        names = [*self.states, self.time, *map(parameter, self.parameters)]
        return {symbol: sympy.Symbol(f"x_{i}", real=True) for i, symbol in enumerate(names) if symbol is not None}

    def read_field(self, where: str, field: Any) -> Field:
        table = read_table(f"{self.name}: {where}", field)
        read = {
            read_symbol(f"{self.name}: {where}: a state", state): read_expression(
                f"{self.name}: {where}, d{state}/dt", rate, self.names
            )
            for state, rate in table.items()
        }
        for state in self.states:
            if state not in read:
                raise ModelError(f"{self.name}: {where} gives no derivative for state {state.name!r}")
        for state in read:
            if state not in self.states:
                raise ModelError(f"{self.name}: {where} gives a derivative for {state}, which is not a state")
        return {state: read[state] for state in self.states}

    def off(self, expression: Any) -> Any:
        """An expression in the states that the system has."""
        return expression

    def at_first(self, expression: Any) -> Any:
        """An expression at time 0."""
        return expression if self.time is None else expression.xreplace({self.time: sympy.Integer(0)})

    def value(self, expression: Any, start: Mapping[str, Any]) -> float:
        """The value of an expression of the states as the fields name them, at the start."""
        numbers = {parameter(key): value for key, value in self.parameters.items()}
        numbers |= dict.fromkeys(self.states, 0.0)
        numbers |= {parameter(key): value for key, value in start.items() if key != "mode"}
        if self.time is not None:
            numbers[self.time] = 0.0
        try:
            return float(expression.subs(numbers))
        except (TypeError, ValueError, OverflowError):
            raise ModelError(f"{self.name}: {expression} has no value at the initial state") from None

    def system(
        self, modes: Mapping[str, Field], transitions: "Iterable[Transition]", regions: Mapping[str, Any]
    ) -> "HybridSystem":
        """The system of these modes and transitions, and of the regions in which its modes begin."""
        from chaosdrill.model.system import HybridSystem

        return HybridSystem(
            name=self.name,
            states=tuple(next(iter(modes.values()))),
            time=self.time,
            parameters=self.parameters,
            modes=modes,
            transitions=transitions,
            regions={mode: region for mode, region in regions.items() if region != sympy.false},
            quadratures={
                name: {mode: self.off(given.get(mode, given.get(""))) for mode in modes}
                for name, given in self.quadratures.items()
            },
            **self.more,
        )


@dataclass(frozen=True)
class TwoSided(Written):
    """The same with a surface."""

    surface: Any
    solved: Any  # the state that the surface determines
    own: Any  # the state that is the surface, in the place of the one it determines; or None

    @staticmethod
    def beside(written: Written, surface: Any) -> "TwoSided":
        name, states, time, parameters = written.name, written.states, written.time, written.parameters
        own, h = _read_surface(name, surface, written.names)
        if own is not None and (own in (*states, time) or own.name in parameters):
            raise ModelError(f"{name}: the surface is named {own}, which names something else; rename it")
        if own is None or not _linear(written, h):
            h = sympy.Mul(*stripped(h))
        given = {field.name: getattr(written, field.name) for field in fields(Written)}
        return TwoSided(**given, surface=h, solved=_solved(written, h, own), own=own)

    @property
    def coordinate(self) -> Any:
        """The state that the sliding mode holds."""
        return self.solved if self.own is None else self.own

    @property
    def held(self) -> Any:
        """Where the sliding mode holds it."""
        return sympy.Integer(0) if self.own is not None else self._value_at(sympy.Integer(0))

    def _value_at(self, h: Any) -> Any:
        """The state that the surface determines, at a distance from it."""
        slope = differentiate(self.surface, self.solved)
        return sympy.expand((h - sympy.expand(self.surface - slope * self.solved)) / slope)

    def on(self, expression: Any) -> Any:
        """An expression on the surface, without the state that the surface determines."""
        return expression.xreplace({self.solved: self._value_at(sympy.Integer(0))})

    def off(self, expression: Any) -> Any:
        """An expression in the states that the system has."""
        return expression if self.own is None else expression.xreplace({self.solved: self._value_at(self.own)})

    def reduced(self, fraction: Any) -> Any:
        """A fraction without common factors."""
        back = {place: symbol for symbol, place in self.places.items()}
        return sympy.cancel(fraction.xreplace(self.places)).xreplace(back)

    def value(self, expression: Any, start: Mapping[str, Any]) -> float:
        """The value of an expression at the start, where the state that the surface determines may be left out."""
        if self.own is not None and self.own.name in start:
            expression = self.off(expression)
        elif start.get("mode") == SLIDING and self.solved.name not in start:
            expression = self.on(expression)
        return super().value(expression, start)

    def speed(self, field: Field) -> Any:
        """Rate of h along a field."""
        along = sum((differentiate(self.surface, x) * rate for x, rate in field.items()), sympy.Integer(0))
        return along if self.time is None else along + differentiate(self.surface, self.time)

    def in_states(self, field: Field, speed: Any) -> Field:
        """Rates of the states that the system has; ``speed`` is that of the coordinate that stands for the surface."""
        rates = field if self.own is None else {**field, self.solved: speed}
        return {self.coordinate if x == self.solved else x: rate for x, rate in rates.items()}

    def combined(self, upper: Field, lower: Field) -> Combined:
        """The parts of two fields, sliding along the convex combination of them that is tangent to the surface."""
        up, down = (sympy.expand(self.on(self.speed(field))) for field in (upper, lower))
        gap = sympy.expand(down - up)

        def rate(state: Any) -> Any:
            one, other = self.on(upper[state]), self.on(lower[state])
            apart = sympy.expand(one - other)
            return one if vanishes(apart) else other + self.reduced(apart / gap) * down

        return self.parts(upper, lower, {state: rate(state) for state in self.states} if not vanishes(gap) else None)

    def parts(self, upper: Field, lower: Field, sliding: Field | None) -> Combined:
        """The parts of two fields and of the rates in sliding; None: all motions cross."""
        up, down = (sympy.expand(self.on(self.speed(field))) for field in (upper, lower))
        modes = {
            side: {x: self.off(rate) for x, rate in self.in_states(field, self.speed(field)).items()}
            for side, field in ((ABOVE, upper), (BELOW, lower))
        }
        if sliding is not None:
            rate = sympy.Integer(0) if self.time is None else differentiate(self.held, self.time)
            modes[SLIDING] = self.in_states({**sliding, self.solved: rate}, rate)
        slides = sliding is not None
        return Combined(modes, self._transitions(up, down, slides=slides), up, down, slides)

    def _transitions(self, up: Any, down: Any, *, slides: bool) -> "list[Transition]":
        guard = self.surface if self.own is None else self.own
        reset = {self.coordinate: self.held}
        moving = {*self.states, self.coordinate, self.time}
        found = []
        for way, source, target, direction, attracts in (
            ("down", ABOVE, BELOW, -1, down >= 0),
            ("up", BELOW, ABOVE, +1, up <= 0),
        ):
            if slides and attracts != sympy.false:
                condition = None if attracts == sympy.true else attracts
                found.append(
                    Transition(f"slide-{way}", source, SLIDING, guard, direction, reset, condition, kind="slide")
                )
            if not slides or attracts != sympy.true:
                found.append(Transition(f"cross-{way}", source, target, guard, direction, kind="cross"))
        exits = [
            Transition(f"leave-{way}", SLIDING, target, speed, direction, reset, kind="leave")
            for way, target, speed, direction in (("up", ABOVE, up, +1), ("down", BELOW, down, -1))
            if slides and speed.free_symbols & moving
        ]
        # where both fields turn away at once, the motion leaves upward
        found += exits[: len(set(crossings(exits)))]
        return found

    def regions(self, parts: Combined) -> dict[str, Any]:
        """Where a start is in each mode."""
        height = sympy.expand(self.surface) if self.own is None else self.own
        h, up, down = map(self.at_first, (height, parts.up, parts.down))
        found = {SLIDING: sympy.And(sympy.Eq(h, 0), up <= 0, down >= 0)} if parts.slides else {}
        return {**found, ABOVE: sympy.Or(h > 0, sympy.And(sympy.Eq(h, 0), up >= 0)), BELOW: h <= 0}

    def start(self, initial: Any) -> dict[str, Any]:
        """The initial state, and the mode if it is named: where the surface says nothing else, those given."""
        start = read_table(f"{self.name}: initial", initial or {})
        where = self.coordinate.name
        mode = start.get("mode")
        slope = sympy.expand(differentiate(self.surface, self.solved))
        if self.value(slope, {}) == 0:
            raise ModelError(
                f"{self.name}: the surface {self.surface} does not depend on {self.solved.name!r}, since {slope} is "
                "zero"
            )
        if self.own is not None and where in start and self.solved.name in start:
            raise ModelError(f"{self.name}: initial names {where!r} and {self.solved.name!r}; leave one out")
        distance = self.value(self.surface, start)
        size = sum(abs(self.value(term, start)) for term in sympy.Add.make_args(sympy.expand(self.surface)))
        if abs(distance) <= TUNING.equal_sides * size:
            distance = 0.0
        if self.own is not None:
            start.pop(self.solved.name, None)
            start[where] = distance
        elif distance == 0.0:
            start.setdefault(where, self.value(self.held, start))
        if mode == SLIDING and distance != 0.0:
            raise ModelError(
                f"{self.name}: the initial mode is {SLIDING!r}, but the initial state is {distance:.6g} away from the "
                f"surface; leave {self.solved.name!r} out of it, or name another mode"
            )
        return start


def vanishes(expression: Any) -> bool:
    """Whether an expression is zero, whole or a double."""
    return sympy.expand(expression).is_zero is True


def several(name: str, what: str) -> ModelError:
    """The message that refuses more than one surface."""
    return ModelError(
        f"{name}: {what}; one surface is possible. Where two meet, four fields join, and the convex combinations of "
        "them that stay on both are not unique: which one is meant is part of the model. Write its modes and "
        "transitions yourself"
    )


def _integrands(where: str, given: Any, names: set[str]) -> dict[str, Any]:
    by_mode = given if isinstance(given, Mapping) else {"": given}
    return {str(mode): read_expression(where, one, names) for mode, one in by_mode.items()}


def _read_surface(name: str, surface: Any, names: set[str]) -> tuple[Any, Any]:
    """The name of a surface, if it has one, and its expression."""
    if isinstance(surface, list | tuple | set | frozenset) or (isinstance(surface, Mapping) and len(surface) != 1):
        raise several(name, f"surface is {surface!r}")
    if not isinstance(surface, Mapping):
        return None, read_expression(f"{name}: surface", surface, names)
    ((key, h),) = surface.items()
    return read_symbol(f"{name}: name of the surface", key), read_expression(f"{name}: surface", h, names)


def _read_control(name: str, control: Any, names: set[str]) -> tuple[Any, list[Any]]:
    table = read_table(f"{name}: control", control)
    values = next(iter(table.values()), None)
    if len(table) != 1 or isinstance(values, str) or not isinstance(values, Sequence) or len(values) != 2:
        raise ModelError(
            f"{name}: control is {control!r}; it must be one control with its values above and below the surface, as "
            "in {'u': ('-U', 'U')}"
        )
    ((u, _),) = table.items()
    found = [read_expression(f"{name}: control {u}", value, names) for value in values]
    return read_symbol(f"{name}: control", u), found


def _linear(written: Written, h: Any) -> list[Any]:
    """States in which an expression is linear, with a coefficient of parameters alone."""
    slopes = {x: sympy.expand(differentiate(h, x)) for x in written.states if x in h.free_symbols}
    return [x for x, slope in slopes.items() if not slope.free_symbols & {*written.states, written.time}]


def _solved(written: Written, h: Any, own: Any) -> Any:
    """The state that a surface determines."""
    name, states = written.name, written.states
    named = [x for x in states if x in h.free_symbols]
    if not named:
        raise ModelError(f"{name}: the surface {h} depends on no state")
    linear = _linear(written, h)
    if not linear:
        raise ModelError(
            f"{name}: the surface {h} is linear in no state with a coefficient of parameters alone; write the system "
            "in states of which the surface is one"
        )
    if len(named) > 1 and own is None:
        raise ModelError(
            f"{name}: the surface {h} names the states {[x.name for x in named]}; name it, as in "
            f"surface={{'s': '{h}'}}, and it takes the place of {linear[-1].name!r} among the states"
        )
    return linear[-1]
