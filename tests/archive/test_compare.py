"""What differs between two archives is found, named and measured, bit by bit or by what can be compared."""

import sys
from hashlib import sha256

import netCDF4
import numpy as np
import pytest
import xarray as xr

from chaosdrill.archive import save
from chaosdrill.archive.digest import altered as altered_names
from chaosdrill.dataset import SCHEMA, Outcome
from chaosdrill.reports import report
from chaosdrill.scene import parse_scene
from chaosdrill.workflow import compare, info, run, verify
from chaosdrill.workflow.compare import LEADERS, examine
from chaosdrill.workflow.verify import Verification

# The smallest change is found, named and measured; times and history do not count.


@pytest.fixture
def other(tree):
    return tree.copy(deep=True)


def only(tree, other):
    (difference,) = compare(other, tree)
    return difference


def test_equal(tree, other):
    assert compare(other, tree) == []


def test_one_bit(tree, other):
    values = other["first/section"].values
    values[1, 0, 0, 0] = np.nextafter(values[1, 0, 0, 0], 1)
    found = only(tree, other)
    assert (found.group, found.variable) == ("/first", "section")
    assert (found.differing, found.total) == (1, 24)
    assert 0 < found.max_abs < 1e-15


def test_largest_of_several(tree, other):
    other["second/section"].values[4, 0, :2, 1] += [0.5, -2.0]
    found = only(tree, other)
    assert (found.group, found.differing, found.total) == ("/second", 2, 40)
    assert found.max_abs == pytest.approx(2.0)


def test_number_where_there_was_none(tree, other):
    other["first/section"].values[0, 0, 0, 0] = 1.0
    found = only(tree, other)
    assert (found.differing, found.max_abs) == (1, np.inf)


def test_sign_of_zero(tree, other):
    tree["first/section"].values[1, 0, 0, 0] = 0.0
    other["first/section"].values[1, 0, 0, 0] = -0.0
    assert (only(tree, other).differing, only(tree, other).max_abs) == (1, 0.0)


def test_code(tree, other):
    other["first/outcome"].values[2, 0] = 4
    assert (only(tree, other).variable, only(tree, other).max_abs) == ("outcome", 1.0)


def test_text(tree, other):
    group = other["first"].to_dataset()
    other["first"] = group.assign_coords(state=("state", ["y", "v"], group["state"].attrs))
    assert (only(tree, other).what, only(tree, other).differing) == ("text differs", 1)


def test_variable_missing_and_added(tree, other):
    other["first"] = other["first"].to_dataset().rename(period="periode")
    found = {difference.variable: difference.what for difference in compare(other, tree)}
    assert found == {"period": "is missing", "periode": "does not belong here"}


def test_group_missing_and_added(tree, other):
    other["third"] = other["first"]
    del other["first"]
    found = {difference.group: difference.what for difference in compare(other, tree)}
    assert found == {"/first": "group is missing", "/third": "unexpected group"}


def test_shape(tree, other):
    other["second"] = other["second"].to_dataset().isel(iterate=slice(3))
    assert only(tree, other).variable == "section"
    assert "'iterate': 3" in only(tree, other).what


def test_dtype(tree, other):
    first = other["first"].to_dataset()
    other["first"] = first.assign(period=first["period"].astype("i4"))
    assert only(tree, other).what == "holds int32; expected int16"


def test_attribute(tree, other):
    other["first/section"].attrs["units"] = "m"
    assert only(tree, other).variable == "section:units"


def test_what_a_clock_measured_does_not_count(tree, other):
    """Declared so in the table of variables; the shape still counts."""
    for archive, seconds in ((tree, 1e-5), (other, 2e-5)):
        archive["third"] = xr.Dataset(
            {"wall_time": (("method", "tolerance"), [[seconds]]), "error": ("quantity", [0.0])},
            attrs={"kind": "work-precision", "recommendation": f"{seconds}"},
        )
    assert compare(other, tree) == []
    other["third/error"].values[0] = 1e-9
    assert only(tree, other).variable == "error"
    other["third"] = tree["third"].to_dataset().assign(wall_time=("method", [1e-5]))
    assert only(tree, other).variable == "wall_time"


@pytest.mark.parametrize("name", ["history", "wall_time_s", "versions", "platform"])
def test_what_a_second_run_changes_does_not_count(tree, other, name):
    other.attrs[name] = other["first"].attrs[name] = "another"
    assert compare(other, tree) == []


