"""Tangents of arcs and across events, against differences, closed forms and the direction of the flow."""

import mpmath
import numpy as np
import pytest
import sympy
from scipy.linalg import expm

import chaosdrill as cd
from chaosdrill import systems
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.kinds import float64, int64, void
from chaosdrill.codegen.signatures import event_places, matrix, vector
from chaosdrill.dataset import Outcome
from chaosdrill.declared import METHODS
from chaosdrill.engine import events, passages
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.run import Run
from chaosdrill.engine.structure import examine
from chaosdrill.model.special import positive_power

X, Y, Z, T, K, CLOCK, V, B = sympy.symbols("x y z t k s v b", real=True)
ENTRIES = sympy.symbols("a0:9", real=True)


# Tangents of smooth arcs against two trajectories, and against solutions in closed form.


MATRIX = np.array([[-0.2, 1.1, 0.0], [-1.0, -0.3, 0.4], [0.5, 0.0, -0.7]])


@pytest.fixture(scope="module")
def system():
    linear = sympy.Matrix(MATRIX.tolist()) * sympy.Matrix([X, Y, Z])
    return cd.HybridSystem(
        name="smooth",
        states=(X, Y, Z),
        time=T,
        parameters={"k": 1.3},
        modes={
            "linear": dict(zip((X, Y, Z), linear, strict=True)),
            "curved": {X: Y, Y: -sympy.sin(X) + sympy.exp(-(Z**2)) * sympy.cos(K * T), Z: X / (1 + Y**2) - Z},
        },
        period=2 * sympy.pi / K,
        initial={X: 0.4, Y: -0.3, Z: 0.2},
    )


