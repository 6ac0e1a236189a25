"""What an orbit's numbers say of each other."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.dataset import Outcome
from chaosdrill.orbits.contraction import contraction
from chaosdrill.orbits.multipliers import structure_of
from chaosdrill.orbits.place import run_from, standpoint
from chaosdrill.orbits.results import Checks, FoundOrbit
from chaosdrill.orbits.verify import ROUND_OFF, Lapped

if TYPE_CHECKING:
    from chaosdrill.orbits.family import Family
    from chaosdrill.orbits.orbit import Orbit

MOST_LAPS = 200
"""Laps that tangents are given to turn into their directions."""

TURNED = 1e-12
"""What is left of a wrong direction after the laps between multipliers that are told apart."""

SMALLEST = -700.0
"""Logarithm of a multiplier that is near the smallest double."""

LOGARITHM = 1e-9
"""Difference of logarithms of multipliers, or of their product, that counts as none, at the best."""


def check(family: "Family", orbit: "Orbit", found: FoundOrbit, lapped: Lapped) -> Checks:
    """Compare multipliers with exponents and contractions, and the start with where two periods lead.

    Parameters
    ----------
    family : Family
    orbit : Orbit
    found : FoundOrbit
        What is said of it.
    lapped : Lapped
        Runs around it.
    """
    moduli = np.abs(found.multipliers)
    tolerance = family.numerics.tolerance
    # the speed at a guard is the less certain the smaller it is, and with it the saltation
    slowest = float(np.abs(found.event_speeds).min(initial=1.0))
    limit = LOGARITHM + lapped.explained(tolerance) + 10 * (ROUND_OFF + tolerance) / slowest**2
    if family.numerics.method == "rk4":
        limit += (2 * np.pi / (family.numerics.steps or 200)) ** 4 * max(1.0, lapped.growth)
    disagreements = []
    exponents, ends = exponents_of(family, orbit, moduli, found.rank)
    with np.errstate(divide="ignore"):
        logs = np.log(moduli)
    # so small that no double holds it: only its exponent is known
    beyond = (moduli == 0) & (exponents * found.duration < SMALLEST) & (np.arange(family.states) < found.rank)
    logs[beyond] = exponents[beyond] * found.duration
    difference = _difference(logs, exponents * found.duration, ends) / found.duration
    allowed = limit / found.duration
    if not difference <= allowed:
        disagreements.append(
            f"exponents and logarithms of the multipliers differ by {difference:.1e} (explained: {allowed:.1e})"
        )
    determinant = float("nan")
    if found.rank == family.states and not beyond.any():
        product, expected = float(logs.sum()), contraction(family, orbit)
        determinant = float(-np.expm1(-abs(product - expected)))
        if not determinant <= limit:
            disagreements.append(
                f"product of the multipliers and product of all contractions differ by {determinant:.1e} of the larger"
            )
    if not lapped.recurrence <= lapped.explained(tolerance, 2):
        disagreements.append(f"after a second period the state is off by {lapped.recurrence:.1e}")
    return Checks(
        exponents=exponents,
        exponent_difference=difference,
        determinant_difference=determinant,
        recurrence_difference=lapped.recurrence,
        consistent=not disagreements,
        disagreements="; ".join(disagreements),
    )


def exponents_of(family: "Family", orbit: "Orbit", moduli: np.ndarray, rank: int) -> tuple[np.ndarray, list[int]]:
    """Lyapunov exponents of the orbit by the engine's QR, and where groups of nearly equal ones end.

    The state is put back onto the orbit after every lap, so that an unstable one is not left. Multipliers of nearly
    the same modulus, as complex pairs, turn about each other for ever; only the mean of their exponents is one lap's.

    Returns
    -------
    exponents : ndarray, shape (d,)
        Descending; -inf for directions that events remove; members of a group share its mean.
    ends : list of int
        Number of the first exponent behind each group.
    """
    d = family.states
    with np.errstate(divide="ignore", invalid="ignore"):
        falls = np.maximum(-np.diff(np.log(moduli[:rank])), 1e-300)
        needed = -np.log(TURNED) / falls
    apart = needed <= MOST_LAPS
    laps = int(np.ceil(max(needed[apart], default=1.0))) + d
    ends = [*(np.flatnonzero(apart) + 1).tolist(), rank]
    arc, time, state = standpoint(family, orbit)
    structure = structure_of(family.plain)
    frame, shifts = structure.tangents(d)
    run = run_from(family, orbit, arc, time, state, tangents=frame, shifts=shifts, deficient=structure.deficient)
    outcome = Outcome.OK
    before = np.zeros(d)
    for _ in range(laps + 1):
        before = run.logs.copy()
        outcome = run.advance(orbit.periods)[0] if outcome == Outcome.OK else outcome
        run.x[:] = state
    values = np.full(d, np.nan)
    if outcome == Outcome.OK:
        values = (run.logs[:d] - before[:d]) / float(orbit.durations.sum())
        values[run.dead[:d] == 1] = -np.inf
        values = values[np.argsort(-values, kind="stable")]
        for first, end in zip([0, *ends[:-1]], ends, strict=True):
            values[first:end] = values[first:end].mean() if end > first else 0.0
    return values, ends


def _difference(logs: np.ndarray, exponents: np.ndarray, ends: list[int]) -> float:
    """Largest difference between the means of groups; infinite if not the same ones are -inf."""
    if not np.array_equal(np.isneginf(logs), np.isneginf(exponents)):
        return float("inf")
    pairs = zip([0, *ends[:-1]], ends, strict=True)
    return max((abs(float(logs[a:b].mean() - exponents[a:b].mean())) for a, b in pairs if b > a), default=0.0)