def test_the_order_in_a_table_of_settings_says_nothing(tree, other):
    tree["first"].attrs["settings"] = '{"periods": 8, "sweep": {"e": [0.1, 0.2]}}'
    other["first"].attrs["settings"] = '{"sweep": {"e": [0.1, 0.2]}, "periods": 8}'
    assert compare(other, tree) == []
    other["first"].attrs["settings"] = '{"sweep": {"e": [0.2, 0.1]}, "periods": 8}'
    assert only(tree, other).variable == ":settings"


# Between machines and versions each variable is compared by what can be, and what is beyond that is found.


# below omega = 2.451 the chaotic motion comes to chatter now and then, which ends a run
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
sweep.omega = { start = 2.46, stop = 2.5, num = 3 }
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
    assert chaos["motion/states"].values[-1, 0] != elsewhere["motion/states"].values[-1, 0]
    wrong, how = named(elsewhere, chaos)
    assert wrong == set()
    assert how["/spectrum/lyapunov_exponent"] == "within 8 standard errors"
    assert how["/spectrum/kaplan_yorke_dimension"] == "within 8 standard errors"
    assert how["/motion/states"] == "until the runs diverge, then by their range"
    assert how["/diagram/outcome"] == "exactly"
    assert how["/diagram/omega"] == "within 1e-08"


CASES = {
    "an average beyond its error": ("spectrum/lyapunov_exponent", 0, 0.2),
    "an error bar": ("spectrum/lyapunov_error", 0, 1.0),
    "a rate": ("spectrum/impacts_per_period", (), 3.0),
    "a sample before the runs part": ("motion/states", (5, 0), 0.12345),
    "a sample out of range after": ("motion/states", (-1, 0), -40.0),
    "a mode that is none": ("motion/mode", 3, 1),
    "an event before the runs part": ("motion/event_time", 1, 0.5),
    "a point off the attractor": ("section/section", (7, 1), 50.0),
    "an outcome": ("diagram/outcome", (1, 0), Outcome.ESCAPED),
    "a period": ("diagram/period", (1, 0), 3),
    "a swept value": ("diagram/omega", 1, 2.4801),
    "a text": ("diagram/state", 1, "w"),
    "a number that is missing": ("spectrum/lyapunov_exponent", 0, np.nan),
}


@pytest.mark.parametrize("case", CASES)
def test_what_is_beyond_that_is_found(chaos, elsewhere, case):
    path, index, value = CASES[case]
    tree = elsewhere.copy(deep=True)
    if path in ("diagram/omega", "diagram/state"):
        group, name = tree["diagram"].to_dataset(), path.removeprefix("diagram/")
        values = group[name].values.copy()
        values[index] = value
        tree["diagram"] = group.assign_coords({name: (name, values, group[name].attrs)})
    else:
        tree = altered(elsewhere, path, index, value)
    assert named(tree, chaos)[0] == {f"/{path}"}


def in_nanometres(tree):
    """The same motion with states a billion times smaller."""
    copy = tree.copy(deep=True)
    for node in copy.subtree:
        for name, variable in node.data_vars.items():
            if variable.dims[-1:] == ("state",):
                node[name].values[...] *= 1e-9
    return copy


def test_small_units_hide_nothing(chaos, elsewhere):
    one, other = in_nanometres(chaos), in_nanometres(elsewhere)
    assert named(other, one)[0] == set()
    for path, index in (("motion/states", (5, 0)), ("section/section", (7, 1))):
        wrong = altered(other, path, index, other[path].values[index] + 40e-9)
        assert named(wrong, one)[0] == {f"/{path}"}


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
    near = altered(regular, path, place, regular[path].values[place] + 1e-9)
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


# An archive in which any single value was altered does not verify, and the variable is named.


@pytest.fixture
def verified(every_kind, monkeypatch, tmp_path):
    """Verify a copy of the archive that was altered; the run that it is compared with is not made anew each time."""
    from chaosdrill.archive import open as open_archive

    again = open_archive(every_kind)
    monkeypatch.setattr(sys.modules["chaosdrill.workflow.verify"], "compute", lambda *args, **keywords: again)

    def check(alter):
        copy = tmp_path / "altered.nc"
        copy.write_bytes(every_kind.read_bytes())
        with netCDF4.Dataset(copy, "a") as file:
            alter(file)
        return verify(copy)

    return check


