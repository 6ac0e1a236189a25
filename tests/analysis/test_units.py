"""Words and periods do not depend on the units of the states. Units are parameters, so each system compiles once."""

import numpy as np
import pytest

import chaosdrill as cd

UNITS = [(1e6, 1e-6), (1e-12, 1e-12)]


@pytest.fixture(scope="module")
def through_zero():
    """A damped oscillator that settles on x = sin(w t), which every strobe finds at zero; u stirs y, and both decay."""
    force = "(2 - w**2)*sin(w*t) + c*w*cos(w*t)"
    return cd.HybridSystem(
        name="through zero",
        states="x v y u",
        parameters={"w": 1.3, "c": 0.2, "X": 1.0, "V": 1.0},
        modes={"on": {"x": "X*v/V", "v": f"V*(-2*x/X - c*v/V + {force})", "y": "u - y/10", "u": "-u/10"}},
        period="2*pi/w",
        initial={"u": 1.0},
    )


@pytest.mark.parametrize(("x", "v"), UNITS)
def test_the_period_of_what_passes_through_zero(through_zero, x, v):
    system = through_zero.with_parameters(X=x, V=v).with_initial(x=0.1 * x, u=v)
    for transient in (100, 1000):
        found = cd.bifurcation_diagram(system, {"w": [1.1, 1.3, 1.5]}, transient=transient, periods=128)
        assert (found["period"] == 1).all()
    section = cd.poincare_section(system, transient=100, periods=128)
    assert section["period"] == 1
    # the response is sin(w t) in its unit
    np.testing.assert_allclose(section["section"].sel(state="v")[-1] / v, 1.3, rtol=1e-9)


@pytest.fixture(scope="module")
def two_cycles():
    """Circles of the radii X and U, w turns of one in a turn of the other."""
    cycle = "(x/X)**2 + (y/X)**2", "(u/U)**2 + (v/U)**2"
    field = {
        "x": f"x - y - x*({cycle[0]})",
        "y": f"x + y - y*({cycle[0]})",
        "u": f"u - w*v - u*({cycle[1]})",
        "v": f"w*u + v - v*({cycle[1]})",
    }
    return cd.HybridSystem(
        name="two cycles", states="x y u v", parameters={"w": 1.5, "X": 1.0, "U": 1.0}, modes={"on": field}
    )


@pytest.mark.parametrize(("x", "u"), UNITS)
def test_a_torus_is_one_in_all_units(two_cycles, x, u):
    system = two_cycles.with_parameters(X=x, U=u).with_initial(x=0.5 * x, u=0.5 * u)
    w = [1.5, np.sqrt(2)]
    cycle, torus = cd.Outcome.PERIODIC, cd.Outcome.QUASIPERIODIC
    strobed = cd.bifurcation_diagram(system, {"w": w}, at="x > 0", transient=50, periods=128)
    np.testing.assert_array_equal(strobed["outcome"].values[:, 0], [cycle, torus])
    np.testing.assert_array_equal(strobed["period"].values[:, 0], [2, 0])
    timed = cd.parameter_chart(system, {"w": w, "X": [x]}, transient=50, duration=2000)
    np.testing.assert_array_equal(timed["outcome"].values.ravel(), [cycle, torus])


def test_a_map_of_the_circle_is_not_chaotic():
    """The spikes of a driven integrate-and-fire cell in order of phase are an invertible map of the circle."""
    cell = cd.HybridSystem(
        name="cell",
        states="v",
        parameters={"I": 1.5, "A": 0.2, "w": 3.0},
        modes={"rest": {"v": "-v + I + A*cos(w*t)"}},
        transitions=[cd.Transition("spike", "rest", "rest", "v - 1", +1, reset={"v": "0"})],
        period="2*pi/w",
    )
    for at in ("strobe", "spike"):
        found = cd.bifurcation_diagram(cell, {"I": np.linspace(1.25, 2.0, 16)}, at=at, transient=400, periods=64)
        assert (found["outcome"] != cd.Outcome.CHAOTIC).all()


@pytest.fixture(scope="module")
def noisy_ball():
    """A ball with random restitution, whose lengths are in units of L, and times in units of T."""
    return cd.HybridSystem(
        name="noisy ball",
        states="x v",
        parameters={"e": 0.8, "L": 1.0, "T": 1.0},
        modes={"flight": {"x": "v", "v": "-L/T**2"}},
        transitions=[cd.Transition("impact", "flight", "flight", "x", -1, reset={"v": "L/T - e*v"})],
    ).with_noise({"e": cd.Uniform(0.7, 0.9)}, at="impact", seed=1)


def only_as_exponents_do(errors, others, moved, rtol):
    """Whether errors in other units are the same, or larger by no more than the units have moved exponents."""
    larger = np.subtract(others, errors)
    return bool(((larger >= -rtol * np.abs(errors)) & (larger <= rtol * np.abs(errors) + moved)).all())


@pytest.mark.parametrize(("length", "time"), [(1.0, 1e4), (1e3, 1e-2), (1e-9, 1e6)])
def test_errors_depend_on_units_only_as_exponents_do(noisy_ball, length, time):
    """A record ends at the apex, where the flow changes the speed alone: its length there is that of a speed."""

    def exponents(length, time):
        ball = noisy_ball.with_parameters(L=length, T=time).with_initial(x=length)
        ds = cd.lyapunov_spectrum(ball, at="impact", transient=50, periods=2000)
        return ds["lyapunov_exponent"] * time, ds["lyapunov_error"] * time, ds["kaplan_yorke_error"]

    (here, error, dimension), (other, other_error, other_dimension) = exponents(1.0, 1.0), exponents(length, time)
    np.testing.assert_allclose(other_dimension, dimension, rtol=1e-6)
    assert only_as_exponents_do(error, other_error, float(abs(other - here).max()), 1e-6)


