"""Branches over a parameter that stands in Abs, Max, sign, Heaviside or Piecewise are exact, and end at the kink."""

import numpy as np
import pytest

import chaosdrill as cd


def over(k, written, start, **more):
    """Orbits of x' = -a x + cos(t), of which a is one more than what is written."""
    system = cd.HybridSystem(
        states="x", parameters={"k": start, "m": 0.5}, modes={"on": {"x": f"-(1 + {written})*x + cos(t)"}}, time="t",
        period="2*pi", initial={"x": 1.0},
    )  # fmt: skip
    return cd.continue_orbit(system, {"k": k}, **more)


@pytest.mark.parametrize(
    ("written", "start", "meant", "ends"),
    [
        ("Abs(k)", 1.0, np.abs, (0.0, 2.0)),
        ("Abs(k)", -1.0, np.abs, (-2.0, 0.0)),
        ("Max(m, k)", 1.0, lambda k: k, (0.5, 2.0)),
        ("Min(k**2, 1 + m)", 1.0, lambda k: k**2, (-np.sqrt(1.5), np.sqrt(1.5))),
        ("k*sign(k - m)", 1.0, lambda k: k, (0.5, 2.0)),
        ("(k + 3)*Heaviside(k)", 1.0, lambda k: k + 3, (0.0, 2.0)),
        ("Piecewise(k, k > 0, -k)", -1.0, np.abs, (-2.0, 0.0)),
        ("Piecewise(k, k > 0 and m >= 1/2, -k)", 1.0, lambda k: k, (0.0, 2.0)),
        ("Abs(Max(k, m) - 3/2)", 1.0, lambda k: 1.5 - k, (0.5, 1.5)),
    ],
)
def test_a_branch_has_its_closed_form_up_to_the_kink(written, start, meant, ends):
    found = over((-2.0, 2.0), written, start)
    k = found["k"].values
    a = 1 + meant(k)
    assert (k.min(), k.max()) == pytest.approx(ends, abs=1e-12)
    np.testing.assert_allclose(found["orbit_state"].values[:, 0], a / (1 + a * a), rtol=1e-11)
    np.testing.assert_allclose(found["multiplier_real"].values[:, 0], np.exp(-2 * np.pi * a), rtol=1e-10)
    assert "has a kink or a jump at k = " in str(found["branch_end_text"].values[0])


def test_the_other_side_is_another_branch_of_the_same_system():
    """What was derived on one side is not used on the other, nor at another value of what the kink depends on."""
    system = cd.HybridSystem(
        states="x", parameters={"k": 1.0, "m": 0.5}, modes={"on": {"x": "cos(t) - (2 + Abs(k - m))*x"}}, time="t",
        period="2*pi",
    )  # fmt: skip
    for start, m, ends in ((1.0, 0.5, (0.5, 2.0)), (-1.0, 0.5, (-2.0, 0.5)), (1.0, -0.25, (-0.25, 2.0))):
        found = cd.continue_orbit(system.with_parameters(k=start, m=m), {"k": (-2.0, 2.0)})
        k = found["k"].values
        a = 2 + np.abs(k - m)
        assert (k.min(), k.max()) == pytest.approx(ends, abs=1e-12)
        np.testing.assert_allclose(found["orbit_state"].values[:, 0], a / (1 + a * a), rtol=1e-11)


def test_another_parameter_chooses_the_branch():
    system = cd.HybridSystem(
        states="x", parameters={"k": 1.0, "m": 0.5}, time="t", period="2*pi",
        modes={"on": {"x": "cos(t) - Piecewise(3 + k, m >= 1/2, 3 - k)*x"}},
    )  # fmt: skip
    for m, way in ((0.5, 1), (0.4, -1), (2.0, 1)):
        found = cd.continue_orbit(system.with_parameters(m=m), {"k": (-2.0, 2.0)})
        k = found["k"].values
        a = 3 + way * k
        assert (k.min(), k.max()) == pytest.approx((-2.0, 2.0))
        np.testing.assert_allclose(found["orbit_state"].values[:, 0], a / (1 + a * a), rtol=1e-11)


@pytest.mark.parametrize("written", ["Abs(k - m)", "Piecewise(k, m >= 1/2, -k)"])
def test_a_side_that_another_parameter_may_change_is_no_system(written):
    system = cd.HybridSystem(states="x", parameters={"k": 1.0, "m": 0.5}, modes={"on": {"x": f"1 - (2 + {written})*x"}})
    with pytest.raises(cd.SettingsError, match="in the parameter 'k' depends on 'm'"):
        system.augmented(parameters=("k",))


@pytest.mark.parametrize("reset", ["0", "x - 1 - Abs(k)", "Abs(k)/4"])
def test_a_kink_in_guards_and_resets(reset):
    hit = cd.Transition("hit", "on", "on", "x - 1 - Abs(k)", +1, reset={"x": reset})
    system = cd.HybridSystem(
        states="x", parameters={"k": 1.0}, modes={"on": {"x": "1 + Abs(k)"}}, transitions=[hit], initial={"x": 0.0}
    )
    found = cd.continue_orbit(system, {"k": (-0.5, 2.0)}, at="hit")
    k, begun = found["k"].values, 0.25 * ("/4" in reset)
    assert (k.min(), k.max()) == pytest.approx((0.0, 2.0), abs=1e-12)
    np.testing.assert_allclose(found["period_time"].values, 1 - begun * k / (1 + k), rtol=1e-11)


@pytest.mark.parametrize("written", ["Abs(sin(k))", "k + floor(k)"])
def test_a_kink_whose_place_is_not_known_is_refused(written):
    with pytest.raises(
        cd.SettingsError, match="has a kink or a jump in the parameter 'k', whose derivatives are needed"
    ):
        over((0.2, 2.0), written, 1.0)
