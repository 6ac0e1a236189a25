"""Systems of Python functions, against closed forms, derivatives of many digits, and the same systems as text."""

import ctypes
import math
import pickle
import subprocess
import sys
from collections import namedtuple
from math import pi
from types import ModuleType

import mpmath
import numpy as np
import pytest
from numba import carray, cfunc, njit, types

import chaosdrill as cd
from chaosdrill import ChaosdrillError
from chaosdrill.codegen import kernels_of, python
from chaosdrill.model.python import Source, _content
from tests.support.closed_autonomous import belt

METHOD = {"method": "dop853"}
EDGES = np.linspace(0, 1, 9)


def oscillator(t, x, p):
    return x.v, -x.x + math.cos(p.omega * t)


def wall(t, x, p):
    return x.x


def bounce(t, x, p):
    return x.x, -p.r * x.v


def impact(**changes):
    given = {
        "states": "x v",
        "modes": {"free": oscillator},
        "transitions": [cd.Transition("impact", "free", "free", wall, +1, reset=bounce)],
        "parameters": {"omega": 2.8, "r": 0.8},
        "period": "2*pi/omega",
        "initial": {"x": -0.1, "v": 0.3},
    }
    return cd.HybridSystem(**{**given, **changes})


def closed_multipliers(w, r):
    c = math.cos(2 * pi / w)
    trace = -2 * r * c + (1 + r) ** 2 * (1 - w * w) * (1 + c) / 2
    return np.sort(np.roots([1, -trace, r * r]))


def test_an_orbit_has_the_multipliers_of_the_closed_form():
    orbit = cd.periodic_orbit(impact(), **METHOD)
    np.testing.assert_allclose(np.sort(orbit["multiplier_real"]), closed_multipliers(2.8, 0.8), rtol=1e-9)
    assert orbit.attrs["disagreement"] == ""


def test_a_branch_doubles_its_period_where_the_closed_form_does():
    branch = cd.continue_orbit(impact(), {"omega": (2.6, 2.85)}, **METHOD)
    special = branch["special_point"].values > 0
    np.testing.assert_allclose(branch["omega"].values[special], [2.65334772785532], rtol=1e-9)


POINTER = types.CPointer(types.float64)
NUMBER = types.float64(types.float64, POINTER, POINTER)


def test_cfuncs_are_taken_by_their_code():
    """They give one number each; derivatives are those of the closed form, of a guard that is one, too."""

    @cfunc(NUMBER)
    def acceleration(t, x, p):
        state = carray(x, (2,))
        return -state[0] + math.cos(p[0] * t)

    @cfunc(NUMBER)
    def rebound(t, x, p):
        return -p[1] * x[1]

    stop = cd.Transition("impact", "free", "free", cfunc(NUMBER)(lambda t, x, p: x[0]), +1, reset={"v": rebound})
    system = impact(modes={"free": {"x": "v", "v": acceleration}}, transitions=[stop])
    orbit = cd.periodic_orbit(system, **METHOD)
    np.testing.assert_allclose(np.sort(orbit["multiplier_real"]), closed_multipliers(2.8, 0.8), rtol=1e-9)
    assert pickle.loads(pickle.dumps(system)).sources == system.sources


def test_a_smooth_flow_contracts_as_its_divergence_says():
    def lorenz(t, x, p):
        a, b, c = x
        return p.sigma * (b - a), a * (p.rho - c) - b, a * b - p.beta * c

    parameters = {"sigma": 10.0, "rho": 28.0, "beta": 8 / 3}
    start = {"x": 1.0, "y": 1.0, "z": 20.0}
    system = cd.HybridSystem(states="x y z", modes={"flow": lorenz}, parameters=parameters, initial=start)
    assert system.time is None
    spectrum = cd.lyapunov_spectrum(system, transient=20.0, duration=400.0, **METHOD)
    found, error = spectrum["lyapunov_exponent"].values, spectrum["lyapunov_error"].values
    assert found.sum() == pytest.approx(-(10 + 1 + 8 / 3), abs=1e-9)
    assert abs(found[0] - 0.9056) < 4 * error[0]
    assert abs(found[1]) < 4 * error[1] + 1e-3


def test_sticking_costs_a_direction():
    def slide(t, x, p):
        return x.v, p.F_k - x.x

    system = cd.HybridSystem(
        states="x v",
        parameters={"belt": 0.2, "F_s": 1.0, "F_k": 0.5},
        modes={"stick": {"x": "belt", "v": "0"}, "slip": slide},
        transitions=[
            cd.Transition("release", "stick", "slip", "x - F_s", +1),
            cd.Transition("stick", "slip", "stick", "v - belt", +1, reset=lambda t, x, p: (x.x, p.belt)),
        ],
        initial={"mode": "stick", "v": 0.2},
    )
    spectrum = cd.lyapunov_spectrum(system, transient=20.0, duration=200.0, **METHOD)
    assert spectrum["lyapunov_exponent"].values[1] == -np.inf
    assert abs(spectrum["lyapunov_exponent"].values[0]) < 1e-2
    run = cd.trajectory(system, transient=20.0, duration=40.0, **METHOD)
    releases = run["event_time"].values[run["event_kind"].values == 0]
    np.testing.assert_allclose(np.diff(releases), belt(0.2, 1.0, 0.5).period, rtol=1e-10)