def run_of(system, mode, length=3.0, method="taylor", tangents=None, **initial):
    run = Run(
        system.with_initial(mode=mode, **initial),
        length,
        Numerics(method, 1e-14, 3000 if method == "rk4" else None),
        tangents=tangents,
        orthonormalise=False,
    )
    assert run.advance(1)[0] == cd.Outcome.OK
    return run


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("method", METHODS)
def test_a_linear_flow_is_its_matrix_exponential(system, method, count):
    tangents = np.array([[1.0, 0, 0], [0.3, -0.5, 2.0], [0, 0, 1.0]])[:count]
    found = run_of(system, "linear", method=method, tangents=tangents)
    expected = tangents @ expm(3 * MATRIX).T
    np.testing.assert_allclose(found.vectors, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_a_curved_flow_against_two_trajectories(system, method):
    here = run_of(system, "curved", method=method, tangents=np.eye(3))
    for j, name in enumerate(system.state_names):
        differences = []
        for h in (2e-3, 1e-3):
            ahead, behind = (
                run_of(system, "curved", method=method, **{name: system.initial[name] + s * h}).x for s in (1, -1)
            )
            differences.append((ahead - behind) / (2 * h))
        np.testing.assert_allclose(here.vectors[j], (4 * differences[1] - differences[0]) / 3, rtol=0, atol=1e-10)


def test_logarithms_of_orthonormalised_tangents_add_up_to_the_determinant(system):
    """Liouville: the sum of the logarithms is the trace times the time, for a linear flow."""
    run = Run(system.with_initial(mode="linear"), 3.0, Numerics(tolerance=1e-14), tangents=np.eye(3))
    run.advance(50)
    assert run.logs.sum() == pytest.approx(np.trace(MATRIX) * 150, rel=1e-12)
    np.testing.assert_allclose(run.vectors @ run.vectors.T, np.eye(3), atol=1e-14)


def test_exponents_of_a_linear_flow_are_real_parts_of_eigenvalues(system):
    run = Run(system.with_initial(mode="linear"), 3.0, Numerics(tolerance=1e-14), tangents=np.eye(3))
    run.advance(2000)
    expected = np.sort(np.linalg.eigvals(MATRIX).real)[::-1]
    np.testing.assert_allclose(run.logs / 6000, expected, atol=1e-3)


@pytest.mark.parametrize("time", [True, False])
def test_sensitivity_to_a_frequency(system, time):
    """The tangent along a parameter that became a state, against two runs at two values."""
    wide = system.augmented(time=time, parameters=["k"])
    unit = np.eye(len(wide.states))[-1:]
    run = Run(wide.with_initial(mode="curved"), 3.0, Numerics(tolerance=1e-14), tangents=unit, orthonormalise=False)
    run.advance(1)
    ends = [run_of(system.with_parameters(k=1.3 + s * 1e-4), "curved").x for s in (1, -1)]
    np.testing.assert_allclose(run.vectors[0, :3], (ends[0] - ends[1]) / 2e-4, rtol=0, atol=1e-7)
    assert run.vectors[0, -1] == 1.0


# Tangents across each kind of event of each system, against finite differences of the flow.
#
# Random starts are kept if, within a short time, exactly one event happens and it is the one asked for; the differences
# share the trajectory with the tangents, but nothing of the variational equation or of the saltation.


PROBED = (
    *("percussive-drill", "percussive-drill-5d", "impact-oscillator", "bouncing-ball", "belt-stick-slip", "den-hartog"),
    *("rimless-wheel", "chua", "tilted-switch", "saddle-reset", "andronov-clock", "izhikevich", "compass-gait"),
)
"""Systems whose events random states of unit size lead to; all others have whole runs among the known answers."""
EVENTS = [
    pytest.param(name, t.name, source, id=f"{name}: {t.name} from {source}")
    for name in PROBED
    for t in systems.build(name).transitions
    for source in t.source
]

NUMERICS = Numerics(tolerance=1e-15)

LENGTH = 0.1

CHANGES = {
    ("bouncing-ball", "rest"): {"e": 0.0},
    ("bouncing-ball", "lift-off"): {"amplitude": 1.3},
    ("percussive-drill", "hold-stick"): {"r": 0.3, "k": 1e-3},
    ("percussive-drill", "hold-slip"): {"r": 0.3, "k": 1e-3},
    ("percussive-drill", "part-stick"): {"r": 0.7},
    ("percussive-drill", "part-slip"): {"r": 0.7},
    ("percussive-drill", "release-held"): {"r": 0.3, "a": 0.5},
    ("percussive-drill", "stick-held"): {"r": 0.3},
}
"""Parameters at which an event happens to states that differ by a finite step."""

SPEED = 0.05
"""Smallest normal speed that finite differences can do with."""


@pytest.fixture(scope="module")
def augmented():
    known = {}

    def get(name, event):
        if name not in known:
            known[name] = systems.build(name).augmented(time=True)
        changes = CHANGES.get((name, event), {})
        # at a stop of 1 friction gives way before every hit, and a stiff contact holds only the slowest
        if name.startswith("percussive") and event.endswith("hit"):
            changes = {"r": 0.5, "k": 4.0}
        return known[name].with_parameters(**changes)

    return get


def moved(system, mode, x, length, tangents=None):
    """State, tangents and the one event of a run, None if it is another number of events."""
    start = system.with_initial(mode=mode, **dict(zip(system.state_names, x, strict=True)))
    run = Run(start, length, NUMERICS, tangents=tangents, orthonormalise=False)
    outcome, _ = run.advance(1)
    if outcome != Outcome.OK or run.counts.sum() != 1:
        return None
    return run.x, run.vectors, int(np.argmax(run.counts)), run.grazing.min()


def held(system, source):
    """States that a mode holds: they have no freedom there, so no tangent."""
    names = ("y", "u", "w") if source.endswith("-held") else ("w", "x4", "v")
    return [i for i, s in enumerate(system.states) if system.modes[source][s] == 0 and s.name in names]


FLOOR = "amplitude*sin(omega*t)", "amplitude*omega*cos(omega*t)"
SURFACES = {
    ("percussive-drill", "slip-held"): ["u - w"],
    ("bouncing-ball", "contact"): [f"x - {FLOOR[0]}", f"v - {FLOOR[1]}"],
}
"""Combinations of states, time among them, that a mode holds."""


def directions(name, system, source, x):
    """What a mode leaves of the directions of the states, one a row, at a state."""
    left = np.eye(len(x))
    left[held(system, source)] = 0.0
    symbols = {str(s): s for s in system.states}
    rows = [sympy.sympify(text, locals=symbols) for text in SURFACES.get((name, source), [])]
    if not rows:
        return left
    values = {**dict(zip(system.states, x, strict=True)), **system.parameters}
    gradients = [[float(sympy.diff(row, s).subs(values)) for s in system.states] for row in rows]
    normals = np.linalg.qr((np.array(gradients) @ left).T)[0].T
    return left - left @ normals.T @ normals


def candidates(system, source, event):
    """Random states near the guard, on the side from which it is reached."""
    rng = np.random.default_rng(5)
    kernels = kernels_of(system)
    mode = system.mode_names.index(source)
    index = [t.name for t in system.transitions].index(event)
    j = next(k for k, e in enumerate(kernels.layout.events[mode]) if index in e.outcomes)
    c, n = kernels.constants(system.parameters), len(system.states)
    gradient, rate = np.empty(n + 1), np.empty(n + len(system.quadratures))
    for _ in range(4000):
        x = rng.normal(size=n) * 10.0 ** rng.uniform(-3.5, 0.3)
        for i in held(system, source):
            x[i] = system.parameters.get("belt", 0.0)
        for _ in range(30):
            value = kernels.functions.guard(mode, j, 0.0, c, x, gradient)
            x -= value * gradient[:n] / (gradient[:n] @ gradient[:n])
        kernels.functions.field(mode, 0.0, c, x, rate)
        yield x - 0.05 * rate[:n]


@pytest.mark.parametrize(("name", "event", "source"), EVENTS)
def test_tangents_are_the_derivative_of_the_flow(augmented, name, event, source):
    system = augmented(name, event)
    index = [t.name for t in system.transitions].index(event)
    n = len(system.states)
    checked = 0
    for x in candidates(system, source, event):
        result = moved(system, source, x, LENGTH, np.eye(n))
        if result is None or result[2] != index or result[3] < SPEED or not np.abs(x).max() < 20:
            continue
        columns = []
        free = [j for j in range(n) if j not in held(system, source)]
        left = directions(name, system, source, x)
        for j in free:
            found = [moved(system, source, x + s * h * left[j], LENGTH) for h in (2e-4, 1e-4) for s in (1, -1)]
            if any(f is None or f[2] != index for f in found):
                break
            coarse, fine = (found[0][0] - found[1][0]) / 4e-4, (found[2][0] - found[3][0]) / 2e-4
            columns.append((4 * fine - coarse) / 3)
        if len(columns) < len(free):
            continue
        expected, tangents = np.array(columns), result[1][free]
        scale = max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(tangents, expected, rtol=0, atol=2e-7 * scale)
        assert not np.any(result[1][held(system, source)])
        checked += 1
        if checked == 2:
            return
    assert checked > 0, "no start leads through this event alone"


# Xi F- = F+ at every event of every system, by the engine's own saltation, at random states on the guards.
#
# Systems are augmented with time, where the identity is exact; states are drawn and put on the guard.


@compiled(float64(vector, int64))
def normal_speed(event, n):
    return passages.normal_speed(event, n)


@compiled(void(vector, vector))
def saltation_jump(event, out):
    events.saltation_jump(event, out)


@compiled(float64(matrix, int64, vector, float64, vector, vector, vector))
def saltate(vectors, live, event, speed, sooner, jump, image):
    return events.saltate(vectors, live, event, speed, False, sooner, jump, image)


DIRECTION_CHANGES = {"bouncing-ball": {"amplitude": 1.3}, "percussive-drill": {"r": 0.5, "a": 0.5}}
"""Parameters at which every event of a system happens."""


def put_on_guard(guard, mode, j, c, x, gradient):
    for _ in range(60):
        value = guard(mode, j, 0.0, c, x, gradient)
        square = gradient[:-1] @ gradient[:-1]
        if not np.isfinite(value) or square == 0:
            return False
        if abs(value) <= 1e-15 * (1 + np.abs(x).max()):
            return True
        x -= value * gradient[:-1] / square
    return abs(value) < 1e-13


def passage(system, mode, j, x):
    """The event at a guard near a state, and its speed; None where the guard or the event is not to be had."""
    kernels, n = kernels_of(system), len(system.states)
    c, event = kernels.constants(system.parameters), np.zeros(event_places(n).size)
    if not put_on_guard(kernels.functions.guard, mode, j, c, x, np.empty(n + 1)):
        return None
    taken = kernels.functions.event_map(mode, j, 0.0, c, x, 1, np.ones(n), 0.0, event)
    assert taken < 0 or taken in kernels.layout.events[mode][j].outcomes
    if taken < 0 or system.transitions[taken].marks_only() or not np.isfinite(event).all():
        return None
    speed = normal_speed(event, n)
    return (event, speed) if abs(speed) > 1e-6 else None


@pytest.mark.parametrize("name", sorted(systems.REGISTRY))
def test_the_flow_goes_over_into_the_flow(name):
    system = systems.build(name, DIRECTION_CHANGES.get(name)).augmented(time=True)
    n = len(system.states)
    places = event_places(n)
    watched = kernels_of(system).layout.events
    for mode, j in ((mode, j) for mode, guards in enumerate(watched) for j in range(len(guards))):
        rng, met = np.random.default_rng([mode, j]), 0
        for size in 25 * [1e-3, 0.1, 1.0, 3.0]:
            if met == 10 or not (found := passage(system, mode, j, rng.normal(size=n) * size)):
                continue
            met += 1
            event, speed = found
            jump = np.empty(n)
            saltation_jump(event, jump)
            before = event[places.before : places.after]
            after = event[places.after : places.image]
            vectors = before[np.newaxis].copy()
            largest = saltate(vectors, 1, event, speed, np.empty(1), jump, np.empty(n))
            slopes = event[places.jacobian :].reshape(n, n + 1)[:, :n]
            # the jump carries the round-off of everything that was added up for it
            scale = max(np.abs(after).max(), (np.abs(slopes) @ np.abs(before)).max(), 1e-3)
            np.testing.assert_allclose(vectors[0], after, rtol=0, atol=1e-10 * scale)
            assert largest == np.abs(vectors[0]).max()
        assert met, (system.mode_names[mode], j)


# The rank of the tangents is that of the product of the resets, whatever the resets are.
#
# One system, x := A x every time unit, with the nine entries of A for parameters.


STATES = sympy.symbols("x y z", real=True)


@pytest.fixture(scope="module")
def mapped():
    matrix = sympy.Matrix(3, 3, ENTRIES)
    image = matrix * sympy.Matrix(STATES)
    system = cd.HybridSystem(
        name="map",
        states=(*STATES, CLOCK),
        parameters={e.name: 0.0 for e in ENTRIES},
        modes={"hold": {**dict.fromkeys(STATES, 0), CLOCK: 1}},
        transitions=[
            cd.Transition(
                "map",
                "hold",
                "hold",
                guard=CLOCK - 1,
                direction=+1,
                reset={**dict(zip(STATES, image, strict=True)), CLOCK: 0},
            )
        ],
        initial={CLOCK: 0.5, STATES[0]: 0.3, STATES[1]: -0.2, STATES[2]: 0.1},
    )
    return lambda a: system.with_parameters(**{e.name: v for e, v in zip(ENTRIES, np.ravel(a), strict=True)})


def turn(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


MATRICES = {
    "regular": np.array([[0.5, 0.2, 0], [0.1, 0.9, 0.3], [0, -0.4, 0.7]]),
    "projection": np.diag([0.9, 0.5, 0]),
    "nilpotent": np.array([[0, 1, 0], [0, 0, 1], [0, 0, 0.0]]),
    "nilpotent in two": np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0.5]]),
    "projection and rotation": turn(0.7) @ np.diag([1, 0, 0.8]),
    "rank one": np.outer([0.3, 0.5, 0.2], [1.0, 1.0, 1.0]),
    "zero": np.zeros((3, 3)),
    "permutation": np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0.0]]),
    "badly scaled and regular": np.diag([1e-3, 1.0, 0.5]),
}


