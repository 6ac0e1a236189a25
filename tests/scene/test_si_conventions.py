"""Archives of scenes in SI units, root and groups, follow CF-1.11, by a checker that is not ours."""

import warnings

import pytest

from chaosdrill.archive import save
from chaosdrill.scene import parse_scene

pytest.importorskip("compliance_checker", reason="compliance-checker is not installed")

pytestmark = pytest.mark.filterwarnings("ignore")

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


def faults(path):
    with warnings.catch_warnings(action="ignore"):
        from compliance_checker.runner import CheckSuite

        CheckSuite.load_all_available_checkers()
    suite = CheckSuite()
    results, stopped = suite.run_all(suite.load_dataset(str(path)), ["cf:1.11"])["cf:1.11"]
    assert not stopped

    def found(result):
        if result.children:
            return [message for child in result.children for message in found(child)]
        passed = result.value[0] == result.value[1] if isinstance(result.value, tuple) else result.value
        return [] if passed else result.msgs or [result.name]

    return [message for result in results for message in found(result)]


@pytest.fixture(scope="module", params=["n = 1", "n = 1.5"])
def tree(request, in_si):
    # a contact whose stiffness is in N/m^1.5, a unit that UDUNITS does not have
    text = in_si.replace("n = 1\n", f"{request.param}\n")
    if request.param != "n = 1":
        text = text.replace("4.8e12 N/m", "4.8e12 N/m^1.5")
    return parse_scene(text + ANALYSES).run()


@pytest.mark.parametrize("group", ["/", "motion", "spectrum"])
def test_no_fault(tree, group, tmp_path):
    path = save(tree[group].to_dataset(inherit=False), tmp_path / "flat.nc")
    # the one of time is the checker's: time of a model without dimension cannot have the standard name
    assert [message for message in faults(path) if "standard_name='time'" not in message] == []


def test_a_wrong_unit_would_be_found(tree, tmp_path):
    root = tree.to_dataset(inherit=False).copy(deep=True)
    root["si_K"].attrs["units"] = "furlongs per fortnite"
    assert any("fortnite" in message for message in faults(save(root, tmp_path / "faulty.nc")))
