"""Branches are drawn where the orbits are, solid where these are stable, and with what happens on them."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from chaosdrill.dataset import BranchEnd, Outcome, Special
from chaosdrill.plot.branches import branches
from chaosdrill.plot.companions import fits


def _legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def _lines(figure, dashed):
    """Points of the lines that are dashed or not, without marks."""
    lines = [line for line in figure.axes[0].get_lines() if line.get_marker() == "None" and len(line.get_xdata())]
    return [line.get_xydata() for line in lines if (line.get_linestyle() == "--") == dashed]


def _drawn(figure, dashed):
    return np.concatenate(_lines(figure, dashed))


def test_what_is_there_is_named_and_nothing_else(continuation):
    figure = branches(continuation)
    assert figure.axes[0].get_xlabel() == "growth rate r"
    assert figure.axes[0].get_ylabel() == "population x"
    names = ["period 1", "period 2", "stable", "unstable", "period doubling", "grazing", "end: grazing"]
    assert _legend(figure) == names


def test_solid_is_stable(continuation):
    """Period 1 up to r = 3, both points of period 2 from there to 1 + sqrt 6."""
    figure = branches(continuation)
    solid, dashed = _drawn(figure, dashed=False), _drawn(figure, dashed=True)
    r, x = solid.T
    assert r.max() == pytest.approx(1 + np.sqrt(6))
    np.testing.assert_allclose(x[r < 3], 1 - 1 / r[r < 3])
    r, x = dashed.T
    assert r.min() == 3.0
    assert r.max() == pytest.approx(3.6)
    before = r < 1 + np.sqrt(6) - 1e-9
    np.testing.assert_allclose(x[before], 1 - 1 / r[before])


def test_both_points_of_an_orbit_are_drawn(continuation):
    r, x = _drawn(branches(continuation), dashed=False).T
    # r^2 x^2 - r (r + 1) x + r + 1 = 0
    np.testing.assert_allclose(np.sort(x[np.isclose(r, 3.2)]), np.sort(np.roots([3.2**2, -3.2 * 4.2, 4.2])))


def test_every_point_of_an_orbit_is_marked(continuation):
    marks = [line for line in branches(continuation).axes[0].get_lines() if line.get_marker() == "^"]
    points = np.concatenate([line.get_xydata() for line in marks])
    assert np.isfinite(points).all(axis=1).sum() == 1 + 2


def test_branches_are_not_joined(continuation):
    figure = branches(continuation)
    for line in _lines(figure, dashed=False) + _lines(figure, dashed=True):
        assert (np.diff(line[:, 0]) > 0).all()


def test_a_jump_of_the_section_is_no_line(branch_result, continuation):
    """An event that comes to the section's phase: the state there is the one before it, and then the one after it."""
    section = branch_result.section.copy()
    section[40:81] += 0.5
    jumped = continuation.assign(section=(("point", "iterate", "state"), section))
    whole, parts = (_lines(branches(ds), dashed=True) for ds in (continuation, jumped))
    assert len(parts) == len(whole) + 1
    assert max(np.abs(np.diff(line[:, 1])).max() for line in parts) < 0.1


@pytest.mark.parametrize("end", BranchEnd)
def test_ends_are_named_unless_they_are_that_of_the_range(continuation, end):
    codes = continuation["branch_end"].copy(data=np.array([BranchEnd.LIMIT, end], dtype=np.int8))
    ends = [text for text in _legend(branches(continuation.assign(branch_end=codes))) if text.startswith("end")]
    assert len(ends) == (end not in (BranchEnd.LIMIT, BranchEnd.CLOSED))


@pytest.mark.parametrize("kind", [kind for kind in Special if kind != Special.REGULAR])
def test_kinds_of_special_points_have_shapes_of_their_own(continuation, kind):
    def marker(code):
        codes = continuation["special_kind"].copy(data=np.full(3, code, dtype=np.int8))
        figure = branches(continuation.assign(special_kind=codes))
        return next(line.get_marker() for line in figure.axes[0].get_lines() if line.get_markerfacecolor() == "white")

    assert [other for other in Special if other and marker(other) == marker(kind)] == [kind]