def test_a_neuron_fires_at_its_rate():
    # v' = i - v from 0 to 1 takes ln(i/(i - 1))
    system = cd.HybridSystem(
        states="v",
        parameters={"i": 1.5},
        modes={"rest": lambda t, x, p: (p.i - x.v,)},
        transitions=[
            cd.Transition("spike", "rest", "rest", "v - 1", +1, reset=lambda t, x, p: (0.0,)),
        ],
    )
    times = cd.trajectory(system, duration=20.0, **METHOD)["event_time"].values
    np.testing.assert_allclose(times, math.log(3) * np.arange(1, len(times) + 1), rtol=1e-11)
    assert len(times) == 18


def test_rebounds_are_completed():
    # floor, restitution 1/2, thrown up at 1 with gravity 1: the bounces end at t = 4 (numerics: 2 v0/g /(1 - e))
    def floor(t, x, p):
        return x.x

    system = cd.HybridSystem(
        states="x v",
        modes={"flight": {"x": "v", "v": "-1"}, "rest": {"x": "0", "v": "0"}},
        transitions=[
            cd.Transition("bounce", "flight", "flight", floor, -1, reset={"v": lambda t, x, p: -x.v / 2}),
            cd.Transition("stop", "flight", "rest", floor, -1, reset={"x": 0, "v": 0}, completes="bounce"),
        ],
        initial={"v": 1.0},
    )
    run = cd.trajectory(system, duration=5.0, **METHOD)
    assert run["event_kind"].values[-1] == 1
    assert run["event_time"].values[-1] == pytest.approx(4, abs=1e-6)
    assert not run["states"].values[-1].any()


@njit
def spline(u, edges, c):
    k = np.searchsorted(edges, u, "right") - 1
    s = u - edges[k]
    return ((c[0, k] * s + c[1, k]) * s + c[2, k]) * s + c[3, k]


def test_a_table_drives_as_driven_does():
    from scipy.interpolate import CubicSpline

    heights = np.array([0.0, 1.0, 0.4, -0.7, -1.2, 0.1, 0.9, -0.3])
    made = np.ascontiguousarray(CubicSpline(EDGES, [*heights, heights[0]], bc_type="periodic").c)

    def driven(t, x, p):
        return x.v, -x.x - 2 * p.zeta * x.v + spline((p.omega * t / (2 * pi)) % 1.0, EDGES, made)

    numbers = {"zeta": 0.05, "omega": 0.8}
    given = {"states": "x v", "period": "2*pi/omega", "initial": {"v": 0.3}}
    system = cd.HybridSystem(modes={"free": driven}, parameters=numbers, **given)
    text = cd.HybridSystem(
        modes={"free": {"x": "v", "v": "-x - 2*zeta*v + f"}}, parameters={**numbers, "f": 0.0}, **given
    )
    runs = [
        cd.trajectory(s, periods=5, **METHOD)["states"].values[-1]
        for s in (system, cd.driven(text, "f", table=heights))
    ]
    np.testing.assert_allclose(*runs, rtol=0, atol=1e-9)


def smooth(t, x, p):
    total = 0.0
    for k in range(1, 4):
        total += math.sin(k * x.x) * np.exp(-x.y) / (1 + x.x**2)
    total -= np.log(x.y) * math.atan2(x.x, x.y) + math.hypot(x.x, t) ** p.n
    return total if x.x > 0 else math.sqrt(x.y) * np.tanh(x.x * t)


def exact(t, x, y, n):
    if x <= 0:
        return mpmath.sqrt(y) * mpmath.tanh(x * t)
    total = sum(mpmath.sin(k * x) * mpmath.exp(-y) / (1 + x**2) for k in range(1, 4))
    return total - mpmath.log(y) * mpmath.atan2(x, y) + -(mpmath.hypot(x, t) ** n)


def marked():
    return cd.HybridSystem(
        states="x y",
        parameters={"n": 2.3},
        modes={"free": {"x": "1", "y": "0"}},
        transitions=[cd.Transition("mark", "free", "free", smooth, +1)],
    )


@pytest.fixture(scope="module")
def one_guard():
    system = marked()
    kernels_of(system)
    return next(iter(system.sources.values()))


