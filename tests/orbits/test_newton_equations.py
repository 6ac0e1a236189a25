"""Linear equations of a step of Newton's method: square ones, more than unknowns, and some that say nothing."""

import numpy as np
import pytest

from chaosdrill.orbits.problem import solve


def test_square_equations_of_very_different_sizes():
    rng = np.random.default_rng(3)
    sizes = 10.0 ** rng.uniform(-8, 8, 6)
    matrix = rng.normal(size=(6, 6)) * 10.0 ** rng.uniform(-8, 8, (6, 1)) / sizes
    known = rng.normal(size=6) * sizes
    assert solve(matrix, matrix @ known, 1 / sizes) == pytest.approx(known, rel=1e-10)


def test_an_equation_that_follows_from_others_holds_with_them():
    rng = np.random.default_rng(4)
    matrix, known = rng.normal(size=(5, 4)), rng.normal(size=4)
    matrix[4] = matrix[0] - 2 * matrix[1]
    assert solve(matrix, matrix @ known, np.ones(4)) == pytest.approx(known, rel=1e-12)


def test_what_no_equation_tells_stays_where_it_is():
    matrix = np.array([[1.0, 0.0, 2.0], [0.0, 0.0, 1.0], [2.0, 0.0, 4.0]])
    assert solve(matrix, np.array([3.0, 1.0, 6.0]), np.ones(3)) == pytest.approx([1.0, 0.0, 1.0], abs=1e-14)


def test_an_entry_that_is_no_number_leaves_no_solution():
    assert np.isnan(solve(np.array([[1.0, np.inf], [0.0, 1.0]]), np.ones(2), np.ones(2))).all()
