"""``run`` prints the numbers that fit on a line, and advice for points without a result."""

import numpy as np
import xarray as xr

from chaosdrill.cli.run import advice, summary
from chaosdrill.dataset import Outcome

FLAGS = {"flag_meanings": " ".join(outcome.meaning for outcome in Outcome)}


def test_exponents_and_scalars():
    dataset = xr.Dataset(
        {
            "lyapunov_exponent": ("exponent", [0.0151, -0.088, -np.inf]),
            "lyapunov_history": (("block", "exponent"), np.zeros((4, 3))),
            "progression_rate": ((), 0.0048),
            "outcome": ((), np.int8(3), FLAGS),
        }
    )
    assert summary(dataset) == [
        "lyapunov_exponent 0.0151 -0.088 -inf",
        "progression_rate 0.0048",
        "outcome chaotic",
    ]
    assert advice(dataset) == []


def test_outcomes_of_many_points():
    codes = np.array([[3, 1], [4, 1], [4, 1]], dtype=np.int8)
    dataset = xr.Dataset({"outcome": (("eta", "seed"), codes, FLAGS)})
    assert summary(dataset) == ["outcome periodic 3, chaotic 1, escaped 2"]
    assert advice(dataset) == [f"escaped (2 of 6): {Outcome.ESCAPED.advice}"]
