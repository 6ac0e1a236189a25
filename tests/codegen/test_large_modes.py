"""Large modes: their operations stand in tables, and what many states share is varied once."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill.codegen import kernels_of, mode
from chaosdrill.codegen.kernels import write
from chaosdrill.codegen.signatures import event_places
from chaosdrill.engine.layout import COLUMNS
from chaosdrill.model.derive import jacobian

K, T = sympy.symbols("k t", real=True)
ORDER = 23


def places(n):
    return sympy.symbols(f"x0:{n}", real=True)


def rotors(n):
    """Kuramoto's rotors, of which each sees the mean of all."""
    x = places(n)
    mean = [sum(f(angle) for angle in x) / n for f in (sympy.cos, sympy.sin)]
    rates = {a: sympy.Rational(i, n) + K * (mean[1] * sympy.cos(a) - mean[0] * sympy.sin(a)) for i, a in enumerate(x)}
    return cd.HybridSystem(name=f"{n} rotors", states=x, parameters={"k": 1.3}, modes={"on": rates})


def mean_field(n):
    """Bistable units that are drawn to their mean."""
    x = places(n)
    rates = {a: a - a**3 + K * (sum(x) / n - a) for a in x}
    return cd.HybridSystem(name=f"{n} units", states=x, parameters={"k": 0.7}, modes={"on": rates})


def advected(n):
    """Lorenz's model of 1996."""
    x = places(n)
    rates = {x[i]: (x[(i + 1) % n] - x[i - 2]) * x[i - 1] - x[i] + K for i in range(n)}
    return cd.HybridSystem(name=f"ring of {n}", states=x, parameters={"k": 8.0}, modes={"on": rates})


def chain(n):
    """Masses on springs in a load, of which the last hits a stop."""
    x, v = sympy.symbols(f"x0:{n}", real=True), sympy.symbols(f"v0:{n}", real=True)
    rates = dict(zip(x, v, strict=True))
    for i in range(n):
        pull = -(x[i] ** 3) - v[i] / 10 - (x[i] - x[i - 1] if i else x[i])
        rates[v[i]] = pull + (K * (x[i + 1] - x[i]) if i < n - 1 else sympy.cos(T) * sympy.exp(-x[i]))
    hit = cd.Transition("hit", "on", "on", guard=x[-1] - 1, direction=1, reset={v[-1]: -0.7 * v[-1]})
    return cd.HybridSystem(
        name=f"{n} masses", states=(*x, *v), time=T, parameters={"k": 1.1}, modes={"on": rates}, transitions=[hit]
    )


MAKERS = {"rotors": rotors, "mean field": mean_field, "advected": advected, "chain": chain}
SIZE = 20


@pytest.fixture(scope="module", params=MAKERS)
def both(request):
    """One system whose operations stand in tables, and the same in line."""
    found = []
    for limit in (-1, 10**6):
        with pytest.MonkeyPatch.context() as patched:
            tuned = replace(mode.TUNING, products_in_line=limit, sums_in_line=limit)
            patched.setattr(mode, "TUNING", tuned)
            system = MAKERS[request.param](SIZE)
            found.append((system, kernels_of(system)))
    return found


def numbers(n):
    rng = np.random.default_rng(5)
    return rng.uniform(0.2, 0.9, n), rng.normal(size=(2, n))


def test_series_and_tangents_are_those_of_code_in_line(both):
    result = []
    for system, kernels in both:
        n = len(system.states)
        x, d = numbers(n)
        c, ws = kernels.constants(system.parameters), np.zeros((kernels.layout.rows + 2 * n, COLUMNS))
        jet, jacobian_jet, tangent = kernels.functions[:3]
        jet(0, ORDER, 0.4, c, x, ws)
        jacobian_jet(0, ORDER, c, ws)
        tangent(0, ORDER, c, *d, ws, kernels.layout.rows)
        guards = sum(len(events) for events in kernels.layout.events)
        result.append((ws[: n + guards, : ORDER + 1], ws[kernels.layout.rows :, : ORDER + 1]))
    for made, reference in zip(*result, strict=True):
        scale = np.abs(reference).max(axis=0)
        assert np.abs(made - reference).max(axis=1) == pytest.approx(0, abs=1e-12 * scale.max())
        np.testing.assert_allclose(made / scale, reference / scale, atol=1e-12)


