"""From an archive, continuations of the same system over the same parameters go into one picture, over its diagram."""

import numpy as np
import pytest
import xarray as xr

from chaosdrill.plot import plot_archive


@pytest.fixture
def archive(tmp_path, continuation, curve, as_orbit, found):
    """Two continuations over r, with a diagram; one of another system, one over less; two curves; an orbit."""
    r = np.linspace(2.8, 3.6, 5)
    diagram = xr.Dataset(
        {
            "section": (("r", "seed", "iterate", "state"), np.full((5, 1, 2, 2), 0.25)),
            "period": (("r", "seed"), np.ones((5, 1), dtype=np.int16)),
            "outcome": (("r", "seed"), np.ones((5, 1), dtype=np.int8), continuation["outcome"].attrs),
        },
        {"r": r, "state_name": continuation["state_name"]},
    )
    groups = {
        "one": continuation,
        "two": continuation,
        "stranger": continuation.assign_attrs(system="another"),
        "narrow": continuation.assign(accumulation=np.nan).assign_attrs(settings='{"sweep": {"r": [3.4, 3.5]}}'),
        "diagram": diagram.assign_attrs(continuation.attrs, kind="bifurcation-diagram"),
        "folds": curve("fold"),
        "doublings": curve("period_doubling"),
        "found": as_orbit(found),
    }
    path = tmp_path / "run.nc"
    xr.DataTree.from_dict(groups).to_netcdf(path)
    return path


def test_what_belongs_together_is_one_picture(archive):
    assert [file.name for file in plot_archive(archive)] == [
        "run-one-two-branches.png",
        "run-one-multipliers.png",
        "run-one-cascade.png",
        "run-two-multipliers.png",
        "run-two-cascade.png",
        "run-stranger-branches.png",
        "run-stranger-multipliers.png",
        "run-stranger-cascade.png",
        "run-narrow-branches.png",
        "run-narrow-multipliers.png",
        "run-diagram-bifurcation-diagram.png",
        "run-folds-doublings-curves.png",
        "run-found-periodic-orbit.png",
    ]


def test_the_diagram_of_another_group_lies_behind(archive, tmp_path):
    for group, behind in (("two", True), ("stranger", False)):
        plot_archive(archive, tmp_path / "a.svg", group=group)
        text = (tmp_path / f"a-{group}-branches.svg").read_text(encoding="utf-8")
        assert ("bifurcation diagram" in text) == behind


def test_a_cascade_without_an_accumulation_point_has_no_picture(tmp_path, continuation):
    short = continuation.assign(accumulation=np.nan)
    xr.DataTree.from_dict({"run": short}).to_netcdf(tmp_path / "run.nc")
    assert [file.name for file in plot_archive(tmp_path / "run.nc")] == ["run-branches.png", "run-multipliers.png"]
