"""Branches of the logistic map x' = r x (1 - x), whose orbits of period 1 and 2 and their multipliers are closed forms.

A second state v = 2 x follows the first, so that one multiplier is exactly 0.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from chaosdrill.analysis.orbit_datasets import branches_dataset, orbits_dataset
from chaosdrill.dataset import BranchEnd, Outcome, Special, label
from chaosdrill.orbits.results import BranchInfo, BranchResult, Cascade, Checks, FoundOrbit, SpecialPoint

DOUBLINGS = np.array([3.0, 1 + np.sqrt(6), 3.5440903596, 3.5644072661, 3.5687594195])
ACCUMULATION = 3.5699456719


@pytest.fixture(scope="session")
def system():
    """What labels and datasets need of a system."""
    return SimpleNamespace(
        name="logistic map",
        parameters={"r": 3.0, "q": 0.5},
        start={"mode": "free", "x": 0.5, "v": 1.0},
        quadratures={},
        labels={"r": "growth rate", "x": "population"},
        modes={"free": {}},
        transitions=(SimpleNamespace(name="hit"), SimpleNamespace(name="slip_forward")),
        states=("x", "v"),
        state_names=("x", "v"),
        forced=True,
        forcing_period=lambda: 1.0,
        shared={"lines": [], "turns": []},
    )


def _points(values, one, two=None):
    """Sections of shape (points, 2, 2): orbits of period 1 have no second point."""
    section = np.full((len(values), 2, 2), np.nan)
    section[:, 0, 0] = one
    if two is not None:
        section[:, 1, 0] = two
    section[..., 1] = 2 * section[..., 0]
    return section


@pytest.fixture
def branch_result():
    """Period 1 from r = 2.8 to 3.6, doubling at 3; period 2 from there to 3.5, doubling at 1 + sqrt 6, then an end."""
    first, second = np.linspace(2.8, 3.6, 81), np.sort(np.append(np.linspace(3.0, 3.5, 51), DOUBLINGS[1]))
    root = np.sqrt((second - 3) * (second + 1))
    upper, lower = ((second + 1 + sign * root) / (2 * second) for sign in (1, -1))
    multiplier = np.concatenate([2 - first, 4 + 2 * second - second**2])
    values = np.concatenate([first, second])
    special = np.zeros(len(values), dtype=np.int64)
    at = [20, 81 + int(np.flatnonzero(second == DOUBLINGS[1])[0]), len(values) - 1]
    special[at] = [Special.PERIOD_DOUBLING, Special.PERIOD_DOUBLING, Special.GRAZING]
    kinds = [Special(code) for code in special[at]]
    return BranchResult(
        parameters=("r",),
        values=values[:, None],
        branch=np.repeat([0, 1], [81, 52]),
        arclength=np.concatenate([first - 2.8, second - 3.0]),
        period=np.repeat([1, 2], [81, 52]),
        duration=np.repeat([1.0, 2.0], [81, 52]),
        state=np.concatenate([_points(first, 1 - 1 / first), _points(second, upper, lower)])[:, 0],
        section=np.concatenate([_points(first, 1 - 1 / first), _points(second, upper, lower)]),
        mode=np.zeros(len(values), dtype=np.int64),
        multipliers=np.stack([multiplier, np.zeros(len(values))], axis=1).astype(complex),
        stable=np.abs(multiplier) < 1,
        special=special,
        sequence=np.zeros(len(values), dtype=np.int64),
        sequences=("hit",),
        smallest_speed=np.full(len(values), 0.3),
        residual=np.full(len(values), 1e-15),
        branches=(
            BranchInfo(-1, 1, "from the attractor", "reached the limit", BranchEnd.LIMIT),
            BranchInfo(0, 2, "period doubling", "a hit vanishes", BranchEnd.GRAZING),
        ),
        events=tuple(SpecialPoint(p, kind, values[[p]], 1e-12, "") for p, kind in zip(at, kinds, strict=True)),
        cascade=Cascade(
            DOUBLINGS,
            2 ** np.arange(5),
            np.concatenate([[np.nan, np.nan], np.diff(DOUBLINGS)[:-1] / np.diff(DOUBLINGS)[1:]]),
            ACCUMULATION,
            1e-6,
        ),
    )


@pytest.fixture
def as_continuation(system):
    """Label a result of following branches as the analysis does."""

    def labelled(result, **settings):
        sweep = {name: [2.8, 3.6] for name in result.parameters}
        raw = branches_dataset(system, result)
        ds = label(raw, "continuation", system=system, settings={"sweep": sweep, **settings})
        return ds.assign_attrs(message=result.message)

    return labelled


@pytest.fixture
def continuation(as_continuation, branch_result):
    """The dataset of these branches."""
    return as_continuation(branch_result)


@pytest.fixture
def curve(as_continuation):
    """Factory of datasets of curves: Henon's fold a = -(1 - b)^2/4 and period doubling a = 3 (1 - b)^2/4."""

    def made(follow, period=1, end=BranchEnd.LIMIT, specials=None):
        b = np.linspace(-0.5, 0.5, 21)
        a = {"fold": -0.25, "period_doubling": 0.75}[follow] * (1 - b) ** 2
        count = len(b)
        kinds = specials or {}
        result = BranchResult(
            parameters=("r", "q"),
            values=np.stack([a, b], axis=1),
            **{name: np.zeros(count, dtype=np.int64) for name in ("branch", "mode", "sequence")},
            special=np.array([kinds.get(i, Special.REGULAR) for i in range(count)]),
            period=np.full(count, period),
            arclength=b + 0.5,
            duration=np.full(count, float(period)),
            state=np.zeros((count, 2)),
            section=np.zeros((count, 1, 2)),
            multipliers=np.ones((count, 2), dtype=complex),
            stable=np.zeros(count, dtype=bool),
            sequences=("hit",),
            smallest_speed=np.ones(count),
            residual=np.zeros(count),
            branches=(BranchInfo(-1, period, "", "", end),),
            events=tuple(SpecialPoint(i, kind, np.array([a[i], b[i]]), 0.0, "") for i, kind in sorted(kinds.items())),
        )
        return as_continuation(result, follow=follow)

    return made