POINTS = [(0.3, 0.7, 1.3, 2.3), (1.1, -0.4, 0.6, 2.3), (0.2, 2.9, 0.05, 1.7)]


@pytest.mark.parametrize("point", POINTS)
def test_derivatives_are_exact(one_guard, point):
    with mpmath.workdps(50):
        for k in range(4):
            order = tuple(int(i == k) for i in range(4))
            expected = float(mpmath.diff(exact, point, order))
            assert python.evaluate(one_guard.digest, 0, (k,), *point) == pytest.approx(expected, rel=1e-13, abs=1e-14)
            for j in range(k, 4):
                order = tuple(int(i == k) + int(i == j) for i in range(4))
                expected = float(mpmath.diff(exact, point, order))
                found = python.evaluate(one_guard.digest, 0, (k, j), *point)
                assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_rounding_stays_within_its_bound_and_comes_near_it():
    kernels = kernels_of(marked())
    rng, parts = np.random.default_rng(3), []
    for _ in range(200):
        t, x, y = rng.uniform(0.1, 3), rng.uniform(-2, 4), rng.uniform(0.02, 3)
        value = kernels.functions.guard(0, 0, t, np.array([2.3]), np.array([x, y]), np.empty(3))
        bound = kernels.functions.guard_error(0, 0, t, np.array([2.3]), np.array([x, y]), np.zeros(2))
        with mpmath.workdps(40):
            parts.append(float(abs(value - exact(t, x, y, 2.3))) / (bound * 2.0**-53))
    assert max(parts) < 1
    assert max(parts) > 0.02


def test_names_and_their_order_change_no_bit():
    def field(t, x, p):
        return x[1], -x[0] + math.cos(p[1] * t) - p[0] * x[1] ** 3

    def run(states, names):
        system = cd.HybridSystem(
            states=states,
            modes={names[2]: field},
            parameters={names[0]: 0.1, names[1]: 2.5},
            period=f"2*pi/`{names[1]}`",
        )
        return cd.lyapunov_spectrum(system, transient=5, periods=20, **METHOD)["lyapunov_exponent"].values

    one = run(["x", "v"], ["zeta", "omega", "free"])
    assert run(["lambda", "a b"], ["class", "_", "mode; import os"]).tobytes() == one.tobytes()


def test_workers_and_another_process_give_the_same_bits():
    system = impact()
    values = {"omega": np.linspace(2.66, 2.9, 6)}
    one, two = (
        cd.bifurcation_diagram(system, values, transient=10, periods=20, workers=n, **METHOD)["section"].values
        for n in (1, 2)
    )
    assert one.tobytes() == two.tobytes()
    script = (
        "import pickle, sys, chaosdrill as cd\n"
        "d = cd.trajectory(pickle.load(sys.stdin.buffer), periods=9, method='dop853')\n"
        "sys.stdout.buffer.write(d['states'].values.tobytes())"
    )
    done = subprocess.run([sys.executable, "-c", script], input=pickle.dumps(system), capture_output=True, check=True)
    assert done.stdout == cd.trajectory(system, periods=9, **METHOD)["states"].values.tobytes()


def decay(rate):
    return cd.HybridSystem(states="x", modes={"one": lambda t, x, p: (-rate * x.x,)}, initial={"x": 1.0})


def test_what_a_function_reads_is_that_of_its_definition():
    def end(system):
        return float(cd.trajectory(system, duration=1.0, **METHOD)["states"].values[-1, 0])

    one, two = decay(1.0), decay(2.0)
    assert [end(one), end(two)] == pytest.approx([math.exp(-1), math.exp(-2)], rel=1e-11)
    assert kernels_of(decay(2.0)) is kernels_of(two)
    table = np.array([3.0])
    late = cd.HybridSystem(states="x", modes={"one": lambda t, x, p: (-table[0] * x.x,)})
    table[0] = 4.0
    with pytest.raises(ChaosdrillError, match="have changed since the system was defined; define the system again"):
        cd.trajectory(late, duration=1.0, **METHOD)


def rate_by(table):
    return cd.HybridSystem(states="x", modes={"one": lambda t, x, p: (-table.rate * x.x,)}, initial={"x": 1.0})


def test_constants_by_name_are_told_apart_by_their_names():
    one, two = (rate_by(namedtuple("table", names)(1.0, 2.0)) for names in ("rate other", "other rate"))
    assert one.modes != two.modes
    assert one.modes == rate_by(namedtuple("table", "rate other")(1.0, 2.0)).modes


def test_an_attribute_of_a_module_is_that_of_the_definition():
    module = ModuleType("settings_of_a_user")
    module.rate = 1.0
    one = rate_by(module)
    module.rate = 2.0
    assert rate_by(module).modes != one.modes
    with pytest.raises(ChaosdrillError, match="have changed since the system was defined"):
        cd.trajectory(one, duration=1.0, **METHOD)


