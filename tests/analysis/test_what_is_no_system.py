"""Every analysis refuses what is no system, with the name of the argument, the value and the remedy."""

import re

import pytest

import chaosdrill as cd
from chaosdrill.declared import ANALYSES

REQUIRED = {
    "bifurcation-diagram": ({"e": [0.5, 0.6]},),
    "parameter-chart": ({"e": [0.5, 0.6], "omega": [2.0, 3.0]},),
    "basins": ({"x": [0.0, 0.1], "v": [0.0, 0.1]},),
    "continuation": ({"e": (0.5, 0.6)},),
}
LENGTHS = {"bifurcation-diagram", "parameter-chart", "basins"}


@pytest.mark.parametrize("given", ["impact-oscillator", None, {"name": "mine"}, len], ids=repr)
@pytest.mark.parametrize("kind", ANALYSES)
def test_refused(kind, given):
    lengths = {"periods": 5, "transient": 5} if kind in LENGTHS else {}
    with pytest.raises(cd.SettingsError, match=r"^system is .*; it must be a HybridSystem") as told:
        getattr(cd, ANALYSES[kind].function)(given, *REQUIRED.get(kind, ()), **lengths)
    assert repr(given)[:60] in str(told.value)


class Alike:
    """What has a method of systems, and is none."""

    def with_parameters(self):
        return self


CALLS = {
    "halved": {"symmetry": {"x": "-x"}},
    "on_level": {"conserved": "x**2"},
    "driven": {"drive": "f", "pieces": "square"},
    "save_scene": {"path": "new.toml", "analyses": {}},
    "event_orders": {"state": [0.0, 0.0]},
}


@pytest.mark.parametrize("name", CALLS)
def test_other_functions_refuse_it_alike(name):
    for given, words in ((Alike(), "Alike"), ("chua", r"chaosdrill\.build\('chua'\)")):
        with pytest.raises(cd.ChaosdrillError, match=r"^system is .*; it must be a HybridSystem.*") as told:
            getattr(cd, name)(system=given, **CALLS[name])
        assert re.search(words, str(told.value))


def test_a_name_is_answered_with_the_way_to_its_system():
    with pytest.raises(cd.SettingsError, match=r"chaosdrill\.build\('chua'\)"):
        cd.lyapunov_spectrum("chua", duration=10)