@pytest.mark.parametrize("name", MATRICES)
def test_rank_and_exponents(mapped, name):
    """Moduli of the eigenvalues, and -inf for each that is zero; the clock has the exponent 0."""
    spectrum = cd.lyapunov_spectrum(mapped(MATRICES[name]), duration=400, transient=20)
    power = np.linalg.matrix_power(MATRICES[name], 3)
    rank = np.linalg.matrix_rank(power) + 1
    assert int(spectrum["rank"]) == rank
    with np.errstate(divide="ignore"):
        moduli = np.abs(np.linalg.eigvals(MATRICES[name]))
        expected = np.sort([0.0, *np.log(np.where(moduli < 1e-5, 0, moduli))])[::-1]
    found = spectrum["lyapunov_exponent"].values
    assert np.array_equal(np.isneginf(found), np.isneginf(expected))
    finite = np.isfinite(expected)
    # non-normal maps turn their basis for ever: the mean converges as 1/length
    np.testing.assert_allclose(found[finite], expected[finite], atol=5e-3)
    assert np.isnan(spectrum["lyapunov_error"].values[~finite]).all()


@pytest.mark.parametrize("name", MATRICES)
def test_only_resets_that_lose_rank_are_watched(mapped, name):
    lost = np.linalg.matrix_rank(MATRICES[name]) < 3
    assert examine(mapped(MATRICES[name])).deficient == (frozenset({0}) if lost else frozenset())


