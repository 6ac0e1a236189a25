"""A hybrid dynamical system as its user writes it: modes that flow, guards, resets."""

from collections import OrderedDict
from collections.abc import Iterable, Mapping
from copy import copy
from threading import RLock
from typing import Any

import sympy

from chaosdrill.declared import DISPLAYS
from chaosdrill.errors import ModelError, SettingsError
from chaosdrill.model.check import check_system
from chaosdrill.model.exponents import exponent_parameters, expressions
from chaosdrill.model.places import in_places, parameter, places_of, rewrite
from chaosdrill.model.reading import read_expression, read_mapping, read_name, read_symbol
from chaosdrill.model.transition import Transition
from chaosdrill.typed import TEXT, refuse

DEFAULT_BOUND = 1e9

# several threads may ask for the placed form of one system at once, and each would derive it
_deriving = RLock()

_LATELY = 32
"""Systems of which what was derived is kept for others of the same equations."""

_derived: "OrderedDict[Any, Shared]" = OrderedDict()


class Shared(dict[Any, Any]):
    """What systems of the same equations have in common: compiled kernels and what was derived from the equations.

    Another process, to which a system is sent, begins with an empty one, shared again by the copies sent together.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        return Shared, ()


class HybridSystem:
    """States that flow in modes and jump at guards, written in sympy.

    Symbols are matched by name, whatever their assumptions. Jacobians, guard gradients, reset Jacobians and saltation
    matrices are derived from the expressions.

    Parameters
    ----------
    name : str
        Name of the system.
    states : sequence of sympy.Symbol
        The n states.
    time : sympy.Symbol, optional
        The symbol that stands for time, if any expression names it.
    parameters : mapping of str to float
        Parameters and their values.
    modes : mapping of str to mapping of state to expression
        Time derivative of every state in every mode.
    transitions : sequence of Transition
        What happens at the guards.
    period : sympy expression, optional
        Period of the explicit time dependence (of parameters only); strobes are taken once a period.
    initial : mapping, optional
        ``"mode"`` and values of states; default: the first mode, and 0.
    quadratures : mapping of str to expression, optional
        Integrals along the flow which feed back into nothing.
    bounds : mapping of state to (low, high) or None, optional
        A state outside of its bounds has escaped. Default +-1e9; None stands for no bound.
    description : str
        One line.
    labels : mapping of str to str
        Long names of states, parameters and quadratures.

    Raises
    ------
    ModelError
        If the system cannot be compiled, with the reason.
    """

    def __init__(
        self,
        *,
        name: str,
        states: Iterable[Any],
        time: Any = None,
        parameters: Mapping[str, float],
        modes: Mapping[str, Mapping[Any, Any]],
        transitions: Iterable[Transition] = (),
        period: Any = None,
        initial: Mapping[Any, Any] | None = None,
        quadratures: Mapping[str, Any] | None = None,
        bounds: Mapping[Any, Any] | None = None,
        description: str = "",
        labels: Mapping[str, str] | None = None,
    ) -> None:
        self.name = read_name("name of the system", name)
        refuse(ModelError, f"{name}: description", description, TEXT)
        self.description = description
        self.labels = dict(read_mapping(f"{name}: labels", {} if labels is None else labels, "{'v': 'velocity'}"))
        self.states = _read_states(name, states)
        self.time = None if time is None else read_symbol(f"{name}: time", time)
        given = read_mapping(f"{name}: parameters", parameters, "{'k': 2.0}")
        self.parameters = {str(key): _number(name, "parameter", key, value) for key, value in given.items()}
        self.modes = _read_modes(name, modes)
        self.transitions = _read_transitions(name, transitions)
        self.period = None if period is None else read_expression(f"{name}: period", period)
        integrals = read_mapping(f"{name}: quadratures", {} if quadratures is None else quadratures, "{'work': v**2}")
        self.quadratures = {
            str(key): read_expression(f"{name}: quadrature {str(key)!r}", value) for key, value in integrals.items()
        }
        self.bounds = _read_bounds(name, self.state_names, {} if bounds is None else bounds)
        self.initial = {"mode": next(iter(self.modes), None), **{s.name: 0.0 for s in self.states}}
        self._read_pi()
        check_system(self)
        start = read_mapping(f"{name}: initial", {} if initial is None else initial, "{'mode': 'free', x: 0.1}")
        self._set_initial({str(key): value for key, value in start.items()})
        self.exponent_parameters = exponent_parameters(self)
        self.shared = self._shared_with_others()

    def _shared_with_others(self) -> Shared:
        """What a system that differs in numbers alone, made not long ago, has derived; else an empty place for it."""
        key = (
            *(self.name, self.description, repr(self.labels), self.states, self.time, tuple(self.parameters)),
            tuple((name, tuple(rates.items())) for name, rates in self.modes.items()),
            tuple(t.content() for t in self.transitions),
            *(self.period, tuple(self.quadratures.items()), repr(self.bounds)),
        )
        with _deriving:
            shared = _derived.setdefault(key, Shared())
            _derived.move_to_end(key)
            while len(_derived) > _LATELY:
                _derived.popitem(last=False)
        return shared

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in order."""
        return tuple(s.name for s in self.states)

    @property
    def mode_names(self) -> tuple[str, ...]:
        """Names of the modes, in order."""
        return tuple(self.modes)

    @property
    def placed(self) -> "HybridSystem":
        """This system with its symbols named by their places, see `chaosdrill.model.places`."""
        with _deriving:
            form = self.shared.get("placed")
            if form is None:
                form = self.shared["placed"] = in_places(self)
        other = copy(form)
        other.parameters = dict(zip(form.parameters, self.parameters.values(), strict=True))
        starts = (self.initial[name] for name in self.state_names)
        other.initial = {"mode": self.initial["mode"], **dict(zip(form.state_names, starts, strict=True))}
        return other

    def forcing_period(self) -> float | None:
        """The period of the forcing at the present parameters.

        Returns
        -------
        float or None
            In units of the system's time; None if the system has no forcing.

        Raises
        ------
        SettingsError
            If it is not a positive number at these parameters.
        """
        if self.period is None:
            return None
        if "period of one" not in self.shared:
            placed = self.placed
            self.shared["period of one"] = sympy.lambdify(
                [parameter(name) for name in placed.parameters], placed.period, modules="math"
            )
        try:
            number = float(self.shared["period of one"](*self.parameters.values()))
        except (ArithmeticError, ValueError, TypeError):
            number = float("nan")
        if not 0 < number < float("inf"):
            named = {p.name: self.parameters[p.name] for p in self.period.free_symbols}
            raise SettingsError(
                f"{self.name}: the period {self.period} is not a positive number at {named}; it must be > 0"
            )
        return number

    def with_parameters(self, **values: float) -> "HybridSystem":
        """A copy with other parameter values; the compiled kernels are shared.

        Parameters
        ----------
        **values : float
            Parameters of the system, by name.

        Returns
        -------
        HybridSystem
            The copy; the system stays as it is.

        Raises
        ------
        SettingsError
            If the system has no such parameter, or if a value is not a finite number.
        """
        for key in values:
            if key not in self.parameters:
                raise SettingsError(f"{self.name}: unknown parameter {key!r}; it has {sorted(self.parameters)}")
        other = copy(self)
        other.parameters = {
            **self.parameters,
            **{key: _number(self.name, "parameter", key, value) for key, value in values.items()},
        }
        return other

    def with_initial(self, **values: Any) -> "HybridSystem":
        """A copy that starts elsewhere: ``with_initial(y=0.1, mode="slip")``.

        Parameters
        ----------
        **values : float or str
            States, and ``mode``, by name; others stay as they are.

        Returns
        -------
        HybridSystem
            The copy; the system stays as it is.

        Raises
        ------
        SettingsError
            If the system has no such state or mode, or if a value is not a finite number.
        """
        other = copy(self)
        other.initial = dict(self.initial)
        other._set_initial(values)
        return other

    def augmented(self, *, time: bool = False, parameters: Iterable[str] = ()) -> "HybridSystem":
        """The same system with time (rate 1) and parameters (rate 0) among its states.

        Tangents of the augmented system hold the explicit dependence on time and the sensitivities to parameters, and
        its saltation matrices obey ``S F- = F+`` exactly.

        Parameters
        ----------
        time : bool
            Make time a state (of the symbol's name).
        parameters : iterable of str
            Parameters that become states of the same name.

        Returns
        -------
        HybridSystem
            With n + 1 states, or n + the number of parameters, or both.

        Raises
        ------
        SettingsError
            If the system has no such parameter.
        """
        names = tuple(parameters)
        unknown = [key for key in names if key not in self.parameters]
        if unknown:
            raise SettingsError(f"{self.name}: unknown parameter {unknown[0]!r}; it has {sorted(self.parameters)}")
        extra: dict[Any, tuple[Any, float]] = {}
        if time and self.time is not None:
            extra[self.time] = (sympy.Integer(1), 0.0)
        for key in names:
            extra[parameter(key)] = (sympy.Integer(0), self.parameters[key])
        fixed = {parameter(key): self.parameters[key] for key in names}
        return HybridSystem(
            name=f"{self.name} (augmented)",
            states=(*self.states, *extra),
            time=None if time else self.time,
            parameters={key: value for key, value in self.parameters.items() if key not in names},
            modes={m: {**field, **{s: rate for s, (rate, _) in extra.items()}} for m, field in self.modes.items()},
            transitions=self.transitions,
            period=None if self.period is None else self.period.subs(fixed),
            initial={**self.initial, **{s.name: value for s, (_, value) in extra.items()}},
            quadratures=self.quadratures,
            bounds={**self.bounds, **{s.name: None for s in extra}},
            description=self.description,
            labels=self.labels,
        )

    def _read_pi(self) -> None:
        """Let ``pi`` be the number in what was read from text, unless something of the system is called so."""
        pi = parameter("pi")
        if pi in places_of(self):
            return
        if self.period is not None:
            self.period = self.period.xreplace({pi: sympy.pi})
        if any(pi in expression.free_symbols for expression in expressions(self)):
            rewrite(self, lambda expression: sympy.sympify(expression).xreplace({pi: sympy.pi}))

    def _set_initial(self, values: Mapping[str, Any]) -> None:
        for key, value in values.items():
            if key == "mode":
                if not isinstance(value, str) or value not in self.modes:
                    raise SettingsError(f"{self.name}: initial mode {value!r}; modes are {list(self.modes)}")
                self.initial["mode"] = value
            elif key in self.state_names:
                self.initial[key] = _number(self.name, "initial", key, value)
            else:
                raise SettingsError(f"{self.name}: initial names {key!r}; expected 'mode' or one of {self.state_names}")

    def _repr_html_(self) -> str | None:
        return DISPLAYS["html"](self)

    def _repr_latex_(self) -> str | None:
        return DISPLAYS["latex"](self)

    def __repr__(self) -> str:
        return (
            f"HybridSystem({self.name!r}, states={self.state_names}, modes={self.mode_names}, "
            f"transitions={tuple(t.name for t in self.transitions)})"
        )


