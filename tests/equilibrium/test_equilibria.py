"""Equilibria of modes and of sliding, against closed forms, whatever the names, the order and the units."""

import numpy as np
import pytest

import chaosdrill as cd

LORENZ = {"x": "s*(y - x)", "y": "x*(r - z) - y", "z": "x*y - b*z"}


def lorenz(**values):
    return cd.HybridSystem(
        name="lorenz",
        states="x y z",
        parameters={"s": 10.0, "r": 28.0, "b": 8 / 3, **values},
        modes={"flow": LORENZ},
        initial={"x": 1.0, "y": 1.0, "z": 20.0},
    )


def two_fields(m=0.3, q=1.0, k=3.0):
    """Sliding along q ((k - 1) x + k m)/(q - x - m), between a focus and a field that leads up."""
    return cd.filippov(
        name="two fields",
        states="x y",
        parameters={"m": m, "q": q, "k": k},
        surface="y",
        above={"x": "-x - y", "y": "x - y + m"},
        below={"x": "-k*q", "y": "q"},
        initial={"x": 1.0, "y": 1.0},
    )


def test_all_equilibria_of_lorenz_and_their_eigenvalues():
    found = cd.equilibria(lorenz())
    assert found.cd.outcome == "equilibrium"
    root = np.sqrt(8 / 3 * 27)
    exact = np.array([[-root, -root, 27], [0, 0, 0], [root, root, 27]])
    assert (np.abs(found["equilibrium_state"] - exact) <= found["equilibrium_error"]).all()
    assert found["equilibrium_error"].max() < 1e-13
    assert found.cd.words("type").values.tolist() == ["saddle_focus", "saddle", "saddle_focus"]
    a, d = (-11 + np.sqrt(121 + 4 * 270)) / 2, (-11 - np.sqrt(121 + 4 * 270)) / 2
    assert (np.abs(found["eigenvalue_real"][1] - [a, -8 / 3, d]) <= found["eigenvalue_error"][1]).all()
    assert found["eigenvalue_error"].max() < 1e-12
    assert set(found.cd.words("admissible").values.tolist()) == {"admissible"}


def test_a_pseudo_equilibrium_has_only_the_eigenvalue_along_its_surface():
    found = cd.equilibria(two_fields())
    modes = found.cd.words("mode").values.tolist()
    assert modes == ["above", "sliding"]
    assert found["pseudo"].values.tolist() == [0, 1]
    assert found["free"].values.tolist() == [2, 1]
    assert np.abs(found["equilibrium_state"] - [[-0.15, 0.15], [-0.45, 0.0]]).max() < 1e-15
    assert abs(found["eigenvalue_real"].values[1, 0] - 2 / 1.15) <= found["eigenvalue_error"].values[1, 0] < 1e-13
    assert np.isnan(found["eigenvalue_real"].values[1, 1])
    message = found.attrs["message"]
    assert "no equilibria: x changes at a rate of its own in mode 'below'" in message
    assert "no eigenvalue: mode 'sliding' holds y" in message
    # where the field below leads down nothing slides
    away = cd.equilibria(two_fields(q=-1.0))
    assert away.cd.words("admissible").values.tolist() == ["admissible", "virtual"]
    assert away["guard"].values.tolist() == ["", "parameters"]


def test_a_conserved_sum_is_that_of_the_initial_state():
    """Susceptible and infected, S + I = N: I = 0 or N - g/b, with the eigenvalue g - b N there."""
    system = cd.HybridSystem(
        states="S I",
        parameters={"b": 0.5, "g": 0.2},
        modes={"on": {"S": "g*I - b*S*I", "I": "b*S*I - g*I"}},
        initial={"S": 0.9, "I": 0.6},
    )
    found = cd.equilibria(system)
    assert np.abs(found["equilibrium_state"] - [[0.4, 1.1], [1.5, 0.0]]).max() < 1e-14
    assert np.abs(found["eigenvalue_real"].isel(eigenvalue=0) - [-0.55, 0.55]).max() < 1e-14
    assert found["free"].values.tolist() == [1, 1]
    assert "is conserved, and has its initial value" in found.attrs["message"]


def test_a_centre_and_a_double_eigenvalue_are_told_within_their_errors():
    centre = cd.HybridSystem(states="x v", modes={"on": {"x": "v", "v": "-sin(x)"}}, initial={"x": 0.3})
    found = cd.equilibria(centre, region={"x": (-4, 4), "v": (-1, 1)})
    assert found.cd.words("type").values.tolist() == ["saddle", "centre", "saddle"]
    jordan = cd.HybridSystem(states="x v", modes={"on": {"x": "v - x", "v": "-v"}}, initial={"x": 0.3, "v": 1.0})
    found = cd.equilibria(jordan)
    assert found.cd.words("type").item() == "node"
    assert (np.abs(found["eigenvalue_real"] + 1) <= found["eigenvalue_error"]).all()