PICO = 2.0**40
"""Units of time in about a second: records are longer than any count."""


@pytest.mark.parametrize(
    ("analysis", "lengths"),
    [
        (cd.lyapunov_spectrum, {"duration": 256, "transient": 64, "max_return": 128}),
        (cd.finite_time_exponents, {"duration": 256, "windows": [1, 16]}),
    ],
)
def test_times_have_no_limit_that_counts_have(noisy_ball, analysis, lengths):
    found = []
    for time in (1.0, PICO):
        scaled = {name: (time * np.array(value)).tolist() for name, value in lengths.items()}
        ds = analysis(noisy_ball.with_parameters(T=time).with_initial(x=1.0), **scaled)
        assert ds.cd.outcome != "failed"
        # how volumes shrink depends on no unit
        found.append(time * ds["lyapunov_exponent"].values.sum())
    assert found[1] == pytest.approx(found[0], rel=1e-6)


@pytest.mark.parametrize("lengths", [{"duration": 1e-3}, {"at": "impact", "periods": 9}])
def test_transients_beyond_any_number_of_records_are_refused(noisy_ball, lengths):
    with pytest.raises(cd.SettingsError, match=r"transient is 1000000000000; must be at most 1e\+10"):
        cd.lyapunov_spectrum(noisy_ball, transient=10**12, **lengths)


@pytest.mark.parametrize(
    ("images", "values", "starts", "periods"),
    [
        (["X*(1 - r*(x/X)**2 + y/Y)", "0.3*Y*x/X"], [1.05, 1.06, 1.2, 1.3], (-0.2, 0.2), 400),
        (["r*x*(1 - y/Y)", "Y*x/X"], [1.99, 2.005, 2.05, 2.27], (0.45, 0.55), 700),
    ],
)
def test_words_of_maps_do_not_depend_on_units_and_errors_as_exponents_do(images, values, starts, periods):
    """On a torus tangents neither grow nor shrink, in plain lengths by as much as units differ."""
    system = cd.Map("x y", {"r": 1.0, "X": 1.0, "Y": 1.0}, images)
    rng = np.random.default_rng(5)
    for r in values:
        start, words, errors, exponents = rng.uniform(*starts, 2), [], [], []
        for x, y in ((1.0, 1.0), (2.0**30, 2.0**-20), (2.0**-25, 2.0**10), (1e-9, 1e9)):
            here = system.with_parameters(r=r, X=x, Y=y).with_initial(x=start[0] * x, y=start[1] * y)
            alone = cd.lyapunov_spectrum(here, transient=20, periods=periods)
            swept = cd.parameter_chart(here, {"r": [r], "X": [x]}, transient=20, periods=periods, max_extension=0)
            words.append((int(alone["outcome"]), int(swept["outcome"].squeeze())))
            # of two exponents of one value units tell which is the first
            exponents.append([*alone["lyapunov_exponent"].values, *swept["lyapunov_exponent"].values.ravel()])
            errors.append([*sorted(alone["lyapunov_error"].values), *sorted(swept["lyapunov_error"].values.ravel())])
        assert len(set(words)) == 1
        # in other units than powers of two rounding moves the motion
        for k in (1, 2):
            moved = np.abs(np.subtract.outer(exponents[k], exponents[0])).max()
            assert only_as_exponents_do(errors[0], errors[k], moved, 1e-9)


def test_states_of_any_small_size_have_exponents():
    """The square of one over a size overflowed below 1e-154: all tangents seemed lost."""
    rest = cd.HybridSystem(
        name="unstable rest",
        states="x",
        parameters={"m": 0.02},
        modes={"m": {"x": "(1 + m)*x - x + x**3 - x**5"}},
        transitions=[],
    )
    found = cd.lyapunov_spectrum(rest.with_initial(x=1e-160), transient=10, duration=300)
    assert found["lyapunov_exponent"].item() == pytest.approx(0.02, abs=1e-9)
    assert found.cd.outcome == "transient"


def test_exponents_of_a_cycle_in_units_far_apart():
    """A tangent that turns from y to x gains 41 at once, and came before that along the flow: -0.0997, 0, -2.0007."""
    p, q, r = "x/X", "y/Y", "z/X"
    field = {
        "x": f"X*({p} - {q} - {p}*(({p})**2 + ({q})**2) + {r}/50)",
        "y": f"Y*({p} + {q} - {q}*(({p})**2 + ({q})**2))",
        "z": f"X*({p} - {r})/10",
    }
    cycle = cd.HybridSystem(states="x y z", parameters={"X": 1.0, "Y": 1.0}, modes={"on": field}, initial={"x": 1.0})
    plain, found = (
        cd.periodic_orbit(cycle.with_parameters(X=x, Y=y).with_initial(x=0.8 * x, y=0.6 * y))
        for x, y in ((1.0, 1.0), (1e9, 1e-9))
    )
    assert abs(plain["lyapunov_exponent"][0]) < 1e-9
    np.testing.assert_allclose(found["lyapunov_exponent"], plain["lyapunov_exponent"], rtol=0, atol=1e-9)
    assert found["consistent"]