def _read_states(system: str, states: Any) -> tuple[Any, ...]:
    if isinstance(states, str) or not isinstance(states, Iterable):
        raise ModelError(f"{system}: states is {states!r}; it must be a sequence of symbols, as in (x, v)")
    return tuple(read_symbol(f"{system}: state {place}", s) for place, s in enumerate(states))


def _read_modes(system: str, modes: Any) -> dict[str, dict[Any, Any]]:
    read: dict[str, dict[Any, Any]] = {}
    for mode, field in read_mapping(f"{system}: modes", modes, "{'free': {x: v, v: -x}}").items():
        where = f"{system}: mode {mode!r}"
        rates = read_mapping(where, field, "{x: v, v: -x}").items()
        read[read_name(f"{system}: name of a mode", mode)] = {
            read_symbol(f"{where}: a state", s): read_expression(f"{where}, d{s}/dt", rate) for s, rate in rates
        }
    return read


def _read_transitions(system: str, transitions: Any) -> tuple[Transition, ...]:
    listed = tuple(transitions) if isinstance(transitions, Iterable) else (transitions,)
    if not isinstance(transitions, Iterable) or not all(isinstance(t, Transition) for t in listed):
        raise ModelError(f"{system}: transitions is {transitions!r}; it must be a list of Transition; [] for none")
    return listed


def _read_bounds(system: str, states: tuple[str, ...], bounds: Any) -> dict[str, tuple[float, float]]:
    read = dict.fromkeys(states, (-DEFAULT_BOUND, DEFAULT_BOUND))
    for key, bound in read_mapping(f"{system}: bounds", bounds, "{x: (-10, 10)}").items():
        if str(key) not in read:
            raise ModelError(f"{system}: bounds name {str(key)!r}, which is no state; states are {states}")
        try:
            low, high = (-float("inf"), float("inf")) if bound is None else map(float, bound)
        except (TypeError, ValueError):
            low = high = float("nan")
        if isinstance(bound, str) or not low < high:
            raise ModelError(
                f"{system}: bounds of {str(key)!r} are {bound!r}; they must be a pair (low, high) with low < high, "
                "or None for no bound"
            )
        read[str(key)] = (low, high)
    return read


def _number(system: str, what: str, key: Any, value: Any) -> float:
    try:
        number = float("nan") if isinstance(value, str | bytes | bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = float("nan")
    if number != number or number in (float("inf"), -float("inf")):
        raise SettingsError(f"{system}: {what} {str(key)!r} is {value!r}; it must be a finite number")
    return number
