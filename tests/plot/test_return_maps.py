"""Return maps and cobwebs, of sections whose map is known in closed form."""

import json

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.plots.sections import return_map

# A point is one iterate over the one before; cobwebs go by the map and the diagonal, within one seed.

COUNT = 60


@pytest.fixture(scope="module")
def logistic():
    """Iterates of x' = 4 x (1 - x) from 0.1, by the closed form sin^2(2^n arcsin sqrt x), and v = 1 - x."""
    x = np.sin(2.0 ** np.arange(COUNT) * np.arcsin(np.sqrt(0.1))) ** 2
    return x[:40], 1 - x[:40]


def _section(like, x, v):
    names = [name for name in like.variables if "iterate" in like[name].dims or name.startswith("multiplier")]
    return like.drop_vars(names).assign(section=(("iterate", "state"), np.stack([x, v], axis=1)), period=0)


def _lines(figure, marker):
    return [
        line.get_xydata()
        for line in figure.axes[0].get_lines()
        if line.get_marker() == marker and len(line.get_xdata())
    ]


def test_points_lie_on_the_map(section, logistic):
    figure = return_map(_section(section, *logistic))
    ((x, y),) = (line.T for line in _lines(figure, "o"))
    assert len(x) == len(logistic[0]) - 1
    np.testing.assert_allclose(y, 4 * x * (1 - x), atol=1e-3)
    ((x, y),) = (line.T for line in _lines(return_map(_section(section, *logistic), state="v"), "o"))
    np.testing.assert_allclose(1 - y, 4 * x * (1 - x), atol=1e-3)


def _is_cobweb(line):
    """Upright and level lines in turn, from the diagonal on; returns the other corners."""
    steps = np.diff(line, axis=0)
    assert (steps[::2, 0] == 0).all()
    assert (steps[1::2, 1] == 0).all()
    assert (line[::2, 0] == line[::2, 1]).all()
    return line[1::2]


def test_a_cobweb_goes_from_the_diagonal_to_the_map(section, logistic):
    web = next(line for line in _lines(return_map(_section(section, *logistic)), "None") if len(line) > 2)
    np.testing.assert_allclose(
        _is_cobweb(web)[:, 1], 4 * _is_cobweb(web)[:, 0] * (1 - _is_cobweb(web)[:, 0]), atol=1e-3
    )


def test_a_cycle_is_closed(section):
    webs = [line for line in _lines(return_map(section), "None") if len(line) > 2]
    corners = {tuple(point) for point in webs[1].tolist()}
    assert corners == {(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)}
    assert webs[1][0].tolist() == webs[1][-1].tolist()


def test_seeds_of_a_diagram_are_apart_and_gaps_are_gaps(diagram):
    one = diagram.isel(q=[80]).assign_attrs(settings=json.dumps({"sweep": {"q": [0.8]}}))
    two = one.isel(seed=[0, 0]).copy(deep=True)
    two["section"][0, 1] += 7.0
    two["section"][0, 0, -1] = np.nan
    axes = cd.plot(two, "return-map")
    assert axes.get_title(loc="left") == "load (kN) = 0.8, once per forcing period"
    first, second = (
        line.get_xydata() for line in axes.get_lines() if line.get_marker() == "o" and len(line.get_xdata())
    )
    assert np.isfinite(first).all(axis=1).sum() == np.isfinite(second).all(axis=1).sum() - 1
    assert np.nanmax(first) < 6 < np.nanmin(second)


def test_several_values_of_a_parameter_have_no_one_map(diagram):
    with pytest.raises(cd.SettingsError, match="there is no picture 'return-map' of this bifurcation-diagram"):
        cd.plot(diagram.assign_attrs(settings=json.dumps({"sweep": {"q": [0.0, 1.0]}})), "return-map")


def test_what_is_left_of_a_transient_at_round_off_is_one_point(section):
    x = 0.25 + 1e-9 * (-0.5) ** np.arange(20)
    left, right = return_map(_section(section, x, 1 - x)).axes[0].get_xlim()
    assert (left, right) == pytest.approx((0.2375, 0.2625), rel=1e-6)
