"""Branches of equilibria: folds, branch points, Hopf points with their coefficient and cycle, boundaries."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.cli.run import orbit_lines
from chaosdrill.dataset.branches import count_special_points


def flow(name, rates, parameters, **initial):
    return cd.HybridSystem(name=name, states=list(rates), parameters=parameters, modes={"flow": rates}, initial=initial)


def specials(found):
    kinds = found.cd.words("special_kind").values.tolist()
    return [(kind, float(value)) for kind, value in zip(kinds, found["special_value"].values, strict=True)]


def within(found, exact):
    """Special values against exact ones, each within its error."""
    apart = np.abs(np.sort(found["special_value"].values) - np.sort(exact))
    return bool((apart <= np.sort(found["special_error"].values) + 1e-15).all())


def test_folds_of_a_cubic_and_of_a_closed_branch():
    cubic = cd.equilibria(flow("cubic", {"x": "m + x - x**3"}, {"m": 0.0}, x=1.0), {"m": (-1.0, 1.0)})
    assert {kind for kind, _ in specials(cubic)} == {"fold"}
    assert within(cubic, [-2 / np.sqrt(27), 2 / np.sqrt(27)])
    assert cubic.sizes["branch_number"] == 1
    # the number of unstable directions changes at special points only
    stable, special = cubic["stable"].values, cubic["special_point"].values
    assert [special[k] or special[k + 1] for k in np.flatnonzero(np.diff(stable))] != []
    assert all(special[k] or special[k + 1] for k in np.flatnonzero(np.diff(stable)))
    circle = cd.equilibria(flow("circle", {"x": "1 - x**2 - m**2"}, {"m": 0.5}, x=0.7), {"m": (-2.0, 2.0)})
    assert circle.cd.words("branch_end").values.tolist() == ["closed"]
    assert within(circle, [-1.0, 1.0])


@pytest.mark.parametrize(
    ("rate", "other", "start"),
    [
        *(("m*x - x**3", "x - y", 1.0), ("m*x - x**2", "x - y", 0.5), ("m*x + x**3 - x**5", "x - y", -0.1)),
        # alone, a rate has no derivative at the crossing
        *(("m*x - x**3", "-2*y", -0.5), ("sqrt(1 + x**2)*asinh(x)*(m - asinh(x))", "-2*y", -0.5)),
    ],
)
def test_branches_that_cross_are_followed_from_either(rate, other, start):
    rates = {"x": rate, "y": other}
    found = cd.equilibria(flow("crossed", rates, {"m": start}, x=0.4, y=0.3), {"m": (-1.0, 2.0)})
    crossed = [value for kind, value in specials(found) if kind == "branch_point"]
    # each of the two branches has the point, and each branch stands once
    assert len(crossed) == 2
    assert found.attrs["message"] == ""
    assert np.abs(crossed).max() < 1e-15
    assert found.sizes["branch_number"] == 2
    assert found["special_multiplicity"].values.tolist().count(1) == found.sizes["special"]


@pytest.mark.parametrize(
    ("rate", "m", "x", "branches", "marks"),
    [
        *(("m**4 - m**2 + x**2", m, m, 1, {"fold": 2, "branch_point": 2}) for m in (0.0, 1e-9, 1e-6, 1e-5)),
        ("m**4 - m**2 + (x - 1)**2", 0.0, 1.0, 1, {"fold": 2, "branch_point": 2}),
        # the circle turns back where the line crosses it
        ("x*(1 - x**2 - m**2)", 0.0, 0.0, 2, {"branch_point": 4}),
    ],
)
def test_a_closed_branch_that_is_crossed_is_walked_once(rate, m, x, branches, marks):
    """Each way through a crossing has its point, also where the branch begins there or nearby."""
    found = cd.equilibria(flow("crossed", {"x": rate}, {"m": m}, x=x), {"m": (-2.0, 2.0)})
    assert found.sizes["branch_number"] == branches
    assert "closed" in found.cd.words("branch_end").values
    assert {kind: [one for one, _ in specials(found)].count(kind) for kind in marks} == marks
    assert found.sizes["special"] == sum(marks.values())
    assert found.attrs["message"] == ""


def test_branches_from_rest_at_zero_are_the_same_in_any_unit():
    """x^2 = m u^2 crosses x = 0; y begins to turn with the amplitude 2 u sqrt(m)."""
    forked = flow("forked", {"x": "m*x - x**3/u**2"}, {"m": -0.3, "u": 1.0}, x=0.0)
    turning = flow("turning", {"y": "z", "z": "m*z - y - y**2*z/u**2"}, {"m": -0.3, "u": 1.0}, y=0.0, z=0.0)
    kinds, counts, cycles = set(), set(), []
    for unit in (1e-9, 1.0, 1e8):
        found = cd.equilibria(forked.with_parameters(u=unit), {"m": (-0.5, 0.4)}, step=0.02)
        kinds |= {kind for kind, _ in specials(found)}
        counts.add((found.sizes["branch_number"], found.sizes["point"]))
        x, m = found["equilibrium_state"].values[:, 0] / unit, found["m"].values
        assert np.abs(x * (x**2 - m)).max() < 1e-9
        found = cd.equilibria(turning.with_parameters(u=unit), {"m": (-0.5, 0.4)}, step=0.02)
        assert abs(found["special_coefficient"].item() * unit**2 + 1 / 4) < 1e-12
        cycles.append([found["cycle_value"].item(), found["cycle_amplitude"].values[0, 0] / unit])
    assert (kinds, len(counts), min(counts)[0]) == ({"branch_point"}, 1, 2)
    np.testing.assert_allclose(cycles, cycles[:1] * 3, rtol=1e-3)
    np.testing.assert_allclose(cycles[0][1], 2 * np.sqrt(cycles[0][0]), rtol=1e-2)


@pytest.fixture(scope="module")
def lorenz():
    rates = {"x": "s*(y - x)", "y": "x*(r - z) - y", "z": "x*y - b*z"}
    system = flow("lorenz", rates, {"s": 10.0, "r": 28.0, "b": 8 / 3}, x=1.0, y=1.0, z=20.0)
    return system, cd.equilibria(system, {"r": (0.0, 30.0)})


def test_lorenz_has_a_pitchfork_and_two_subcritical_hopf_points(lorenz):
    _, found = lorenz
    hopf = 10 * (10 + 8 / 3 + 3) / (10 - 8 / 3 - 1)
    assert within(found, [1.0, 1.0, hopf, hopf])
    assert found["special_error"].max() < 1e-11
    kinds = found.cd.words("special_kind").values
    born = found.cd.words("special_criticality").values
    assert born[kinds == "hopf"].tolist() == ["subcritical"] * 2
    omega = np.sqrt(8 / 3 * (10 + hopf))
    assert np.abs(found["special_frequency"].values[kinds == "hopf"] - omega).max() < 1e-12


def test_special_points_at_the_limits_are_listed(lorenz):
    hopf = 10 * (10 + 8 / 3 + 3) / (10 - 8 / 3 - 1)
    found = cd.equilibria(lorenz[0].with_parameters(r=10.0), {"r": (1.0, hopf)})
    assert within(found, [1.0, 1.0, hopf, hopf])
    assert sorted(kind for kind, _ in specials(found)) == ["branch_point"] * 2 + ["hopf"] * 2


def test_special_points_of_equilibria_are_not_named_as_those_of_orbits(lorenz):
    """By the command line, which has 2 and 3 for a period doubling and a Neimark-Sacker point of an orbit."""
    _, found = lorenz
    assert count_special_points(found["special_kind"]) == {"branch_point": 2, "hopf": 2}
    lines = orbit_lines(found)
    hopf = 10 * (10 + 8 / 3 + 3) / (10 - 8 / 3 - 1)
    assert sum(line.startswith(f"  hopf at r = {hopf:.8g}") for line in lines) == 2
    assert sum(line.startswith("  branch point at r = ") for line in lines) == 2
    counts = [line for line in lines if line.startswith("branch ")]
    assert len(counts) == found.sizes["branch_number"]
    assert all("mode flow, " in line for line in counts)


def test_the_unstable_cycle_of_lorenz_is_followed_from_its_hopf_point_and_back(lorenz):
    system, found = lorenz
    k = int(np.flatnonzero(found.cd.words("special_kind").values == "hopf")[0])
    start = system.with_parameters(r=float(found["cycle_value"][k])).with_initial(found["cycle_state"][k])
    branch = cd.continue_orbit(start, {"r": (22.0, 26.0)}, start="guess")
    assert branch.cd.outcome == "periodic"
    assert not branch["stable"].values[branch["special_point"].values == 0].any()
    assert branch.cd.words("special_kind").values.tolist() == ["hopf"]
    assert abs(branch["special_value"].item() - found["special_value"].values[k]) < 1e-11
    assert branch.cd.words("special_criticality").item() == "subcritical"
    assert "subcritical Hopf point of mode 'flow'" in branch["branch_end_text"].item()


def test_brusselator_against_its_closed_form():
    """Hopf at b = 1 + a^2 with omega = a; l1 from the normal form (Kuznetsov 2023, example 3.1), rescaled."""
    a = 1.3
    rates = {"x": "a - (b + 1)*x + x**2*y", "y": "b*x - x**2*y"}
    system = flow("brusselator", rates, {"a": a, "b": 2.0}, x=1.0, y=1.0)
    found = cd.equilibria(system, {"b": (1.0, 4.0)})
    assert within(found, [1 + a**2])
    assert abs(found["special_frequency"].item() - a) < 1e-14
    assert found.cd.words("special_criticality").item() == "supercritical"
    start = system.with_parameters(b=float(found["cycle_value"][0])).with_initial(found["cycle_state"][0])
    cycle = cd.periodic_orbit(start, start="guess")
    assert abs(cycle["period_time"].item() / found["cycle_period"].item() - 1) < 1e-5
    extent = np.ptp(cycle["path_state"].values, axis=0) / 2
    assert np.abs(extent / found["cycle_amplitude"].values[0] - 1).max() < 3e-3
    # planes across the flow do not contain the equilibrium, and the branch gets there all the same
    top = {"top": {"of": "x", "take": "maximum"}}
    branch = cd.continue_orbit(start, {"b": (2.5, 2.9)}, start="guess", functions=top)
    assert abs(branch["function_value"].values[branch["special_index"].item(), 0] - a) < 1e-10
    assert branch.cd.words("special_kind").values.tolist() == ["hopf"]
    assert abs(branch["special_value"].item() - (1 + a**2)) < 1e-11


@pytest.mark.parametrize("rate", ["{}**3", "{}**3 + 1e-6*{}", "tanh(50*{})", "{}**2"])
def test_bars_of_hopf_points_where_the_pair_crosses_slowly_or_fast(rate):
    """The cycle of the normal form has the square of its radius equal to the rate, which is zero at 1.2345."""
    rate = rate.replace("{}", "(m - 1.2345)")
    field = {"x": f"({rate})*x - 3*y - x*(x**2 + y**2)", "y": f"3*x + ({rate})*y - y*(x**2 + y**2)"}
    radius = float(np.sqrt(eval(rate, {"m": 1.6, "tanh": np.tanh})))
    cycles = flow("slow", field, {"m": 1.6}, x=radius, y=0.0)
    ends = [cd.continue_orbit(cycles, {"m": (0.0, 2.0)}, start="guess", step=0.05)]
    if rate[-1] != "2":
        ends.append(cd.equilibria(cycles.with_initial([0.0, 0.0]), {"m": (0.0, 2.0)}))
    for found in ends:
        assert [kind for kind, _ in specials(found)] == ["hopf"]
        assert within(found, [1.2345])
        assert found["special_error"].item() < 4e-5
    assert "shrinks onto the equilibrium" in ends[0]["branch_end_text"].item()


def test_adaptive_control_has_the_published_coefficient_and_cycles():
    """MatCont manual (version 7p4), adaptive control: l1 = -0.3000001 at 1; the cycle doubles at 0.6303020."""
    rates = {"x": "y", "y": "z", "z": "-alpha*z - beta*y - x + x**2"}
    system = flow("adaptx", rates, {"alpha": 1.5, "beta": 1.0}, x=0.1)
    region = {"x": (-0.5, 0.5), "y": (-0.5, 0.5), "z": (-0.5, 0.5)}
    found = cd.equilibria(system, {"alpha": (0.5, 2.0)}, region=region)
    assert within(found, [1.0])
    assert abs(found["special_coefficient"].item() + 0.3) <= found["special_coefficient_error"].item() < 1e-11
    start = system.with_parameters(alpha=float(found["cycle_value"][0])).with_initial(found["cycle_state"][0])
    branch = cd.continue_orbit(start, {"alpha": (0.62, 1.1)}, start="guess")
    by_kind = dict(specials(branch))
    assert abs(by_kind["period_doubling"] - 0.6303020) < 1e-6
    k = int(np.flatnonzero(branch.cd.words("special_kind").values == "period_doubling")[0])
    assert abs(branch["period_time"].values[branch["special_index"].values[k]] - 6.364071) < 1e-5
    assert abs(by_kind["hopf"] - 1.0) < 1e-12


def test_the_catalytic_oscillator_has_the_published_points():
    """MatCont manual (version 6.11), Bykov's model: l1 there is times the frequency, and by differences."""
    z = "(1 - x - y - s)"
    rates = {
        "x": f"2*q1*{z}**2 - 2*q5*x**2 - q3*x*y",
        "y": f"q2*{z} - q6*y - q3*x*y",
        "s": f"q4*{z} - k*q4*s",
    }
    given = {"q1": 2.5, "q2": 2.204678, "q3": 10.0, "q4": 0.0675, "q5": 1.0, "q6": 0.1, "k": 0.4}
    system = flow("catalytic", rates, given, x=0.001137, y=0.891483, s=0.062345)
    found = cd.equilibria(system, {"q2": (0.8, 2.5)}, region=dict.fromkeys("xys", (0, 1)))
    at = found["special_index"].values
    ours = dict(zip(specials(found), found["equilibrium_state"].values[at].tolist(), strict=True))
    printed = {
        ("hopf", 1.051558): (0.016357, 0.523973, 0.328336),
        ("fold", 1.042049): (0.024717, 0.450257, 0.375018),
        ("fold", 1.052200): (0.054030, 0.302241, 0.459807),
        ("hopf", 1.040991): (0.077929, 0.233063, 0.492149),
    }
    assert [kind for kind, _ in sorted(ours)] == [kind for kind, _ in sorted(printed)]
    for (one, state), (other, known) in zip(sorted(ours.items()), sorted(printed.items()), strict=True):
        assert [one[1], *state] == pytest.approx([other[1], *known], abs=5e-6)
    hopf = np.argsort(found["special_value"].values[found.cd.words("special_kind").values == "hopf"])
    l1 = (found["special_coefficient"] * found["special_frequency"]).dropna("special").values
    assert l1[hopf] == pytest.approx([4.332247, 10.70259], rel=3e-4)


