"""Dimensions of section points, against sets whose dimensions are exact, published figures, and counts of all pairs."""

from time import process_time

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial import cKDTree
from scipy.special import digamma
from support import discrete

import chaosdrill as cd
from chaosdrill.analysis.measures.neighbours import NEAREST, SCALES, neighbours, picked, shares
from chaosdrill.analysis.measures.scaling import (
    FEWEST,
    STEP,
    Sums,
    by_chance,
    local_slopes,
    refusal,
    scaling_region,
    sums_of,
)
from chaosdrill.analysis.tuning import SCALING

SHARE, LEFT, RIGHT = 0.3, 0.25, 0.4
"""Of a skew baker's map: the part of the square that goes to the left, and the widths of the images."""


def exact(order):
    """Dimension of its attractor, smooth along one direction and a two-scale Cantor set across."""
    if order == 1:
        entropy = SHARE * np.log(SHARE) + (1 - SHARE) * np.log(1 - SHARE)
        return 1 + entropy / (SHARE * np.log(LEFT) + (1 - SHARE) * np.log(RIGHT))
    across = brentq(
        lambda d: SHARE**order * LEFT ** ((1 - order) * d) + (1 - SHARE) ** order * RIGHT ** ((1 - order) * d) - 1, 0, 3
    )
    return 1 + across


BAKER = cd.Map(
    "x y",
    {"s": SHARE, "l": LEFT, "r": RIGHT},
    {"x": "piecewise(l*x, y < s, 1/2 + r*x)", "y": "piecewise(y/s, y < s, (y - s)/(1 - s))"},
    initial={"x": 0.2, "y": 0.37},
)
HENON = cd.Map(**discrete.HENON)
TURN = 2 * np.pi * (np.sqrt(5) - 1) / 2


def within(found, truth, order=2):
    """Whether a dimension is right by its error, which is small enough to say something."""
    one = found.sel(order=order)
    return abs(float(one["dimension"]) - truth) <= 2 * float(one["dimension_error"]) < 0.25


def of_points(points, order):
    return scaling_region(sums_of(points, 0, np.array([order]))[0])


@pytest.fixture(scope="module")
def henon():
    return cd.dimensions(HENON, transient=500, periods=8000)


def test_skew_baker_map():
    found = cd.dimensions(BAKER, transient=100, periods=8000)
    assert found.cd.outcome == "ok"
    for order in (1, 2, 3):
        assert within(found, exact(order), order)
    assert 0 < float(found["scale_low"][0]) < float(found["scale_high"][0]) / 11


def test_henon_map(henon):
    """Order 2: 1.22 by Grassberger and Procaccia 1983, doi:10.1103/PhysRevLett.50.346; order 1 by the exponents."""
    assert within(henon, 1.22)
    assert within(henon, 1.258, 1)
    assert (henon["dimension"].diff("order") <= 2 * henon["dimension_error"][1:]).all()
    one = henon.sel(order=2)
    region = one["local_slope"].sel(scale=slice(one["scale_low"], one["scale_high"]))
    assert float(region.isel(scale=slice(0, -1)).mean()) == pytest.approx(float(one["dimension"]), abs=0.05)


def test_units_of_states_do_not_matter(henon):
    units = cd.Map(
        "x y", {"a": 1.4, "b": 0.3}, {"x": "1 - a*x**2 + 1048576*y", "y": "b*x/1048576"},
        initial={"x": 0.1, "y": 0.05 / 2**20},
    )  # fmt: skip
    other = cd.dimensions(units, transient=500, periods=8000)
    for name in ("dimension", "dimension_error", "correlation_sum", "scale_low"):
        assert np.array_equal(other[name], henon[name], equal_nan=True), name
    np.testing.assert_array_equal(other["spread"], henon["spread"] * [1, 2.0**-20])


def test_smooth_coordinates_do_not_matter():
    rng = np.random.default_rng(9)
    points = np.column_stack([rng.random(4000), np.zeros(4000)])
    for one in rng.random((40, 4000)) < SHARE:
        points[:, 1] = np.where(one, LEFT * points[:, 1], 0.5 + RIGHT * points[:, 1])
    bent = np.column_stack([points[:, 0] + points[:, 1] ** 2, np.exp(2 * points[:, 1] - points[:, 0])])
    for order in (1, 2):
        one, other = (of_points(set_ / set_.std(axis=0), order) for set_ in (points, bent))
        assert abs(one.dimension - exact(order)) <= 2 * one.error
        assert abs(other.dimension - exact(order)) <= 2 * other.error < 0.2


