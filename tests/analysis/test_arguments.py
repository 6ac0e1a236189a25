"""An argument that cannot be used is refused; the text names it, the value and the remedy."""

import tomllib

import numpy as np
import pytest

import chaosdrill as cd
from chaosdrill.declared import ANALYSES, METHODS
from chaosdrill.engine.methods import NAMES

SPAN = {"periods": 10}
FAULTS = [
    ({}, "give either periods .* or duration"),
    ({"periods": 5, "duration": 3.0}, "duration is 3.0; periods are given, too"),
    ({"duration": 31.4}, r"duration is 31.4; \w+ has a forcing period; give periods instead .about 5"),
    ({"periods": 0}, "periods is 0; must be at least 1"),
    ({"periods": -3}, "periods is -3"),
    ({"periods": 2.5}, "periods is 2.5; expected a whole number"),
    ({"periods": "ten"}, "periods is 'ten'"),
    ({"periods": True}, "periods is True"),
    ({"periods": float("inf")}, "periods is inf"),
    ({**SPAN, "transient": -1}, "transient is -1; must be at least 0"),
    ({**SPAN, "transient": 0.5}, "transient is 0.5"),
    ({**SPAN, "method": "RK45"}, "method: unknown method 'RK45'; did you mean 'dop853'?"),
    ({**SPAN, "method": "euler"}, "method: unknown method 'euler'; known here: taylor, dop853, radau, rk4"),
    ({**SPAN, "tolerance": 0}, "tolerance is 0; must be at least 1e-16"),
    ({**SPAN, "tolerance": 1.0}, "tolerance is 1.0; must be at most 0.01"),
    ({**SPAN, "tolerance": float("nan")}, "tolerance is nan; must be finite"),
    ({**SPAN, "steps": 100}, "steps is 100; taylor chooses its own steps; leave it out, or choose rk4"),
    ({**SPAN, "steps": 2, "method": "rk4"}, "steps is 2; must be at least 4"),
    ({**SPAN, "max_events": 0}, "max_events is 0; must be at least 1"),
    ({**SPAN, "max_events": 2.5}, "max_events is 2.5"),
    ({**SPAN, "max_stalls": None}, "max_stalls is None; expected a whole number"),
]
DURATION_FAULTS = [
    ({}, "give either periods .* or duration"),
    ({"periods": 4, "at": None}, "ball has no forcing period(; give duration|, and so no strobe; name a).* at='apex'"),
    ({"periods": 4, "at": "hit", "transient": 0.5}, "transient is 0.5; expected whole points of the section"),
    ({"periods": 4, "at": "strobe"}, "at is 'strobe'; ball has no forcing period for a strobe; .* at='apex'"),
    ({"duration": 0}, "duration is 0; must be greater than 0"),
    ({"duration": float("nan")}, "duration is nan"),
    ({"duration": "long"}, "duration is 'long'"),
    ({"duration": 1.0, "transient": -2.0}, "transient is -2.0; must be at least 0"),
    ({"duration": 1.0, "transient": float("inf")}, "transient is inf"),
]
FUNCTIONS = ["trajectory", "poincare_section", "lyapunov_spectrum"]


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize(("arguments", "words"), FAULTS)
def test_systems_with_a_period(duffing, function, arguments, words):
    with pytest.raises(cd.SettingsError, match=words):
        getattr(cd, function)(duffing, **arguments)


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize(("arguments", "words"), DURATION_FAULTS)
def test_systems_without_a_period(bouncer, function, arguments, words):
    extra = {"at": "hit"} if function == "poincare_section" else {}
    with pytest.raises(cd.SettingsError, match=words):
        getattr(cd, function)(bouncer, **extra | arguments)