def planar(second, third, bend=0.0, scale=1.0):
    """x' = m x - w y + f, y' = w x + m y + g in the states u = x and v = scale (y + bend x^2), w = 1.4."""
    (fxx, fxy, fyy, gxx, gxy, gyy), (fxxx, fxyy, gxxy, gyyy) = second, third
    y = f"(v/scale - ({bend})*u**2)"
    f = f"({fxx}*u**2/2 + {fxy}*u*{y} + {fyy}*{y}**2/2 + {fxxx}*u**3/6 + {fxyy}*u*{y}**2/2)"
    g = f"({gxx}*u**2/2 + {gxy}*u*{y} + {gyy}*{y}**2/2 + {gxxy}*u**2*{y}/2 + {gyyy}*{y}**3/6)"
    du = f"(m*u - 1.4*{y} + {f})"
    rates = {"u": du, "v": f"scale*(1.4*u + m*{y} + {g} + 2*({bend})*u*{du})"}
    return flow("planar", rates, {"m": 0.3, "scale": scale}, u=0.2, v=0.1)


@pytest.mark.parametrize(("bend", "scale"), [(0.0, 1.0), (0.7, 1.0), (-0.4, 5.0)])
def test_the_coefficient_of_a_planar_normal_form_in_several_coordinates(bend, scale):
    """Guckenheimer and Holmes 1983, (3.4.11): r' = a r^3; l1 = 4 a/(w (1 + scale^2)) for an eigenvector of length 1."""
    second, third, w = (0.3, -0.7, 0.5, 0.2, 0.9, -0.4), (-0.6, 0.8, -1.1, 0.25), 1.4
    (fxx, fxy, fyy, gxx, gxy, gyy), (fxxx, fxyy, gxxy, gyyy) = second, third
    a = (fxxx + fxyy + gxxy + gyyy) / 16
    a += (fxy * (fxx + fyy) - gxy * (gxx + gyy) - fxx * gxx + fyy * gyy) / (16 * w)
    region = {"u": (-0.1, 0.1), "v": (-0.1, 0.1)}
    found = cd.equilibria(planar(second, third, bend, scale), {"m": (-0.2, 0.4)}, region=region)
    exact = 4 * a / (w * (1 + scale**2))
    assert abs(found["special_coefficient"].item() - exact) <= found["special_coefficient_error"].item() < 1e-11
    assert abs(found["special_value"].item()) <= found["special_error"].item() < 1e-13