def test_rates_and_variations_are_those_of_the_expressions(both):
    system, kernels = both[0]
    n = len(system.states)
    x, d = numbers(n)
    values = {**dict(zip(system.states, x, strict=True)), K: system.parameters["k"], T: 0.4}
    c, out = kernels.constants(system.parameters), np.empty(n)
    names = list(values)
    rates = sympy.lambdify(names, [system.modes["on"][s] for s in system.states])(*values.values())
    kernels.functions.field(0, 0.4, c, x, out)
    np.testing.assert_allclose(out, np.array(rates, dtype=float), rtol=1e-13, atol=1e-14)
    matrix = np.array(sympy.lambdify(names, jacobian(system, "on").tolist())(*values.values()), dtype=float)
    for vector in d:
        kernels.functions.variation(0, 0.4, c, x, vector, out)
        np.testing.assert_allclose(out, matrix @ vector, rtol=1e-12, atol=1e-13)


def test_an_event_is_that_of_code_in_line():
    found = []
    for limit in (-1, 10**6):
        with pytest.MonkeyPatch.context() as patched:
            tuned = replace(mode.TUNING, products_in_line=limit, sums_in_line=limit)
            patched.setattr(mode, "TUNING", tuned)
            system = chain(SIZE)
            kernels = kernels_of(system)
        n = len(system.states)
        x, _ = numbers(n)
        x[SIZE - 1] = 1.0
        event = np.full(event_places(n).size, np.nan)
        assert (
            kernels.functions.event_map(0, 0, 0.4, kernels.constants(system.parameters), x, 1, np.ones(n), 1e-12, event)
            == 0
        )
        found.append(event)
    np.testing.assert_allclose(*found, rtol=1e-13, atol=1e-14)


def edges(system):
    (series,) = write(system.placed).modes
    return len(series.mode.linear) + len(series.mode.products)


@pytest.mark.parametrize("name", MAKERS)
def test_a_tangent_costs_in_proportion_to_the_operations(name):
    """The Jacobian of rotors that all see their mean is full; what a tangent takes is not."""
    assert edges(MAKERS[name](64)) <= 2.05 * edges(MAKERS[name](32))


@pytest.mark.parametrize("name", MAKERS)
def test_code_does_not_grow_with_the_system(name):
    """Tables do; instructions are as many."""

    def instructions(system):
        return sum(line.startswith("  ") for code in write(system.placed).single[:1] for line in code.text.splitlines())

    assert instructions(MAKERS[name](60)) == instructions(MAKERS[name](40))


def test_advection_is_two_products_a_state():
    """(x[i+1] - x[i-2]) x[i-1]: the difference is varied once, and not each of its parts in a product of its own."""
    (series,) = write(advected(40).placed).modes
    assert len(series.mode.kept) == 40
    assert len(series.mode.products) == 80


def test_products_with_states_that_stand_still_are_no_products_of_series():
    """As those of parameters that an orbit is derived by: a mode with many is written in line; x = exp(-rate t)."""
    still = sympy.symbols("p0:30", real=True)
    (x,) = sympy.symbols("x0:1", real=True)
    rate = sum(a * b for a, b in pairwise(still)) / (1 + still[0])
    system = cd.HybridSystem(
        name="led", states=(x, *still), modes={"on": {x: -rate * x, **dict.fromkeys(still, 0)}},
        initial={"x0": 1.0, **{p.name: 0.1 + 0.01 * i for i, p in enumerate(still)}},
    )  # fmt: skip
    assert write(system.placed).modes[0].mode.small
    found = cd.trajectory(system, duration=2.0, samples=5)
    exact = np.exp(-float(rate.subs({p: 0.1 + 0.01 * i for i, p in enumerate(still)})) * found["time"].values)
    np.testing.assert_allclose(found["states"].values[:, 0], exact, rtol=1e-12)