@pytest.mark.parametrize(
    ("function", "arguments", "words"),
    [
        ("trajectory", {"samples": 0}, "samples is 0; must be at least 1"),
        (
            "poincare_section",
            {"at": "moon"},
            "at is 'moon'; unknown event 'moon'; .*strobe.*; or give a comparison",
        ),
        ("poincare_section", {"at": "strobes"}, r"did you mean .*'; or give a comparison"),
        ("poincare_section", {"at": "moon > 1"}, "at is 'moon > 1'; unknown name 'moon'"),
        ("poincare_section", {"at": "gamma > 1"}, "a section is one comparison of states"),
        ("poincare_section", {"at": "Abs(x) > 1"}, "has no Taylor series"),
        ("poincare_section", {"at": "x > 0 and v > 0"}, "a section is one comparison of states"),
        ("poincare_section", {"max_period": 0}, "max_period is 0"),
        ("lyapunov_spectrum", {"exponents": 3}, "exponents is 3; the system has 2 states and as many exponents"),
        ("lyapunov_spectrum", {"exponents": -1}, "exponents is -1"),
        ("lyapunov_spectrum", {"blocks": 0}, "blocks is 0"),
    ],
)
def test_arguments_of_one_analysis(duffing, function, arguments, words):
    with pytest.raises(cd.SettingsError, match=words):
        getattr(cd, function)(duffing, periods=4, **arguments)


def test_a_strobe_needs_a_period(bouncer):
    with pytest.raises(
        cd.SettingsError, match=r"ball has no forcing period, and so no strobe; .*at='apex' or at='x > 0'"
    ):
        cd.poincare_section(bouncer, duration=3.0)


DIAGRAM = {"transient": 1, "periods": 4}
SWEEPS = [
    ({"gamma": []}, {}, r"sweep.gamma is \[\]; must not be empty"),
    ({"gamma": [0.1, np.nan]}, {}, r"sweep.gamma\[1\] is nan; must be finite"),
    ({"gamma": [[0.1, 0.2]]}, {}, r"sweep.gamma\[0\] is .*; expected a number"),
    ({"gamma": ["a"]}, {}, r"sweep.gamma\[0\] is .*; expected a number"),
    ({"gamma": [0.1, 0.1]}, {}, "contains a value twice"),
    ({"gama": [0.1]}, {}, "sweep.gama: unknown parameter; did you mean 'gamma'"),
    ({"gamma": [0.1], "delta": [0.1]}, {}, "sweeps one parameter"),
    ({}, {}, "sweeps one parameter"),
    ({"gamma": [0.1]}, {"seeds": [{}, {"x": np.nan}]}, "seeds.1..x is nan; must be finite"),
    ({"gamma": [0.1]}, {"seeds": []}, "seeds is .*; must not be empty"),
    ({"gamma": [0.1]}, {"seeds": [{"z": 1.0}]}, "seeds.0..z: unknown state; known here: mode, x, v"),
    ({"gamma": [0.1]}, {"workers": 0}, "workers is 0; must be at least 1"),
    ({"gamma": [0.1]}, {"periods": 1}, "periods is 1; must be at least 2"),
    ({"gamma": [0.1]}, {"exponents": 3}, "the system has 2 states"),
    ({"gamma": [0.1]}, {"at": "moon"}, "at is 'moon'"),
    ({"gamma": [0.1]}, {"max_period": 0}, "max_period is 0"),
]


@pytest.mark.parametrize(("sweep", "arguments", "words"), SWEEPS)
def test_diagrams(duffing, sweep, arguments, words):
    with pytest.raises(cd.SettingsError, match=words):
        cd.bifurcation_diagram(duffing, sweep, **{**DIAGRAM, **arguments})


def test_a_diagram_needs_a_section(bouncer):
    with pytest.raises(cd.SettingsError, match="ball has no forcing period, and so no strobe; name a section"):
        cd.bifurcation_diagram(bouncer, {"e": [0.5]}, transient=1, duration=4.0)
    with pytest.raises(cd.SettingsError, match=r"ball has no forcing period.*; name a section, as in at='apex'"):
        cd.bifurcation_diagram(bouncer, {"e": [0.5]}, **DIAGRAM)


def test_every_analysis_of_the_registry_can_be_called():
    import chaosdrill.analysis as analysis

    assert all(callable(getattr(analysis, entry.function)) for entry in ANALYSES.values())
    assert {entry.function for entry in ANALYSES.values()} == set(analysis.__all__)
    assert set(METHODS) == set(NAMES)
    with pytest.raises(AttributeError, match="no attribute 'astrology'"):
        analysis.astrology  # noqa: B018