def test_a_closed_curve_and_a_cycle():
    turned = {"x": "c*x - s*y", "y": "s*x + c*y"}
    start = {"initial": {"x": 1.0, "y": 0.2}}
    curve = cd.Map("x y", {"c": np.cos(TURN), "s": np.sin(TURN)}, turned, **start)
    assert within(cd.dimensions(curve, periods=4000), 1)
    cycle = cd.dimensions(HENON.with_parameters(a=1.0), transient=500, periods=600)
    assert cycle.cd.outcome == "periodic"
    assert (cycle["dimension"].values == 0).all()
    assert (cycle["dimension_error"].values == 0).all()


def test_gaps_between_clusters_are_no_scaling():
    """A circle near a resonance: neighbours rest in number from the width of the clusters to their distance."""
    rng, orders, ratio = np.random.default_rng(12), np.array([1, 2, 3]), []
    near = [rng.integers(1, q) / q + 10 ** rng.uniform(-7, -3) for q in rng.integers(2, 130, 12)]
    for turn in [*near, *rng.random(4), *(np.array([0.5, 1, 2, 3]) / (2 * np.pi))]:
        for count in (2000, 5000):
            angles = 2 * np.pi * (turn * np.arange(count) % 1)
            points = np.column_stack([np.cos(angles), np.sin(angles)])
            for sums in sums_of(points / points.std(axis=0), 10, orders):
                if found := scaling_region(sums):
                    ratio.append(abs(found.dimension - 1) / found.error)
                elif sums.sound.sum() > SCALING.shortest:
                    assert "clusters" in refusal(sums)
    assert max(ratio) <= 2
    assert len(ratio) > 100


def test_a_long_cycle_is_a_finite_set():
    """Longer than periods that are looked for."""
    angles = 2 * np.pi * 7 / 1001 * (np.arange(5000) % 1001)
    for sums in sums_of(np.column_stack([np.cos(angles), np.sin(angles)]), 10, np.array([2, 3])):
        assert scaling_region(sums)[:2] == (0, 0)


def test_phase_of_the_forcing_is_a_coordinate_at_events():
    """A clock turns by a golden part of the forcing from event to event; nothing else moves."""
    clock = cd.HybridSystem(
        states="s u", parameters={"g": (np.sqrt(5) - 1) / 2}, time="t",
        modes={"on": {"s": "1", "u": "cos(2*pi*t) - u"}}, period="1",
        transitions=[cd.Transition("tick", "on", "on", "s - g", 1, {"s": "0", "u": "0"})],
    )  # fmt: skip
    assert within(cd.dimensions(clock, at="tick", periods=3000), 1)


def test_drill_has_no_more_than_its_lyapunov_dimension():
    drill = cd.drill(friction="stribeck", contact="hunt-crossley", eta=0.448)
    found = cd.dimensions(drill, transient=500, periods=8000)
    spectrum = cd.lyapunov_spectrum(drill, transient=500, periods=4000)
    one = found.sel(order=2)
    assert float(one["dimension"]) > 0.8
    assert float(one["dimension"] - 2 * one["dimension_error"]) < float(spectrum["kaplan_yorke_dimension"])
    assert float(found["spread"].sel(state="w")) == 0.0


def test_information_dimension_of_the_lozi_map_is_that_of_its_exponents():
    """Its measure is smooth along the unstable direction (Collet and Levy 1984)."""
    lozi = cd.Map(
        "x y", {"a": 1.7, "b": 0.5}, {"x": "1 - a*abs(x) + y", "y": "b*x"}, initial={"x": 0.1, "y": 0.05}
    )  # fmt: skip
    found = cd.dimensions(lozi, transient=500, periods=8000, orders=[1])
    spectrum = cd.lyapunov_spectrum(lozi, transient=500, periods=8000)
    assert within(found, float(spectrum["kaplan_yorke_dimension"]), 1)


@pytest.mark.parametrize(("dimension", "order"), [(1, 1), (1, 2), (2, 2), (2, 3), (3, 2)])
def test_noise_has_the_dimension_of_its_space(dimension, order):
    found = of_points(np.random.default_rng(2).normal(size=(6000, dimension)), order)
    assert abs(found.dimension - dimension) <= 2 * found.error < 0.25


def test_counts_are_those_of_all_pairs():
    points = np.cumsum(np.random.default_rng(4).normal(size=(700, 2)), axis=0) / 10
    ((places, counts, possible),) = neighbours(points, 5)
    apart = np.abs(points[:, np.newaxis] - points).max(axis=2)
    steps = np.abs(np.subtract.outer(np.arange(700), np.arange(700)))
    apart[steps <= 5] = np.inf
    assert len(places) >= 8
    for place, within in zip(places, counts.T, strict=True):
        assert (within == (apart <= SCALES[place]).sum(axis=1)).all()
    assert (possible == np.isfinite(apart).sum(axis=1)).all()


