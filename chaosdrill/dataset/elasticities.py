"""Effects of one per cent more of each parameter on an orbit, from its derivatives."""

import numpy as np

from chaosdrill.annotations import Dataset


def elasticities(dataset: Dataset) -> dict[str, np.ndarray]:
    """Changes of mean rates and the period, in per cent, and of the largest exponent not 0 by structure, as it is.

    Each has shape (parameters,), and is 0 where it is within its error. Left out are rates that are zero, the period of
    a forced orbit, which is that of its forcing, and, as ``lyapunov_exponent``, an exponent that nothing moves.
    """

    def moved(name: str) -> np.ndarray:
        change, error = dataset[f"{name}_derivative"].values, dataset[f"{name}_derivative_error"].values
        return np.asarray(dataset["parameter_value"].values * np.where(np.abs(change) <= error, 0.0, change))

    trivial = "period_time" if "forcing_period" in dataset.variables else ""
    found = {
        name: moved(name) / float(dataset[name])
        for name in map(str, dataset.data_vars)
        if not dataset[name].ndim and f"{name}_derivative" in dataset and float(dataset[name]) and name != trivial
    }
    exponents = moved("lyapunov_exponent") / 100
    moving = exponents[np.isfinite(exponents).all(axis=1) & exponents.any(axis=1)]
    return found | ({"lyapunov_exponent": moving[0]} if len(moving) else {})
