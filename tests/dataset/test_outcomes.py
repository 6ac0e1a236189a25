"""Outcomes are fixed codes with advice."""

import numpy as np
import pytest

from chaosdrill.dataset import Outcome
from chaosdrill.dataset.outcomes import count_outcomes


def test_codes_are_fixed():
    # archives hold these numbers
    codes = (
        "ok periodic quasiperiodic chaotic escaped event_limit stalled nonfinite step_underflow invalid_start failed "
        "no_orbit equilibrium inadmissible open no_special_point undecided no_return singular transient "
        "contracting no_equilibrium no_saddle"
    )
    assert [outcome.meaning for outcome in Outcome] == codes.split()
    assert [int(outcome) for outcome in Outcome] == list(range(23))


@pytest.mark.parametrize("outcome", Outcome)
def test_every_outcome_has_advice(outcome):
    assert outcome.advice.endswith(".")


def test_counts_by_meaning():
    assert count_outcomes(np.array([[3, 1], [1, 4]], dtype=np.int8)) == {"periodic": 2, "chaotic": 1, "escaped": 1}


def test_a_code_that_is_no_outcome_is_counted_as_such():
    assert count_outcomes(np.array(77, dtype=np.int8)) == {"code 77": 1}


@pytest.mark.parametrize("outcome", [Outcome.STALLED, Outcome.EVENT_LIMIT])
def test_advice_on_chatter_names_it_and_the_remedies(outcome):
    for words in ("chatter", "a mode that holds", "raise the restitution", "look for a reset"):
        assert words in outcome.advice