def test_a_branch_far_from_the_start_loses_rank():
    """What grows is cut to 100 at each tick of a clock, and its direction is gone as soon as that is reached."""
    axes = sympy.Matrix([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3
    u, v, w = axes * sympy.Matrix(STATES)
    rates = axes.T * sympy.Matrix([u / 2 + v / 9, -v / 3 + u / 7 - w, -w / 5 + v])
    cut = sympy.Matrix(STATES) - axes.T[:, 0] * (u - 100 + sympy.Abs(u - 100)) / 2
    reset = {**dict(zip(STATES, cut, strict=True)), CLOCK: 0}
    capped = cd.HybridSystem(
        states=(*STATES, CLOCK),
        modes={"run": {**dict(zip(STATES, rates, strict=True)), CLOCK: 1}},
        transitions=[cd.Transition("tick", "run", "run", CLOCK - 1, 1, reset=reset)],
        initial=dict(zip(STATES, (0.5, 0.3, 1.0), strict=True)),
    )
    spectrum = cd.lyapunov_spectrum(capped, duration=60, transient=0)
    assert int(spectrum["rank"]) == 3
    assert np.isneginf(spectrum["lyapunov_exponent"].values[-1])


def test_a_function_may_lose_rank_far_from_the_start():
    def cut(t, x, p):
        return x.x if x.x < 100.0 else 100.0

    tick = cd.Transition("tick", "run", "run", CLOCK - 1, 1, reset={X: cut, CLOCK: 0})
    capped = cd.HybridSystem(states=(X, CLOCK), modes={"run": {X: X, CLOCK: 1}}, transitions=[tick], initial={X: 1.0})
    assert examine(capped).deficient == frozenset({0})


def test_dimension_survives_minus_infinity(mapped):
    rest = mapped(np.diag([1.2, 0.9, 0])).with_initial(x=0.0)
    spectrum = cd.lyapunov_spectrum(rest, duration=200)
    # ln 1.2 + 0 + ln 0.9 > 0, and the lost direction adds nothing
    assert float(spectrum["kaplan_yorke_dimension"]) == 3.0


# Through a contact whose force is not analytic, state and tangents follow the tolerance at any stiffness.


START = ("-0.1", "1")

LOAD = 1


@pytest.fixture(scope="module")
def contact():
    """A mass pressed by a static load flies to x = 0, where it meets the force k x**(3/2), and leaves again."""
    return cd.HybridSystem(
        name="contact",
        states=(X, V),
        parameters={"k": 1e8, "b": LOAD},
        modes={
            "free": {X: V, V: B},
            "contact": {X: V, V: B - K * positive_power(X, sympy.Rational(3, 2))},
        },
        transitions=[
            cd.Transition("touch", "free", "contact", guard=X, direction=+1),
            cd.Transition("leave", "contact", "free", guard=X, direction=-1),
        ],
        initial={"mode": "free", X: float(START[0]), V: float(START[1])},
    )


def duration(k, v):
    """Time of the contact: both branches are the same, x = deepest (1 - u**2) takes the singularity away."""

    def square(x):
        return v * v + 2 * LOAD * x - mpmath.mpf("0.8") * k * x ** mpmath.mpf("2.5")

    def integrand(u):
        # near u = 0 the square is a difference of equals
        with mpmath.workdps(120):
            return 4 * u * deepest / mpmath.sqrt(square(deepest * (1 - u * u)))

    with mpmath.workdps(120):
        deepest = mpmath.findroot(square, (mpmath.mpf("1.25") * v * v / k) ** mpmath.mpf("0.4"))
    return mpmath.quad(integrand, [0, mpmath.mpf("0.5"), 1])


def closed_form(k):
    """Length of a run that ends after the contact, the state there, and the tangent map, one image a row.

    The energy is kept, so the mass leaves as fast as it came, and all that the contact does is to take its time.
    """
    with mpmath.workdps(30):
        h = mpmath.mpf(10) ** -8
        start = [mpmath.mpf(s) for s in START]

        def arrival(x, v):
            speed = mpmath.sqrt(v * v - 2 * LOAD * x)
            return speed, (speed - v) / LOAD

        speed, touch = arrival(*start)
        length = touch + duration(k, speed) + mpmath.mpf("0.05")

        def end(x, v):
            speed, touch = arrival(x, v)
            rest = length - touch - duration(k, speed)
            return [-speed * rest + LOAD * rest * rest / 2, -speed + LOAD * rest]

        rows = []
        for moved in ((h, 0), (0, h)):
            ahead = end(*(s + m for s, m in zip(start, moved, strict=True)))
            behind = end(*(s - m for s, m in zip(start, moved, strict=True)))
            rows.append([float((a - b) / (2 * h)) for a, b in zip(ahead, behind, strict=True)])
        return float(length), np.array(end(*start), dtype=float), np.array(rows)


@pytest.fixture(scope="module", params=[1e4, 1e8, 1e12])
def stiff(request, contact):
    """Stiffness, the system with it, and the solution."""
    return request.param, contact.with_parameters(k=request.param), closed_form(request.param)


def through(system, length, tolerance):
    run = Run(system, length, Numerics("dop853", tolerance), tangents=np.eye(2), orthonormalise=False)
    assert run.advance(1)[0] == cd.Outcome.OK
    assert list(run.counts) == [1, 1]
    return run


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10, 1e-12, 1e-14])
def test_the_state_follows_the_tolerance(stiff, tolerance):
    _, system, (length, state, _) = stiff
    np.testing.assert_allclose(through(system, length, tolerance).x, state, atol=0.05 * tolerance + 5e-15)


