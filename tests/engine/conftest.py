"""Solutions in closed form, found once for all tests."""

import pytest
from support.closed_forms import CASES


@pytest.fixture(scope="session")
def solved():
    """Solutions found so far, by case."""
    return {}


@pytest.fixture(params=CASES, ids=lambda make: make.__name__)
def closed_form(request, solved):
    """A case and its solution: state, event times, tangent map."""
    make = request.param
    if make not in solved:
        case = make()
        solved[make] = case, case.solve()
    return solved[make]
