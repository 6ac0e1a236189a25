"""An archive in which any single value was altered does not verify, and the variable is named."""

import netCDF4
import numpy as np
import pytest

from chaosdrill.archive import verify
from chaosdrill.scene import Scene


@pytest.fixture
def verified(every_kind, monkeypatch, tmp_path):
    """Verify a copy of the archive that was altered; the run that it is compared with is not made anew each time."""
    from chaosdrill.archive import open as open_archive

    again = open_archive(every_kind)
    monkeypatch.setattr(Scene, "run", lambda *args, **keywords: again)

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
        "by the digest of its values alone: a clock measured it",
    }


def other(value, rng):
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
    altered = []
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
            variable[index] = other(variable[index], rng)
            altered.append((f"/{group}", name))

    result = verified(alter_all)
    assert len(altered) > 150
    named = {(item.group, item.variable) for item in result.differences}
    # texts along a dimension have another name in the file
    along = {"/precision": {"method_name": "method", "quantity_name": "quantity"}}
    assert {(group, along.get(group, {}).get(name, name)) for group, name in altered} - named == set()


@pytest.mark.parametrize(
    "name", ["motion/state", "orbit/multiplier_real", "precision/wall_time", "branch/event_sequence"]
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