@pytest.mark.parametrize("states", [1, 2, 5])
def test_any_number_of_states(continuation, states):
    """States that do not vary are passed over."""
    section = continuation["section"].values
    wide = np.concatenate([np.zeros((*section.shape[:2], states - 1)), section[..., :1]], axis=2)
    one = continuation.drop_dims("state").assign(section=(("point", "iterate", "state"), wide))
    one = one.assign_coords(state_name=("state", [f"s{i}" for i in range(states)]))
    assert branches(one).axes[0].get_ylabel() == f"s{states - 1}"


def test_a_search_that_found_no_orbit_says_so(continuation):
    none = continuation.isel(point=slice(0), branch_number=slice(0), special=slice(0))
    none = none.assign(outcome=continuation["outcome"].copy(data=np.int8(Outcome.NO_ORBIT)))
    title = branches(none.assign_attrs(message="none near the start")).legends[0].get_title().get_text()
    assert title == "no orbit; none near the start"


def _diagram(continuation, **attrs):
    r = np.linspace(2.8, 3.6, 11)
    section = np.broadcast_to((1 - 1 / r)[:, None, None, None], (11, 1, 4, 2))
    ds = xr.Dataset(
        {
            "section": (("r", "seed", "iterate", "state"), section),
            "period": (("r", "seed"), np.where(r < 3.2, 1, 0)[:, None]),
        },
        {"r": r, "state_name": ("state", ["x", "v"])},
    )
    return ds.assign_attrs(continuation.attrs, kind="bifurcation-diagram", **attrs)


def test_the_diagram_lies_behind(continuation):
    figure = branches(continuation, over=_diagram(continuation))
    assert _legend(figure)[0] == "bifurcation diagram"
    clouds, cycles, _, *lines = figure.axes[0].get_lines()
    assert (len(clouds.get_xdata()), len(cycles.get_xdata())) == (24, 20)
    assert clouds.get_zorder() == cycles.get_zorder() < min(line.get_zorder() for line in lines)


def test_a_diagram_over_a_wider_range_does_not_widen_the_picture(continuation):
    narrow = continuation.assign_attrs(settings='{"sweep": {"r": [3.45, 3.2]}}')
    axes = branches(narrow, over=_diagram(continuation)).axes[0]
    np.testing.assert_allclose(axes.get_xlim(), [3.195, 3.455])
    np.testing.assert_allclose(np.unique(axes.get_lines()[0].get_xdata()), [3.2, 3.28, 3.36, 3.44])


@pytest.mark.parametrize(
    "attrs",
    [
        {"system": "other"},
        {"parameters": '{"r": 3.0, "q": 0.75}'},
        {"settings": '{"sweep": {"q": []}}'},
        {"settings": '{"sweep": {"r": []}, "at": "hit"}'},
    ],
)
def test_what_is_of_another_system_or_section_is_not_drawn_over(continuation, attrs):
    assert fits(continuation, _diagram(continuation, parameters='{"r": 2.0, "q": 0.5}'))
    assert not fits(continuation, _diagram(continuation, **attrs))


def test_several_continuations_share_a_picture(as_continuation, branch_result, continuation):
    infos = tuple(replace(info, period=3 * info.period) for info in branch_result.branches)
    other = as_continuation(replace(branch_result, branches=infos))
    assert _legend(branches(continuation, other))[:4] == ["period 1", "period 2", "period 3", "period 6"]


def test_many_periods_share_the_last_colour(as_continuation, branch_result):
    def with_period(factor):
        infos = tuple(replace(info, period=factor * info.period) for info in branch_result.branches)
        return as_continuation(replace(branch_result, branches=infos))

    names = _legend(branches(*[with_period(factor) for factor in (1, 4, 16, 64)]))
    assert names[4:7] == ["period 16", "periods 32 to 128", "stable"]
