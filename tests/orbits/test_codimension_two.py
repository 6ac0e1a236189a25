"""Neimark-Sacker curves and points of codimension two, against closed forms of maps, flows and hybrid orbits."""

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.dataset.branches import Special

NEIMARK_SACKER = Special.NEIMARK_SACKER


def points(result, *kinds):
    """Values of both parameters at the special points of these kinds, shape (k, 2), in order of the first."""
    named = [k for k, code in enumerate(result["special_kind"].values) if Special(int(code)) in kinds]
    found = np.array([result["special_value"].values[named], result["special_value_2"].values[named]]).T
    return found[np.lexsort(found.T[::-1])]


def others(result):
    """Kinds of the special points but for the one from which the curve was followed, counted."""
    start = [text == "start of the curve" for text in result["special_text"].values]
    kinds = [Special(int(k)) for k, first in zip(result["special_kind"].values, start, strict=True) if not first]
    return {kind: kinds.count(kind) for kind in kinds}


def within(result, kind, exact, factor=3.0):
    """Whether the points of a kind are where they should be, the first parameter within its error."""
    found, exact = points(result, kind), np.array(sorted(map(tuple, exact)))
    errors = result["special_error"].values[[Special(int(k)) == kind for k in result["special_kind"].values]]
    return (
        found.shape == exact.shape
        and bool((np.abs(found - exact)[:, 0] <= factor * errors.max()).all())
        and np.abs(found - exact).max() < 1e-7
    )


# A family of predator-prey maps through the delayed logistic map, c = 0: the Jacobian of its fixed point 1 - 1/r has
# the determinant (1 - c)(r - 1) and the trace 1 - c(r - 1).


@pytest.fixture(scope="module")
def delayed():
    images = {"x": "r*x*(1 - (1 - c)*y - c*x)", "y": "x"}
    return cd.Map("x y", {"r": 1.9, "c": 0.0}, images, initial={"x": 0.45, "y": 0.45})


@pytest.fixture(scope="module")
def delayed_curve(delayed):
    return cd.continue_orbit(delayed, {"r": (1.5, 6.0), "c": (-0.4, 0.9)}, follow="neimark_sacker", step=0.15)


def test_the_delayed_logistic_map_turns_at_two(delayed_curve):
    r, c = delayed_curve["r"].values, delayed_curve["c"].values
    assert np.abs((1 - c) * (r - 1) - 1).max() < 1e-11
    (start,) = points(delayed_curve, NEIMARK_SACKER)
    # Maynard Smith 1968; there the angle is pi/3
    assert abs(start[0] - 2) < 1e-12
    assert delayed_curve.attrs["message"] == ""


def test_its_resonances_are_where_the_trace_says(delayed_curve):
    assert others(delayed_curve) == {
        Special.RESONANCE_1_4: 1,
        Special.RESONANCE_1_3: 1,
        Special.RESONANCE_1_2: 1,
    }
    assert within(delayed_curve, Special.RESONANCE_1_4, [(3, 1 / 2)])
    assert within(delayed_curve, Special.RESONANCE_1_3, [(4, 2 / 3)])
    assert within(delayed_curve, Special.RESONANCE_1_2, [(5, 3 / 4)])


@pytest.mark.parametrize(
    ("r", "c", "last"),
    [
        (4.0, 0.9, Special.RESONANCE_1_3),
        (6.0, 2 / 3, Special.RESONANCE_1_3),
        (5.0, 0.9, Special.RESONANCE_1_2),
        (6.0, 0.75, Special.RESONANCE_1_2),
    ],
)
@pytest.mark.parametrize("step", [0.15, 0.3])
def test_a_resonance_at_the_limit_of_a_parameter_stands_once(delayed, r, c, last, step):
    limits = {"r": (1.5, r), "c": (-0.4, c)}
    found = cd.continue_orbit(delayed, limits, follow="neimark_sacker", step=step)
    expected = {Special.RESONANCE_1_4: (3, 1 / 2), Special.RESONANCE_1_3: (4, 2 / 3), Special.RESONANCE_1_2: (5, 3 / 4)}
    kinds = list(expected)[: list(expected).index(last) + 1]
    assert others(found) == dict.fromkeys(kinds, 1)
    for kind in kinds:
        assert within(found, kind, [expected[kind]])