def test_the_tangent_map_is_that_of_the_closed_form(stiff):
    """In between the tangents grow to sqrt(k) of their length, and lose that many digits when they come back."""
    k, system, (length, _, rows) = stiff
    for tolerance in (1e-8, 1e-10, 1e-12):
        found = through(system, length, tolerance).vectors
        np.testing.assert_allclose(found, rows, atol=tolerance * k**0.5)
    assert k > 1e8 or np.abs(found - rows).max() < 1e-9


def test_the_flow_direction_comes_through(stiff):
    k, system, (length, _, _) = stiff
    run = through(system, length, 1e-12)
    before = np.array([float(START[1]), LOAD])
    np.testing.assert_allclose(before @ run.vectors, [run.x[1], LOAD], atol=1e-12 * k**0.5)
    assert np.linalg.det(run.vectors) == pytest.approx(1, abs=1e-12 * k**0.5)


def test_a_start_where_no_series_exists_costs_a_few_rejected_steps(stiff):
    """Sixteen evaluations a step at least; what is beyond are events, the first step of each phase, and rejections."""
    _, system, (length, _, _) = stiff
    run = through(system, length, 1e-10)
    rejected = (run.evaluations - 16 * run.steps) / 11
    assert rejected < 0.3 * run.steps


def test_a_tangent_without_a_number_ends_what_follows_tangents_where_it_comes():
    """A root at its branch point has no derivative; the states of a trajectory go on, and its outcome says so."""
    system = cd.HybridSystem(
        states="x y",
        parameters={},
        modes={"on": {"x": "1", "y": "0"}},
        transitions=[cd.Transition("meet", "on", "on", guard="x - 1", direction=1, reset={"y": "sqrt(x - 1)"})],
        initial={"x": 0.0, "y": 1.0},
    )
    told = "a tangent is infinite or not a number: in mode 'on', time 1, at x = 1, y = 0"
    spectrum = cd.lyapunov_spectrum(system, duration=50)
    assert (spectrum.cd.outcome, spectrum.attrs["message"]) == ("nonfinite", told)
    run = cd.trajectory(system, duration=3, tangents=True)
    assert (run.cd.outcome, run.attrs["message"]) == ("nonfinite", told)
    assert run["states"][-1, 0] == 3
    assert np.isnan(run["final_tangent"]).any()
