"""What a scene may say of an analysis is what the analysis function takes."""

import inspect

import pytest

import chaosdrill.analysis
from chaosdrill.analysis.registry import ANALYSES, FIXED_STEP, METHODS
from chaosdrill.scene.kinds import KINDS
from chaosdrill.scene.numerics import Numerics

# what comes from elsewhere: the system, the table numerics, the command line
ELSEWHERE = {"progress", "workers", "scheduler", "store"}
NUMERICS = set(Numerics.model_fields)


def parameters(kind):
    found = inspect.signature(getattr(chaosdrill.analysis, ANALYSES[kind].function)).parameters
    return dict(list(found.items())[1:])


def elsewhere(kind):
    return ELSEWHERE if KINDS[kind].own_numerics else ELSEWHERE | NUMERICS


def test_every_analysis_can_be_asked_for():
    assert KINDS.keys() == ANALYSES.keys()


@pytest.mark.parametrize("kind", KINDS)
def test_same_names(kind):
    assert KINDS[kind].model_fields.keys() - {"kind"} == parameters(kind).keys() - elsewhere(kind)


@pytest.mark.parametrize("kind", KINDS)
def test_same_names_are_required(kind):
    required = {name for name, field in KINDS[kind].model_fields.items() if field.is_required()}
    empty = inspect.Parameter.empty
    assert required - {"kind"} == {name for name, parameter in parameters(kind).items() if parameter.default is empty}


@pytest.mark.parametrize("kind", KINDS)
def test_workers_go_to_those_that_take_them(kind):
    assert KINDS[kind].parallel == ("workers" in parameters(kind))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if not KINDS[kind].own_numerics])
def test_numerics_go_to_all_that_do_not_choose_their_own(kind):
    assert parameters(kind).keys() >= NUMERICS


def test_numerics_that_the_scene_leaves_out_are_not_passed_on():
    assert Numerics(tolerance=1e-9).keywords() == {"tolerance": 1e-9}


def test_methods_with_a_fixed_step_exist():
    assert set(FIXED_STEP) < METHODS.keys()