def test_unaltered(every_kind):
    result = verify(every_kind)
    assert result.equal, result.table()
    assert result.exact
    assert {check.how for check in result.checks} == {
        "bit for bit",
        "by the checksum of its values alone: measured time",
    }


def other_value(value, rng):
    """Another value, as near as can be for numbers."""
    if isinstance(value, str):
        return value + "x"
    if np.asarray(value).dtype.kind in "iu":
        return value + 1 if value < 100 else value - 1
    if np.isfinite(value):
        return np.nextafter(value, rng.choice([-np.inf, np.inf]))
    return 0.0


def test_any_value_of_any_variable(every_kind, verified):
    rng = np.random.default_rng(6)
    changed = []
    with netCDF4.Dataset(every_kind) as file:
        places = [
            (group, name, tuple(int(rng.integers(n)) for n in variable.shape))
            for group, content in file.groups.items()
            for name, variable in content.variables.items()
            if variable.size
        ]

    def alter_all(file):
        for group, name, index in places:
            variable = file[group][name]
            variable.set_auto_mask(False)
            variable[index] = other_value(variable[index], rng)
            changed.append((f"/{group}", name))

    result = verified(alter_all)
    assert len(changed) > 150
    named = {(item.group, item.variable) for item in result.differences}
    assert set(changed) - named == set()


@pytest.mark.parametrize(
    "name", ["motion/states", "orbit/multiplier_real", "precision/wall_time", "branch/event_sequence"]
)
def test_only_the_altered_one_is_named(verified, name):
    def alter(file):
        variable = file[name]
        index = (0,) * variable.ndim
        variable[index] = variable[index] + "x" if variable.dtype is str else np.nextafter(variable[index], np.inf)

    (difference,) = verified(alter).differences
    assert f"{difference.group}/{difference.variable}" == f"/{name}"


def test_an_attribute(verified):
    def alter(file):
        file["spectrum"].parameters = file["spectrum"].parameters.replace("3.3", "3.4")

    assert [(d.group, d.variable) for d in verified(alter).differences] == [("/spectrum", ":parameters")]


def test_a_line_of_history_is_no_alteration(verified):
    def alter(file):
        file.history = "ncatted ...\n" + file.history

    assert verified(alter).equal


SCENE = 'title = "A ball"\n[system]\nmodel = "impact-oscillator"\n[system.parameters]\ne = 0.9\n'

ROOT = {"scene": SCENE.replace("0.9", "0.8"), "scene_sha256": "0" * 64, "title": "Another", "wall_time_s": 2.5}


@pytest.fixture
def small(tree, tmp_path):
    """An archive with a scene that was never run."""
    tree.attrs |= {"scene": SCENE, "scene_sha256": sha256(SCENE.encode()).hexdigest()}
    return save(tree, tmp_path / "small.nc")


@pytest.mark.parametrize("name", ROOT)
def test_an_attribute_of_the_root_is_told_without_a_run(small, name):
    with netCDF4.Dataset(small, "a") as file:
        file.setncattr(name, ROOT[name])
    assert info(small)["altered"] == ([":", ":scene"] if name.startswith("scene") else [":"])
    page = report(small).path.read_text(encoding="utf-8")
    assert "Altered since the archive was written" in page
    assert "altered since they were written: :" in page
    assert "as they were written, by the digests" not in page


def test_a_number_of_the_root_is_told_without_a_run(tree, tmp_path):
    path = save(tree.assign(si_m1=xr.Variable((), 250.0)), tmp_path / "si.nc")
    with netCDF4.Dataset(path, "a") as file:
        file["si_m1"][...] = 25.0
    assert info(path)["altered"] == ["si_m1"]
    assert "altered since they were written: si_m1" in report(path).path.read_text(encoding="utf-8")


def test_an_archive_without_digests_has_the_digest_of_its_scene():
    root = xr.Dataset(attrs={"scene": "e = 0.8", "scene_sha256": sha256(b"e = 0.9").hexdigest()})
    assert altered_names(root) == [":scene"]
    assert altered_names(root.assign_attrs(scene="e = 0.9")) is None


def test_nothing_is_told_of_one_that_was_not(small):
    assert "altered" not in info(small)
    page = report(small).path.read_text(encoding="utf-8")
    assert "Altered" not in page
    assert "as they were written, by the digests" in page