def test_a_coefficient_that_vanishes_is_undecided():
    """x'' - m (1 - x^2) x' + x = 0: at m = 0 all that is not linear has gone, and every orbit is a cycle."""
    found = cd.equilibria(flow("pol", {"x": "v", "v": "m*(1 - x**2)*v - x"}, {"m": 0.2}, x=0.5), {"m": (-1.0, 1.0)})
    assert specials(found)[0][0] == "hopf"
    assert found.cd.words("special_criticality").item() == "undecided"
    assert abs(found["special_coefficient"].item()) <= found["special_coefficient_error"].item()
    # with the cubic term kept it is soft, with l1 = -1/4 (x^2 x' alone)
    found = cd.equilibria(flow("pol", {"x": "v", "v": "(m - x**2)*v - x"}, {"m": 0.2}, x=0.5), {"m": (-1.0, 1.0)})
    assert abs(found["special_coefficient"].item() + 0.25) < 1e-14


def test_stribeck_friction_on_a_belt_has_a_hopf_point_in_closed_form():
    """Force F - a w + b w^3 of the relative speed w: steady slip at x = F - a V + b V^3, Hopf at V^2 = a/(3 b)."""
    belt = cd.filippov(
        name="belt",
        states="x v",
        parameters={"V": 1.0, "F": 1.0, "a": 0.6, "b": 0.5},
        surface={"w": "v - V"},
        above={"x": "v", "v": "-x - F - a*(V - v) + b*(V - v)**3"},
        below={"x": "v", "v": "-x + F - a*(V - v) + b*(V - v)**3"},
        initial={"x": 0.5, "v": 0.0},
    )
    found = cd.equilibria(belt, {"V": (0.2, 1.5)}, region={"x": (-3, 3), "w": (-3, 3)}, modes=["below"])
    assert within(found, [np.sqrt(0.4)])
    assert found.cd.words("special_criticality").item() == "supercritical"
    assert abs(found["special_coefficient"].item() + 0.75 * 0.5) <= found["special_coefficient_error"].item()
    at = found["equilibrium_state"].values[found["special_index"].item()]
    assert abs(at[0] - (1 - 0.6 * np.sqrt(0.4) + 0.5 * 0.4**1.5)) < 1e-14
    assert "rests only where parameters make it zero" in cd.equilibria(belt, modes=["sliding"]).attrs["message"]


