"""Every model of the shelf runs every analysis that makes sense for it, by one definition and over one section."""

import warnings

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill import systems

SECTIONS = {
    "belt-stick-slip": "stick",
    "boost-converter": "clock",
    "buck-converter": "clock",
    "chua": "x > 0",
    "drill-string": "twist > 0",
    "percussive-drill-5d": "x1 > 0",
    "roessler": "y > 0",
    "tilted-switch": "return",
    "two-masses-on-belt": "v1 > 0",
}
"""Of models without forcing, where it is neither the first event nor, without events, the zero of the first state."""

LARGE = ("kuramoto", "lorenz-96")
"""Models of many states, which have known answers of their own."""

SOUND = {"ok", "periodic", "quasiperiodic", "chaotic", "undecided", "equilibrium", "no_orbit", "open", "transient"}
"""Outcomes that say what a motion does; the others say why it could not be followed."""

NAMES = [name for name in systems.REGISTRY if name not in LARGE]


@pytest.fixture(params=NAMES, scope="module")
def model(request):
    return systems.build(request.param)


@pytest.fixture
def section(model):
    first = model.transitions[0].name if model.transitions else f"{model.state_names[0]} > 0"
    return {} if model.period is not None else {"at": SECTIONS.get(model.name, first)}


@pytest.fixture(autouse=True)
def without_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def words(result):
    return set(np.atleast_1d(result.cd.outcome).ravel().tolist())


def ways(model, count):
    """Two values of each of this number of parameters."""
    values = list(model.parameters.items())[:count]
    return {name: [value, 1.001 * value if value else 1e-3] for name, value in values}


def test_trajectory_and_section_have_as_many_points_as_asked_for(model, section):
    motion = cd.trajectory(model, periods=3, samples=4, **section)
    assert words(motion) == {"ok"}
    assert motion.sizes["time"] == 13
    points = cd.poincare_section(model, periods=5, transient=2, **section)
    assert words(points) <= SOUND
    assert points.sizes["iterate"] == 5
    assert np.isfinite(points["section"]).all()


def test_spectrum(model, section):
    spectrum = cd.lyapunov_spectrum(model, periods=6, transient=5, blocks=4, **section)
    assert words(spectrum) <= SOUND
    exponents = spectrum["lyapunov_exponent"].values
    assert exponents.shape == (len(model.states),)
    assert not np.isnan(exponents).any()
    assert (np.diff(exponents[np.isfinite(exponents)]) <= 0).all()


def test_evidence(model, section):
    for function in (cd.zero_one_test, cd.regularity):
        found = function(model, periods=40, transient=5, **section)
        assert words(found) <= SOUND
        moves = found["k" if "k" in found else "digits"].notnull()
        assert found["outcome"] == cd.Outcome.PERIODIC or moves.any()
        # a result that has k holds no parameter of that name
        if model.parameters and next(iter(model.parameters)) not in found:
            swept = function(model, ways(model, 1), periods=40, transient=5, **section)
            assert words(swept) <= SOUND
            assert swept["outcome"].values[0] == found["outcome"]
    growth = cd.finite_time_exponents(model, periods=8, transient=5, **section)
    assert words(growth) == {"ok"}
    exponents = growth["lyapunov_exponent"].values
    assert not np.isnan(exponents).any()
    assert (growth["cumulant"].sel(order=1).isnull().values == np.isneginf(exponents)).all()


def test_dimensions(model, section):
    found = cd.dimensions(model, periods=40, transient=5, **section)
    assert words(found) <= SOUND
    assert (found["dimension"].isnull() | (found["outcome"] == cd.Outcome.PERIODIC)).all()


def test_covariant_vectors(model, section):
    found = cd.covariant_vectors(model, periods=6, transient=5, forward=4, backward=4, **section)
    assert words(found) == {"ok"}
    lost = found["lost"].values == 1
    lengths = np.linalg.norm(found["vector"].values, axis=1)
    np.testing.assert_allclose(lengths, np.where(lost, 0.0, 1.0), rtol=0, atol=1e-12)
    assert np.isneginf(found["local_growth"].values[lost]).all()
    assert not np.isnan(found["local_growth"]).any()


def test_manifolds(model, section):
    if model.name in ("drill-string", "two-masses-on-belt"):
        pytest.skip("half a minute, for an orbit that does not graze")
    found = cd.manifolds(model, start="attractor", transient=20, length=0.1, spacing=0.1, max_points=200, **section)
    assert words(found) <= SOUND | {"no_saddle", "no_return", "inadmissible"}
    assert (found["curve_number"].size > 0) == (words(found) == {"periodic"})
    assert found["curve_number"].size or found.attrs["message"]


def test_edge_states(model, section):
    start = [model.initial[name] for name in model.state_names]
    found = cd.edge_states(model, initial=[start, start], transient=5, periods=6, max_period=2, rounds=2, **section)
    assert words(found) <= {"undecided"}
    assert "fate" in found.attrs["reason"]


def test_transient_chaos(model):
    length = {"duration": 3.0} if model.period is None else {"periods": 3}
    start = [model.initial[name] for name in model.state_names]
    found = cd.transient_chaos(model, **length, initial=[start, start])
    assert words(found) == {"ok"}
    assert (found["lifetime"] == found["age"][-1]).all()
    assert found["escape_rate"] == 0


def test_sweeps(model, section):
    for count, sweep in ((1, cd.bifurcation_diagram), (2, cd.parameter_chart)):
        if len(model.parameters) >= count:
            found = sweep(model, ways(model, count), periods=6, transient=5, max_period=2, **section)
            assert words(found) <= SOUND


def test_basins(model, section):
    held = {"belt-stick-slip", "drill-string"}
    if len(model.states) < 2 or model.name in held:
        pytest.skip("no plane of starts: one state, or a start in a mode that holds the second one")
    grid = {state: [model.initial[state], model.initial[state] + 1e-3] for state in model.state_names[:2]}
    assert words(cd.basins(model, grid, periods=6, transient=5, max_period=2, **section)) <= SOUND
    measures = cd.basin_measures(model, grid, box=2, periods=6, transient=5, max_period=2, **section)
    assert float(measures["fraction"].sum() + measures["fraction_none"]) == pytest.approx(1.0)


def test_attractors(model, section):
    if not model.parameters:
        pytest.skip("no parameter to sweep")
    starts = [{}, {model.state_names[0]: model.initial[model.state_names[0]] + 1e-3}]
    sweep = ways(model, 1)
    if model.name == "drill-string":
        # its motions are told apart by a thousand turns each, at each value and from each to the next
        sweep = {name: values[:1] for name, values in sweep.items()}
    found = cd.attractors(
        model, sweep, initial=starts, periods=6, transient=5, max_period=2, max_extension=0, **section
    )
    assert words(found) <= SOUND
    share = found["fraction"].sum("attractor") + found["fraction_none"]
    np.testing.assert_allclose(share, 1.0, rtol=1e-12)


def test_orbit_and_branch(model, section):
    given = section if model.period is None else {}
    orbit = cd.periodic_orbit(model, transient=20, **given)
    assert words(orbit) <= SOUND
    if model.parameters:
        (name, (start, stop)), *_ = ways(model, 1).items()
        branch = cd.continue_orbit(model, {name: (start, stop)}, max_points=3, transient=20, **given)
        assert words(branch) <= SOUND
        if words(orbit) == {"periodic"} == words(branch):
            np.testing.assert_allclose(branch["orbit_state"][0], orbit["orbit_state"], rtol=1e-6, atol=1e-6)
