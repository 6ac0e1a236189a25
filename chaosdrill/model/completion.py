"""Whether a transition can complete rebounds: an infinite series of them that ends in a finite time.

Refused here is only a series that ends for no values of the parameters; the run decides about all others.
"""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import sympy

from chaosdrill.model.crossings import crossings
from chaosdrill.model.derive import differentiate, image_of, rate
from chaosdrill.model.held import Trial
from chaosdrill.model.python import opaque
from chaosdrill.model.transition import Transition
from chaosdrill.model.tuning import TUNING
from chaosdrill.model.values import Definition

if TYPE_CHECKING:
    import numpy as np

_REMEDY = (
    "leave completes out, and end what does accumulate by a guard of its own that is zero when all is over, such as "
    "the sum of what is left"
)


def wrong_completion(found: Definition, parameters: Mapping[str, Any], transition: Transition) -> str | None:
    """Why a transition cannot complete the one that it names; parameters as for `never_completed`."""
    rebound = next(t for t in found.transitions if t.name == transition.completes)
    rivals = [t for t in found.transitions if t.completes == transition.completes and t is not transition]
    where = f"completes {transition.completes!r:.60}"
    if any(set(t.source) & set(transition.source) for t in rivals) or rebound.completes is not None:
        return f"{where}: only one transition may complete a rebound, and it cannot be a rebound itself; leave one out"
    own, its = crossings((transition, rebound))
    if own != its or rebound.direction == 0:
        return f"{where}: both must have the same guard and the same direction, +1 or -1"
    if not set(transition.source) <= set(rebound.source):
        return f"{where}: that one must start from the mode {transition.source[0]!r:.60} too"
    if transition.target in transition.source:
        return f"{where}: its target must be another mode, one that holds the contact"
    told = never_completed(found, parameters, rebound)
    return f"completes {rebound.name!r:.60}: {told}" if told else None


def never_completed(found: Definition, parameters: Mapping[str, Any], rebound: Transition) -> str | None:
    """Say why a transition starts no series of rebounds, or none that ends; None if it may.

    A series needs a way back: a transition on the surface of the guard in a mode to which the rebound leads. It needs
    an acceleration that brings the motion back to the surface, so that the times between rebounds fall as their speeds
    do; a rebound that turns the speed; and a loss. Each is asked of expressions on the surface, at random numbers; no
    values of the ``parameters`` matter but where only these let motions lose speed or come back.
    """
    # a state or a parameter may have the name that time has in expressions
    clock = sympy.Dummy(real=True) if found.time is None else found.time
    system: Any = SimpleNamespace(**{**vars(found), "time": clock}, parameters=dict(parameters))
    trial, guard, target = Trial(system), rebound.guard, rebound.target
    zero = trial.zero
    surface = (guard,)
    if not guard.free_symbols & set(found.states):
        return f"the guard {guard} depends on time alone, which no rebound changes; {_REMEDY}"
    following = _following(found.transitions, target)
    back = [t for t in following if zero(t.guard, surface)]
    others = [t for t in following if t not in back]
    if not back:
        return (
            f"{rebound.name!r} leads to the mode {target!r}, from which no transition leads on to a guard that is zero "
            f"where {guard} is; {_REMEDY}"
        )
    reached = {target, *(t.target for t in _following(others, target))}
    for ways in ([rebound], [t for t in back if reached & set(t.source)]):
        if all(_lifts(system, trial, guard, t) for t in ways):
            lifted = guard.xreplace(image_of(system, ways[0]))
            return (
                f"the reset of {ways[0].name!r} takes {guard} from zero to {lifted}, while a series of rebounds is "
                "summed up on one surface; let it leave the guard at zero, or leave completes out"
            )
    before, after, pull = _speeds(system, rebound)
    if zero(pull, surface):
        turns = f", and {others[0].name!r} is an event of another surface, {others[0].guard} = 0" if others else ""
        return (
            f"after {rebound.name!r} the guard {guard} has no acceleration where it is zero in {target!r}, which would "
            f"bring the next rebounds ever sooner{turns}; {_REMEDY}"
        )
    alone = target in rebound.source
    if alone and all(zero(after - one, surface) for one in before):
        return f"{rebound.name!r} does not change the rate of {guard}, so nothing rebounds; {_REMEDY}"
    series = [(t, *_speeds(system, t)) for t in ([rebound] if alone else [rebound, *back])]
    if opaque(guard) or any(opaque(e) for _, rates, last, force in series for e in (*rates, last, force)):
        return None
    places = (trial.points(surface)[1], Trial(system, near=True).points(surface)[1])
    if (alone or not others) and all(_met(trial, places, *one)[:2] == (True, False) for one in series):
        return (
            f"{rebound.name!r} loses no speed, so rebounds never come faster; let its reset lose some, as in "
            "v = -e*v with e < 1, or leave completes out"
        )
    met, _, returned = _met(trial, places, rebound, before, after, pull)
    if met and not returned:
        return (
            f"after {rebound.name!r} the guard {guard} leaves zero with a speed and an acceleration of one sign in "
            f"{target!r}, so the motion does not come back; let the reset turn the speed, as in v = -e*v, or "
            f"{_REMEDY}"
        )
    return None