def sliding(k):
    return cd.filippov(
        name="two fields",
        states="x y",
        parameters={"m": 0.3, "q": 1.0, "k": k},
        surface="y",
        above={"x": "-x - y", "y": "x - y + m"},
        below={"x": "-k*q", "y": "q"},
        initial={"x": 1.0, "y": 1.0},
    )


@pytest.mark.parametrize(("k", "what"), [(0.3, "persistence"), (3.0, "nonsmooth_fold")])
def test_what_follows_a_boundary_equilibrium_of_sliding(k, what):
    """di Bernardo, Nordmark, Olivar 2008: the sign of C A^-1 (F2 - F1), here (k - 1)/2, decides."""
    found = cd.equilibria(sliding(k), {"m": (-0.5, 0.5)})
    assert [kind for kind, _ in specials(found)] == ["boundary"] * 2
    assert np.abs(found["special_value"]).max() < 1e-15
    assert found.cd.words("special_beyond").values.tolist() == [what] * 2
    modes = found.cd.words("mode").values
    admissible = found.cd.words("admissible").values
    for mode, sign in (("above", 1), ("sliding", 1 if what == "nonsmooth_fold" else -1)):
        beyond = sign * found["m"].values
        assert set(admissible[(modes == mode) & (beyond > 1e-12)]) == {"admissible"}
        assert set(admissible[(modes == mode) & (beyond < -1e-12)]) == {"virtual"}


