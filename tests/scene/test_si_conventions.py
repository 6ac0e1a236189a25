"""Archives of scenes in SI units, root and groups, follow CF-1.11, by a checker that is not ours."""

import pytest
from support import compliance

from chaosdrill.archive import save
from chaosdrill.scene import parse_scene
from chaosdrill.workflow import run

pytestmark = [
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.skipif(not compliance.INSTALLED, reason="compliance-checker is not installed"),
]

ANALYSES = """
[analysis.motion]
kind = "trajectory"
periods = 2
samples = 10
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 5
periods = 32
"""


@pytest.fixture(scope="module")
def faults():
    """What the checker has against a file."""
    with compliance.checker() as check:

        def messages(path):
            failed, stopped = check(path, "cf:1.11")
            assert not stopped
            return [message for _, message in failed]

        yield messages


@pytest.fixture(scope="module", params=["n = 1", "n = 1.5"])
def tree(request, in_si):
    # a contact whose stiffness is in N/m^1.5, a unit that UDUNITS does not have
    text = in_si.replace("n = 1\n", f"{request.param}\n")
    if request.param != "n = 1":
        text = text.replace("4.8e12 N/m", "4.8e12 N/m^1.5")
    return run(parse_scene(text + ANALYSES))


def result(ds):
    """The dataset as a result of an analysis, which the root of a tree is not, so that it can be saved by itself."""
    return ds.assign_attrs(kind=ds.attrs.get("kind", "quantities"))


@pytest.mark.parametrize("group", ["/", "motion", "spectrum"])
def test_no_fault(tree, group, faults, tmp_path):
    path = save(compliance.in_numbers(result(tree[group].to_dataset(inherit=False))), tmp_path / "flat.nc")
    # the one of time is the checker's: time of a model without dimension cannot have the standard name
    assert [message for message in faults(path) if "standard_name='time'" not in message] == []


def test_a_wrong_unit_would_be_found(tree, faults, tmp_path):
    root = tree.to_dataset(inherit=False).copy(deep=True)
    root["si_K"].attrs["units"] = "furlongs per fortnite"
    assert any("fortnite" in message for message in faults(save(result(root), tmp_path / "faulty.nc")))
