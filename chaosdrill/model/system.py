"""A hybrid dynamical system as its user writes it: modes that flow, guards, resets."""

import math
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import fields
from functools import partial
from inspect import Parameter, signature
from typing import TYPE_CHECKING, Any, TypedDict, Unpack

from chaosdrill.declared import KEPT
from chaosdrill.errors import ModelError, SettingsError
from chaosdrill.limits import Limit
from chaosdrill.model import arithmetic
from chaosdrill.model.outline import WholeSystem, attributes, outline
from chaosdrill.model.tables import UNNAMED, finite
from chaosdrill.model.transition import Transition
from chaosdrill.model.tuning import TUNING
from chaosdrill.model.values import Definition, Shared, System, deriving
from chaosdrill.names import brief, remedy, shown
from chaosdrill.typed import Kind, constructor, meant

if TYPE_CHECKING:
    from chaosdrill.model.noise import Noise
    from chaosdrill.model.reading import Reader

RELATED = "related"
"""Under which `Shared` has the systems that were derived from one, by what tells them apart."""

_derived: "OrderedDict[Any, Shared]" = OrderedDict()
_listed: "OrderedDict[Any, HybridSystem]" = OrderedDict()
"""Systems of the library of late, by their keys."""


class Words(TypedDict, total=False):
    """Description and labels of a system."""

    description: str
    labels: Mapping[str, str] | None


def arguments_of(kind: type) -> list[str]:
    """The names of all arguments that make a system."""
    named = [name for name, one in signature(kind).parameters.items() if one.kind is not Parameter.VAR_KEYWORD]
    return [*named, *Words.__annotations__]