def test_what_follows_between_persistence_and_a_fold_is_undecided():
    # at k = 1 that sign is zero
    assert cd.equilibria(sliding(1.0), {"m": (-0.5, 0.5)}).cd.words("special_beyond").values.tolist() == ["undecided"]


def test_boundaries_of_a_continuous_field_and_of_a_wall():
    stop = cd.in_modes(
        name="stop",
        states="x v",
        parameters={"p": 0.5, "k": 20.0},
        field={"x": "v", "v": "p - x - 0.1*v - k*Max(x - 1, 0)"},
        initial={"x": 0.2},
    )
    found = cd.equilibria(stop, {"p": (0.0, 2.0)})
    assert [kind for kind, _ in specials(found)] == ["boundary"] * 2
    assert within(found, [1.0, 1.0])
    assert found.cd.words("special_beyond").values.tolist() == ["persistence"] * 2
    fold = cd.in_modes(name="fold", states="x", parameters={"p": 0.5}, field={"x": "p - Abs(x)"}, initial={"x": 0.2})
    found = cd.equilibria(fold, {"p": (-1.0, 1.0)})
    assert found.cd.words("special_beyond").values.tolist() == ["nonsmooth_fold"] * 2
    wall = cd.HybridSystem(
        name="wall",
        states="x v",
        parameters={"p": 0.5},
        modes={"free": {"x": "v", "v": "p - x - 0.1*v"}},
        transitions=[cd.Transition("hit", "free", "free", "x - 1", +1, reset={"v": "-0.8*v"})],
        initial={"x": 0.2},
    )
    found = cd.equilibria(wall, {"p": (0.0, 2.0)})
    assert found.cd.words("special_beyond").values.tolist() == ["no_partner"]
    assert found.cd.words("admissible").values[-1] == "virtual"
    assert "hit" in found["special_text"].item()


