"""Datasets written by hand after the table of variables, with values that the tests can say beforehand."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import chaosdrill as cd
from chaosdrill.dataset import Outcome, label


def _variable(dims, values, long_name, units="1", **attributes):
    return (dims, values, {"long_name": long_name, "units": units, **attributes})


def _flags(dims, codes, meanings):
    codes = np.asarray(codes, dtype=np.int8)
    values = np.arange(len(meanings.split()), dtype=np.int8)
    return _variable(dims, codes, "code", flag_values=values, flag_meanings=meanings)


OUTCOMES = "ok periodic quasiperiodic chaotic escaped"


@pytest.fixture
def ball():
    """Elastic ball over a floor at x = 0 with g = 1: ten flights of two units of time; drift 0.5 t; wet below 0.25."""
    time = np.linspace(0, 20, 401)
    local = time % 2
    events = np.arange(2.0, 20.5, 2.0)
    height = local * (2 - local) / 2
    return xr.Dataset(
        {
            "states": _variable(("time", "state"), np.stack([height, 1 - local], axis=1), "state"),
            "mode": _flags("time", height < 0.25, "dry wet"),
            "penetration": _variable("time", 0.5 * time, "penetration", "mm"),
            "event_time": _variable("event", events, "time of the event"),
            "event_kind": _flags("event", np.zeros(10), "bounce_off other"),
            "event_speed": _variable("event", np.ones(10), "normal speed"),
            "event_state_before": _variable(
                ("event", "state"), np.tile([0.0, -1.0], (10, 1)), "state before the event"
            ),
            "event_state_after": _variable(("event", "state"), np.tile([0.0, 1.0], (10, 1)), "state after the event"),
            "outcome": _flags((), 0, OUTCOMES),
            "forcing_period": _variable((), 2.0, "forcing period"),
        },
        {
            "time": _variable("time", time, "model time"),
            "state": ("state", ["x", "v"], {"long_name": "state", "units": "1"}),
        },
        {"kind": "trajectory"},
    )


@pytest.fixture
def section():
    """Period two: the points (0, 1) and (1, -1), 20 times each; multipliers 0.5 +- 0.25i."""
    return xr.Dataset(
        {
            "section": _variable(
                ("iterate", "state"), np.tile([[0.0, 1.0], [1.0, -1.0]], (20, 1)), "state on the section"
            ),
            "period": _variable((), 2, "period found"),
            "multiplier_real": _variable("multiplier", [0.5, 0.5], "multiplier, real part"),
            "multiplier_imag": _variable("multiplier", [0.25, -0.25], "multiplier, imaginary part"),
            "outcome": _flags((), 1, OUTCOMES),
        },
        {"state": ["x", "v"]},
        {"kind": "poincare-section", "settings": '{"at": "strobe"}'},
    )


@pytest.fixture
def spectrum():
    """Exponents 0.015(1), -0.0879(2) and minus infinity."""
    time = 10.0 * np.arange(1, 101)
    history = np.stack([0.015 + 0.05 / time, -0.0879 - 0.1 / time, np.full(100, -np.inf)], axis=1)
    return xr.Dataset(
        {
            "lyapunov_exponent": _variable("exponent", [0.015, -0.0879, -np.inf], "Lyapunov exponent"),
            "lyapunov_error": _variable("exponent", [0.001, 0.0002, np.nan], "standard error"),
            "lyapunov_history": _variable(("block", "exponent"), history, "running mean"),
            "forcing_period": _variable((), 2.0, "forcing period"),
        },
        {"block_time": _variable("block", time, "model time at the block's end")},
        {"kind": "lyapunov-spectrum"},
    )


@pytest.fixture
def diagram():
    """Square-root branches over q from 0 to 1: period 1 below 0.5, 2 above; one point escaped, one exponent lost."""
    q = np.linspace(0, 1, 101)
    branch = np.sqrt(np.maximum(q - 0.5, 0))[:, None] * (-1.0) ** np.arange(8)
    section = np.stack([branch, 2 * branch], axis=-1)[:, None]
    exponents = np.stack([-np.abs(q - 0.5), np.full(101, -np.inf)], axis=-1)[:, None]
    period = np.where(q > 0.5, 2, 1)[:, None]
    outcome = np.ones((101, 1), dtype=int)
    section[70], exponents[70], period[70], outcome[70] = np.nan, np.nan, 0, 4
    return xr.Dataset(
        {
            "section": _variable(("q", "seed", "iterate", "state"), section, "state on the section"),
            "period": _variable(("q", "seed"), period.astype(np.int16), "period found"),
            "lyapunov_exponent": _variable(("q", "seed", "exponent"), exponents, "Lyapunov exponent"),
            "progression_rate": _variable(
                ("q", "seed"), np.where(outcome == 4, np.nan, q[:, None]), "mean progression rate"
            ),
            "outcome": _flags(("q", "seed"), outcome, OUTCOMES),
        },
        {"q": _variable("q", q, "load", "kN"), "state": ["x", "v"]},
        {"kind": "bifurcation-diagram"},
    )


def _system():
    """What the labels need of a system."""
    return SimpleNamespace(
        name="made up",
        parameters={"p": 1.0, "q": 0.5},
        start={"mode": "free", "x": 0.0, "v": 0.0, "w": 0.25},
        quadratures={},
        labels={"q": "load", "x": "height", "v": "speed"},
        modes={"free": {}},
        transitions=(),
    )


@pytest.fixture
def chart():
    """Over q (4 uneven values, not in order) and p (5 values), two seeds.

    Seed 1 has the period of its row of q: 1, 2, 12 and none (chaos); p = 4 escapes, and fails at q = 1. Seed 2 is as
    seed 1 where p is 0, and of period 3 elsewhere. The exponent is q - 0.6, and is lost at p = 3; the rate is p q.
    """
    q, p = np.array([0.0, 0.5, 1.0, 0.2]), np.arange(5.0)
    own = np.array([1, 12, 0, 2])
    period = np.full((4, 5, 2), 3)
    period[:, :, 0] = own[:, None]
    period[:, 0, 1] = own
    outcome = np.where(period > 0, Outcome.PERIODIC, Outcome.CHAOTIC)
    outcome[:, 4] = Outcome.ESCAPED
    outcome[2, 4] = Outcome.STALLED
    ended = outcome < Outcome.ESCAPED
    exponents = np.broadcast_to(q[:, None, None] - 0.6, period.shape).copy()
    exponents[:, 3] = -np.inf
    grid = ("q", "p", "seed")
    ds = xr.Dataset(
        {
            "period": (grid, np.where(ended, period, 0)),
            "outcome": (grid, outcome),
            "lyapunov_exponent": ((*grid, "exponent"), np.where(ended, exponents, np.nan)[..., None]),
            "progression_rate": (grid, np.where(ended, (q[:, None] * p)[..., None], np.nan)),
            "attractor_count": (("q", "p"), np.where(ended.any(axis=2), np.where(p == 0, 1, 2), 0)),
        },
        {"q": q, "p": p, "exponent": [1], "state": ["x", "v", "w"]},
    )
    return label(ds, "parameter-chart", system=_system(), settings={"sweep": {"q": q, "p": p}})


@pytest.fixture
def basin():
    """Over x and v from -1 to 1: attractor 1 of period 2 where x < 0, chaos where x > 0, escape where v is largest.

    Attractor 1 has the point (-0.5, 0.5) in the plane w = 0.25, attractor 2 one at w = 0.3, off the plane.
    """
    x = np.linspace(-1, 1, 40)
    reached = np.where(x < 0, 1, 2)[:, None] * (np.arange(20) < 19)
    fraction = np.array([(reached == 1).mean(), (reached == 2).mean()])
    ds = xr.Dataset(
        {
            "attractor": (("x", "v"), reached),
            "outcome": (("x", "v"), np.array([Outcome.ESCAPED, Outcome.PERIODIC, Outcome.CHAOTIC])[reached]),
            "attractor_period": ("attractor_number", [2, 0]),
            "attractor_outcome": ("attractor_number", [Outcome.PERIODIC, Outcome.CHAOTIC]),
            "attractor_exponent": (("attractor_number", "exponent"), [[-0.25, -np.inf], [0.0151, -0.1]]),
            "attractor_error": (("attractor_number", "exponent"), [[0.0, np.nan], [0.0004, 0.001]]),
            "attractor_state": (("attractor_number", "state"), [[-0.5, 0.5, 0.25], [0.5, 0.5, 0.3]]),
            "fraction": ("attractor_number", fraction),
            "fraction_error": ("attractor_number", np.sqrt(fraction * (1 - fraction) / reached.size)),
        },
        {
            "x": x,
            "v": np.linspace(-1, 1, 20),
            "attractor_number": [1, 2],
            "exponent": [1, 2],
            "state": ["x", "v", "w"],
        },
    )
    return label(ds, "basins", system=_system(), settings={"grid": {"x": None, "v": None}})


@pytest.fixture
def runs(ball):
    """The ball, and another of twice the height and speed whose last four events are missing."""
    other = ball.isel(event=slice(6)).copy()
    for name in ("states", "event_state_before", "event_state_after"):
        other[name] = 2 * other[name]
    return {"low": ball, "high": other}


@pytest.fixture
def joined(runs):
    return cd.join(runs)
