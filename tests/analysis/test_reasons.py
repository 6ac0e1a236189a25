"""Every number that is missing from a measure says why: by its outcome, the attribute ``reason``, or its comment."""

import inspect
import re

import numpy as np
import pytest
from support.short_calls import short_calls

import chaosdrill as cd
from chaosdrill.dataset.outcomes import MEASURED, Outcome
from chaosdrill.dataset.schema import SCHEMA


def maps():
    """Maps of two states by what happens to them."""
    henon = cd.Map("x y", {"a": 1.4, "b": 0.3}, {"x": "1 - a*x**2 + y", "y": "b*x"}, initial={"x": 0.1, "y": 0.05})
    return {
        "chaotic": henon,
        "on a cycle": henon.with_parameters(a=0.3),
        "on a curve": henon.with_parameters(a=0.2, b=-1.0),
        "escaping": henon.with_parameters(a=3.0),
        "without its rank": henon.with_parameters(b=0.0),
    }


MAPS = maps()
LONGER = {
    "lyapunov_spectrum": {"periods": 300},
    "dimensions": {"periods": 600},
    "finite_time_exponents": {"periods": 64},
    "covariant_vectors": {"periods": 64},
    "transient_chaos": {"periods": 8, "initial": None, "random": {"count": 200, "seed": 1, "x": (-2, 2)}},
    "edge_states": {"initial": [{"x": 0.1}, {"x": 5.0}], "rounds": 3},
    "basin_measures": {"initial": [{"x": 0.1}, {"x": 9.0}]},
}
"""Arguments by which analyses say more than in their short calls."""


def calls():
    """Every analysis but of orbits and of what accuracy costs, which have words of their own for what is missing."""
    swept = {"sweep": {"a": [1.4, 3.0]}}
    every = short_calls(("x", [0.1, 0.2]), ("y", [0.0, 0.1]), ("a", [1.4, 3.0]), ("b", [0.3, 0.2]))
    for name, arguments in every.items():
        if name in ("periodic_orbit", "continue_orbit", "manifolds", "work_precision"):
            continue
        yield name, arguments
        if name in LONGER:
            yield name, {key: value for key, value in (arguments | LONGER[name]).items() if value is not None}
        if "sweep" in inspect.signature(getattr(cd, name)).parameters and "sweep" not in arguments:
            yield name, arguments | swept


def told(ds):
    """Names of the variables that the attribute ``reason`` names, and whether it gives one for all."""
    named, general = set(), False
    for part in filter(None, ds.attrs.get("reason", "").split("; ")):
        head, colon, _ = part.partition(": ")
        names = set(re.split("[, ]+", head)) & set(ds.data_vars) if colon else set()
        named |= names
        general |= not names
    # of a spectrum it tells why the outcome is what it is
    return named, general and ds.attrs["kind"] != "lyapunov-spectrum"


def unexplained(ds):
    """Names of variables with a number that is missing and does not say why."""
    declared = SCHEMA[ds.attrs["kind"]]
    named, general = told(ds)
    codes = [name for name, one in declared.items() if one.flags is Outcome and name in ds]
    found = []
    for name, one in ds.data_vars.items():
        value = next((other for other, of in declared.items() if of.bar == name), name.removesuffix("_error"))
        if one.dtype.kind != "f" or general or {name, value} & named or "NaN" in one.attrs["comment"]:
            continue
        missing = np.isnan(one)
        for code in codes:
            if set(ds[code].dims) <= set(one.dims):
                missing &= ds[code].isin(MEASURED)
        if value != name and value in ds and ds[value].dims == one.dims:
            # what has no finite number has no error
            missing &= np.isfinite(ds[value])
        if missing.any():
            found.append(name)
    return found


@pytest.mark.parametrize("motion", MAPS)
def test_what_is_missing_says_why(motion):
    silent = {}
    for name, arguments in calls():
        ds = getattr(cd, name)(MAPS[motion], **arguments)
        if names := unexplained(ds):
            silent[name, str(arguments)] = names
    assert silent == {}


def test_basins_name_starts_beyond_a_guard():
    oscillator, lengths = cd.build("impact-oscillator"), {"transient": 2, "periods": 4, "max_period": 2}
    for wall, told in ((0.0, "fraction_none: 2 of 4"), (1.0, "no start could be run: 4 of 4")):
        found = cd.basin_measures(oscillator, {"x": [wall, 2.0], "v": [0.0, 0.1]}, **lengths)
        assert f"{told} starts are invalid_start" in found.attrs["reason"]


def test_a_sweep_has_the_reasons_of_all_orders():
    """They ended within that of the second."""
    states = [f"x{i}" for i in range(8)]
    many = cd.Map(
        states, {"a": 1.99}, {x: f"1 - (a - {i}/200)*{x}**2" for i, x in enumerate(states)},
        initial={x: 0.1 + 0.07 * i for i, x in enumerate(states)},
    )  # fmt: skip
    given = {"transient": 100, "periods": 520, "orders": [1, 2, 3, 4]}
    one, swept = (cd.dimensions(many, **given, **more) for more in ({}, {"sweep": {"a": [1.99]}}))
    assert one.attrs["reason"].count("record more points") == 4
    assert swept.attrs["reason"] == one.attrs["reason"]
