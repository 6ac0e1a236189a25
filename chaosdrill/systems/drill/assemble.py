"""The drill in reduced coordinates, assembled from its effects.

    y' = u - w
    u' = b + load(t) - l                 l = y + 2 xi (u - w): force of spring and damper
    w' = eps (l - f(w))                  stick: w = 0 while l <= 1
    stop: y <= r, by a law of impact or by a force beyond it

y is the stretch of the spring, u and w are the speeds of bit and rock; the penetration (integral of w) enters no force
and is a quadrature. Displacements are in units of mu_e F_N / K, time in units of sqrt(m1 / K). Source: equations (1) to
(11) of the paper "System for percussive drilling with rock model", with its misprints corrected as on the theory page.
"""

from collections.abc import Collection, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from chaosdrill.errors import ModelError
from chaosdrill.names import no_parameter
from chaosdrill.systems.drill import contact, drive, effects, friction, rock
from chaosdrill.systems.drill.si import QUANTITIES, read_si
from chaosdrill.typed import TABLE, TEXT, expecting

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

NAME = "percussive-drill"

# Beyond w = 25 friction is at its kinetic value to 1e-32 and a static load above it accelerates for ever.
BOUNDS = {"w": (-25.0, 25.0), "timer": None}

_THE_SAME = ("n", "lobes")
"""Parameters that have no unit, and are quantities of a drill in SI units as they stand."""

LABELS = {
    "y": "stretch of the spring",
    "u": "speed of the bit",
    "w": "speed of the rock-side mass",
    "timer": "remaining contact time",
    "depth": "depth of the bit beyond the stop",
    "penetration": "penetration of the rock-side mass",
    "b": "static load over the static friction force",
    "xi": "damping ratio",
    **drive.LABELS,
    **friction.LABELS,
    **rock.LABELS,
    **contact.LABELS,
}


@expecting(ModelError, initial=TABLE, name=TEXT)
def drill(
    *,
    drive: str = "harmonic",
    friction: str = "stribeck",
    rock: str = "moving",
    contact: str = "hunt-crossley",
    initial: Mapping[str, Any] | None = None,
    name: str | None = None,
    **parameters: float | str,
) -> "HybridSystem":
    """Build the percussive drill.

    Parameters
    ----------
    drive : {"harmonic", "lobes", "none"}
        Dynamic load on the bit.
    friction : {"stribeck", "coulomb", "stribeck-two-sided", "coulomb-two-sided", "none"}
        Friction between rock-side mass and rock; one-sided unless its name says two-sided.
    rock : {"moving", "fixed"}
        Whether the rock-side mass moves; if it does, its penetration is a quadrature.
    contact : {"hunt-crossley", "hunt-crossley-timed", "compliant", "newton", "none"}
        Contact at the stop.
    initial : mapping, optional
        ``mode``, ``y``, ``u``, ``w`` that differ from rest (and ``timer`` or ``depth`` of a contact that takes time).
    name : str, optional
        Name of the system; default ``"percussive-drill"``.
    **parameters : float or str
        Values of ``a b xi eps eta mu g r lam phi n k`` (``lobes spin`` for lobes, ``e`` for newton) that differ from
        the defaults: 0.25, 0.7, 0.06, 1, 0.8, 0.6, 3, 1, 0.6, pi/2, 1, 12e5. All are dimensionless. Alternatively
        quantities with units, named as in scenes in SI units (``m1="250 kg"``, ``K="4 MN/m"``): masses, spring,
        friction and all others that the effects need. The parameters follow from them.

    Returns
    -------
    HybridSystem
        With those of the modes ``stick``, ``slip`` and ``slip-back``, and of the contact (``-held``, ``-contact``),
        that the effects make reachable.

    Raises
    ------
    ModelError
        If an option does not exist, effects exclude each other, or a parameter is used by none of them; if a quantity
        is missing, cannot be read, has the wrong dimension, or fixes a parameter that is given too.
    SettingsError
        If a parameter is not a finite number, or beyond its limits.
    """
    chosen = {"drive": drive, "friction": friction, "rock": rock, "contact": contact}
    used = effects.parameters(chosen)
    numbers = _without_units(parameters, used)
    for key in numbers:
        if key not in used:
            raise ModelError(no_parameter(key, used, effects.unused(key, chosen)))
    system = _listed(effects.complete(chosen), name or NAME)
    return system.with_parameters(**numbers).with_initial(**(initial or {}))


