"""Diagrams: each point is a run of its own, whatever becomes of the others and however many workers there are."""

import numpy as np
import pytest
import sympy

import chaosdrill as cd

SWEEP = {"growth": np.array([-0.2, 0.0, 0.05, 3.0])}


@pytest.fixture(scope="module")
def spiral(circle):
    seeds = [{}, {"x": 0.5, "y": 0.1}, {"x": 0.0}]
    return cd.bifurcation_diagram(circle, SWEEP, transient=10, periods=40, seeds=seeds, max_extension=0)


def test_a_spiral_repeats_rests_or_escapes(spiral):
    """Decay and a fifth of a turn repeat, growth below 4/length leaves a rest and is no torus, more escapes."""
    o = cd.Outcome
    expected = [[o.PERIODIC] * 3, [o.PERIODIC] * 3, [o.TRANSIENT] * 2 + [None], [o.ESCAPED] * 2 + [None]]
    found = spiral["outcome"].values
    for row, wanted in zip(found, expected, strict=True):
        assert all(w is None or f == w for f, w in zip(row, wanted, strict=True))


def test_sections_are_the_closed_form(spiral):
    k = np.arange(11, 51)
    for i, growth in enumerate([-0.2, 0.0, 0.05]):
        z = np.array([1.0, 0.5 + 0.1j, 0.0])[:, None] * np.exp((growth + 2j * np.pi / 5) * k)
        exact = np.stack([z.real, z.imag], axis=-1)
        np.testing.assert_allclose(spiral["section"].values[i], exact, rtol=0, atol=1e-11)


def test_exponents_are_the_growth(spiral):
    for i, growth in enumerate([-0.2, 0.0, 0.05]):
        np.testing.assert_allclose(spiral["lyapunov_exponent"].values[i], growth, rtol=0, atol=1e-12)


def test_a_point_that_escapes_holds_nothing(spiral):
    lost = spiral.isel(growth=3, seed=[0, 1])
    for name in ("section", "lyapunov_exponent", "lyapunov_error", "events_per_period"):
        assert np.isnan(lost[name].values).all(), name
    assert (lost["period"].values == 0).all()
    assert np.isfinite(spiral["section"].isel(growth=[0, 1, 2]).values).all()


def test_a_fifth_of_a_turn_has_period_five(spiral):
    np.testing.assert_array_equal(spiral["period"].isel(growth=1).values, [5, 5, 1])
    assert (spiral["period"].isel(growth=2, seed=[0, 1]).values == 0).all()


def test_seeds_are_kept(spiral):
    np.testing.assert_array_equal(spiral["initial_state"].values, [[1.0, 0.0], [0.5, 0.1], [0.0, 0.0]])


@pytest.fixture(scope="module")
def sweep_of_the_drill():
    def run(**more):
        return cd.bifurcation_diagram(
            cd.drill(),
            {"eta": np.linspace(0.42, 0.82, 9)},
            transient=40,
            periods=24,
            seeds=[{}, {"u": 0.1}],
            **more,
        )

    return run


def test_workers_change_no_bit(sweep_of_the_drill):
    one, two, three = (sweep_of_the_drill(workers=n) for n in (1, 2, 3))
    for name in one.variables:
        assert one[name].values.tobytes() == two[name].values.tobytes() == three[name].values.tobytes(), name


def test_a_point_alone_is_the_point_in_the_sweep(sweep_of_the_drill):
    whole = sweep_of_the_drill()
    alone = cd.bifurcation_diagram(cd.drill(), {"eta": whole["eta"].values[[7]]}, transient=40, periods=24)
    np.testing.assert_array_equal(alone["section"].values[0, 0], whole["section"].values[7, 0])
    np.testing.assert_array_equal(alone["lyapunov_exponent"].values[0, 0], whole["lyapunov_exponent"].values[7, 0])


def test_points_are_those_of_the_section_and_the_spectrum(sweep_of_the_drill):
    whole = sweep_of_the_drill()
    system = cd.drill(eta=float(whole["eta"][7]))
    section = cd.poincare_section(system, periods=24, transient=40)
    np.testing.assert_allclose(whole["section"].values[7, 0], section["section"].values, rtol=0, atol=1e-9)


@pytest.mark.parametrize("workers", [1, 2])
def test_progress_counts_points_and_outcomes(circle, workers):
    seen = []
    cd.bifurcation_diagram(
        circle,
        {"growth": np.linspace(-0.3, -0.1, 10)},
        transient=0,
        periods=20,
        workers=workers,
        progress=lambda *call: seen.append(call),
    )
    done = [done for done, _, _ in seen]
    assert done == sorted(done)
    assert (done[0], done[-1]) == (0, 10)
    assert {total for _, total, _ in seen} == {10}
    assert [sum(outcomes.values()) for _, _, outcomes in seen] == done


