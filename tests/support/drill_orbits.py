"""Special points of the drill's periodic orbits at xi = 0.06: reference values, and how to compute them again.

All were located by Newton's method on the period map of `drill_in_series`, with 30 digits, and stand in
``drill_orbits.csv``. ``python -m support.drill_orbits DIGITS``, called in ``tests``, computes that table again.

What they say:

* The period-1 orbit has one stick, slip and hit a period from 0.90 down to 0.4553, where a second hit begins to touch
  and the branch turns back. With two hits it goes on through folds at 0.4565 and 0.4490 up to 0.4649, where a stick
  begins to touch and it turns back again. It is unstable from 0.7645 to 0.5510 and below 0.4794, so that between 0.60
  and 0.64 there is no doubling of it, its multipliers being -2.74 and 0.05 there.
* The period-2 orbit known at 0.6 doubles upward at 0.6200 and again, downward, at 0.6705. The first cascade ends at
  once: its period-4 orbit grazes at 0.6212. The period-4 orbit of the second one loses its stability at 0.6619 and has
  it again from 0.6321 to 0.6239. Its cascade runs from 0.6705 down to 0.66002.
"""

import csv
import sys
from dataclasses import dataclass
from pathlib import Path

from mpmath import mp

from support.strobe_orbits import Branch, Orbit, touches


@dataclass(frozen=True)
class Special:
    """A special point.

    Attributes
    ----------
    branch : str
        Which orbit it is; p2 is that known at eta = 0.6.
    kind : str
        ``period doubling``, ``fold`` or ``grazing``.
    periods : int
        Forcing periods of the orbit.
    eta : str
        Forcing frequency; within 1e-14 for periods 1 and 2 and at grazings, 1e-12 for the others.
    state : tuple of str
        y, u, w at phase 0; the rock slips there.
    multipliers : tuple of complex
        The two that are not zero by structure; at a grazing those of the orbit without the event.
    touched : str
        At a grazing: the event, ``hit``, ``slip`` or ``stick``.
    time : float
        When that is, in forcing periods.
    beyond : str
        At a grazing: ``folds back`` if the orbits with the event lie on the side of those without, else ``continues``.
    without : int
        At a grazing: +1 if the orbit without the event exists above eta, -1 if below.
    """

    branch: str
    kind: str
    periods: int
    eta: str
    state: tuple[str, str, str]
    multipliers: tuple[complex, complex]
    touched: str
    time: float
    beyond: str
    without: int


def _read() -> tuple[Special, ...]:
    with (Path(__file__).parent / "drill_orbits.csv").open(newline="") as file:
        return tuple(
            Special(
                branch=row["branch"],
                kind=row["kind"],
                periods=int(row["periods"]),
                eta=row["eta"],
                state=(row["y"], row["u"], row["w"]),
                multipliers=(complex(row["multiplier_1"]), complex(row["multiplier_2"])),
                touched=row["touched"],
                time=float(row["time"] or "nan"),
                beyond=row["beyond"],
                without=int(row["without"] or 0),
            )
            for row in csv.DictReader(file)
        )


ALL = _read()
"""Every special point, in the order in which they lie along their branches."""

CASCADE = (0.67051322593363, 0.66191656894072, 0.66042302655040, 0.6600962861442, 0.6600261699957)
"""Doublings of the periods 2 to 32 of the orbit that doubles at 0.6705, within 1e-11.

Those of periods 16 and 32 come from series in doubles and differences of fourth order; for shorter ones that way agrees
with 30 digits within 1e-12.
"""

TESTS = {
    "period doubling": lambda orbit: orbit.determinant(-1),
    "fold": lambda orbit: orbit.determinant(1),
}


def located(special: Special, step: str = "1e-6") -> Orbit:
    """The special point, located again from 8 digits of its state."""
    start = [mp.mpf(mp.nstr(mp.mpf(value), 8)) for value in (*special.state, special.eta)]
    if special.kind == "grazing":
        touching = touches(special.touched, mp.mpf(special.time))
        found = Branch(special.periods, overlook=1e-2).find(start, touching)
        if found is None:
            raise ArithmeticError(f"no grazing beside {special.eta}")
        return found
    branch = Branch(special.periods)
    # a fold is no function of eta: the state's first component leads there
    held = 0 if special.kind == "fold" else 3
    first = branch.find(start, lambda z, run: z[held] - start[held])
    if first is None:
        raise ArithmeticError(f"no orbit beside {special.eta}")
    return branch.root(first, mp.mpf(step), TESTS[special.kind])


def named(branch: str, kind: str, near: float) -> Special:
    """The special point of a branch and kind next to ``near``."""
    return min((s for s in ALL if (s.branch, s.kind) == (branch, kind)), key=lambda s: abs(float(s.eta) - near))


def _main(digits: int) -> None:
    mp.dps = digits
    for special in ALL:
        orbit = located(special)
        state = [mp.nstr(value, 17) for value in orbit.unknowns[:3]]
        moved = mp.nstr(orbit.eta - mp.mpf(special.eta), 3)
        print(special.branch, special.kind, mp.nstr(orbit.eta, 17), *state, *orbit.multipliers, moved, flush=True)


if __name__ == "__main__":
    _main(int(sys.argv[1]) if len(sys.argv) > 1 else 30)