def test_behind_a_resonance_nothing_bifurcates(delayed_curve):
    r, kind = delayed_curve["r"].values, delayed_curve["special_point"].values
    assert ((kind == Special.REGULAR) == (r > 5 + 1e-9)).all()
    assert ((delayed_curve["stable"].values != 0) == (r < 5 + 1e-9)).all()


def test_special_points_do_not_depend_on_step_and_start(delayed):
    limits = {"r": (1.5, 6.0), "c": (-0.4, 0.9)}
    places = []
    # at c = 1/2 the curve starts at a resonance
    for c, step in ((0.2, 0.08), (0.5, 0.3)):
        start = delayed.with_parameters(c=c, r=1 + 0.95 / (1 - c))
        found = cd.continue_orbit(start, limits, follow="neimark_sacker", step=step, transient=400)
        assert sum(others(found).values()) == 3
        places.append(points(found, Special.RESONANCE_1_2, Special.RESONANCE_1_3, Special.RESONANCE_1_4))
    np.testing.assert_allclose(*places, rtol=0, atol=1e-11)


# The generalised Henon map of Gonchenko, (x, y) -> (y, alpha - beta x - y^2 + R x y + S y^3): Kuznetsov and Meijer
# 2005, doi:10.1137/030601508. At the fixed point x = y the determinant is beta - R y, the trace (R - 2) y + 3 S y^2.

R = 0.3


@pytest.fixture(scope="module")
def henon():
    images = {"x": "y", "y": "alpha - beta*x - y**2 + R*x*y + S*y**3"}
    return cd.Map("x y", {"alpha": 0.0, "beta": 0.5, "R": R, "S": 0.1}, images)


def alpha(y, beta, s):
    return y + beta * y + (1 - R) * y**2 - s * y**3


def fixed(henon, y, beta, s):
    return henon.with_parameters(alpha=alpha(y, beta, s), beta=beta, S=s).with_initial(x=y, y=y)


def on_circle(cosine, s):
    """Both points of the Neimark-Sacker curve at which the angle has this cosine."""
    return [(1 + R * y, alpha(y, 1 + R * y, s)) for y in np.roots([3 * s, R - 2, -2 * cosine]).real]


def test_all_strong_resonances_of_the_generalised_henon_map(henon):
    s = 0.1
    result = cd.continue_orbit(
        fixed(henon, 0.3, 1.04, s),
        {"beta": (0.2, 3.2), "alpha": (-5.0, 40.0)},
        follow="neimark_sacker", start="guess", step=0.1,
    )  # fmt: skip
    kinds = (Special.RESONANCE_1_1, Special.RESONANCE_1_2, Special.RESONANCE_1_3, Special.RESONANCE_1_4)
    for kind, cosine in zip(kinds, (1, -1, -0.5, 0), strict=True):
        assert within(result, kind, on_circle(cosine, s))
    assert others(result) == dict.fromkeys(kinds, 2)
    assert set(result["special_multiplicity"].values[1:].tolist()) <= {0, 2}


def test_the_torus_is_born_softly_up_to_a_chenciner_point(henon):
    s = 0.7
    result = cd.continue_orbit(
        fixed(henon, 0.3, 1.04, s), {"beta": (0.95, 1.15), "alpha": (-1.0, 2.0)},
        follow="neimark_sacker", start="guess", step=0.02,
    )  # fmt: skip
    # the coefficient, with derivatives of the map by hand, vanishes at y = 1/3
    assert within(result, Special.CHENCINER, [(1 + R / 3, alpha(1 / 3, 1 + R / 3, s))])
    assert others(result) == {Special.CHENCINER: 1, Special.RESONANCE_1_4: 1}


