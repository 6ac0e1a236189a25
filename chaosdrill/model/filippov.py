"""Two fields that meet at a surface: the sliding mode, its entries and its exits.

Where both fields point to the surface h = 0 the motion stays on it, along the convex combination of the fields that is
tangent to it (Filippov 1988, doi:10.1007/978-94-015-7793-9), or under the equivalent control, the value of an input
that keeps it there (Utkin 1977, doi:10.1109/TAC.1977.1101446). Both are the same where the input enters linearly.

The surface is a coordinate of the system: a state that the surface alone determines, or the distance h itself in the
place of a state. So the sliding mode pins it, and the tangents lose that direction wherever a record begins.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.errors import ModelError
from chaosdrill.model.derive import differentiate
from chaosdrill.model.places import parameter
from chaosdrill.model.reading import Transition, read_expression, read_symbol, read_table

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem

ABOVE, BELOW, SLIDING = "above", "below", "sliding"

Field = dict[Any, Any]


def filippov(
    *,
    name: str,
    states: Iterable[Any],
    parameters: Mapping[str, float],
    surface: Any,
    above: Mapping[Any, Any],
    below: Mapping[Any, Any],
    time: Any = None,
    initial: Mapping[Any, Any] | None = None,
    **more: Any,
) -> "HybridSystem":
    """A system of two fields on the two sides of a surface, with the sliding motion that Filippov gives it.

    Modes are ``above`` (h > 0), ``below`` (h < 0) and ``sliding`` (h = 0). With the rates of h along the fields, u
    above and d below:

    - A motion that reaches h = 0 slides if both fields point to the surface, u <= 0 <= d, and crosses otherwise.
    - It slides along (d F_above - u F_below) / (d - u). It leaves upward where u rises through zero, and downward
      where d falls through zero; where both happen at once, upward.
    - Where both fields point away, u > 0 > d, nothing slides: a motion that starts there leaves, upward unless
      ``initial`` names ``below`` as its mode.

    Events are of the kinds ``slide``, ``cross`` and ``leave``. Without a mode in ``initial`` the system starts in that
    of its initial state. If the fields have the same rate of h everywhere, all motions cross, and there is no sliding
    mode.

    Parameters
    ----------
    name : str
    states : sequence of sympy.Symbol or str
    parameters : mapping of str to float
    surface : expression, or mapping of str to expression
        The expression h that is zero on the surface. It has to be linear in a state, with a coefficient of parameters
        alone. If it names other states too, it becomes a state, under the name given: with ``{"s": "x + tau*v"}``
        the system has the state s in the place of v, the last state in which it is linear. Its initial value follows
        from that of v.
    above, below : mapping of state to expression
        Time derivative of every state where h > 0, and where h < 0.
    time : sympy.Symbol or str, optional
        The symbol that stands for time, if any expression names it.
    initial : mapping, optional
        ``"mode"`` and values of states, also of the one that the surface replaces.
    **more : any
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
    given = _Given.read(name, states, time, parameters, surface)
    upper, lower = (given.read_field(side, field) for side, field in ((ABOVE, above), (BELOW, below)))

    def combined(up: Any, down: Any) -> Field:
        gap = sympy.expand(down - up)

        def rate(state: Any) -> Any:
            one, other = given.on(upper[state]), given.on(lower[state])
            apart = sympy.expand(one - other)
            return one if apart == 0 else other + given.reduced(apart / gap) * down

        return {state: rate(state) for state in given.states}

    return given.system(upper, lower, combined, initial, more)