def _lifts(system: Any, trial: Trial, guard: Any, t: Transition) -> bool:
    """Whether a reset takes a guard off zero on all sheets of its surface, by more than rounding of the new state."""
    import numpy as np

    image = image_of(system, t)
    if opaque(guard) or opaque(guard.xreplace(image)):
        return False
    places = trial.points((guard,))[1]
    slopes = (differentiate(guard, x).xreplace(image) * image.get(x, x) for x in (*system.states, system.time))
    heights, reach = (trial.values(e, places) for e in (guard.xreplace(image), sympy.Add(*map(sympy.Abs, slopes))))
    known = np.isfinite(heights) & np.isfinite(reach)
    lifted = (np.abs(heights) > TUNING.vanishing * reach)[known]
    return lifted.size >= TUNING.fewest_samples and bool(lifted.all())


def _speeds(system: Any, t: Transition) -> tuple[list[Any], Any, Any]:
    """Rates of a guard before its event, in every source, and after it, and the acceleration after it."""
    leaves, image = rate(system, t.target, t.guard), image_of(system, t)
    pull = rate(system, t.target, leaves)
    return [rate(system, mode, t.guard) for mode in t.source], leaves.xreplace(image), pull.xreplace(image)


def _met(
    trial: Trial, places: "tuple[np.ndarray, np.ndarray]", rebound: Transition, before: list[Any], after: Any, pull: Any
) -> tuple[bool, bool, bool]:
    """Whether motions are met at the guard, some of them lose speed there, and some come back to it.

    Parameters have any values and signs at the first of the places, and about their own at the others.
    """
    import numpy as np

    on, n = np.hstack(places), len(trial.states)
    signs = on[n + 1 :, : places[0].shape[1]]
    signs *= np.random.default_rng(20261128).choice([-1.0, 1.0], signs.shape)
    speed, force = trial.values(after, on), trial.values(pull, on)
    speeds = np.array([trial.values(e, on) for e in before]) * rebound.direction
    known = np.isfinite(speed) & np.isfinite(force)
    met, lost = (speeds > 0.0) & known, np.abs(speed) < (1.0 - TUNING.vanishing) * speeds
    coming = np.sign(speed) * np.sign(force) <= 0.0
    enough = int(met.any(axis=0).sum()) >= TUNING.fewest_samples
    return enough, bool((met & lost).any()), bool((met & coming).any())


def _following(transitions: Sequence[Transition], mode: str) -> list[Transition]:
    """Those of the transitions that a motion may meet from a mode on, nearest first."""
    met, modes = list[Transition](), [mode]
    for mode in modes:
        new = [t for t in transitions if mode in t.source and t not in met]
        met += [t for t in new if t.completes is None and not t.marks_only()]
        modes += [t.target for t in met if t.target not in modes]
    return met