def test_cusp_and_resonances_on_the_curve_of_folds(henon):
    s = 0.7
    result = cd.continue_orbit(
        fixed(henon, 0.3, 0.5, s), {"alpha": (-5.0, 5.0), "beta": (-3.0, 3.0)},
        follow="fold", start="guess", step=0.2,
    )  # fmt: skip
    cusp = (1 - R) / (3 * s)
    beta = -1 - 2 * (1 - R) * cusp + 3 * s * cusp**2
    assert within(result, Special.CUSP, [(alpha(cusp, beta, s), beta)])
    # determinant 1 and trace 2; determinant -1 and trace 0
    ones = np.roots([3 * s, R - 2, -2])
    assert within(result, Special.RESONANCE_1_1, [(alpha(y, 1 + R * y, s), 1 + R * y) for y in ones])
    flips = (0.0, (2 - R) / (3 * s))
    assert within(result, Special.FOLD_FLIP, [(alpha(y, -1 + R * y, s), -1 + R * y) for y in flips])
    assert others(result) == {Special.CUSP: 1, Special.RESONANCE_1_1: 2, Special.FOLD_FLIP: 2}


def test_what_meets_the_curve_of_doublings(henon):
    s = 0.1
    result = cd.continue_orbit(
        fixed(henon, 0.06, -0.9, s), {"alpha": (-1.0, 10.0), "beta": (-1.5, 3.0)},
        follow="period_doubling", start="guess", step=0.4,
    )  # fmt: skip
    y = min(np.roots([3 * s, R - 2, 2]).real)
    assert within(result, Special.RESONANCE_1_2, [(alpha(y, 1 + R * y, s), 1 + R * y)])
    assert within(result, Special.FOLD_FLIP, [(0.0, -1.0)])
    assert others(result) == {Special.RESONANCE_1_2: 1, Special.FOLD_FLIP: 1}


def test_a_doubling_turns_hard_in_any_coordinates():
    # -(1 + m) z + z^2 + b z^3 + z u doubles at m = 0; u = z^2/2 on the centre manifold of u/2 + z^2/4, so that it does
    # so softly as long as 1 + b + 1/2 > 0; here x = 1000 (z + 3) and y = u + z/5
    z = "(x/1000 - 3)"
    u = f"(y - {z}/5)"
    image = f"(-(1 + m)*{z} + {z}**2 + b*{z}**3 + {z}*{u})"
    system = cd.Map(
        "y x", {"m": -0.1, "b": 0.5}, {"x": f"1000*({image} + 3)", "y": f"{u}/2 + {z}**2/4 + {image}/5"},
        initial={"x": 3000.0},
    )  # fmt: skip
    result = cd.continue_orbit(system, {"m": (-0.2, 0.2), "b": (-2.0, 1.0)}, follow="period_doubling", step=0.1)
    assert within(result, Special.GENERALISED_FLIP, [(0.0, -1.5)])
    assert others(result) == {Special.GENERALISED_FLIP: 1}


# Cycles of a flow: z' = c + a z - k z^3/3 - r^2, r' = (z - 1) r, turning at the rate d. The cycle z = 1 has the
# exponents of this planar system, a - k their sum and 2 r^2 their product; it turns softly where k > 0.