@pytest.mark.parametrize(("pull", "beyond"), [("F", "undecided"), ("F - b/10", "no_partner")])
def test_a_mode_that_rests_anywhere_is_not_without_equilibria(pull, beyond):
    # without load a gear rests anywhere in its backlash
    gear = cd.HybridSystem(
        name="gear",
        states="x v",
        parameters={"F": 0.1, "b": 1.0},
        modes={"flank": {"x": "v", "v": "F - 0.1*v - (x - b)"}, "backlash": {"x": "v", "v": f"{pull} - 0.1*v"}},
        transitions=[
            cd.Transition("loses", "flank", "backlash", "x - b", -1),
            cd.Transition("meets", "backlash", "flank", "x - b", +1),
        ],
        initial={"mode": "flank", "x": 1.1},
    )
    found = cd.equilibria(gear, {"F": (-0.5, 0.5)})
    assert within(found, [0.0])
    assert found.cd.words("special_beyond").values.tolist() == [beyond]
    assert "rests only where parameters make it zero" in found.attrs["message"]


def test_a_branch_is_followed_to_where_a_logarithm_runs_away():
    # without infection beyond b = g + m: log I falls without bound there, and its column of the Jacobian underflows
    rates = {"s": "m*exp(-s) - b*exp(i) - m", "i": "b*exp(s) - (g + m)"}
    found = cd.equilibria(flow("epidemic", rates, {"b": 2.0, "g": 0.5, "m": 0.02}, s=-1.2, i=-4.6), {"b": (0.1, 3.0)})
    assert found.cd.words("branch_end").values.tolist() == ["escaped"]
    assert abs(float(found["b"].min()) - 0.52) < 1e-12
    known = found["equilibrium_state"].sel(state="i").values > -30
    b, (s, i) = found["b"].values[known], found["equilibrium_state"].values[known].T
    assert np.abs(s - np.log(0.52 / b)).max() < 1e-12
    assert np.abs(np.exp(i) - 0.02 * (1 / 0.52 - 1 / b)).max() < 1e-12


def test_a_python_function_has_its_points_without_normal_forms():
    def rates(t, x, p):
        return x.v, p.k * x.x - x.x**3 - x.v

    system = cd.HybridSystem(states="x v", parameters={"k": 1.0}, modes={"on": rates}, initial={"x": 0.3})
    region = {"x": (-2, 2), "v": (-1, 1)}
    found = cd.equilibria(system, {"k": (-1.0, 2.0)}, region=region, method="dop853")
    assert np.abs(found["special_value"].values).max() < 1e-7
    assert set(found.cd.words("special_kind").values.tolist()) == {"branch_point"}