@pytest.fixture
def found():
    """An orbit of period 2 with three events: a hit at x = 1 that turns v round, a slip, and another hit."""
    before = np.array([[1.0, 0.5], [0.2, 0.1], [1.0, 0.25]])
    after = before * [[1, -1], [1, 1], [1, -1]]
    return FoundOrbit(
        outcome=Outcome.PERIODIC,
        message="",
        period=2,
        duration=2.0,
        states=np.array([[0.4, 0.3], [0.6, -0.1]]),
        section=np.array([[0.4, 0.3], [0.6, -0.1]]),
        mode=0,
        multipliers=np.array([-0.26096 + 0.65086j, -0.26096 - 0.65086j]),
        rank=2,
        residual=3e-15,
        newton=np.array([1e-1, 1e-3, 1e-7, 0.0]),
        event_times=np.array([0.25, 0.5, 1.5]),
        event_speeds=np.array([0.5, 1.0, 0.25]),
        event_transitions=np.array([0, 1, 0]),
        event_states_before=before,
        event_states_after=after,
        checks=Checks(np.array([-0.1776, -0.1776]), 1e-12, 1e-14, 1e-13, True),
        path_times=np.array([0.0, 0.25, 0.25, 0.5, 1.0, 1.5, 1.5, 2.0]),
        path_states=np.array(
            [[0.4, 0.3], [1.0, 0.5], [1.0, -0.5], [0.2, 0.1], [0.6, -0.1], [1.0, 0.25], [1.0, -0.25], [0.4, 0.3]]
        ),
    )


@pytest.fixture
def as_orbit(system):
    """Label results as the analysis does: one orbit, or those of a search."""

    def labelled(*orbits, search=False, **attrs):
        raw = orbits_dataset(system, orbits)
        raw = raw if search else raw.isel(orbit=0, drop=True)
        return label(raw, "periodic-orbit", system=system, settings={}).assign_attrs(attrs)

    return labelled
