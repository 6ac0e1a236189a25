"""One call draws what suits an archive, under predictable names, and leaves matplotlib as it was."""

import matplotlib as mpl
import pytest
import xarray as xr

from chaosdrill.errors import ArchiveError, SettingsError
from chaosdrill.plot import PICTURES, plot_archive
from chaosdrill.plot.pictures import stems_of


@pytest.fixture
def archive(tmp_path, ball, spectrum):
    path = tmp_path / "run.nc"
    xr.DataTree.from_dict({"orbit": ball, "spectrum": spectrum}).to_netcdf(path)
    return path


def test_every_suitable_picture_is_drawn_beside_the_archive(archive):
    files = plot_archive(archive)
    assert [file.name for file in files] == [
        "run-orbit-time-history.png",
        "run-orbit-phase-portrait.png",
        "run-spectrum-convergence.png",
    ]
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in files)


def test_several_pictures_of_a_group_are_named_apart(tmp_path, chart, basin):
    path = tmp_path / "run.nc"
    xr.DataTree.from_dict({"load": chart, "basins": basin}).to_netcdf(path)
    assert [file.name for file in plot_archive(path)] == [
        "run-load-isoperiodic-chart.png",
        "run-load-lyapunov-chart.png",
        "run-load-progression-chart.png",
        "run-load-attractor-count-chart.png",
        "run-load-outcome-chart.png",
        "run-basins.png",
    ]


def test_no_picture_replaces_another_where_archive_and_group_are_named_as_pictures():
    drawn = {picture.name: picture for picture in PICTURES if picture.kind == "continuation"}
    planned = [(["branches"], drawn["branches"]), (["branches"], drawn["cascade"])]
    assert stems_of("cascade", planned) == ["cascade-branches-branches", "cascade-branches-cascade"]
    assert stems_of("orbits", planned) == ["orbits-branches", "orbits-branches-cascade"]


def test_one_picture_goes_exactly_where_it_was_asked_to(archive, tmp_path):
    assert plot_archive(archive, tmp_path / "a.svg", group="spectrum") == [tmp_path / "a.svg"]
    assert "λ₂ = −0.0879(2)" in (tmp_path / "a.svg").read_text(encoding="utf-8")


def test_unknown_group_is_refused_with_the_names_of_the_others(archive):
    with pytest.raises(ArchiveError, match=r"no group 'orbid'; groups are orbit, spectrum"):
        plot_archive(archive, group="orbid")


def test_an_archive_without_a_suitable_picture_says_what_it_holds(tmp_path, ball):
    path = tmp_path / "other.nc"
    ball.attrs["kind"] = "unheard-of"
    xr.DataTree.from_dict({"orbit": ball}).to_netcdf(path)
    with pytest.raises(ArchiveError, match=r"no picture for orbit \(unheard-of\)"):
        plot_archive(path)


def test_unknown_format_is_refused(archive, tmp_path):
    with pytest.raises(SettingsError, match=r"\.gif.*png, pdf, svg"):
        plot_archive(archive, tmp_path / "a.gif")
    assert not (tmp_path / "a.gif").exists()


def test_nothing_is_left_changed_in_matplotlib(archive):
    before = dict(mpl.rcParams)
    plot_archive(archive, group="spectrum")
    assert dict(mpl.rcParams) == before
