"""Reference orbits lie beside the tests that use them."""

import sys
from pathlib import Path

import pytest
from mpmath import mp

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def digits():
    """Set the working precision of mpmath for one test."""
    before = mp.dps

    def work_with(count):
        mp.dps = count

    yield work_with
    mp.dps = before
