"""Sections: at the strobe and at events, with the period and the multipliers of maps known in closed form."""

import numpy as np
import pytest

import chaosdrill as cd


@pytest.mark.parametrize("turns", [1, 2, 3, 5, 7])
def test_strobes_of_a_rotation(circle, turns):
    angle = 2 * np.pi / turns
    section = cd.poincare_section(circle.with_parameters(angle=angle), periods=40, transient=3)
    k = np.arange(4, 44)
    exact = np.array([np.cos(k * angle), np.sin(k * angle)]).T
    np.testing.assert_allclose(section["section"].values, exact, rtol=0, atol=1e-12)
    np.testing.assert_allclose(section["time"].values, k, rtol=1e-14)
    assert int(section["period"]) == turns
    assert int(section["outcome"]) == cd.Outcome.PERIODIC
    found = section["multiplier_real"].values + 1j * section["multiplier_imag"].values
    np.testing.assert_allclose(found, 1.0, atol=1e-11)


def test_multipliers_of_a_focus(circle):
    """exp(growth + i angle) at the origin."""
    section = cd.poincare_section(circle.with_parameters(growth=-0.1, angle=1.0).with_initial(x=0.0), periods=8)
    found = section["multiplier_real"].values + 1j * section["multiplier_imag"].values
    expected = np.exp(-0.1 + np.array([1j, -1j]))
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(expected), atol=1e-12)


def test_an_irrational_rotation_has_no_period(circle):
    section = cd.poincare_section(circle.with_parameters(angle=np.sqrt(2)), periods=200)
    assert int(section["period"]) == 0
    assert np.isnan(section["multiplier_real"].values).all()
    assert int(section["outcome"]) == cd.Outcome.OK


def test_a_section_at_an_event_holds_no_point_twice(bouncer):
    """Hits by name and by kind; apexes are marks between them, at heights that fall with e^2."""
    hits = cd.poincare_section(bouncer, duration=10.0, at="hit")
    again = cd.poincare_section(bouncer, duration=10.0, at="impact")
    np.testing.assert_array_equal(hits["section"].values, again["section"].values)
    assert np.all(np.diff(hits["time"].values) > 1e-3)
    speeds = np.sqrt(9 + 4.0) * 0.75 ** np.arange(hits.sizes["iterate"])
    np.testing.assert_allclose(hits["section"].values[:, 1], -speeds, rtol=1e-12)
    apexes = cd.poincare_section(bouncer, duration=10.0, at="apex")
    np.testing.assert_allclose(
        apexes["section"].values[:, 0], 13 / 4 * 0.75 ** (2.0 * np.arange(apexes.sizes["iterate"]))
    )
    assert abs(hits.sizes["iterate"] - apexes.sizes["iterate"]) <= 1
    assert np.isnan(hits["multiplier_real"].values).all()


def test_a_section_at_an_event_after_a_transient(circle):
    """The axis is crossed upward after every full turn of five periods; lengths count these crossings."""
    section = cd.poincare_section(circle.with_initial(x=0.8, y=-0.6), periods=20, transient=10, at="axis")
    first = np.arctan2(0.6, 0.8) * 5 / (2 * np.pi)
    np.testing.assert_allclose(section["time"].values, first + 5 * np.arange(10, 30), rtol=0, atol=1e-10)
    assert float(section["return_time"]) == pytest.approx(5.0, rel=1e-12)
    np.testing.assert_allclose(section["section"].values, [[1.0, 0.0]] * section.sizes["iterate"], atol=1e-11)
    assert int(section["period"]) == 1


def test_a_start_on_a_section_is_its_first_crossing(circle):
    """From (1, 0) the axis is crossed at 0, and after 5, 10, ... periods."""
    section = cd.poincare_section(circle, periods=4, at="axis")
    np.testing.assert_allclose(section["time"].values, [0, 5, 10, 15], atol=1e-11)


def test_a_run_that_escapes_keeps_its_points(circle):
    section = cd.poincare_section(circle.with_parameters(growth=1.0), periods=10)
    assert int(section["outcome"]) == cd.Outcome.ESCAPED
    radius = np.hypot(*section["section"].values.T)
    # the last step may pass a strobe before it is looked at
    assert len(radius) in (4, 5)
    np.testing.assert_allclose(radius, np.exp(1.0 + np.arange(len(radius))), rtol=1e-12)


def test_a_transient_that_escapes_leaves_no_point(circle):
    section = cd.poincare_section(circle.with_parameters(growth=1.0), periods=10, transient=10)
    assert int(section["outcome"]) == cd.Outcome.ESCAPED
    assert section.sizes["iterate"] == 0
    assert int(section["period"]) == 0


def test_quadratures_go_along(duffing):
    section = cd.poincare_section(duffing, periods=4)
    displacement = section["section"].values[:, 0] - 0.5
    np.testing.assert_allclose(section["penetration"].values, displacement, rtol=0, atol=1e-11)


def test_progress(duffing, circle):
    seen = []
    cd.poincare_section(duffing, periods=7, progress=lambda *call: seen.append(call))
    assert [done for done, _, _ in seen] == [1, 2, 3, 4, 5, 6, 7]
    events = []
    cd.poincare_section(circle, periods=7, at="axis", progress=lambda *call: events.append(call))
    assert events[-1] == (7, 7, None)