def test_many_points_are_counted_as_few():
    """Beyond some thousand points large distances are counted among some alone; the sums go on evenly and exactly."""
    points = np.random.default_rng(8).random((20_000, 2))
    few, many = neighbours(points, 3)
    assert len(few.places) > 5
    assert len(np.intersect1d(few.places, many.places)) == 1
    (sums,) = sums_of(points, 3, np.array([2]))
    told = np.isfinite(sums.values)
    # two points of the unit interval are within r with the probability 2r - r^2
    exactly = 2 * np.log(2 * SCALES - SCALES**2, where=told, out=np.zeros(len(SCALES)))
    error = np.sqrt((sums.blocks**2).mean(axis=0) / len(sums.blocks))
    assert (abs(sums.values - exactly) <= 4 * error + 0.02)[told].all()
    slopes, errors = local_slopes(sums)
    at = np.isfinite(slopes)
    assert (abs(slopes - np.diff(exactly) / STEP) <= 4 * errors + 1e-3)[at].all()


@pytest.mark.parametrize("points", [
    np.random.default_rng(6).normal(size=(9000, 3)),
    np.random.default_rng(6).standard_cauchy(size=(9000, 2)),
    np.random.default_rng(6).integers(0, 30, (9000, 2)) / 8,
])  # fmt: skip
def test_boxes_hold_what_is_near(points):
    """Also far away from where points crowd, and on the edges of boxes."""

    def apart(at, among):
        found = np.abs(points[at, np.newaxis] - points[among]).max(axis=2)
        found[np.abs(np.subtract.outer(at, among)) <= 20] = np.inf
        return found

    every, some, centres = np.arange(9000), slice(None, None, 50), picked(9000, SCALING.centres)
    for counted, among in zip(neighbours(points, 20), (every, picked(9000, SCALING.fewer)), strict=True):
        assert len(counted.places) > 1
        within = apart(centres[some], among)[..., np.newaxis] <= SCALES[counted.places]
        assert np.array_equal(counted.counts[some], within.sum(axis=1))
    found = shares(points, 20)
    with np.errstate(divide="ignore"):
        nearest = np.log(np.sort(apart(picked(9000, SCALING.centres_of_shares)[some], every), axis=1))
    few = found.neighbours <= NEAREST[-1]
    assert np.array_equal(found.logs[some][:, few], nearest[:, NEAREST - 1])


def test_many_points_take_little_time():
    """No longer than a tree takes to find the nearest neighbour of each."""
    points = np.random.default_rng(8).random((40_000, 2))
    times = [process_time()]
    cKDTree(points).query(points, k=2, p=np.inf)
    times.append(process_time())
    sums_of(points, 3, np.array([1, 2, 3]))
    times.append(process_time())
    library, ours = np.diff(times)
    assert ours < 3 * library


def test_shares_are_those_of_all_points():
    """Of points of density 1 the share is twice the distance; sorted distances of all points say the same."""
    points = np.random.default_rng(5).random((3000, 1))
    found = shares(points, 0)
    apart, numbers = np.sort(np.abs(points - points[:, 0]), axis=1), found.neighbours.astype(int)
    exactly = np.log(apart[:, numbers]).mean(axis=0) - digamma(numbers) + digamma(3000)
    ratio = found.logs.mean(axis=0) - found.parts
    error = found.logs.std(axis=0) / np.sqrt(len(points))
    assert (abs(ratio - exactly) <= 4 * error).all()
    few = numbers < 30
    assert (abs(ratio + np.log(2)) <= 4 * error + 0.02)[few].all()


def test_points_that_follow_each_other_are_no_pairs():
    """A slow motion through a plane: near in time all is a curve (Theiler 1986)."""
    steps = np.random.default_rng(7).normal(size=(2500, 3)) * 0.02
    points = np.empty_like(steps)
    place = np.full(3, 0.5)
    for row, step in zip(points, steps, strict=True):
        place = np.abs(1 - np.abs(1 - (place + step)))
        row[:] = place
    every, apart = (neighbours(points, window)[0] for window in (0, 250))
    assert every.near()[every.places == apart.places[0]] > 1.5 * apart.near()[0]


def test_what_cannot_be_told_has_a_reason():
    short = cd.dimensions(HENON, transient=500, periods=FEWEST - 1)
    assert short.cd.outcome == "undecided"
    assert f"{FEWEST - 1} points are too few" in short.attrs["reason"]
    assert np.isnan(short["dimension"]).all()
    noise = np.random.default_rng(3).normal(size=(600, 4))
    for sums in sums_of(noise, 0, np.array([1, 2])):
        assert scaling_region(sums) is None
        assert "no scaling region" in refusal(sums)