def _without_units(parameters: Mapping[str, Any], used: Mapping[str, float]) -> dict[str, Any]:
    """The dimensionless parameters, those included that follow from quantities with units."""
    raw = {
        key: value
        for key, value in parameters.items()
        if key in QUANTITIES and (key not in used or isinstance(value, str) or key in _THE_SAME)
    }
    if not raw.keys() - used.keys():
        return dict(parameters)
    numbers = {key: value for key, value in parameters.items() if key not in raw}
    si, faults = read_si(raw, numbers, used)
    if wrong := [f"{path[-1]}: {message}" for path, message in faults if path[-1] in raw]:
        raise ModelError("; ".join(wrong).replace("system.parameters.", ""))
    if faults:
        missing = [str(path[-1]) for path, _ in faults]
        given = next(key for key in raw if key not in used)
        raise ModelError(
            f"{given} is a quantity with a unit; give {', '.join(missing)} too, as in "
            f"{missing[0]}={QUANTITIES[missing[0]].example!r}; or give dimensionless parameters only"
        )
    return numbers | si.parameters


def bodies(known: Collection[str]) -> dict[str, str]:
    """Heights of bit, stop and rock, for animations: the stop stands on the rock-side mass, at y = r from the bit."""
    if not {"y", "r"} <= set(known):
        return {}
    sunk = "-penetration" if "penetration" in known else "0"
    return {"bit": f"{sunk} - y", "stop": f"{sunk} - r", "rock at the start": "-r"}


def system(chosen: Mapping[str, str] | None = None) -> "HybridSystem":
    """The drill with these effects and default parameters; an effect that is absent is not simulated."""
    return _listed(effects.complete(chosen), NAME)


def _listed(chosen: dict[str, str], name: str) -> "HybridSystem":
    from chaosdrill.model import HybridSystem

    key = (NAME, name, *chosen.values())
    return HybridSystem.listed(key, partial(_assemble, chosen, name), effects.limits(chosen))


def _assemble(chosen: dict[str, str], name: str) -> "HybridSystem":
    from chaosdrill.model import HybridSystem
    from chaosdrill.systems.drill import hits
    from chaosdrill.systems.drill.balance import REST, Balance, stick_slip

    option = chosen["contact"]
    balance = Balance(chosen)
    modes = {mode: balance.apart(mode) for mode in balance.modes}
    transitions = stick_slip(balance, balance.spring(REST), "", balance.free, {})
    if contact.jumps(option):
        modes |= hits.hit_modes(balance) | {mode + hits.HELD: balance.together(mode) for mode in balance.modes}
        transitions += hits.hits(balance, option) + hits.held(balance)
    elif option != "none":
        modes |= hits.contact_modes(balance)
        transitions += hits.contacts(balance)
    states = (balance.y, balance.u, *((balance.w,) if balance.moves else ()), *balance.free)
    parameters = effects.parameters(chosen)
    quadratures = {"penetration": balance.w} if balance.moves else {}
    kept = {*(s.name for s in states), *parameters, *quadratures}
    assembled = HybridSystem(
        name=name,
        states=states,
        time=None if balance.period is None else balance.t,
        parameters=parameters,
        modes={mode: {x: {**balance.free, **field}[x] for x in states} for mode, field in modes.items()},
        transitions=transitions,
        period=balance.period,
        quadratures=quadratures,
        bounds={s.name: BOUNDS[s.name] for s in states if s.name in BOUNDS},
        description="percussive drill: " + ", ".join(f"{effect} {option}" for effect, option in chosen.items()),
        labels={key: label for key, label in LABELS.items() if key in kept},
    )
    return assembled.limited(effects.limits(chosen))
