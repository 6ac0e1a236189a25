"""Cells have their true bounds on any grid, hatchings cover what they should, and names stand inside their regions."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch

from chaosdrill.plot.cells import bounds, draw_kinds
from chaosdrill.plot.looks import Look

PLAIN, HATCHED = Look("plain", "#FFFFFF", short="plain"), Look("hatched", "#009E73", "....", "h")


def test_bounds_are_half_way_between_neighbours_and_as_far_outside():
    np.testing.assert_allclose(bounds(np.array([0.0, 1.0, 4.0])), [-0.5, 0.5, 2.5, 5.5])


@pytest.mark.parametrize(("value", "expected"), [(2.0, [1.9, 2.1]), (-2.0, [-2.1, -1.9]), (0.0, [-0.5, 0.5])])
def test_a_value_alone_has_a_cell_around_it(value, expected):
    np.testing.assert_allclose(bounds(np.array([value])), expected)


def _drawn(kinds, x=None, y=None, **options):
    axes = Figure().subplots()
    x = np.arange(kinds.shape[1] + 1.0) if x is None else x
    y = np.arange(kinds.shape[0] + 1.0) if y is None else y
    draw_kinds(axes, x, y, kinds, [PLAIN, HATCHED], (5.0, 4.0), **options)
    return axes


def _area(patch):
    """Of the rectangles of a path, each of five corners."""
    corners = patch.get_path().vertices.reshape(-1, 5, 2)
    return np.prod(corners[:, 2] - corners[:, 0], axis=1).sum()


def _hatched(axes):
    return next(patch for patch in axes.patches if isinstance(patch, PathPatch))


def test_the_mesh_has_the_bounds_and_the_colours_of_the_looks():
    x, y = np.array([0.0, 0.1, 2.0]), np.array([1.0, 5.0])
    mesh = _drawn(np.array([[0, 1]]), x, y).collections[0]
    np.testing.assert_array_equal(mesh.get_coordinates()[0, :, 0], x)
    np.testing.assert_array_equal(mesh.get_coordinates()[:, 0, 1], y)
    np.testing.assert_allclose(mesh.get_array()[0], [[1, 1, 1], [0, 0x9E / 255, 0x73 / 255]])
    assert mesh.get_rasterized()


def test_hatching_covers_exactly_the_cells_of_its_kind():
    rng = np.random.default_rng(3)
    kinds = rng.integers(0, 2, (12, 15))
    x, y = np.sort(rng.random(16)), np.sort(rng.random(13))
    cells = np.diff(y)[:, None] * np.diff(x)
    axes = _drawn(kinds, x, y)
    assert _area(_hatched(axes)) == pytest.approx(cells[kinds == 1].sum(), rel=1e-12)
    inside = _hatched(axes).get_path()
    centres = [((x[j] + x[j + 1]) / 2, (y[i] + y[i + 1]) / 2) for i in range(12) for j in range(15)]
    np.testing.assert_array_equal(inside.contains_points(centres), kinds.ravel() == 1)


def test_hatching_of_a_grid_finer_than_a_point_is_as_large():
    row, column = np.mgrid[0:1500, 0:1000]
    kinds = ((row - 750) ** 2 + (column - 500) ** 2 < 400**2).astype(int)
    patch = _hatched(_drawn(kinds))
    assert _area(patch) == pytest.approx(np.pi * 400**2, rel=5e-3)
    assert len(patch.get_path().vertices) < 5 * 300


def test_names_stand_inside_their_regions_and_small_regions_have_none():
    """A disc and a speck of kind 1 in a sea of kind 0: the disc is named in its middle, the speck is not."""
    row, column = np.mgrid[0:100, 0:100]
    kinds = ((row - 40) ** 2 + (column - 60) ** 2 < 20**2).astype(int)
    kinds[90, 90] = 1
    texts = {text.get_text(): text.get_position() for text in _drawn(kinds).texts}
    assert set(texts) == {"plain", "h"}
    np.testing.assert_allclose(texts["h"], [60.5, 40.5], atol=2)
    x, y = texts["plain"]
    assert kinds[int(y), int(x)] == 0
    assert not _drawn(kinds, names=False).texts


def test_regions_apart_are_named_apart():
    kinds = np.zeros((60, 90), dtype=int)
    kinds[:, :40] = kinds[:, 50:] = 1
    axes = _drawn(kinds)
    where = sorted(text.get_position()[0] for text in axes.texts if text.get_text() == "h")
    np.testing.assert_allclose(where, [20, 70], atol=2)


def test_cells_with_a_colour_of_their_own_keep_it():
    shades = np.full((1, 2, 3), 0.25)
    mesh = _drawn(np.array([[-1, 1]]), colours=shades).collections[0]
    np.testing.assert_allclose(mesh.get_array()[0], [[0.25] * 3, [0, 0x9E / 255, 0x73 / 255]])
