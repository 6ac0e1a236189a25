"""Between machines and versions each variable is compared by what can be, and what is beyond that is found."""

import sys

import numpy as np
import pytest
import xarray as xr

from chaosdrill.dataset import SCHEMA, Outcome
from chaosdrill.scene import parse_scene
from chaosdrill.workflow import run, verify
from chaosdrill.workflow.agreement import LEADERS
from chaosdrill.workflow.compare import examine
from chaosdrill.workflow.verify import Verification

CHAOS = """\
[system]
model = "impact-oscillator"
[analysis.motion]
kind = "trajectory"
periods = 60
samples = 10
[analysis.section]
kind = "poincare-section"
transient = 100
periods = 64
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 100
periods = 3000
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.omega = { start = 2.45, stop = 2.5, num = 3 }
transient = 100
periods = 512
max_period = 8
"""


@pytest.fixture(scope="module")
def chaos():
    return run(parse_scene(CHAOS))


@pytest.fixture(scope="module")
def elsewhere():
    """The same run with another tolerance, which changes round-off and nothing that can be compared."""
    return run(parse_scene(CHAOS + "[numerics]\ntolerance = 2e-13\n"))


def named(first, second):
    """Variables that disagree, and how each was compared."""
    differences, checks = examine(first, second, exact=False)
    return {f"{d.group}/{d.variable}" for d in differences if ":" not in d.variable}, {
        f"{check.group}/{check.variable}": check.how for check in checks
    }


def altered(tree, path, index, value):
    copy = tree.copy(deep=True)
    copy[path].values[index] = value
    return copy


def test_names_are_those_of_variables():
    assert set(LEADERS.values()) <= {name for table in SCHEMA.values() for name in table}
    for table in SCHEMA.values():
        assert {variable.rule for variable in table.values()} <= {"", "average", "sampled", "magnitude"}
        assert {variable.bar for variable in table.values()} <= {"", *table}


def test_another_round_off_agrees(chaos, elsewhere):
    assert chaos["motion/state"].values[-1, 0] != elsewhere["motion/state"].values[-1, 0]
    wrong, how = named(elsewhere, chaos)
    assert wrong == set()
    assert how["/spectrum/lyapunov_exponent"] == "within 8 standard errors"
    assert how["/spectrum/kaplan_yorke_dimension"] == "within a tenth"
    assert how["/motion/state"] == "until the runs part, then by their range"
    assert how["/diagram/outcome"] == "exactly"
    assert how["/diagram/omega"] == "within 1e-08"


CASES = {
    "an average beyond its error": ("spectrum/lyapunov_exponent", 0, 0.2),
    "an error bar": ("spectrum/lyapunov_error", 0, 1.0),
    "a rate": ("spectrum/impacts_per_period", (), 3.0),
    "a sample before the runs part": ("motion/state", (5, 0), 0.12345),
    "a sample out of range after": ("motion/state", (-1, 0), -40.0),
    "a mode that is none": ("motion/mode", 3, 1),
    "an event before the runs part": ("motion/event_time", 1, 0.5),
    "a point off the attractor": ("section/section", (7, 1), 50.0),
    "an outcome": ("diagram/outcome", (1, 0), Outcome.ESCAPED),
    "a period": ("diagram/period", (1, 0), 3),
    "a swept value": ("diagram/omega", 1, 2.4751),
    "a text": ("diagram/state_name", 1, "w"),
    "a number that is missing": ("spectrum/lyapunov_exponent", 0, np.nan),
}


@pytest.mark.parametrize("case", CASES)
def test_what_is_beyond_that_is_found(chaos, elsewhere, case):
    path, index, value = CASES[case]
    tree = elsewhere.copy(deep=True)
    if path == "diagram/omega":
        group = tree["diagram"].to_dataset()
        values = group["omega"].values.copy()
        values[index] = value
        tree["diagram"] = group.assign_coords(omega=("omega", values, group["omega"].attrs))
    else:
        tree = altered(elsewhere, path, index, value)
    assert named(tree, chaos)[0] == {f"/{path}"}


@pytest.fixture(scope="module")
def regular(every_group):
    return xr.DataTree.from_dict(every_group)


@pytest.mark.parametrize(
    "path",
    [
        "section/multiplier_real",
        "orbit/orbit_state",
        "branch/multiplier_imag",
        "diagram/section",
        "chart/lyapunov_exponent",
    ],
)
def test_cycles_and_multipliers_agree_within_the_stated_error(regular, path):
    place = (0,) * regular[path].ndim
    near = altered(regular, path, place, regular[path].values[place] + 2e-9)
    far = altered(regular, path, place, regular[path].values[place] + 3e-8)
    wrong, how = named(near, regular)
    assert wrong == set()
    assert how[f"/{path}"] == "within 1e-08"
    assert named(far, regular)[0] == {f"/{path}"}


def test_errors_agree_in_magnitude(regular):
    error = float(regular["precision/error"].values[0, 0, 0])
    assert named(altered(regular, "precision/error", (0, 0, 0), 5 * error), regular)[0] == set()
    assert named(altered(regular, "precision/error", (0, 0, 0), 50 * error), regular)[0] == {"/precision/error"}


@pytest.mark.parametrize(("name", "text"), [("versions", '{"chaosdrill": "0.0.1"}'), ("platform", "Plan 9 on a Cray")])
def test_verify_chooses_by_version_and_platform(chaos, elsewhere, monkeypatch, tmp_path, name, text):
    from chaosdrill.archive import save

    tree = elsewhere.copy(deep=True)
    tree.attrs[name] = text
    for node in tree.children.values():
        # settings and the like are those of the same scene
        node.attrs = dict(chaos[node.name].attrs)
    for key in ("scene", "scene_name", "scene_sha256"):
        tree.attrs[key] = chaos.attrs[key]
    monkeypatch.setattr(sys.modules["chaosdrill.workflow.verify"], "compute", lambda *args, **keywords: chaos)
    result = verify(save(tree, tmp_path / "there.nc"))
    assert isinstance(result, Verification)
    assert result.equal, result.table()
    assert not result.exact
    assert result.notes
    assert "within 8 standard errors" in result.how()


def test_descriptions_of_another_version_may_differ(chaos):
    tree = chaos.copy(deep=True)
    tree["diagram/outcome"].attrs["flag_meanings"] = "ok periodic"
    tree["diagram"].attrs["references"] = "none"
    assert {d.variable for d in examine(tree, chaos)[0]} == {"outcome:flag_meanings", ":references"}
    assert examine(tree, chaos, older=True)[0] == []