def test_motions_do_not_depend_on_how_many_section_points_are_kept():
    """Cycles of period 4 and 2, met while the record is extended."""
    system = cd.build("impact-oscillator", {"wall": 0.3, "zeta": 0.05, "e": 0.8})
    given = {"transient": 100, "periods": 64}
    plain = cd.bifurcation_diagram(system, {"omega": [2.6, 2.7348]}, **given)
    assert (plain["outcome"] == cd.Outcome.PERIODIC).all()
    for count in (1, 1000):
        other = cd.bifurcation_diagram(system, {"omega": [2.6, 2.7348]}, **given, section_points=count)
        for name in ("outcome", "period", "lyapunov_exponent", "lyapunov_error"):
            np.testing.assert_array_equal(other[name], plain[name], err_msg=name)
        section = other["section"].values
        assert section.shape[2] == count
        assert np.isfinite(section).all()
        many = min(count, 64)
        np.testing.assert_allclose(section[:, :, -many:], plain["section"].values[:, :, -many:], atol=1e-9)


def test_lengths_count_the_points_of_the_section(circle):
    """One crossing in five periods of the strobe: 8 points are 8 of them; more are kept only if there are more."""
    given = {"transient": 0, "periods": 8, "at": "axis", "exponents": 0, "seeds": [{"x": 0.8, "y": -0.6}]}
    diagram = cd.bifurcation_diagram(circle, {"growth": [-0.01]}, **given, section_points=10)
    section = diagram["section"].values[0, 0]
    first = np.arctan2(0.6, 0.8) * 5 / (2 * np.pi)
    np.testing.assert_allclose(section[:8, 0], np.exp(-0.01 * (first + 5 * np.arange(8))), rtol=1e-11)
    assert np.isnan(section[8:]).all()
    assert "lyapunov_exponent" not in diagram


def test_a_parameter_that_has_no_period_fails_alone(duffing):
    """omega = 0 has no forcing period: that point failed, the other ran."""
    diagram = cd.bifurcation_diagram(duffing, {"omega": [0.0, 1.0]}, transient=1, periods=4)
    assert list(diagram["outcome"].values[:, 0] == cd.Outcome.FAILED) == [True, False]
    assert np.isnan(diagram["section"].values[0]).all()
    assert np.isfinite(diagram["section"].values[1]).all()


def test_rank_that_a_parameter_of_a_reset_decides():
    """On the circle the radius is pulled to 1 once a turn: exponents 0 and ln(c)/5, and -inf where c is zero."""
    x, y, c = sympy.symbols("x y c", real=True)
    turn = 2 * sympy.pi / 5
    pulled = cd.HybridSystem(
        name="pulled",
        states=(x, y),
        parameters={"c": 0.5},
        modes={"turn": {x: -turn * y, y: turn * x}},
        transitions=[cd.Transition("pull", "turn", "turn", guard=y, direction=+1, reset={x: 1 - c + c * x})],
        period=sympy.Integer(1),
        initial={x: 0.8, y: -0.3},
    )
    diagram = cd.bifurcation_diagram(pulled, {"c": [0.0, 0.5]}, transient=150, periods=50)
    found = diagram["lyapunov_exponent"].values[:, 0]
    np.testing.assert_allclose(found[:, 0], 0.0, atol=1e-10)
    assert found[0, 1] == -np.inf
    assert found[1, 1] == pytest.approx(np.log(0.5) / 5, abs=1e-10)


def test_transient_may_be_nothing(circle):
    diagram = cd.bifurcation_diagram(circle, {"growth": [0.0]}, transient=0, periods=10)
    k = np.arange(1, 11) * 2 * np.pi / 5
    np.testing.assert_allclose(diagram["section"].values[0, 0], np.array([np.cos(k), np.sin(k)]).T, atol=1e-12)


def test_a_forced_cell_that_fires_at_one_level_is_told_by_its_phase():
    """Keener, Hoppensteadt and Rinzel 1981, doi:10.1137/0141042: one state, so that every spike looks like the last."""
    fire = cd.Transition("fire", "rest", "rest", "v - 1", 1, {"v": 0})
    cell = cd.HybridSystem(
        states="v", modes={"rest": {"v": "-g*v + I + A*sin(2*pi*t)"}}, transitions=[fire], period=1,
        parameters={"g": 0.5, "I": 0.9, "A": 0.1},
    )  # fmt: skip
    values = {"A": [0.1, 0.6, 0.75, 0.85]}
    lengths = {"transient": 100, "periods": 200}
    strobes, spikes, levels = (
        cd.bifurcation_diagram(cell, values, at=at, **lengths).isel(seed=0) for at in (None, "fire", "v > 0.5")
    )
    np.testing.assert_array_equal(spikes["outcome"], strobes["outcome"])
    # 13 forcing periods of 8 spikes, 8 of 5: by the return time, which is free of the count of the period
    turns = (spikes["period"] * spikes["return_time"])[1:]
    np.testing.assert_allclose(turns, strobes["period"][1:], rtol=1e-9)
    assert strobes["period"].values.tolist() == [0, 13, 8, 8]
    assert spikes["period"].values.tolist() == [0, 8, 5, 5]
    np.testing.assert_array_equal(levels["period"], spikes["period"])
    assert int(cd.poincare_section(cell.with_parameters(A=0.85), at="fire", **lengths)["period"]) == 5
    assert int(cd.poincare_section(cell, at="fire", **lengths)["period"]) == 0
