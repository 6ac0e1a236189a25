"""Library of systems: one file each, discovered by its presence.

A module of the library offers ``NAME``, ``GROUP``, ``SUMMARY``, ``CITES`` (if results cite anything), ``STATES`` (name:
label), ``PARAMETERS`` (name: default and label), ``LIMITS`` (name: `Limit`, if any has one) and ``EQUATIONS``: the
other arguments of `HybridSystem`, with an `event` for each transition, or of `filippov` if there is a surface among
them; ``equations()``, which returns them, where sympy derives them. One that is assembled from effects offers
``states(effects)``, ``parameters(effects)``, ``unused(key, effects)``, ``limits(effects)`` and ``system(effects)``
instead of the last four. One whose bodies move along a line offers ``BODIES`` for animations, the height of each as
text, or ``bodies(known)`` if they depend on effects. None imports sympy before a system is built.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ModelError
from chaosdrill.limits import Limit
from chaosdrill.names import no_parameter, remedy
from chaosdrill.systems.drill.effects import OPTIONS
from chaosdrill.typed import TABLE, TEXT, expecting

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


GROUPS = (
    "drilling",
    "impacts",
    "friction and sliding",
    "machines",
    "converters",
    "circuits",
    "neurons",
    "walkers",
    "smooth flows",
    "maps for tests",
)
"""Groups, in the order of listings."""


@dataclass(frozen=True)
class Entry:
    """Information on a system before it is built."""

    name: str  # name by which scenes and `build` know the system
    group: str  # group in which it is listed
    summary: str  # one line
    cites: tuple[str, ...]  # keys of the references that a result of it cites
    module: str  # module that defines the system
    effects: bool  # whether it is assembled from effects


def _entries() -> Iterator[Entry]:
    for found in iter_modules(__path__, f"{__name__}."):
        module = import_module(found.name)
        cites = getattr(module, "CITES", ())
        yield Entry(module.NAME, module.GROUP, module.SUMMARY, cites, found.name, hasattr(module, "states"))


REGISTRY: dict[str, Entry] = {
    entry.name: entry for entry in sorted(_entries(), key=lambda entry: (GROUPS.index(entry.group), entry.name))
}

EFFECTS: dict[str, dict[str, str]] = OPTIONS


def parameters(name: str, effects: Mapping[str, str] | None = None) -> dict[str, float]:
    """Names and defaults of the parameters that a system has with these effects.

    ``effects``: option of each effect, from `EFFECTS`; absent effects are not simulated. None: those of the system.

    Raises `ModelError` if the system, an effect or an option does not exist, or if effects exclude each other.
    """
    entry, module = _module(name, effects)
    return module.parameters(effects) if entry.effects else _defaults(module)


def limits(name: str, effects: Mapping[str, str] | None = None) -> dict[str, Limit]:
    """Limits of the parameters of a system with these effects; arguments and errors as for `parameters`."""
    entry, module = _module(name, effects)
    return module.limits(effects) if entry.effects else _limits(module)


def unused(name: str, key: str, effects: Mapping[str, str] | None = None) -> str:
    """Say which other effects would use a parameter that these do not; empty if there are none.

    Arguments and errors as for `parameters`.
    """
    entry, module = _module(name, effects)
    return str(module.unused(key, effects)) if entry.effects else ""


def states(name: str, effects: Mapping[str, str] | None = None) -> tuple[str, ...]:
    """Names of the states that a system has with these effects; arguments and errors as for `parameters`."""
    entry, module = _module(name, effects)
    return module.states(effects) if entry.effects else tuple(module.STATES)


def bodies_of(name: str, known: Collection[str]) -> dict[str, str]:
    """The height of each body of a system, as expressions in its states, quadratures, parameters and ``t``.

    ``known``: names of its states, quadratures and parameters. There are none for a system without bodies on a line,
    and for one that only has the name of one in the library.
    """
    if name not in REGISTRY:
        return {}
    module = import_module(REGISTRY[name].module)
    if hasattr(module, "bodies"):
        return dict(module.bodies(known))
    own = {*module.STATES, *module.PARAMETERS} if hasattr(module, "BODIES") else {""}
    return dict(module.BODIES) if own <= set(known) else {}


@expecting(ModelError, name=TEXT, parameters=TABLE, effects=TABLE, initial=TABLE)
def build(
    name: str,
    parameters: Mapping[str, float] | None = None,
    effects: Mapping[str, str] | None = None,
    initial: Mapping[str, Any] | None = None,
) -> "HybridSystem":
    """Build a system of the library.

    Parameters
    ----------
    name : str
        Name of a system, a key of `REGISTRY`.
    parameters : mapping of str to float, optional
        Values that replace defaults.
    effects : mapping of str to str, optional
        Option of each effect, from `EFFECTS`; absent effects are not simulated. None: those of the system.
    initial : mapping of str to float or str, optional
        ``mode`` and values of states that replace those of the system.

    Returns
    -------
    HybridSystem
        With the given values, and defaults for all others.

    Raises
    ------
    ModelError
        If the system, an effect, an option or a parameter does not exist, with the remedy.
    SettingsError
        If a value is not a finite number or beyond the limits of its parameter, or if ``initial`` names an unknown
        state or mode.
    """
    from chaosdrill.model import HybridSystem

    entry, module = _module(name, effects)
    known = module.parameters(effects) if entry.effects else _defaults(module)
    for key in parameters or {}:
        if key not in known:
            raise ModelError(f"{name}: {no_parameter(key, known, unused(name, key, effects))}")
    if entry.effects:
        system = module.system(effects)
    else:
        system = HybridSystem.listed((name,), partial(_built, entry.module), _limits(module))
    return system.with_parameters(**(parameters or {})).with_initial(**(initial or {}))


def _module(name: str, effects: Mapping[str, str] | None) -> tuple[Entry, Any]:
    if name not in REGISTRY:
        raise ModelError(f"unknown system {name!r}; {remedy(name, REGISTRY)}")
    entry = REGISTRY[name]
    if effects and not entry.effects:
        raise ModelError(f"{name} is not assembled from effects; leave {sorted(effects)} out")
    return entry, import_module(entry.module)


def _defaults(module: Any) -> dict[str, float]:
    return {name: default for name, (default, _) in module.PARAMETERS.items()}


def _limits(module: Any) -> dict[str, Limit]:
    """Limits, each with its parameter's label if it has no words of its own."""
    own: Mapping[str, Limit] = getattr(module, "LIMITS", {})
    words = {name: one.quantity or f"the {module.PARAMETERS[name][1]}" for name, one in own.items()}
    return {name: replace(one, quantity=words[name]) for name, one in own.items()}


def _built(module_name: str) -> "HybridSystem":
    from chaosdrill.model import HybridSystem, Transition
    from chaosdrill.model.filippov import filippov

    module = import_module(module_name)
    given = dict(module.EQUATIONS) if hasattr(module, "EQUATIONS") else module.equations()
    labels = module.STATES | {name: label for name, (_, label) in module.PARAMETERS.items()} | given.pop("labels", {})
    about = {"name": module.NAME, "description": module.SUMMARY, "labels": labels, "parameters": _defaults(module)}
    if "surface" in given:
        return filippov(**about, **given).limited(_limits(module))
    given["transitions"] = [Transition(*arguments, **named) for arguments, named in given.get("transitions", ())]
    return HybridSystem(**about, states=tuple(module.STATES), **given).limited(_limits(module))
