"""Invariant manifolds of saddles, held to exact curves, symmetries, published values, and an independent simulation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial import cKDTree

import chaosdrill as cd
from chaosdrill.dataset.curves import CurveBreak, CurveEnd

FAR = {"x": (-1e3, 1e3), "y": (-1e3, 1e3)}
BOX = {"x": (-2, 2), "y": (-2, 2)}


def curve(ds, number):
    return ds["curve_state"].values[ds["curve"].values == number]


def numbers(ds, stable):
    return ds["curve_number"].values[ds["curve_stable"].values == stable]


def points(ds, stable):
    return np.concatenate([curve(ds, number) for number in numbers(ds, stable)])


def distance_to(ds, stable, states):
    """Distances of states from the chords of curves, in parts of the region."""
    scale = ds["region"].values[1] - ds["region"].values[0]
    found = np.full(len(states), np.inf)
    for number in numbers(ds, stable):
        here = ds["curve"].values == number
        rows, part = ds["curve_state"].values[here] / scale, ds["part"].values[here]
        joined = np.diff(part) == 0
        begin, step = rows[:-1][joined], np.diff(rows, axis=0)[joined]
        _, near = cKDTree(begin + step / 2).query(states / scale, k=min(40, len(begin)))
        for j in near.T:
            along = ((states / scale - begin[j]) * step[j]).sum(axis=1) / np.maximum((step[j] ** 2).sum(axis=1), 1e-300)
            foot = begin[j] + np.clip(along, 0, 1)[:, np.newaxis] * step[j]
            found = np.minimum(found, np.linalg.norm(states / scale - foot, axis=1))
    return found


def bowed(m=2.0, names=("x", "y"), unit=1.0):
    """Conjugate to (u, v) -> (m u, v/2) by x = u, y = v + 0.3 u**2, in another unit."""
    x, y = names
    return cd.Map(
        sorted(names),
        {"m": m, "c": 0.3 / unit},
        {x: f"m*{x}", y: f"{y}/2 + (m**2 - 1/2)*c*{x}**2"},
        bounds={x: (-1e3 * unit, 1e3 * unit), y: (-1e3 * unit, 1e3 * unit)},
    )


@pytest.mark.parametrize("m", [2.0, -2.0, 40.0])
def test_curves_of_a_map_conjugate_to_a_linear_one_are_exact(m):
    ds = cd.manifolds(bowed(m), {"x": 1e-3}, region=BOX, length=0.6)
    for stable in (0, 1):
        assert len(numbers(ds, stable)) == 2
        for number in numbers(ds, stable):
            here = ds["curve"].values == number
            x, y = ds["curve_state"].values[here].T
            error = np.abs(x) if stable else np.abs(y - 0.3 * x**2)
            assert (error / 4 <= 2 * ds["curve_error"].values[here] + 1e-15).all()
            assert error.max() < 1e-7
            steps = np.linalg.norm(np.diff(ds["curve_state"].values[here] / 4, axis=0), axis=1)
            assert steps.max() <= 0.01
    assert (ds["curve_length"].values > 0.59).all()
    assert (ds["curve_end"].values == CurveEnd.LENGTH).all()
    sides = [np.sign(curve(ds, number)[-1][0]) for number in numbers(ds, 0)]
    assert sorted(sides) == [-1, 1]


def test_units_names_and_the_order_of_states_do_not_matter():
    known = cd.manifolds(bowed(), {"x": 1e-3}, region=BOX, length=0.6)
    for unit in (1e-9, 1e9):
        box = dict.fromkeys("xy", (-2 * unit, 2 * unit))
        ds = cd.manifolds(bowed(unit=unit), {"x": 1e-3 * unit}, region=box, length=0.6)
        np.testing.assert_allclose(ds["curve_state"].values / unit, known["curve_state"].values, atol=1e-9)
        np.testing.assert_allclose(ds["arclength"].values, known["arclength"].values, atol=1e-9)
    ds = cd.manifolds(bowed(names=("q", "p")), {"q": 1e-3}, region={"q": (-2, 2), "p": (-2, 2)}, length=0.6)
    np.testing.assert_allclose(ds["curve_state"].values[:, ::-1], known["curve_state"].values, atol=1e-9)


def mcmillan(tilt=0.0):
    """A reversible map; without a tilt its separatrix is x**2 y**2 + x**2 + y**2 = 4 x y (McMillan 1971)."""
    return cd.Map("x y", {"k": 4.0, "e": tilt}, {"x": "y", "y": "-x + k*y/(1 + y**2) + e*y**3"}, bounds=FAR)


def test_the_separatrix_of_the_mcmillan_map():
    ds = cd.manifolds(mcmillan(), region=BOX, length=1.2)
    x, y = ds["curve_state"].values.T
    slope = np.hypot(2 * x * y**2 + 2 * x - 4 * y, 2 * x**2 * y + 2 * y - 4 * x)
    off = np.abs(x**2 * y**2 + x**2 + y**2 - 4 * x * y) / np.maximum(slope, 1e-3)
    assert off.max() < 1e-7
    np.testing.assert_allclose(np.sort(ds["multiplier_real"].values), [2 - np.sqrt(3), 2 + np.sqrt(3)], rtol=1e-10)


def test_homoclinic_points_of_a_reversible_map_lie_on_its_axis():
    ds = cd.manifolds(mcmillan(0.02), region=BOX, length=1.0)
    # (x, y) -> (y, x) takes the unstable manifold to the stable one
    assert distance_to(ds, 1, points(ds, 0)[:, ::-1]).max() < 2e-4
    apart = np.abs(ds["crossing_state"].values @ [1, -1])
    assert len(apart) >= 2
    assert (apart[np.argsort(apart)[:2]] / 4 <= ds["crossing_error"].values[np.argsort(apart)[:2]]).all()
    assert (ds["crossing_angle"].values > 0).all()


@pytest.fixture(scope="module")
def henon():
    system = cd.Map(
        "x y", {"a": 1.4, "b": 0.3}, {"x": "1 - a*x**2 + y", "y": "b*x"}, bounds={"x": (-1e6, 1e6), "y": (-1e6, 1e6)}
    )
    return cd.manifolds(system, {"x": 0.63, "y": 0.19}, region={"x": (-1.5, 1.5), "y": (-0.5, 0.5)}, length=6)


def test_the_unstable_manifold_of_henon_lies_in_the_attractor(henon):
    np.testing.assert_allclose(henon["orbit_section"].values, [[0.6313544771, 0.1894063431]], atol=1e-10)
    np.testing.assert_allclose(henon["multiplier_real"].values, [-1.9237388583, 0.1559463222], atol=1e-9)
    x, y = np.full(200, 0.6), np.linspace(0.18, 0.2, 200)
    cloud = []
    for _ in range(1500):
        x, y = 1 - 1.4 * x**2 + y, 0.3 * x
        cloud.append(np.column_stack([x / 3, y]))
    away, _ = cKDTree(np.concatenate(cloud[100:])).query(points(henon, 0) / [3, 1])
    assert away.max() < 2e-3
    assert np.median(away) < 1e-4


def test_images_of_points_of_a_curve_lie_on_it(henon):
    x, y = points(henon, 0).T
    images = np.column_stack([1 - 1.4 * x**2 + y, 0.3 * x])
    ends = henon["generation"].values[henon["curve"].values <= 2]
    last = min(henon["generation"].values[henon["curve"].values == k].max() for k in numbers(henon, 0))
    assert distance_to(henon, 0, images[ends < last - 1]).max() < 0.01 * 0.1 / 8 * 2
    x, y = points(henon, 1).T
    seen = (np.abs(x) < 1.2) & (np.abs(y) < 0.45)
    images = np.column_stack([1 - 1.4 * x**2 + y, 0.3 * x])[seen]
    assert distance_to(henon, 1, images).max() < 0.01 * 0.1 / 8 * 2


def test_the_stable_manifold_of_a_flow_without_damping_is_the_mirror_of_the_unstable_one():
    system = cd.build("duffing", {"delta": 0.0, "amplitude": 0.05})
    ds = cd.manifolds(system, {"x": -0.02, "v": 0.0}, region={"x": (-2, 2), "v": (-2, 2)}, length=2.5)
    assert ds["curve_number"].size == 4
    assert distance_to(ds, 1, points(ds, 0) * [1, -1]).max() < 0.01 * 0.1 / 8 * 2
    assert len(ds["crossing"]) > 2


def extremes(state, periods, zeta=0.05, omega=2.5, e=0.8, wall=0.3):
    """Distances from the wall at turning points, and speeds at impacts, of an impact oscillator by scipy."""
    span, z, t, found = periods * 2 * np.pi / omega, np.array(state), 0.0, []

    def rates(t, z):
        return [z[1], -z[0] - 2 * zeta * z[1] + np.cos(omega * t)]

    def hit(t, z):
        return z[0] - wall

    def turn(t, z):
        return z[1]

    hit.terminal, hit.direction, turn.direction = True, 1, -1
    while t < span:
        run = solve_ivp(rates, (t, span), z, events=[hit, turn], rtol=1e-11, atol=1e-12, max_step=0.05)
        found += [abs(one[0] - wall) for one in run.y_events[1]]
        t, z = run.t[-1], run.y[:, -1]
        if run.status == 1:
            # the height from which that speed is fallen
            found.append(z[1] ** 2 / 2)
            z = np.array([wall - 1e-13, -e * z[1]])
    return np.array(found)


@pytest.fixture(scope="module")
def impacts():
    system = cd.build("impact-oscillator")
    near = {"x": -0.79520954, "v": 0.06733806}
    return cd.manifolds(system, near, period=2, region={"x": (-1, 0.3), "v": (-1.5, 1.5)}, length=1.6)


def test_curves_of_an_impact_oscillator_break_at_grazing(impacts):
    grazing = impacts["break_kind"].values == CurveBreak.GRAZING
    fresh = grazing & (impacts["break_generation"].values <= 12)
    states = np.unique(impacts["break_state"].values[fresh].round(6), axis=0, return_index=True)[1]
    chosen = impacts["break_state"].values[fresh][states]
    assert len(chosen) >= 4
    for state in chosen[:6]:
        assert extremes(state, 2).min() < 1e-6
    assert not impacts["break_jump"].values[grazing].any()
    assert (impacts["break_size"].values[grazing] < 0.01).all()


def test_curves_jump_where_an_impact_passes_the_strobe(impacts):
    cut = np.flatnonzero(impacts["break_jump"].values)
    assert len(cut)
    for place in impacts["break_point"].values[cut]:
        before, after = impacts["curve_state"].values[[place, place + 1]]
        one, other = (before, after) if before[1] > 0 else (after, before)
        np.testing.assert_allclose([one[0], other[0]], 0.3, atol=1e-5)
        assert other[1] == pytest.approx(-0.8 * one[1], abs=1e-4)


def test_images_of_curves_with_breaks_lie_on_them(impacts):
    system = cd.build("impact-oscillator")
    rng = np.random.default_rng(1)
    stable = points(impacts, 1)
    chosen = stable[rng.choice(len(stable), 20, replace=False)]
    images = [
        cd.trajectory(system.with_initial(x=x, v=v), periods=2, samples=1)["states"].values[-1] for x, v in chosen
    ]
    assert distance_to(impacts, 1, np.array(images)).max() < 1e-3


def saddle_cycle():
    """The cycle x**2 + y**2 = 1, unstable in the plane, with z - (x**2 + y**2 - 1)/2 decaying."""
    rates = {
        "x": "-y + k*x*(x**2 + y**2 - 1)",
        "y": "x + k*y*(x**2 + y**2 - 1)",
        "z": "-a*z + (a + 2*k*(x**2 + y**2))*(x**2 + y**2 - 1)/2",
    }
    return cd.HybridSystem(
        states="x y z", parameters={"k": 0.1, "a": 0.2}, modes={"flow": rates}, initial={"x": 1.0, "y": -0.1}
    )


def test_manifolds_of_a_cycle_on_a_surface():
    box = {"x": (0, 2), "y": (-1, 1), "z": (-1, 1)}
    ds = cd.manifolds(saddle_cycle(), at="y > 0", region=box, length=0.3)
    x, y, z = points(ds, 0).T
    assert len(x) > 50
    np.testing.assert_allclose(y, 0, atol=1e-7)
    np.testing.assert_allclose(z, (x**2 - 1) / 2, atol=1e-7)
    x, y, z = points(ds, 1).T
    assert np.ptp(z) > 0.5
    np.testing.assert_allclose(x, 1, atol=1e-7)
    np.testing.assert_allclose(y, 0, atol=1e-7)


def test_what_has_no_curve_says_why():
    stable = cd.manifolds(cd.build("impact-oscillator"), {"x": -0.19, "v": 0.02})
    assert cd.Outcome(int(stable["outcome"])).name == "NO_SADDLE"
    assert "the unstable manifold has 0 dimensions" in stable.attrs["message"]
    plastic = cd.Map("x y", {}, {"x": "2*x", "y": "x**2"}, bounds=FAR)
    ds = cd.manifolds(plastic, {"x": 1e-3}, region=BOX, length=0.5)
    assert "rank is lost" in ds.attrs["message"]
    assert (ds["curve_stable"].values == 0).all()
    np.testing.assert_allclose(points(ds, 0)[:, 1], points(ds, 0)[:, 0] ** 2 / 4, atol=1e-7)
    clipped = cd.Map("x y", {}, {"x": "Min(2*x, 2)", "y": "y/2"}, bounds=FAR)
    ds = cd.manifolds(clipped, {"x": 1e-3}, of="unstable", region={"x": (-4, 4), "y": (-4, 4)}, length=2, spacing=0.05)
    ahead = ds["curve_side"].values == 1
    assert ds["curve_end"].values[ahead] == CurveEnd.RANK_LOSS
    assert ds["curve_length"].values[ahead] == pytest.approx(2 / 8)
    with pytest.raises(cd.SettingsError, match="name a section"):
        cd.manifolds(saddle_cycle())
    with pytest.raises(cd.SettingsError, match="must increase"):
        cd.manifolds(bowed(), region={"x": (1, -1)})
    with pytest.raises(cd.SettingsError, match="expected a list"):
        cd.manifolds(bowed(), region={"x": {-1, 1}})


def test_points_are_bounded(henon):
    system = cd.system(henon)
    ds = cd.manifolds(system, {"x": 0.63, "y": 0.19}, of="unstable", length=1e6, max_points=300)
    assert (ds["curve_end"].values == CurveEnd.MOST_POINTS).all()
    assert ds.sizes["point"] <= 2 * 301


def test_an_orbit_that_was_found_tells_its_period():
    system = cd.build("impact-oscillator")
    orbit = cd.periodic_orbit(system.with_initial(x=-0.795, v=0.067), period=2, start="guess")
    ds = cd.manifolds(system, orbit, of="unstable", length=0.2)
    assert ds.sizes["iterate"] == 2
    assert ds["curve_number"].size == 4
    with pytest.raises(cd.SettingsError, match="its outcome is"):
        cd.manifolds(system, orbit.assign(outcome=orbit["outcome"] * 0 + 11))
