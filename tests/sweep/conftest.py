import numpy as np
import pytest
from support.logistic_task import Logistic


def expected(task):
    """Results of a task, unit by unit, without any scheduling."""
    parts = [task.run(k, 1) for k in range(task.units)]
    return {name: np.concatenate([part[name] for part in parts]) for name in task.columns()}


def same_bits(one, other):
    """Whether two sets of arrays are equal to the bit."""
    return one.keys() == other.keys() and all(
        one[name].dtype == other[name].dtype
        and one[name].shape == other[name].shape
        and one[name].tobytes() == other[name].tobytes()
        for name in one
    )


@pytest.fixture
def task():
    """A cheap task."""
    return Logistic()


@pytest.fixture
def whole():
    """Function that gives the results of a task, unit by unit, without any scheduling."""
    return expected


@pytest.fixture
def same():
    """Function that tells whether two sets of arrays are equal to the bit."""
    return same_bits
