"""What a scene may say of an analysis is what the analysis function takes."""

import inspect

import pytest

import chaosdrill as cd
import chaosdrill.analysis
from chaosdrill.analysis.base import NumericsSettings
from chaosdrill.analysis.registry import analyses
from chaosdrill.declared import METHODS
from chaosdrill.scene import parse_scene

ANALYSES = analyses()
# what comes from elsewhere: the system, the table numerics, the command line
ELSEWHERE = {"progress", "workers", "scheduler", "store"}
NUMERICS = set(NumericsSettings.values())


def parameters(kind):
    found = inspect.signature(getattr(chaosdrill.analysis, ANALYSES[kind].function)).parameters
    return dict(list(found.items())[1:])


def elsewhere(kind):
    return ELSEWHERE if ANALYSES[kind].settings.own_numerics else ELSEWHERE | NUMERICS


@pytest.mark.parametrize("kind", ANALYSES)
def test_same_names(kind):
    assert ANALYSES[kind].settings.values().keys() == parameters(kind).keys() - elsewhere(kind)


@pytest.mark.parametrize("kind", ANALYSES)
def test_same_names_are_required(kind):
    empty = inspect.Parameter.empty
    required = {name for name, parameter in parameters(kind).items() if parameter.default is empty}
    faults = dict(ANALYSES[kind].settings.faults({}, also=()))
    assert {path[0] for path, text in faults.items() if text == "missing"} == required


@pytest.mark.parametrize("kind", ANALYSES)
def test_workers_go_to_those_that_take_them(kind):
    assert ANALYSES[kind].settings.parallel == ("workers" in parameters(kind))


@pytest.mark.parametrize("kind", [kind for kind in ANALYSES if not ANALYSES[kind].settings.own_numerics])
def test_numerics_go_to_all_that_do_not_choose_their_own(kind):
    assert parameters(kind).keys() >= NUMERICS


def test_settings_that_the_scene_leaves_out_are_not_passed_on():
    scene = parse_scene(
        '[system]\nmodel = "lorenz"\n[numerics]\ntolerance = 1e-9\n[analysis.a]\nkind = "trajectory"\nduration = 3\n'
    )
    assert scene.numerics == {"tolerance": 1e-9}
    assert scene.analyses["a"].keywords() == {"duration": 3}


def test_methods_with_a_fixed_step_exist():
    assert {name for name, method in METHODS.items() if method.fixed_step} < METHODS.keys()


def test_an_argument_that_there_is_not_is_refused_as_python_does():
    with pytest.raises(TypeError, match=r"trajectory\(\) got an unexpected keyword argument 'period'"):
        cd.trajectory(cd.build("lorenz"), period=3)
    with pytest.raises(TypeError, match=r"basins\(\) missing a required argument: 'grid'"):
        cd.basins(cd.build("lorenz"))