@pytest.mark.parametrize("unit", [1.0, 1e10])
def test_eigenvalues_fall_in_any_unit_of_time(unit):
    rates = {"x": f"-{unit}*x", "y": f"-3*{unit}*y", "z": f"-2*{unit}*z"}
    found = cd.equilibria(cd.HybridSystem(states="x y z", modes={"on": rates}, initial={"x": 1.0}))
    assert found["eigenvalue_real"].values[0] / unit == pytest.approx([-1, -2, -3], rel=1e-12)


def test_a_region_bounds_what_is_found_and_names_states():
    found = cd.equilibria(lorenz(), region={"x": (1, 20)})
    assert found.sizes["point"] == 1
    with pytest.raises(cd.SettingsError, match="unknown state"):
        cd.equilibria(lorenz(), region={"w": (0, 1)})
    with pytest.raises(cd.SettingsError, match="unknown mode"):
        cd.equilibria(lorenz(), modes=["fall"])
    nowhere = cd.HybridSystem(states="x", parameters={"m": -1.0}, modes={"on": {"x": "m - x**2"}}, initial={"x": 1.0})
    found = cd.equilibria(nowhere, region={"x": (-2, 2)})
    assert (found.cd.outcome, found.sizes["point"]) == ("no_equilibrium", 0)


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (lambda: cd.build("impact-oscillator"), "periodic_orbit with period = 1, whose strobes are fixed points"),
        (
            lambda: cd.Map("x", {"r": 3.2}, {"x": "r*x*(1 - x)"}, initial={"x": 0.3}),
            "is a map, which has fixed points; take periodic_orbit with period = 1",
        ),
        (lambda: cd.HybridSystem(states="x", modes={"on": {"x": "t - x"}}), "depends on time"),
    ],
)
def test_what_cannot_rest_is_refused_with_the_way_out(system, words):
    with pytest.raises(cd.SettingsError, match=words):
        cd.equilibria(system())


SPECIAL = ("special_kind", "special_criticality", "special_beyond")


def told(found):
    """All words of branches, by the value of the parameter."""
    order = np.argsort(found["special_value"].values, kind="stable")
    return [found.cd.words(name).values[order].tolist() for name in SPECIAL]


def fitzhugh(unit=1.0, time=1.0, names=("v", "w"), current=0.0):
    """In other units of the states and of time; the parameter I keeps its own."""
    v, w = names
    rates = {
        v: f"(({v}/U) - ({v}/U)**3/3 - ({w}/W) + I)*U/T",
        w: f"0.08*(({v}/U) + 0.7 - 0.8*({w}/W))*W/T",
    }
    return cd.HybridSystem(
        name="fitzhugh",
        states=names,
        parameters={"I": current, "U": unit, "W": 1 / unit, "T": time},
        modes={"on": {name: rates[name] for name in names}},
        initial={v: -unit, w: -0.5 / unit},
        bounds={v: None, w: None},
    )


@pytest.fixture(scope="module")
def excitable():
    return cd.equilibria(fitzhugh(), {"I": (-1.0, 2.0)})


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_units_change_no_word_and_no_value(excitable, unit):
    found = cd.equilibria(fitzhugh(unit, 1e3), {"I": (-1.0, 2.0)})
    assert told(found) == told(excitable)
    assert np.abs(found["special_value"].values - excitable["special_value"].values).max() < 1e-12
    assert np.abs(found["special_frequency"] * 1e3 - excitable["special_frequency"]).max() < 1e-12
    states = found["cycle_state"] / [unit, 1 / unit] - excitable["cycle_state"]
    assert np.abs(states).max() < 1e-6


def test_names_order_start_and_direction_change_nothing(excitable):
    others = (
        cd.equilibria(fitzhugh(names=("zeta", "a")), {"I": (2.0, -1.0)}),
        cd.equilibria(fitzhugh(current=1.7), {"I": (-1.0, 2.0)}),
    )
    for found in others:
        assert told(found) == told(excitable)
        assert np.abs(np.sort(found["special_value"]) - np.sort(excitable["special_value"])).max() < 1e-13
        assert np.abs(np.sort(found["special_coefficient"]) - np.sort(excitable["special_coefficient"])).max() < 1e-10