def equivalent_control(
    *,
    name: str,
    states: Iterable[Any],
    parameters: Mapping[str, float],
    surface: Any,
    field: Mapping[Any, Any],
    control: Mapping[Any, Sequence[Any]],
    time: Any = None,
    initial: Mapping[Any, Any] | None = None,
    **more: Any,
) -> "HybridSystem":
    """A system under a control that switches at a surface, with the sliding motion under Utkin's equivalent control.

    The sliding mode has the value of the control that keeps h at zero. The rate of h has to be linear in the control;
    the rates of the states need not be, and where they are not the sliding motion is not Filippov's. Entries, exits and
    all else are those of `filippov`.

    Parameters
    ----------
    name : str
    states : sequence of sympy.Symbol or str
    parameters : mapping of str to float
    surface : expression, or mapping of str to expression
        As for `filippov`.
    field : mapping of state to expression
        Time derivative of every state, in which the control is named.
    control : mapping of str to (expression, expression)
        The control, and its values above and below the surface: ``{"u": ("-U", "U")}``.
    time : sympy.Symbol or str, optional
        The symbol that stands for time, if any expression names it.
    initial : mapping, optional
        ``"mode"`` and values of states, also of the one that the surface replaces.
    **more : any
        ``period``, ``quadratures``, ``bounds``, ``description`` and ``labels``, as for `HybridSystem`.

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
    given = _Given.read(name, states, time, parameters, surface)
    u, values = _read_control(name, control)
    rates = given.read_field("field", field)
    upper, lower = ({state: rate.xreplace({u: value}) for state, rate in rates.items()} for value in values)
    speed = sympy.expand(given.on(given.speed(rates)))
    slope = differentiate(speed, u)
    if slope == 0:
        raise ModelError(
            f"{name}: the control {u} does not act on the rate of {given.surface}, so that no value of it keeps the "
            "motion on the surface; choose a surface whose rate names it"
        )
    if u in slope.free_symbols:
        raise ModelError(
            f"{name}: the rate {speed} of {given.surface} is not linear in the control {u}, so that its equivalent "
            "value is not unique; write the two fields, and use filippov"
        )
    equivalent = given.reduced(-speed.xreplace({u: sympy.Integer(0)}) / slope)

    def controlled(up: Any, down: Any) -> Field:
        return {state: given.on(rate).xreplace({u: equivalent}) for state, rate in rates.items()}

    return given.system(upper, lower, controlled, initial, more)


@dataclass(frozen=True)
class _Given:
    """States, time, parameters and surface of a system.

    Attributes
    ----------
    name : str
    states : tuple of sympy.Symbol
        As the user writes the fields.
    time : sympy.Symbol or None
    parameters : mapping of str to float
    surface : sympy expression
    solved : sympy.Symbol
        The state that the surface determines.
    own : sympy.Symbol or None
        The state that is the surface, in the place of the one it determines.
    """

    name: str
    states: tuple[Any, ...]
    time: Any
    parameters: Mapping[str, float]
    surface: Any
    solved: Any
    own: Any

    @staticmethod
    def read(name: str, states: Any, time: Any, parameters: Any, surface: Any) -> "_Given":
        if isinstance(states, str) or not isinstance(states, Iterable):
            raise ModelError(f"{name}: states is {states!r}; it must be a sequence of symbols, as in (x, v)")
        symbols = tuple(read_symbol(f"{name}: state {place}", s) for place, s in enumerate(states))
        clock = None if time is None else read_symbol(f"{name}: time", time)
        known = read_table(f"{name}: parameters", parameters)
        own, h = _read_surface(name, surface)
        if own is not None and (own in (*symbols, clock) or own.name in known):
            raise ModelError(f"{name}: the surface is named {own}, which names something else; rename it")
        return _Given(name, symbols, clock, known, h, _solved(name, symbols, clock, known, h, own), own)

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

    def read_field(self, where: str, field: Any) -> Field:
        table = read_table(f"{self.name}: {where}", field)
        read = {
            read_symbol(f"{self.name}: {where}: a state", state): read_expression(
                f"{self.name}: {where}, d{state}/dt", rate
            )
            for state, rate in table.items()
        }
        for state in self.states:
            if state not in read:
                raise ModelError(f"{self.name}: {where} gives no derivative for state {state.name!r}")
        for state in read:
            if state not in self.states:
                raise ModelError(f"{self.name}: {where} gives a derivative for {state}, which is no state")
        return {state: read[state] for state in self.states}

    def on(self, expression: Any) -> Any:
        """An expression on the surface, without the state that the surface determines."""
        return expression.xreplace({self.solved: self._value_at(sympy.Integer(0))})

    def off(self, expression: Any) -> Any:
        """An expression in the states that the system has."""
        return expression if self.own is None else expression.xreplace({self.solved: self._value_at(self.own)})

    def reduced(self, fraction: Any) -> Any:
        """A fraction without common factors; of what symbols are called its form does not depend."""
        names = [*self.states, self.time, *map(parameter, self.parameters)]
        places = {symbol: sympy.Symbol(f"x_{i}", real=True) for i, symbol in enumerate(names) if symbol is not None}
        reduced = sympy.cancel(fraction.xreplace(places))
        return reduced.xreplace({place: symbol for symbol, place in places.items()})

    def speed(self, field: Field) -> Any:
        """Rate of h along a field."""
        along = sum((differentiate(self.surface, x) * rate for x, rate in field.items()), sympy.Integer(0))
        return along if self.time is None else along + differentiate(self.surface, self.time)

    def in_states(self, field: Field, speed: Any) -> Field:
        """Rates of the states that the system has; ``speed`` is that of the coordinate that stands for the surface."""
        return {
            self.own if x == self.solved and self.own is not None else x: speed
            if x == self.solved and self.own is not None
            else rate
            for x, rate in field.items()
        }

    def system(
        self,
        upper: Field,
        lower: Field,
        sliding: Callable[[Any, Any], Field],
        initial: Mapping[Any, Any] | None,
        more: Mapping[str, Any],
    ) -> "HybridSystem":
        """The system of two fields, and of the rates in sliding as a function of the rates of h at the surface."""
        from chaosdrill.model.system import HybridSystem

        up, down = (sympy.expand(self.on(self.speed(field))) for field in (upper, lower))
        modes = {
            side: {x: self.off(rate) for x, rate in self.in_states(field, self.speed(field)).items()}
            for side, field in ((ABOVE, upper), (BELOW, lower))
        }
        slides = sympy.expand(down - up) != 0
        if slides:
            led = {x: rate for x, rate in sliding(up, down).items() if x != self.solved}
            rate = sympy.Integer(0) if self.time is None else differentiate(self.held, self.time)
            order = [self.coordinate if x == self.solved else x for x in self.states]
            modes[SLIDING] = {x: led.get(x, rate) for x in order}
        read = dict(more)
        integrals = read_table(f"{self.name}: quadratures", read.pop("quadratures", None) or {})

        def off(name: str, given: Any) -> Any:
            if isinstance(given, Mapping):
                return {mode: off(name, one) for mode, one in given.items()}
            return self.off(read_expression(f"{self.name}: {name}", given))

        system = HybridSystem(
            name=self.name,
            states=tuple(modes[ABOVE]),
            time=self.time,
            parameters=self.parameters,
            modes=modes,
            transitions=self._transitions(up, down, slides=slides),
            quadratures={name: off(name, given) for name, given in integrals.items()},
            **read,
        )
        return system.with_initial(**self._start(initial, up, down, slides=slides))

    def _transitions(self, up: Any, down: Any, *, slides: bool) -> list[Any]:
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
        for way, target, speed, direction in (("up", ABOVE, up, +1), ("down", BELOW, down, -1)):
            if slides and speed.free_symbols & moving:
                found.append(Transition(f"leave-{way}", SLIDING, target, speed, direction, reset, kind="leave"))
        return found

    def _start(self, initial: Any, up: Any, down: Any, *, slides: bool) -> dict[str, Any]:
        """The initial mode and state: where the surface says nothing else, those given."""
        start = {str(k): v for k, v in read_table(f"{self.name}: initial", initial or {}).items()}
        where = self.coordinate.name
        numbers = {parameter(key): value for key, value in self.parameters.items()}
        if parameter("pi") not in {*self.states, self.own, self.time, *numbers}:
            numbers[parameter("pi")] = sympy.pi
        numbers |= {x: start.get(x.name, 0.0) for x in self.states}
        if self.time is not None:
            numbers[self.time] = 0.0

        def value(expression: Any) -> float:
            try:
                return float(expression.subs(numbers))
            except (TypeError, ValueError, OverflowError):
                raise ModelError(f"{self.name}: {expression} has no value at the initial state") from None

        mode = start.get("mode")
        if self.own is not None and where in start:
            distance = start[where]
            if self.solved.name in start:
                raise ModelError(f"{self.name}: initial names {where!r} and {self.solved.name!r}; leave one out")
        elif mode == SLIDING and self.solved.name not in start:
            distance = 0.0
        else:
            distance = value(self.surface)
        start.pop(self.solved.name if self.own is not None else "", None)
        if self.own is not None:
            start[where] = distance
        elif distance == 0.0 and where not in start:
            start[where] = value(self.held)
        if mode == SLIDING and distance != 0.0:
            raise ModelError(
                f"{self.name}: the initial mode is {SLIDING!r}, but the initial state is {distance:.6g} away from the "
                f"surface; leave {self.solved.name!r} out of it, or name another mode"
            )
        if mode is None:
            attracts = slides and value(up) <= 0 <= value(down)
            if distance == 0.0 and attracts:
                mode = SLIDING
            else:
                mode = ABOVE if distance > 0 or (distance == 0.0 and value(up) >= 0) else BELOW
        return {**start, "mode": mode}


def _read_surface(name: str, surface: Any) -> tuple[Any, Any]:
    """The name of a surface, if it has one, and its expression."""
    several = isinstance(surface, list | tuple | set | frozenset) or (
        isinstance(surface, Mapping) and len(surface) != 1
    )
    if several:
        raise ModelError(
            f"{name}: surface is {surface!r}; one surface is possible. Where two meet, four fields join, and the "
            "convex combinations of them that stay on both are not unique: which one is meant is part of the model. "
            "Write its modes and transitions yourself"
        )
    if not isinstance(surface, Mapping):
        return None, read_expression(f"{name}: surface", surface)
    ((key, h),) = surface.items()
    return read_symbol(f"{name}: name of the surface", key), read_expression(f"{name}: surface", h)


def _read_control(name: str, control: Any) -> tuple[Any, list[Any]]:
    table = read_table(f"{name}: control", control)
    values = next(iter(table.values()), None)
    if len(table) != 1 or isinstance(values, str) or not isinstance(values, Sequence) or len(values) != 2:
        raise ModelError(
            f"{name}: control is {control!r}; it must be one control with its values above and below the surface, as "
            "in {'u': ('-U', 'U')}"
        )
    ((u, _),) = table.items()
    return read_symbol(f"{name}: control", u), [read_expression(f"{name}: control {u}", value) for value in values]


def _solved(name: str, states: Any, time: Any, parameters: Mapping[str, float], h: Any, own: Any) -> Any:
    """The state that a surface determines."""
    named = [x for x in states if x in h.free_symbols]
    if not named:
        raise ModelError(f"{name}: the surface {h} depends on no state")
    slopes = {x: sympy.expand(differentiate(h, x)) for x in named}
    linear = [x for x in named if not slopes[x].free_symbols & {*states, time}]
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