def test_pairs_that_cross_together_are_one_point_of_multiplicity_four():
    rates = {"x": "m*x - y - x*(x**2 + y**2)", "y": "x + m*y - y*(x**2 + y**2)"}
    rates |= {
        name.replace("x", "u").replace("y", "v"): e.replace("x", "u").replace("y", "v") for name, e in rates.items()
    }
    found = cd.equilibria(flow("two", rates, {"m": 0.2}, x=0.3, u=0.2), {"m": (-0.5, 0.5)})
    assert [kind for kind, _ in specials(found)] == ["hopf"]
    assert found["special_multiplicity"].item() == 4
    assert abs(found["special_value"].item()) < 1e-14


def test_pairs_that_share_a_vector_have_no_coefficient():
    rates = {"x": "m*x - y + u", "y": "x + m*y + v", "u": "m*u - v - u**3", "v": "u + m*v"}
    found = cd.equilibria(flow("chain", rates, {"m": -0.2}), {"m": (-0.5, 0.5)})
    assert found["special_multiplicity"].values.tolist() == [4]
    assert found.cd.words("special_criticality").item() == "undecided"
    assert np.isnan(found["special_coefficient"].item())


@pytest.mark.parametrize(("bend", "scale"), [(0.0, 1.0), (0.7, 5.0)])
def test_crossings_there_and_back_within_a_step_are_found(bend, scale):
    """The real part is (m - 0.1003)(m - 0.1004) of one pair; or m - 0.1003 of one pair and 0.1004 - m of another."""

    def pair(growth, one, other):
        y = f"({other}/{scale} - {bend}*{one}**2)"
        change = f"(({growth})*{one} - 1.4*{y} - {one}*({one}**2 + {y}**2))"
        turned = f"1.4*{one} + ({growth})*{y} - {y}*({one}**2 + {y}**2) + 2*{bend}*{one}*{change}"
        return {one: change, other: f"{scale}*({turned})"}

    exact = [0.1003, 0.1004]
    region = dict.fromkeys("uvxy", (-0.1, 0.1))
    for rates in (
        pair("(m - 0.1003)*(m - 0.1004)", "u", "v"),
        pair("m - 0.1003", "u", "v") | pair("0.1004 - m", "x", "y"),
    ):
        near = {name: region[name] for name in rates}
        found = cd.equilibria(flow("back", rates, {"m": 0.5}, u=0.2), {"m": (-0.2, 0.6)}, region=near)
        assert [kind for kind, _ in specials(found)] == ["hopf", "hopf"]
        assert found["special_multiplicity"].values.tolist() == [2, 2]
        assert within(found, exact)
        assert found["special_error"].values.max() < 1e-10
        assert found.attrs["message"] == ""
    # two transcritical points as near to each other
    found = cd.equilibria(
        flow("twice", {"x": "(m - 0.1003)*(m - 0.1004)*x - x**2"}, {"m": 0.5}, x=0.0), {"m": (-0.2, 0.6)}
    )
    crossed = [value for kind, value in specials(found) if kind == "branch_point"]
    np.testing.assert_allclose(np.unique(np.round(crossed, 9)), exact, atol=1e-9)


SCENE = """\
title = "where an oscillation begins"

[system.definition]
name = "van-der-pol"
states = "x v"

[system.definition.modes.flow]
x = "v"
v = "(m - x**2)*v - x"

[system.parameters]
m = 0.2

[system.initial]
x = 0.5

[analysis.rest]
kind = "equilibria"
region = { x = [-1, 1], v = [-1, 1] }

[analysis.branch]
kind = "equilibria"
sweep.m = { start = -1.0, stop = 1.0 }
region = { x = [-1, 1], v = [-1, 1] }
"""


def test_a_scene_gives_an_archive_that_is_verified_and_reported(tmp_path):
    scene = cd.parse_scene(SCENE)
    archive = cd.save(cd.run(scene), tmp_path / "rest.nc")
    assert cd.verify(archive).equal
    page = cd.report(archive, tmp_path / "page.html")
    assert page.faults == ()
    assert page.pictures == 2
    text = page.path.read_text(encoding="utf-8")
    for words in ("Equilibria</caption>", "Branches of equilibria</caption>", "first Lyapunov coefficient"):
        assert words in text
    held = cd.open(archive)["branch"].to_dataset()
    assert held.cd.words("special_kind").values.tolist() == ["hopf"]
    with pytest.raises(cd.SceneError, match="must increase"):
        _ = cd.parse_scene(SCENE.replace("x = [-1, 1], v", "x = [1, -1], v")).system