def test_errors_cover():
    """Points that are independent, on the Cantor set across the baker's map."""
    rng, hits = np.random.default_rng(11), []
    orders = np.array([1, 2, 3])
    for _ in range(12):
        left = rng.random((30, 800)) < SHARE
        x = np.zeros(800)
        for one in left:
            x = np.where(one, LEFT * x, 0.5 + RIGHT * x)
        found = [scaling_region(one) for one in sums_of((x / x.std())[:, np.newaxis], 0, orders)]
        hits.append([abs(f.dimension - (exact(q) - 1)) <= 2 * f.error for q, f in zip(orders, found, strict=True)])
    assert (np.mean(hits, axis=0) >= 0.85).all()


def test_two_thousand_points_have_an_information_dimension():
    """Parts of an attractor from one point to a twentieth of all are enough, also where two points are the same."""
    rng, first = np.random.default_rng(13), np.array([1])
    for _ in range(4):
        points = np.column_stack([rng.random(2000), np.zeros(2000)])
        for one in rng.random((40, 2000)) < SHARE:
            points[:, 1] = np.where(one, LEFT * points[:, 1], 0.5 + RIGHT * points[:, 1])
        points /= points.std(axis=0)
        region = of_points(points, 1)
        assert abs(region.dimension - exact(1)) <= 2 * region.error < 0.2
    line = rng.random((2000, 1))
    line[1::100] = line[::100]
    region = scaling_region(*sums_of(line, 0, first))
    assert abs(region.dimension - 1) <= 2 * region.error < 0.1


def test_wrong_windows_and_orders():
    with pytest.raises(cd.SettingsError, match="window is 70; pairs of points so near in time are left out"):
        cd.dimensions(HENON, periods=600, window=70)
    with pytest.raises(cd.SettingsError, match="window is -1"):
        cd.dimensions(HENON, periods=400, window=-1)
    with pytest.raises(cd.SettingsError, match="orders"):
        cd.dimensions(HENON, periods=400, orders=[0])


def test_over_a_parameter_each_value_is_a_record_of_its_own(tmp_path):
    """Skew tents fill the interval, of dimension 1 at any skew; a logistic window is a cycle, of dimension 0."""
    tent = cd.Map("x", {"c": 0.3}, {"x": "Min(x/c, (1 - x)/(1 - c))"}, initial={"x": 0.1234})
    skews = [0.3, 0.42]
    given = {"transient": 10, "periods": 2000, "orders": [1, 2]}
    found = cd.dimensions(tent, {"c": skews}, workers=2, store=tmp_path / "store", **given)
    for skew in skews:
        one = cd.dimensions(tent.with_parameters(c=skew), **given)
        for name in ("dimension", "dimension_error", "correlation_sum", "spread", "outcome"):
            np.testing.assert_array_equal(found[name].sel(c=skew), one[name])
    assert (abs(found["dimension"] - 1) <= 2 * found["dimension_error"]).all()

    logistic = cd.Map("x", {"r": 4.0}, {"x": "r*x*(1 - x)"}, initial={"x": 0.3})
    ds = cd.dimensions(logistic, {"r": [3.83, 3.9]}, transient=500, periods=600, window=80)
    assert ds.cd.outcome.values.tolist() == ["periodic", "undecided"]
    assert ds.attrs["reason"].startswith(
        "window is 80; pairs of points so near in time are left out of a record of 600"
    )
    assert ds.attrs["reason"].endswith(" (at 1 of 2 values, the first r = 3.9)")
    assert not ds["dimension"][0].any()
    assert np.isnan(ds["dimension"][1]).all()
    # of one of two orders alone; of a run that escapes the outcome tells
    images = {at: f"a*Min({at}/{skew}, (1 - {at})/{1 - skew})" for at, skew in zip("xy", skews, strict=True)}
    tents = cd.Map("x y", {"a": 1.0}, images, initial={"x": 0.1234, "y": 0.5678})
    ds = cd.dimensions(tents, {"a": [1.0, 3.0]}, periods=1200)
    assert np.isnan(ds["dimension"].values).tolist() == [[True, False, False], [True, True, True]]
    assert ds.attrs["reason"].startswith("order 1: no scaling region; the points resolve ")
    assert ds.attrs["reason"].endswith(" (at 1 of 2 values, the first a = 1)")


def test_a_pair_that_is_near_by_chance_adds_to_the_error_once():
    """Of independent points the scatter over records is known, and pairs make most of it at small distances."""
    rng, weights, at = np.random.default_rng(8), np.zeros((1, 12)), slice(36, 48)
    place = np.arange(12) - 5.5
    weights[0] = place / (place**2).sum() / STEP
    for order, most in ((2, 1.45), (3, 1.45)):
        every = [sums_of(rng.uniform(0, 3.4, (800, 1)), 0, np.array([order]))[0] for _ in range(200)]
        every = [Sums(*(part[..., at] for part in one)) for one in every]
        scatter = np.std([weights @ one.values for one in every])
        errors = [by_chance(one, weights) for one in every]
        assert 0.95 < np.sqrt(np.mean(np.square(errors))) / scatter < most