@pytest.mark.parametrize("at", ["x > wall", "wall < x", "x - wall > 0"])
def test_a_surface_that_is_a_guard_is_named_by_its_event(at):
    system = cd.build("impact-oscillator")
    with pytest.raises(cd.SettingsError, match="this surface is the guard of 'impact'; name that, as in at='impact'"):
        cd.poincare_section(system, at=at, periods=4)
    assert cd.poincare_section(system, at="x < wall", periods=4, transient=4).sizes["iterate"] == 4


@pytest.fixture(scope="module")
def grip():
    """Constant friction on a belt: every motion ends on the circle about (F, 0) that touches the belt's speed."""
    slip = cd.Transition("release", "stick", "slip", "x - F", 1)
    stick = cd.Transition("stick", "slip", "stick", "v - vb", 1, {"v": "vb"})
    return cd.HybridSystem(
        states="x v", parameters={"vb": 0.5, "F": 0.3}, transitions=[slip, stick],
        modes={"stick": {"x": "vb", "v": 0}, "slip": {"x": "v", "v": "F - x"}}, initial={"mode": "stick", "v": 0.5},
    )  # fmt: skip


@pytest.mark.parametrize(("transient", "periods"), [(0, 4), (1, 8), (2, 30)])
def test_a_section_that_is_only_touched_tells_no_period(grip, transient, periods):
    """Points at one instant were a cycle of the duration 0, or a division by it.

    Whether round-off touches the surface once a turn, or several times, is open; the period is that of a turn, or none.
    """
    lengths = {"transient": transient, "periods": periods, "max_period": 2}
    found = cd.poincare_section(grip, at="v < vb", **lengths)
    if int(found["period"]):
        assert float(found["return_time"]) == pytest.approx(int(found["period"]) * 2 * np.pi, abs=1e-6)
    else:
        assert int(found["outcome"]) in (cd.Outcome.OK, cd.Outcome.NO_RETURN)
        assert np.isnan(found["return_time"]) or float(found["return_time"]) > 1.0
    line = cd.bifurcation_diagram(grip, {"F": [0.3, 0.5]}, at="v < vb", **lengths)
    turn = (line["period"] == 1) & (abs(line["return_time"] - 2 * np.pi) < 1e-6)
    nothing = (line["period"] == 0) & (line["outcome"] == cd.Outcome.NO_RETURN) & line["return_time"].isnull()
    assert (turn | nothing).all()
    assert line["lyapunov_exponent"].where(nothing).isnull().all()
    spectrum = cd.lyapunov_spectrum(grip, at="v < vb", transient=transient, periods=16)
    assert (int(spectrum["outcome"]) == cd.Outcome.NO_RETURN) == bool(spectrum["lyapunov_exponent"].isnull().all())


@pytest.mark.parametrize(("turns", "off"), [(1, 0.0), (2, 0.0), (3, 0.0), (3, 1e-9)])
def test_all_analyses_say_alike_whether_a_rotation_repeats(circle, turns, off):
    """A state next to zero at all strobes counts by what it was between; a drift is more after many turns than one."""
    repeats = not off
    system = circle.with_parameters(angle=2 * np.pi / turns + off)
    section = cd.poincare_section(system, periods=300)
    assert (int(section["period"]), section.cd.outcome) == ((turns, "periodic") if repeats else (0, "ok"))
    assert cd.lyapunov_spectrum(system, periods=300).cd.outcome == ("periodic" if repeats else "undecided")
    for exponents, open_ in ((0, "ok"), (2, "undecided")):
        given = {"transient": 0, "periods": 300, "max_extension": 0, "exponents": exponents}
        line = cd.bifurcation_diagram(system, {"angle": [system.parameters["angle"]]}, **given)
        assert line.cd.outcome.values.item() == ("periodic" if repeats else open_)
        assert int(line["period"].item()) == (turns if repeats else 0)


@pytest.mark.parametrize("turns", [1, 5, 29])
def test_errors_of_all_steps_of_a_period_make_no_drift(circle, turns):
    system = circle.with_parameters(angle=2 * np.pi * turns)
    found = cd.poincare_section(system, periods=200, method="dop853")
    assert (int(found["period"]), found.cd.outcome) == (1, "periodic")
    assert cd.lyapunov_spectrum(system, periods=200, method="dop853").cd.outcome == "periodic"


def test_a_section_that_crosses_the_same_cycle_tells_its_period(grip):
    found = cd.poincare_section(grip, at="v < 0", transient=20, periods=40)
    assert float(found["return_time"]) == pytest.approx(2 * np.pi, rel=1e-9)
    assert int(found["period"]) == 1


def test_a_run_that_has_left_its_bounds_before_the_record_has_none():
    """x = 2 sin t leaves |x| <= 1 and comes back into it: what has ended is not taken up again."""
    system = cd.HybridSystem(
        name="swing", states="x v", time="t", period="1", modes={"on": {"x": "v", "v": "-x"}},
        initial={"x": 0.0, "v": 2.0}, bounds={"x": (-1, 1)},
    )  # fmt: skip
    found = cd.poincare_section(system, transient=5, periods=3)
    assert found["outcome"] == cd.Outcome.ESCAPED
    assert found.sizes["iterate"] == 0