@constructor
class HybridSystem(System):
    """States that flow in modes and jump at guards.

    Expressions are text, numbers or sympy: ``"-x - 2*zeta*v + cos(omega*t)"``. Text is read by the grammar of scenes
    and never run as code; in sympy, symbols are matched by name, whatever their assumptions. Jacobians, guard
    gradients, reset Jacobians and saltation matrices are derived from the expressions.

    Instead of an expression there may be a Python function ``f(t, x, p)`` that numba can compile, for the methods
    ``dop853``, ``radau`` and ``rk4``. ``x`` and ``p`` are named tuples of the states and the parameters, in order:
    ``x.v`` and ``x[1]`` are the same. It returns one number; for a whole mode or a whole reset a tuple, with one for
    every state. Its derivatives are computed by dual numbers, exact but for rounding. What it reads beside its
    arguments is taken as it is at the definition. Archives hold its name and a digest, and cannot be run again.

    Parameters
    ----------
    name : str
        Name of the system.
    states : str or sequence of str or sympy.Symbol
        The n states in order, as in ``"x v"``.
    time : str or sympy.Symbol, optional
        What stands for time in expressions. Default: ``t``, unless a state or a parameter has this name.
    parameters : mapping of str to float, optional
        Parameters and their values.
    modes : mapping of str to mapping of state to expression, or to a function
        Time derivative of every state in every mode.
    transitions : sequence of Transition
        What happens at the guards.
    period : expression, optional
        Period of the explicit time dependence (of parameters only); strobes are taken once a period.
    initial : mapping, optional
        ``"mode"`` and values of states; default: 0, and the mode in whose region the state is, else the first mode.
    regions : mapping of mode to condition, optional
        Comparisons of states and parameters that choose the mode of a start that names none: the first mode whose
        comparisons hold at time 0. They do so in every analysis, at its own states and parameters. If all of them
        contain a comparison of parameters that does not hold, the system cannot start.
    quadratures : mapping of str to expression, or to mapping of mode to expression, optional
        Integrals along the flow which feed back into nothing; the integrand may differ by mode.
    bounds : mapping of state to (low, high) or None, optional
        A state outside of its bounds has escaped. Default +-1e9, in units of the largest initial state where that is
        larger than 1; None stands for no bound.
    **words : optional
        ``description``: one line. ``labels``: long names of states, parameters, quadratures and time, by name.

    Raises
    ------
    ModelError
        With everything that is wrong, one fault a line, each with its place and the remedy.
    SettingsError
        If a parameter or an initial value is no finite number; if a system is changed after it was made.
    """

    def __init__(
        self,
        *,
        name: str = UNNAMED,
        states: str | Iterable[Any],
        time: Any = None,
        parameters: Mapping[str, float] | None = None,
        modes: Mapping[str, Mapping[Any, Any] | Callable[..., Any]],
        transitions: Iterable[Transition] = (),
        period: Any = None,
        initial: Mapping[Any, Any] | None = None,
        regions: Mapping[str, Any] | None = None,
        quadratures: Mapping[str, Any] | None = None,
        bounds: Mapping[Any, Any] | None = None,
        **words: Unpack[Words],
    ) -> None:
        given = {
            "name": name, "states": states, "time": time, "period": period, "modes": modes, "transitions": transitions,
            "regions": regions, "quadratures": quadratures, "bounds": bounds,
        }  # fmt: skip
        self._read(given, words, parameters, initial)

    def _read(self, given: dict[str, Any], words: Mapping[str, Any], parameters: Any, initial: Any) -> None:
        """Become what these arguments say, or refuse them."""
        kind = type(self)
        for key in words:
            if key not in Words.__annotations__:
                way = meant(key, words, arguments_of(kind))
                raise TypeError(f"{kind.__name__}() got an unexpected keyword argument {key!r}; {way}")
        reader = self.reader({} if parameters is None else parameters)
        found = reader.read({**given, **words})
        if found is None:
            raise ModelError(reader.told(f"{given['name']!s:.60}"))
        self._become(found, reader.parameters, initial)

    @staticmethod
    def reader(parameters: Any) -> "Reader":
        """The reader of definitions, with these parameters."""
        from chaosdrill.model.reading import Reader

        return Reader(parameters)

    @classmethod
    def of(cls, found: Definition, parameters: Mapping[Any, Any], initial: Mapping[Any, Any] | None) -> "HybridSystem":
        """The system of a definition that was read with these parameters."""
        system = cls.__new__(cls)
        system._become(found, parameters, initial)
        return system

    @classmethod
    def listed(
        cls, key: tuple[str, ...], make: Callable[[], "HybridSystem"], limits: Mapping[str, Limit]
    ) -> "HybridSystem":
        """A system of the library with its defaults, or of a scene, from a stored outline or built.

        ``key``: determines the system, together with the code of the package. ``make``: builds it, and can be sent to
        another process. ``limits``: those of its parameters.
        """
        with deriving:
            found = cls.known(key, make, limits)
            if found is None:
                found = make().enlisted(key)
        return found

    def enlisted(self, key: tuple[str, ...]) -> "HybridSystem":
        """Register this system under a key that, with the code of the package, determines it."""
        with deriving:
            # others of the same equations may be known by another key
            self.shared.key, self.shared.outline, self.shared.recalled = key, outline(self), frozenset()
            _keep(_listed, key, self)
        return self

    @classmethod
    def known(
        cls, key: tuple[str, ...], make: Callable[[], "HybridSystem"], limits: Mapping[str, Limit]
    ) -> "HybridSystem | None":
        """As `listed`, but None if neither this process nor an earlier one has built the system."""
        with deriving:
            found = _listed.get(key)
            if found is None:
                shared = Shared(key)
                if "recall" not in KEPT or not KEPT["recall"](shared):
                    return None
                found, whole = cls.__new__(cls), WholeSystem(make)
                found._put(whole=whole, limits=limits, shared=shared, **attributes(shared.outline, whole))
            _keep(_listed, key, found)
        return found

    def relative(
        self, how: tuple[str, ...], make: "Callable[[], HybridSystem]", kind: "type[HybridSystem] | None" = None
    ) -> "HybridSystem":
        """A system derived from the equations of this one, with its numbers where it has them; stored or built.

        ``how``: identifies it among the systems derived from this one. ``make``: builds it, and can be sent to another
        process. ``kind``: of what is built, as a record of it is read; default: `HybridSystem`.
        """
        kind = kind or HybridSystem
        related = self.shared.setdefault(RELATED, {})
        if how not in related:
            key = self.shared.key
            related[how] = make() if key is None else kind.listed((*key, *how), make, {})
        found: HybridSystem = related[how]
        start = {**self.parameters, **self.initial}
        return found.changed(
            parameters={name: self.parameters.get(name, value) for name, value in found.parameters.items()},
            initial={name: start.get(name, value) for name, value in found.initial.items()},
        )

    def _become(self, found: Definition, parameters: Mapping[Any, Any], initial: Mapping[Any, Any] | None) -> None:
        self._put(
            **{one.name: getattr(found, one.name) for one in fields(found)},
            parameters={str(key): _number(found.name, "parameter", key, value) for key, value in parameters.items()},
            limits={},
        )
        if not isinstance(initial, Mapping | None):
            raise ModelError(
                f"{self.name}: initial: expected numbers by name, as in {{{self.state_names[0]!r}: 0.1}}, received "
                f"{shown(initial):.60}; with_initial also takes numbers in the order of the states"
            )
        from chaosdrill.model.exponents import exponent_parameters

        self._put(exponent_parameters=exponent_parameters(self))
        key = (type(self), *self._content())
        with deriving:
            # a recent system with the same equations shares what is derived of them
            self._put(shared=_derived.get(key, Shared()))
            _keep(_derived, key, self.shared)
        self._begin({str(key): value for key, value in (initial or {}).items()})

    def begun(self, initial: Mapping[str, Any]) -> "HybridSystem":
        """A copy that starts as if it had been made with this initial state."""
        other = copy(self)
        other._begin(initial)
        return other

    def _begin(self, initial: Mapping[str, Any]) -> None:
        start = {"mode": next(iter(self.modes)), **dict.fromkeys(self.state_names, 0.0)}
        self._put(initial=start, names_mode=not self.regions)
        self._set_initial(initial)

    @property
    def autonomous(self) -> bool:
        """Whether no rate, guard, reset or condition depends on time, so that a motion shifted in time is a motion.

        Quadratures do not count, since they feed back into nothing.
        """
        if "autonomous" not in self.shared:
            import sympy

            from chaosdrill.model.derive import time_derivative
            from chaosdrill.model.exponents import differences, motion
            from chaosdrill.model.held import Trial

            zero = Trial(self).zero
            slopes = [time_derivative(self, one) for one in differences(motion(self)) if self.time in one.free_symbols]
            # a pulse may be no double but zero at all places that are tried: what seems to vanish is expanded as well
            self.shared["autonomous"] = all(
                zero(one, ()) and sympy.expand(sympy.numer(sympy.together(one)), trig=True) == 0 for one in slopes
            )
        return bool(self.shared["autonomous"])

    @property
    def placed(self) -> "HybridSystem":
        """This system with its symbols named by their places, see `chaosdrill.model.places`."""
        from chaosdrill.model.places import placed

        return placed(self)

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
        if not self.forced:
            return None
        try:
            number = float(arithmetic.period(self, list(self.parameters.values()), math))
        except (ArithmeticError, ValueError, TypeError):
            number = float("nan")
        if not 0 < number < float("inf"):
            named = {p.name: self.parameters[p.name] for p in self.period.free_symbols}
            raise SettingsError(
                f"{self.name}: the period {self.period} is not a positive number at {named}; it must be > 0"
            )
        return number

    def with_parameters(self, table: Mapping[str, float] | None = None, /, **values: float) -> "HybridSystem":
        """A copy with other parameter values; the compiled kernels are shared.

        Parameters
        ----------
        table : mapping of str to float, optional
            Parameters of the system, by name.
        **values : float
            Parameters of the system, by name.

        Returns
        -------
        HybridSystem
            The copy; the system stays as it is.

        Raises
        ------
        SettingsError
            If the system has no such parameter, or if a value is not a finite number, or beyond the parameter's limits.
        """
        if not isinstance(table, Mapping | None):
            raise SettingsError(f"{self.name}: parameters are {shown(table):.60}; give them by name, as in eta=0.4")
        values = {**(table or {}), **values}
        for key in values:
            if key not in self.parameters:
                raise SettingsError(f"{self.name}: unknown parameter {key!r}; {remedy(str(key), self.parameters)}")
        for key, value in values.items():
            if key in self.limits and (told := self.limits[key].refuses(_number(self.name, "parameter", key, value))):
                raise SettingsError(f"{self.name}: parameter {key!r}: {told}")
        numbers = {key: _number(self.name, "parameter", key, value) for key, value in values.items()}
        other = self.changed(parameters={**self.parameters, **numbers})
        other._find_mode()
        return other

    def with_initial(self, start: Any = None, /, **values: Any) -> "HybridSystem":
        """A copy that starts elsewhere: ``with_initial(y=0.1, mode="slip")``, ``with_initial(ds["states"][-1])``.

        Parameters
        ----------
        start : sequence of n float, or mapping of str to float or str, optional
            All states in order, or some, and ``mode``, by name. Names that the dimension ``state`` of an xarray has
            count, not its order.
        **values : float or str
            States, and ``mode``, by name; others stay as they are. A mode that was never named is that in whose region
            the state is then.

        Returns
        -------
        HybridSystem
            The copy; the system stays as it is.

        Raises
        ------
        SettingsError
            If the system has no such state or mode, if there are more or fewer numbers than states, or if a value is
            not a finite number.
        """
        other = copy(self)
        other._set_initial({**self._by_name(start), **values})
        return other

    def _by_name(self, start: Any) -> dict[str, Any]:
        """A start by names of states."""
        if start is None:
            return {}
        if isinstance(start, Mapping):
            if "state" in getattr(start, "dims", ()):
                name, one = next(entry for entry in start.items() if "state" in entry[1].dims)
                place = f"[{', '.join(['-1'] * (one.ndim - 1))}]" if one.ndim > 1 else ""
                raise SettingsError(
                    f"{self.name}: the initial state is a whole result; give a state of it, as in "
                    f"with_initial(ds[{name!r}]{place})"
                )
            return {str(name): value for name, value in start.items()}
        names, found = self.state_names, start
        if getattr(start, "dims", None) == ("state",):
            names = tuple(map(str, start["state"].values)) if "state" in start.coords else names
            found = start.values
        numbers = list(found) if isinstance(found, Iterable) and not isinstance(found, str | bytes) else []
        if getattr(found, "ndim", 1) != 1 or len(numbers) != len(self.state_names):
            received = f"an array of shape {found.shape}" if hasattr(found, "shape") else f"{shown(found):.60}"
            raise SettingsError(
                f"{self.name}: the initial state is {received}; it must have {len(self.state_names)} numbers, in the "
                f"order {', '.join(self.state_names)}; or give some by name, as in {self.state_names[0]}=0.1"
            )
        return dict(zip(names, numbers, strict=True))

    def with_noise(
        self,
        distributions: Mapping[str, Any],
        /,
        *,
        at: str | Iterable[str] | Mapping[str, Any] | None = None,
        seed: int = 0,
    ) -> "HybridSystem":
        """A copy in which parameters are drawn anew whenever certain events happen, or once a period.

        A value that was drawn at an event holds from then on, beginning after its reset, up to the next draw; until the
        first one the parameter has the median of its distribution. The numbers depend only on the seed and on the count
        of earlier draws: they are the same to the bit in every run, with any number of workers, so that exponents and
        means are those of this realisation of the noise. Another seed gives other noise, and may be swept. Where starts
        are counted, in `basins`, `attractors` and `transient_chaos`, start k, from 0, has the seed plus k.

        Parameters
        ----------
        distributions : mapping of str to Uniform, Normal, LogNormal, Exponential or Choice
            By the parameter that is drawn.
        at : str, list of str, or mapping of parameter to these
            Names or kinds of events; ``"period"``: once a forcing period, a quarter of it after the strobe. Maps need
            none: they draw at every iterate.
        seed : int, default 0
            Whole number from 0 to 2**53 - 1.

        Returns
        -------
        HybridSystem
            The copy; the system stays as it is. Of a parameter ``e`` there are the states ``e_draw``, the standard
            variate, and ``e_count``, the draws so far, behind all other states; no exponent belongs to them. Instead of
            ``e`` it has the parameters of its distribution, such as ``e_low`` and ``e_high``, and ``noise_seed``. A
            distribution without spread has its first parameter alone: the run is then that without noise to the bit.

        Raises
        ------
        SettingsError
            If there is no such parameter, event or period; if a value may be drawn that the parameter cannot have; if
            the system has noise already.
        ModelError
            If the parameter is where no state can stand.
        """
        from chaosdrill.model.noise import noise_of

        noise = noise_of(self, distributions, at, seed)
        make = partial(_drawn, self, noise)
        known = self.relative(("noise", noise.form), make, type(self))
        known.shared.origin = self
        found = known.changed(parameters={name: noise.parameters[name] for name in known.parameters})
        return found.begun(noise.initial).limited(noise.limits)

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
            With n + 1 states, or n + the number of parameters, or both; what noise is made of stays behind them. A map
            stays one, unless its clock is made a state. Kinks and jumps in the parameters bound their states: a run
            beyond has `escaped`.

        Raises
        ------
        SettingsError
            If the system has no such parameter, or a rate or guard has a kink or a jump at its value, or one of which
            the place is not known, or depends on other parameters.
        """
        import sympy

        from chaosdrill.model.places import parameter
        from chaosdrill.model.sides import Side

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
        side = Side.of(self, names)
        smooth = side.smooth(self)
        side.alone()
        ends = {key: tuple(end.value for end in side.ends(key)) if smooth is not self else None for key in names}
        wide = smooth.remade(
            name=f"{self.name} (augmented)",
            states=(*self.states[: self.free], *extra, *self.states[self.free :]),
            parameters={key: value for key, value in self.parameters.items() if key not in names},
            initial={**self.start, **{s.name: value for s, (_, value) in extra.items()}},
            bounds={**self.bounds, **{s.name: ends.get(s.name) for s in extra}},
            **smooth._moved_with({s: rate for s, (rate, _) in extra.items()}, fixed),
        )
        return wide.limited(self.limits)

    def _moved_with(self, rates: Mapping[Any, Any], fixed: Mapping[Any, float]) -> dict[str, Any]:
        """The arguments that say how states move, beside further ones; ``fixed``: parameters with their values."""
        return {
            "time": None if self.time in rates else self.time,
            "modes": {mode: {**field, **rates} for mode, field in self.modes.items()},
            "period": None if self.period is None else self.period.subs(fixed),
        }

    def remade(self, **other: Any) -> "HybridSystem":
        """A system made of other arguments, where they are given, and of those that this one is made of."""
        return self._remade(HybridSystem, other)

    def _remade(self, kind: "type[HybridSystem]", other: Mapping[str, Any]) -> "HybridSystem":
        own = {name: getattr(self, name) for name in arguments_of(kind) if name != "initial"}
        made = kind(**{**own, "initial": self.start, **other})
        return made.changed(noise=self.noise) if self.noise else made

    def _set_initial(self, values: Mapping[str, Any]) -> None:
        start: dict[str, Any] = {}
        for key, value in values.items():
            if key == "mode":
                if not isinstance(value, str) or value not in self.modes:
                    raise SettingsError(f"{self.name}: initial mode {value!r}; modes are {list(self.modes)}")
                start[key] = value
            elif key in self.state_names:
                start[key] = _number(self.name, "initial", key, value)
            else:
                known = ("mode", *self.state_names)
                raise SettingsError(f"{self.name}: initial names {key!r}, which is not a state; {remedy(key, known)}")
        self._put(initial={**self.initial, **start}, names_mode=self.names_mode or "mode" in start)
        self._find_mode()

    def _find_mode(self) -> None:
        """Set the initial mode to that of the region that holds the initial state, unless it was named."""
        if self.names_mode:
            return
        import numpy as np

        from chaosdrill.model.regions import UNTOLD, modes_at

        ((mode,), _) = modes_at(self, {}, np.array([self.initial_values]))
        if mode != UNTOLD:
            self._put(initial={**self.initial, "mode": self.mode_names[mode]})


def _drawn(system: HybridSystem, noise: "Noise") -> HybridSystem:
    """The system with noise, from its equations."""
    from chaosdrill.model.drawing import with_draws

    reader = system.reader(noise.parameters)
    found = reader.read(with_draws(system, noise))
    if found is None:
        raise ModelError(reader.told(f"{system.name} with noise"))
    return type(system).of(found, reader.parameters, noise.initial)


def recent(definition: Mapping[str, Any], parameters: Mapping[str, float]) -> HybridSystem | None:
    """A system of late that is known to have this definition, with these parameters; None if there is none."""
    for system in reversed(_listed.values()):
        if system.shared.get("definition") == definition and [*system.parameters] == [*parameters]:
            return system.changed(parameters=dict(parameters))
    return None


def _keep(table: "OrderedDict[Any, Any]", key: Any, value: Any) -> None:
    """Keep the most recent entries of a table alone."""
    table[key] = value
    table.move_to_end(key)
    while len(table) > TUNING.recent_systems:
        table.popitem(last=False)


def _number(system: str, what: str, key: Any, value: Any) -> float:
    number = finite(value)
    if number is None:
        way = ", without quotes" if isinstance(value, str) else ""
        way = "; take one of its values after another" if getattr(value, "ndim", 0) else way
        raise SettingsError(f"{system}: {what} {str(key)!r} is {shown(value):.60}; it must be a finite number{way}")
    return number


SYSTEM = Kind(
    "a HybridSystem: your own, that of a scene or a result (load_scene(path).system, system(ds)), or one with a name",
    lambda value: isinstance(value, HybridSystem),
    lambda value: f", as in chaosdrill.{f'build({brief(value)})' if isinstance(value, str) else 'drill()'}",
)