def test_a_torus_of_an_autonomous_flow():
    rates = {"x": "(z - 1)*x - 7*y/2", "y": "7*x/2 + (z - 1)*y", "z": "1/2 + a*z - k*z**3/3 - x**2 - y**2"}
    system = cd.HybridSystem(
        name="langford", states="x y z", parameters={"a": 0.45, "k": 0.5}, modes={"flow": rates},
        initial={"x": 0.9, "z": 1.0},
    )  # fmt: skip
    limits = {"a": (-0.3, 0.8), "k": (-0.3, 0.8)}
    result = cd.continue_orbit(system, limits, follow="neimark_sacker", at="y < 0", step=0.1)
    assert np.abs(result["a"].values - result["k"].values).max() < 1e-11
    assert result["stable"].values.all()

    def angle(share):
        """Where 2 pi sqrt(2 r^2)/d is this share of a turn, with r^2 = 1/2 + 2 k/3."""
        return [((3.5 * share) ** 2 / 2 - 0.5) * 1.5] * 2

    assert within(result, Special.RESONANCE_1_3, [angle(1 / 3)])
    assert within(result, Special.RESONANCE_1_4, [angle(1 / 4)])
    assert within(result, Special.CHENCINER, [(0.0, 0.0)])
    assert others(result) == {Special.RESONANCE_1_3: 1, Special.RESONANCE_1_4: 1, Special.CHENCINER: 1}


# A ball on a moving floor A cos t, g = 1, an impact a period: the determinant is e^2. At e = 1 it is met at its top,
# and with the flow between the impacts integrated by hand the trace is 2 - 4 A.


def test_impacts_without_loss():
    hit = cd.Transition("impact", "flight", "flight", "x - A*cos(t)", -1, reset={"v": "-e*v - (1 + e)*A*sin(t)"})
    ball = cd.HybridSystem(
        name="ball", states="x v", parameters={"A": 0.3, "e": 0.97}, modes={"flight": {"x": "v", "v": "-1"}},
        transitions=[hit], period="2*pi", initial={"x": 0.3, "v": np.pi - 0.001},
    )  # fmt: skip
    result = cd.continue_orbit(
        ball, {"e": (0.9, 1.1), "A": (0.2, 1.1)}, follow="neimark_sacker", start="guess", step=0.03
    )
    assert np.abs(result["e"].values - 1).max() < 1e-12
    floor, values = result["A"].values, result["multiplier_real"].values
    circling = floor < 1 - 1e-9
    assert np.abs(values[circling] - (1 - 2 * floor[circling])[:, np.newaxis]).max() < 1e-10
    assert within(result, Special.RESONANCE_1_4, [(1.0, 0.5)])
    assert within(result, Special.RESONANCE_1_3, [(1.0, 0.75)])
    assert within(result, Special.RESONANCE_1_2, [(1.0, 1.0)])
    # the map preserves areas: the coefficient is zero along the curve, and changes its sign nowhere
    assert others(result) == {Special.RESONANCE_1_2: 1, Special.RESONANCE_1_3: 1, Special.RESONANCE_1_4: 1}


# The touching orbit of a curve of grazing folds and doubles: x is a driven oscillator, u rests at the root of q, which
# moves the wall, and w is turned over once a period.


def test_a_touching_orbit_folds_and_doubles():
    system = cd.HybridSystem(
        name="touching",
        states="x v u w",
        parameters={"p": 0.6, "q": 0.3},
        modes={"free": {"x": "v", "v": "-4*x - v/2 + cos(t)", "u": "(q - u**2)/10", "w": "0"}},
        transitions=[
            cd.Transition("wall", "free", "free", "x + u/5 - p", 1, reset={"v": "-v/2"}),
            cd.Transition("turn", "free", "free", "sin(t)", 1, reset={"w": "-(q + 0.5)*w"}),
        ],
        period="2*pi",
        initial={"u": 0.5, "w": 0.1},
    )
    result = cd.continue_orbit(system, {"p": (0.05, 0.8), "q": (-0.1, 0.8)}, follow="grazing", step=0.4)
    height = 1 / np.hypot(3, 0.5)
    p_, q_ = result["p"].values, result["q"].values
    assert np.abs((5 * (p_ - height)) ** 2 - q_).max() < 1e-10
    assert within(result, Special.GRAZING_FOLD, [(height, 0.0)])
    assert within(result, Special.GRAZING_FLIP, [(height + sign * np.sqrt(0.5) / 5, 0.5) for sign in (-1, 1)])
    assert others(result) == {Special.GRAZING_FOLD: 1, Special.GRAZING_FLIP: 2}
