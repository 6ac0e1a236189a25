"""Basins: a colour an attractor, a legend that says what each is, and attractors marked where they can be seen."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.text import Annotation

from chaosdrill.plot.basins import basins
from chaosdrill.plot.looks import ATTRACTOR_COLOURS, UNRECOGNISED
from chaosdrill.plot.style import OUTCOME_COLOURS


def _legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def _cells(figure):
    """Colours as hex, over v (up) and x (across)."""
    return np.array([[to_hex(cell).upper() for cell in row] for row in figure.axes[0].collections[0].get_array()])


def test_the_legend_says_what_each_attractor_is_and_its_part(basin):
    """Half of 19/20 each; sqrt(0.475 0.525 / 800) is 0.01766, and sqrt(0.05 0.95 / 800) is 0.0077."""
    assert _legend(basins(basin)) == [
        "1: period 2, λ₁ = −0.25; 48(2) %",
        "2: chaotic, λ₁ = 0.0151(4); 48(2) %",
        "escaped; 5.0(8) %",
        "points of attractors",
    ]


def test_cells_have_the_colour_of_their_attractor(basin):
    cells = _cells(basins(basin))
    assert (cells[:19, :20] == ATTRACTOR_COLOURS[0]).all()
    assert (cells[:19, 20:] == ATTRACTOR_COLOURS[1]).all()
    assert (cells[19] == OUTCOME_COLOURS["escaped"]).all()


def test_axes_are_named_and_regions_numbered(basin):
    axes = basins(basin).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("height x", "speed v")
    texts = {text.get_text(): text.get_position()[0] for text in axes.texts}
    assert texts["1"] < 0 < texts["2"]


def test_only_points_in_the_plane_of_the_grid_are_marked(basin):
    axes = basins(basin).axes[0]
    (mark,) = axes.get_lines()
    assert [mark.get_xdata()[0], mark.get_ydata()[0]] == [-0.5, 0.5]
    assert mark.get_color() == ATTRACTOR_COLOURS[0]
    assert [text.get_text() for text in axes.texts if isinstance(text, Annotation)] == ["1"]


def test_points_outside_of_the_grid_are_not_marked(basin):
    axes = basins(basin.isel(x=slice(20, 40))).axes[0]
    assert not axes.get_lines()
    assert axes.get_xlim()[0] > -0.5


def test_a_run_that_ended_on_no_known_attractor_is_said(basin):
    basin["attractor"][:, 0] = 0
    figure = basins(basin)
    assert f"{UNRECOGNISED.name}; 5.0(8) %" in _legend(figure)
    assert (_cells(figure)[0] == UNRECOGNISED.colour).all()


def test_many_attractors_share_a_look_in_the_end(basin):
    """Twenty of them: twelve are named, and the rest is one kind."""
    table = {
        name: v for name, v in basin.variables.items() if "attractor_number" in v.dims and name != "attractor_number"
    }
    many = xr.Dataset(
        {name: xr.concat([basin[name].isel(attractor_number=0)] * 20, "attractor_number") for name in table}
    )
    many = many.assign_coords(attractor_number=np.arange(1, 21)).assign_attrs(basin.attrs)
    reached = basin["attractor"].copy(data=np.arange(800).reshape(40, 20) % 20 + 1)
    figure = basins(many.assign(attractor=reached, outcome=basin["outcome"], state_name=basin["state_name"]))
    names = _legend(figure)
    assert names[12] == "further attractors; 40(2) %"
    assert [name.split(":")[0] for name in names[:12]] == [str(n) for n in range(1, 13)]


@pytest.mark.parametrize("shape", [(1, 20), (40, 1), (2, 2)])
def test_grids_of_any_size(basin, shape, tmp_path):
    figure = basins(basin.isel(x=slice(shape[0]), v=slice(shape[1])))
    figure.savefig(tmp_path / "a.png", dpi=40)
    assert _cells(figure).shape == shape[::-1]


def test_a_grid_on_which_everything_escapes(basin):
    lost = basin.isel(v=[19]).isel(attractor_number=slice(0))
    assert _legend(basins(lost)) == ["escaped; 100 %"]


def test_the_title_says_where_the_plane_is(basin):
    assert basins(basin).axes[0].get_title() == "at w = 0.25"
    plane = basin.isel(state=[0, 1]).assign_attrs(initial='{"mode": "free", "x": 0.0, "v": 0.0}')
    figure = basins(plane)
    assert figure.axes[0].get_title() == ""
    assert len(figure.axes[0].get_lines()) == 2, "in a plane of all states every attractor can be marked"


def test_the_progression_is_told_where_there_is_one(basin):
    basin["attractor_rate"] = ("attractor_number", [0.146, np.nan])
    first, second = _legend(basins(basin))[:2]
    assert first == "1: period 2, λ₁ = −0.25, progression 0.146; 48(2) %"
    assert "progression" not in second
