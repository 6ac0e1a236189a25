"""In which order states, parameters, modes and transitions are declared changes no result but by rounding.

The order of parameters, of modes, and of transitions that never act together changes no bit. The order of states may
change the last ones, since sums over all states follow it, and tangents begin along the states one by one.
"""

import numpy as np
import pytest
import sympy
from support.short_calls import short_calls

import chaosdrill as cd
from chaosdrill.analysis.registry import FUNCTIONS

STATES, PARAMETERS, MODES, TRANSITIONS = (
    ("x", "v", "z"),
    ("w", "k", "c"),
    ("free", "pressed"),
    ("touch", "leave", "top"),
)


def system(states=STATES, parameters=PARAMETERS, modes=MODES, transitions=TRANSITIONS):
    """An oscillator that hits a soft stop, on a cycle of two turns of the drive, with a mark where it is deepest."""
    rates = {
        "free": {"x": "v", "v": "-x - c*v + cos(w*t) + z*x/20", "z": "-z + x**2*v"},
        "pressed": {"x": "v", "v": "-x - 4*c*v + cos(w*t) - 5*(x - 1/10)", "z": "-z/2 + v"},
    }
    numbers = {"w": 2.45, "k": 0.9, "c": 0.1}
    known = {
        "touch": {"source": "free", "target": "pressed", "guard": "x - 1/10", "direction": 1},
        "leave": {"source": "pressed", "target": "free", "guard": "x - 1/10", "direction": -1},
        "top": {"source": "pressed", "target": "pressed", "guard": "v", "direction": -1},
    }
    known["touch"]["reset"] = {"v": "k*v", "z": "z + v*x"}
    return cd.HybridSystem(
        name="soft stop",
        states=states,
        time="t",
        parameters={name: numbers[name] for name in parameters},
        modes={mode: {state: rates[mode][state] for state in states} for mode in modes},
        transitions=[cd.Transition(name, **known[name]) for name in transitions],
        period=2 * sympy.pi / sympy.Symbol("w", real=True),
        quadratures={"work": "v**2 + w*x"},
        initial={"mode": "free", "x": -0.3},
    )


SHORT = {"transient": 200, "periods": 32, "max_period": 4}
MORE = {
    "trajectory": {"transient": 200, "periods": 4, "samples": 8},
    **{name: {"transient": 200, "periods": 16} for name in ("poincare_section", "covariant_vectors")},
    **{name: {"transient": 200, "periods": 64} for name in ("zero_one_test", "regularity", "dimensions")},
    "finite_time_exponents": {"transient": 200, "periods": 32, "windows": [1]},
    "transient_chaos": {"periods": 8, "initial": {"x": [-0.4, -0.3, -0.2], "v": [0.0, 0.1, 0.2]}, "until": "touch"},
    "lyapunov_spectrum": {"transient": 200, "periods": 200},
    "bifurcation_diagram": {"sweep": {"w": [2.2, 2.45]}, **SHORT},
    "parameter_chart": {"sweep": {"w": [2.2, 2.45], "c": [0.1, 0.11]}, **SHORT},
    "basins": {"grid": {"x": [-0.3, 0.0], "z": [0.0, 0.2]}, **SHORT},
    "attractors": {"sweep": {"w": [2.2, 2.45]}, "initial": {"x": [-0.3, 0.0]}, **SHORT},
    "basin_measures": {"grid": {"x": [-0.3, 0.0], "z": [0.0, 0.2]}, "box": 2, "sweep": {"w": [2.2, 2.45]}, **SHORT},
    "edge_states": {"initial": {"x": [-0.3, 0.0]}, **SHORT},
    "periodic_orbit": {"start": "attractor", "period": 2},
    "continue_orbit": {"sweep": {"w": (2.4, 2.5)}, "period": 2, "step": 0.02},
    "manifolds": {"start": "attractor", "period": 2},
}
"""Arguments with which motions have settled where the analysis looks."""

FORCED = {
    **short_calls(("x", [-0.3, 0.0]), ("z", [0.0, 0.2]), ("w", [2.2, 2.45]), ("c", [0.1, 0.11])),
    **MORE,
}


def results(tried):
    """What each analysis finds; there are no equilibria under a force, see tests/equilibrium."""
    for name in FUNCTIONS:
        if name != "equilibria":
            # on a spiral no single vector has a meaning
            settled = tried.with_parameters(c=0.3) if name == "covariant_vectors" else tried
            yield name, facts(getattr(cd, name)(settled, **FORCED[name]))


EXPONENTS = {
    "lyapunov_exponent": "lyapunov_error",
    "attractor_exponent": "attractor_error",
    "cumulant": "cumulant_error",
    "correlation_time": "correlation_time_error",
}
"""Means over a time, in which tangents begin along the states in their order, by the names of their errors."""

HISTORIES = ("lyapunov_history", "histogram", "histogram_error", "bin_centre")
"""Single values of which such means are made."""


def facts(ds):
    """Values of a result by name, in an order and with words that do not depend on how the system was declared."""
    for dimension in ("state", "transition"):
        if dimension in ds.variables:
            ds = ds.isel({dimension: np.argsort(ds[dimension].values)})
    found = {}
    for name, variable in ds.variables.items():
        values = variable.values
        if "flag_meanings" in variable.attrs:
            words = dict(zip(variable.attrs["flag_values"], variable.attrs["flag_meanings"].split(), strict=True))
            values = np.array([words.get(code, "none") for code in values.ravel()]).reshape(values.shape)
        elif values.dtype.kind in "OU":
            # texts name events in the order of their declaration
            values = np.array([" ".join(sorted(str(text).replace(";", "").split())) for text in values.ravel()])
        if not str(name).startswith("wall_time"):
            found[name] = values
    return found


@pytest.fixture(scope="module")
def plain():
    return dict(results(system()))


def test_modes_transitions_and_parameters_may_be_declared_in_any_order(plain):
    other = system(parameters=PARAMETERS[::-1], modes=MODES[::-1], transitions=("top", "leave", "touch"))
    for kind, found in results(other):
        assert found.keys() == plain[kind].keys()
        differ = [name for name, values in found.items() if values.tobytes() != plain[kind][name].tobytes()]
        assert not differ, kind


def test_states_may_be_declared_in_any_order_but_for_rounding(plain):
    other = system(states=("z", "x", "v"))
    for kind, found in results(other):
        for name, values in found.items():
            before = plain[kind][name]
            error = EXPONENTS.get(name)
            if error in found:
                allowed = np.maximum(found[error], plain[kind][error]) + 1e-12
                missing = np.isnan(values) & np.isnan(before)
                assert (missing | (np.abs(values - before) <= allowed)).all(), (kind, name)
            elif values.dtype.kind != "f":
                assert (values == before).all(), (kind, name)
            elif name not in (*EXPONENTS.values(), *HISTORIES):
                np.testing.assert_allclose(values, before, rtol=1e-6, atol=1e-9, err_msg=f"{kind} {name}")
