"""Whatever is given for an argument of a public function, an error of this package says which argument it is."""

import inspect
from pathlib import Path

import pytest
from support.short_calls import short_calls

import chaosdrill as cd

SCENE = '[system]\nmodel = "impact-oscillator"\n[analysis.motion]\nkind = "trajectory"\nperiods = 2\n'


class Odd:
    """What no argument can be."""

    def __repr__(self):
        return "Odd()"


SYSTEM = cd.build("impact-oscillator")
TWO = {"name": "d", "states": ["x"], "parameters": {"k": 1.0}}
PUSHED = cd.HybridSystem(
    name="p", states=["x"], time="t", parameters={"f": 0.0}, modes={"on": {"x": "f - x"}}, period="2*pi"
)
SWING = cd.HybridSystem(name="s", states="x v", parameters={"k": 1.0}, modes={"on": {"x": "v", "v": "-x"}})
REST = cd.HybridSystem(name="r", states=["x"], parameters={"k": 1.0}, modes={"on": {"x": "-k*x"}})
CALLS = short_calls(("x", [0.0, 0.1]), ("v", [0.1, 0.2]), ("omega", [2.5, 2.6]), ("e", [0.7, 0.8]))
RIGHT = {
    "HybridSystem": {"name": "d", "states": ["x"], "parameters": {"k": 1.0}, "modes": {"on": {"x": "-k*x"}}},
    "Transition": {"name": "hit", "source": "on", "target": "on", "guard": "x", "direction": 1},
    "filippov": {**TWO, "surface": "x", "above": {"x": "-1"}, "below": {"x": "1"}},
    "equivalent_control": {**TWO, "surface": "x", "field": {"x": "u"}, "control": {"u": (-1, 1)}},
    "in_modes": {**TWO, "field": {"x": "-sign(x)"}},
    "halved": {"system": cd.build("duffing"), "symmetry": {"x": "-x", "v": "-v"}},
    "on_level": {"system": SWING, "conserved": "x**2 + v**2"},
    "driven": {"system": PUSHED, "drive": "f", "pieces": "square"},
    "drill": {},
    "build": {"name": "impact-oscillator"},
    "load_scene": {"path": "scene.toml"},
    "parse_scene": {"text": SCENE},
    "save_scene": {"path": "new.toml", "system": SYSTEM, "analyses": {}},
    "check": {"scene": "scene.toml"},
    "list_names": {"topic": "systems"},
    "new_scene": {"model": "lorenz"},
    **{name: {"system": SYSTEM, **given} for name, given in CALLS.items()},
    "equilibria": {"system": REST, "sweep": {"k": (0.5, 2.0)}},
    "run": {"scene": "scene.toml", "output": "out.nc"},
    "system": {"result": "own.nc"},
    "info": {"path": "own.nc"},
    "save": {"tree": None, "path": "own.nc"},
    "open": {"path": "own.nc"},
    "verify": {"path": "own.nc"},
    "cite": {"path": "own.nc"},
    "cut": {"ds": None, "start": 0.0, "stop": 1.0},
    "join": {"runs": None},
    "recurrences": {"ds": None},
    "series_measures": {"values": [0.3 * (7 * i % 11) for i in range(600)]},
    "event_orders": {"system": SYSTEM, "state": [0.3, 1.0]},
    "plot": {"ds": None},
    "plot_archive": {"path": "own.nc"},
    "animate": {"ds": None, "path": "run.gif"},
    "report": {"path": "own.nc"},
}
FUNCTIONS = [
    name
    for name in cd.__all__
    if inspect.isroutine(function := getattr(cd, name)) or name in ("HybridSystem", "Transition")
]


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """A dataset and the bytes of its archive."""
    motion = cd.trajectory(SYSTEM, periods=1, samples=10)
    return motion, cd.save(motion, tmp_path_factory.mktemp("own") / "own.nc").read_bytes()


@pytest.fixture
def here(own, tmp_path, monkeypatch):
    """The working folder, with a scene and an archive."""
    monkeypatch.chdir(tmp_path)
    motion, held = own
    Path("scene.toml").write_text(SCENE)
    Path("own.nc").write_bytes(held)
    return {"tree": motion, "ds": motion, "runs": {"one": motion}}


def test_the_list_has_every_public_function():
    assert set(RIGHT) == set(FUNCTIONS)


def wrong_values(parameter):
    """Values that an argument cannot have."""
    yield from (Odd(), b"raw", [Odd()], {"a": Odd()}, {1: Odd()})
    if parameter.default is not None and parameter.annotation is not inspect.Parameter.empty:
        yield None
    if not any(word in str(parameter.annotation) for word in ("int", "float", "Any")):
        yield 3


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_argument_of_another_type_is_named_and_one_that_there_is_not_has_pythons_own_error(here, name):
    right = {key: here.get(key, value) for key, value in RIGHT[name].items()}
    for given, parameter in inspect.signature(getattr(cd, name)).parameters.items():
        if parameter.kind is parameter.VAR_KEYWORD and name != "drill":
            continue
        argument = "eta" if parameter.kind is parameter.VAR_KEYWORD else given
        for value in wrong_values(parameter):
            with pytest.raises(cd.ChaosdrillError) as caught:
                getattr(cd, name)(**{**right, argument: value})
            if isinstance(value, Odd) or value in (None, 3):
                assert argument in str(caught.value)
    expected = cd.ModelError if name == "drill" else TypeError
    with pytest.raises(expected, match="no_such_argument"):
        getattr(cd, name)(**right, no_such_argument=1)