@pytest.mark.parametrize("function", ["trajectory", "poincare_section"])
def test_a_limit_of_events_ends_a_run(bouncer, function):
    extra = {"at": "hit"} if function == "poincare_section" else {}
    free, bound = (getattr(cd, function)(bouncer, duration=6.0, **extra, **more) for more in ({}, {"max_events": 2}))
    assert cd.Outcome(int(free["outcome"])) == cd.Outcome.OK
    assert cd.Outcome(int(bound["outcome"])) == cd.Outcome.EVENT_LIMIT


def test_how_a_run_is_cut_does_not_decide_whether_it_meets_a_limit_of_events(bouncer):
    settings = {"duration": 6.0, "transient": 1.0, "exponents": 1}
    events = int(cd.lyapunov_spectrum(bouncer, **settings)["event_count"].sum())
    assert events > 3
    for limit, met in ((events, False), (events - 1, True)):
        for blocks in (1, 4, 64):
            run = cd.lyapunov_spectrum(bouncer, **settings, blocks=blocks, max_events=limit)
            assert (cd.Outcome(int(run["outcome"])) == cd.Outcome.EVENT_LIMIT) == met


SAME_RULES = [
    ("max_extension = -1", {"max_extension": -1}, "must be at least 0"),
    ("exponents = 3", {"exponents": 3}, "the system has 2 states and as many exponents"),
    ('follow = "up"', {"follow": "up"}, "expected one of ['forward', 'backward', 'both'], or leave it out"),
    ("random = { count = 2, seed = 1 }", {"random": {"count": 2, "seed": 1}}, "names no state; give the range"),
    ("random = { count = 2, seed = 1, y = 3 }", {"random": {"count": 2, "seed": 1, "y": 3}}, "expected a list"),
    ("sweep.k = [1.0]", {"sweep": {"gamma": [0.1], "k": [1.0]}}, "names ['gamma', 'k']; a bifurcation diagram sweeps"),
]


DUFFING = """
[system]
parameters = { gamma = 0.1, k = 0.2 }
initial = { x = 0.0, v = 0.1 }
[system.definition]
states = ["x", "v"]
modes.free = { x = "v", v = "-k*v - x + gamma*cos(t)" }
time = "t"
period = "2*pi"
[analysis.a]
"""


@pytest.mark.parametrize(("line", "arguments", "words"), SAME_RULES)
def test_scenes_and_arguments_are_refused_in_the_same_words(duffing, line, arguments, words):
    scene = f"{DUFFING}kind = 'bifurcation-diagram'\ntransient = 1\nperiods = 4\nsweep.gamma = [0.1]\n{line}\n"
    with pytest.raises(cd.SceneError) as of_scene:
        cd.parse_scene(scene)
    with pytest.raises(cd.SettingsError) as of_arguments:
        cd.bifurcation_diagram(duffing, **{"sweep": {"gamma": [0.1]}, **DIAGRAM, **arguments})
    assert words in str(of_scene.value)
    assert words in str(of_arguments.value)


EXCLUDED = [
    ("periodic-orbit", 'start = "search"\nmax_period = 2\nat = "x > 0"', 'start = "search" counts forcing periods, or'),
    ("periodic-orbit", "max_period = 2", 'applies with start = "search" only'),
    ("continuation", 'sweep.gamma = { start = 0.1, stop = 0.9 }\nfollow = "fold"', "sweep names only 'gamma'"),
    ("trajectory", "times = [1.0]\nsamples = 4", "times are given"),
    ("work-precision", "periods = 8\ntolerances = [1e-6]\nsteps = [100, 200]", "expected a list of 1 counts"),
]


@pytest.mark.parametrize(("kind", "settings", "words"), EXCLUDED)
def test_settings_that_exclude_each_other_do_so_in_scenes_and_arguments(duffing, kind, settings, words):
    with pytest.raises(cd.SceneError) as of_scene:
        cd.parse_scene(f"{DUFFING}kind = '{kind}'\n{settings}\n")
    arguments = tomllib.loads(settings)
    if sweep := arguments.get("sweep"):
        arguments["sweep"] = {name: tuple(ends.values()) for name, ends in sweep.items()}
    with pytest.raises(cd.SettingsError) as of_arguments:
        getattr(cd, ANALYSES[kind].function)(duffing, **arguments)
    assert words in str(of_scene.value)
    assert words in str(of_arguments.value)
