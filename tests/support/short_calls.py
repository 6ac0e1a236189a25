"""Short calls of every analysis, for laws that hold of all: a new analysis is entered here once."""


def short_calls(x, v, sweep, other):
    """Arguments besides the system by function, but for `equilibria`, which forced systems have none of.

    ``x``, ``v``: two states, and ``sweep``, ``other``: two parameters, each as its name with two values.
    """
    few = {"transient": 2, "periods": 4, "max_period": 2}
    (state, starts), (parameter, values) = x, sweep
    grid, swept, one_start = dict([x, v]), dict([sweep]), [{state: starts[0]}]
    return {
        "trajectory": {"periods": 3, "samples": 2},
        "poincare_section": {"periods": 3},
        "zero_one_test": {"periods": 64, "max_period": 2},
        "regularity": {"periods": 64, "max_period": 2},
        "dimensions": {"periods": 200, "max_period": 2},
        "finite_time_exponents": {"periods": 4, "windows": [1]},
        "covariant_vectors": {"periods": 4, "forward": 2, "backward": 2},
        "transient_chaos": {"periods": 4, "initial": one_start},
        "lyapunov_spectrum": {"periods": 4},
        "bifurcation_diagram": {"sweep": swept, "seeds": [{}], "follow": "both", **few},
        "parameter_chart": {"sweep": dict([sweep, other]), **few},
        "basins": {"grid": grid, **few},
        "basin_measures": {"grid": grid, **few},
        "attractors": {"sweep": swept, "initial": {state: starts}, **few},
        "edge_states": {"initial": 2 * one_start, **few},
        "periodic_orbit": {"start": "search", "max_period": 1},
        "continue_orbit": {"sweep": {parameter: tuple(values)}, "doublings": 0, "max_points": 5},
        "manifolds": {"start": "attractor", "length": 0.1, "spacing": 0.1},
        "work_precision": {"periods": 2, "methods": ["taylor"], "tolerances": [1e-6], "repeats": 1},
    }