def test_what_a_function_of_a_module_reads_in_it_is_content():
    module = ModuleType("settings_of_a_user")
    module.itself, module.rate = module, 1.0
    exec("def speed(x): return itself.rate*x", vars(module))
    one = Source(lambda t, x, p: module.speed(x.x), ["x"], [], 0)
    module.rate = 2.0
    assert not one.is_what_it_was()


def test_each_of_modules_that_refer_to_each_other_is_read_once():
    modules = [ModuleType(f"part_{i}_of_a_user") for i in range(7)]
    for module in modules:
        vars(module).update({other.__name__: other for other in modules}, rate=1.0)
    told = " + ".join(f"part_0_of_a_user.{module.__name__}.rate" for module in modules)
    function = eval(f"lambda t, x, p: {told}", vars(modules[0]))
    assert sum("float" in part for part in _content(function, [])) == len(modules)


def test_a_name_of_the_module_that_is_a_parameter_too_is_not_read(monkeypatch):
    system = impact()
    monkeypatch.setitem(globals(), "omega", 1.0)
    assert all(source.is_what_it_was() for source in system.sources.values())
    assert impact().sources == system.sources


def test_an_exception_ends_the_run():
    def fails(t, x, p):
        if x.x < 0.5:
            raise ValueError("no")
        return (-x.x,)

    run = cd.trajectory(cd.HybridSystem(states="x", modes={"one": fails}, initial={"x": 1.0}), duration=2.0, **METHOD)
    assert run.cd.outcome != "ok"
    assert 0.5 <= run["states"].values.min() < 0.51


def test_an_archive_says_that_it_cannot_be_run_again(tmp_path):
    system = decay(1.0)
    run = cd.trajectory(system, duration=1.0, **METHOD)
    (source,) = system.sources.values()
    assert run.attrs["derivatives"].startswith("of Python functions by dual numbers")
    assert f"modes.one is the Python function '<lambda>', content {source.digest}" in run.attrs["definition_missing"]
    assert "definition" not in run.attrs
    cd.save(run, tmp_path / "run.nc")
    with pytest.raises(ChaosdrillError, match=r"nothing in it can be computed again:(.|\n)*no text can hold Python"):
        cd.verify(tmp_path / "run.nc")
    with pytest.raises(ChaosdrillError, match=r"no text can hold Python functions: modes\.one"):
        cd.save_scene(tmp_path / "scene.toml", system, {})


def test_a_page_and_a_notebook_show_the_call():
    assert r"\operatorname{oscillator}_{1}\left(t, x, v, \omega, r\right)" in impact()._repr_latex_()
    assert "oscillator" in impact()._repr_html_()


def array(t, x, p):
    made = np.zeros(2)
    made[0] = x.v
    return made[0], 0.0


def fill(t, x, p, out):
    out[0], out[1] = x[1], -x[0]


REFUSED = {
    "takes .*; it must be f": lambda: impact(modes={"free": lambda t, x: x}),
    "expected a table of names": lambda: impact(modes={"free": print}),
    r"period: names .*made of parameters": lambda: impact(period=lambda t, x, p: 1.0),
    "name the time, as in time": lambda: cd.HybridSystem(states="t", modes={"one": lambda t, x, p: (t,)}),
    "expected an expression": lambda: cd.driven(impact(), "r", {0: wall}),
    r"method is 'taylor', .* 'oscillator' at modes.free; pass method='dop853' or 'radau' or 'rk4'": lambda: (
        cd.trajectory(impact(), periods=1)
    ),
    "can be called, but numba cannot read its code.*numba.cfunc": lambda: impact(
        modes={"free": {"x": "v", "v": ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(math.sin)}}
    ),
    r"takes \(t, x, p, out\); it must be f": lambda: impact(
        modes={"free": cfunc(types.void(types.float64, POINTER, POINTER, POINTER))(fill)}
    ),
    "for which no reference with more digits": lambda: cd.work_precision(impact(), periods=1),
    "returns 3 numbers; it must return 2": lambda: kernels_of(impact(modes={"free": lambda t, x, p: (x.v, 0.0, 0.0)})),
    "it must return a tuple of 2 numbers": lambda: kernels_of(impact(modes={"free": lambda t, x, p: x.v})),
    "Unknown attribute 'k'": lambda: kernels_of(impact(modes={"free": lambda t, x, p: (p.k, 0.0)})),
    "but not for the dual numbers": lambda: kernels_of(impact(modes={"free": array})),
}


@pytest.mark.parametrize("told", REFUSED)
def test_what_cannot_be_is_told(told):
    with pytest.raises(ChaosdrillError, match=told):
        REFUSED[told]()
