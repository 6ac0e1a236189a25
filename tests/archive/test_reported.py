"""A report shows every kind of analysis, nothing of it at the page's end as a fault."""

import pytest

from chaosdrill.plot import PICTURES
from chaosdrill.reports import report

# a caption that only this kind of analysis has, where its numbers stand
CAPTIONS = {
    "trajectory": "Events on the way",
    "poincare-section": "Multipliers of the cycle",
    "lyapunov-spectrum": "Events counted",
    "bifurcation-diagram": "Motions along",
    "parameter-chart": "Cycles and other motions",
    "basins": "Attractors",
    "periodic-orbit": "How good the orbits are",
    "continuation": "Branches",
    "work-precision": "Work and precision",
}


@pytest.fixture(scope="module")
def made(every_kind, tmp_path_factory):
    return report(every_kind, tmp_path_factory.mktemp("report") / "page.html")


def test_all_parts_are_there(made, every_group):
    assert made.faults == ()
    assert made.groups == tuple(every_group)
    assert made.pictures >= len({dataset.attrs["kind"] for dataset in every_group.values()})
    assert made.charts == 2


def test_each_kind_has_its_own_table(made, every_group):
    text = made.path.read_text(encoding="utf-8")
    parts = text.split('<section id="analysis-')[1:]
    assert len(parts) == len(every_group)
    assert set(CAPTIONS) <= {d.attrs["kind"] for d in every_group.values()} == {p.kind for p in PICTURES}
    for part, dataset in zip(parts, every_group.values(), strict=True):
        assert f"<caption>{CAPTIONS.get(dataset.attrs['kind'], '')}" in part
