"""What happens on a branch has fixed codes, each with its words."""

import pytest

from chaosdrill.dataset import BranchEnd, Special
from chaosdrill.dataset.branches import Onset


def test_codes_are_fixed():
    # archives hold these numbers
    special = "regular fold period_doubling neimark_sacker grazing event_swap outcome_switch branch_point"
    special += " border_collision cusp resonance_1_1 resonance_1_2 resonance_1_3 resonance_1_4 fold_flip"
    special += " generalised_flip chenciner fold_neimark_sacker flip_neimark_sacker double_neimark_sacker"
    special += " grazing_fold grazing_flip grazing_neimark_sacker level optimum hopf"
    special += " crossing_sliding grazing_sliding adding_sliding switching_sliding resonant_grazing"
    special += " degenerate_sliding sliding_fold sliding_flip sliding_neimark_sacker"
    ends = "limit grazing event_swap outcome_switch closed most_points escaped no_convergence no_effect joined"
    ends += " doubling rest"
    assert [code.meaning for code in Special] == special.split()
    assert [code.meaning for code in BranchEnd] == ends.split()
    onsets = "none continuous period_adding period_adding_chaos chaos jump undecided"
    assert [code.meaning for code in Onset] == onsets.split()
    assert [*map(int, Onset)] == list(range(7))
    assert [*map(int, Special)] == list(range(35))
    assert [*map(int, BranchEnd)] == list(range(12))


@pytest.mark.parametrize("text", [*(code.advice for kind in (Special, BranchEnd) for code in kind)])
def test_every_code_has_a_sentence(text):
    assert text.endswith(".")
