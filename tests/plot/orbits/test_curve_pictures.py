"""Curves over two parameters keep their places whatever lies behind them."""

import numpy as np
import pytest
import xarray as xr

from chaosdrill.dataset import BranchEnd, Outcome, Special, label
from chaosdrill.plot.curves import curves


@pytest.fixture
def chart(system):
    """Period 1 everywhere over q and r, in this order, for two seeds."""
    grid = {"q": np.linspace(-0.4, 0.4, 5), "r": np.linspace(0, 1, 6)}
    ds = xr.Dataset(
        {
            "period": (("q", "r", "seed"), np.ones((5, 6, 2), dtype=int)),
            "outcome": (("q", "r", "seed"), np.full((5, 6, 2), Outcome.PERIODIC)),
            "attractor_count": (("q", "r"), np.ones((5, 6), dtype=int)),
        },
        {**grid, "seed": [0, 1], "state_name": ("state", ["x", "v"])},
    )
    return label(ds, "parameter-chart", system=system, settings={"sweep": grid})


def _legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def _points(axes):
    (line,) = [line for line in axes.get_lines() if line.get_marker() == "None"]
    return line.get_xydata()


def _marks(ds):
    lines = curves(ds).axes[0].get_lines()
    return [tuple(line.get_xydata()[0]) for line in lines if line.get_markerfacecolor() == "white"]


def test_curves_are_named_by_kind_and_period(curve):
    figure = curves(curve("fold"), curve("period_doubling"), curve("period_doubling", 2, BranchEnd.GRAZING))
    names = ["fold, period 1", "period doubling, period 1", "period doubling, period 2", "end: grazing"]
    assert _legend(figure) == names
    lines = [line for line in figure.axes[0].get_lines() if len(line.get_xdata()) > 1]
    assert len({line.get_color() for line in lines}) == 3
    assert [line.get_linestyle() for line in lines] == ["-", "--", "--"]


def test_alone_the_first_parameter_runs_across(curve):
    axes = curves(curve("period_doubling")).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("growth rate r", "q")
    a, b = _points(axes).T
    np.testing.assert_allclose(a, 0.75 * (1 - b) ** 2)


def test_over_a_chart_they_follow_its_axes_in_every_panel(curve, chart):
    figure = curves(curve("period_doubling"), over=chart)
    assert _legend(figure) == ["period 1", "period doubling, period 1"]
    for axes in figure.axes[:2]:
        b, a = _points(axes).T
        np.testing.assert_allclose(a, 0.75 * (1 - b) ** 2)
        # the curve goes on to 0.5, the chart does not
        np.testing.assert_allclose(axes.get_xlim(), [-0.5, 0.5])
        np.testing.assert_allclose(axes.get_ylim(), [-0.1, 1.1])


def test_a_failed_search_is_said(curve):
    none = curve("fold").isel(point=slice(0), branch_number=slice(0))
    none = none.assign(outcome=none["outcome"].copy(data=np.int8(Outcome.EQUILIBRIUM)))
    figure = curves(none.assign_attrs(message="no fold on the way"))
    assert "equilibrium; no fold on the way" in figure.get_suptitle()


def test_the_point_from_which_a_curve_was_followed_is_nothing_special(curve):
    """It has the system's own value of the second parameter, q = 0.5, which is the curve's last point."""
    ds = curve("period_doubling", specials={20: Special.PERIOD_DOUBLING, 5: Special.PERIOD_DOUBLING})
    assert _marks(ds) == [(0.75 * 1.25**2, -0.25)]
    assert _marks(curve("period_doubling", specials={20: Special.GRAZING})) == [(0.75 * 0.5**2, 0.5)]


def test_what_lies_beyond_the_chart_is_not_named(curve, chart):
    """Folds have a < 0; of the period doublings only those with a below 1.1 are within the chart."""
    ds = curve("period_doubling", specials={0: Special.GRAZING, 10: Special.FOLD})
    figure = curves(curve("fold"), ds, over=chart.sel(r=slice(0.2, None)))
    assert _legend(figure) == ["period 1", "period doubling, period 1", "fold"]
