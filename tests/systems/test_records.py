"""A second process reads what the first derived of a system: nothing of it is derived again, and no bit differs."""

import json
import math
import os
import pickle
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy

import chaosdrill as cd
from chaosdrill import systems
from chaosdrill.codegen import cache, kernels_of, record
from chaosdrill.engine.numerics import Numerics
from chaosdrill.engine.period import forcing_periods
from chaosdrill.errors import SettingsError
from chaosdrill.model import system as model
from chaosdrill.model.lifted import lifted
from chaosdrill.model.system import RELATED
from chaosdrill.orbits.residual import Residual

PACKAGE = Path(cd.__file__).parent
CHOSEN = ("lorenz", "impact-oscillator", "percussive-drill")
MORE = ("orbit", "branch", "noise", "equilibria", "pseudo-equilibria")

RESULTS = """
import json, sys
import chaosdrill as cd

def spectrum(name):
    system = cd.build(name)
    length = {"periods": 20} if system.forced else {"duration": 20.0}
    return cd.lyapunov_spectrum(system, **length)

def noisy():
    noise = {"e": cd.Choice([0.7, 0.9], [1, 3]), "zeta": cd.Uniform(0.04, 0.06)}
    return impact.with_parameters(e=0.75).with_noise(noise, at="impact", seed=3)

impact = cd.build("impact-oscillator")
taken = {"work": {"of": "amplitude*cos(omega*t)*v"}, "hit": {"of": "v", "at": "impact", "take": "maximum"}}
ASKED = {
    "orbit": lambda: cd.periodic_orbit(impact, derivatives=["e"], functions=taken),
    "branch": lambda: cd.continue_orbit(
        impact, {"omega": (2.5, 2.52)}, max_points=5, functions=taken, optima=["hit"]
    ),
    "noise": lambda: cd.lyapunov_spectrum(noisy(), periods=20),
    "equilibria": lambda: cd.equilibria(cd.build("lorenz"), {"rho": (20.0, 29.0)}, starts=20),
    "pseudo-equilibria": lambda: cd.equilibria(cd.build("belt-stick-slip"), starts=20),
}
results = {}
for name in sys.argv[1:]:
    ds = ASKED[name]() if name in ASKED else spectrum(name)
    text = {name: value for name, value in ds.attrs.items() if name not in ("history", "date_created")}
    bits = {name: ds[name].values.tobytes().hex() for name in ds.variables if ds[name].dtype.kind in "fiu"}
    results[name] = [text, bits]
print(json.dumps([[name for name in ("sympy", "numba", "dask") if sys.modules.get(name)], results]))
"""


def process(folder, *names, package=PACKAGE):
    """What a new process says: modules that it has loaded, attributes and bits of each result; and its warnings."""
    environment = {**os.environ, "CHAOSDRILL_CACHE_DIR": str(folder), "PYTHONPATH": str(package.parent)}
    command = [sys.executable, "-P", "-c", RESULTS, *names]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=300)
    return (*json.loads(done.stdout), done.stderr)


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """The folder of a cache, and what the process says that filled it."""
    folder = tmp_path_factory.mktemp("first")
    return folder, process(folder, *CHOSEN, *MORE)


def test_the_second_process_needs_no_sympy_and_gives_the_same_bits(first):
    """Of spectra, of an orbit with its derivatives and functions, of a branch, of noise, and of equilibria."""
    folder, (loaded, derived, _) = first
    assert "sympy" in loaded
    again, read, told = process(folder, *CHOSEN, *MORE)
    assert again == []
    assert read == derived
    assert told == ""


@pytest.fixture
def shared(first, monkeypatch):
    """An empty place for what is known of Lorenz's model, and the file of its record."""
    folder, _ = first
    monkeypatch.setattr(record, "cache_folder", lambda: folder)
    return model.Shared(("lorenz",)), record.place(("lorenz",))


@pytest.fixture
def own(shared, tmp_path):
    """A cache that has the same, and the file of Lorenz's record in it."""
    _, path = shared
    folder = path.parent.parent
    shutil.copytree(folder, tmp_path / "cache")
    return tmp_path / "cache", tmp_path / "cache" / path.relative_to(folder)


def test_a_damaged_record_changes_nothing(first, own):
    folder, file = own
    _, (_, derived, _) = first
    content = bytearray(file.read_bytes())
    content[-1] ^= 1
    file.write_bytes(content)
    loaded, found, told = process(folder, "lorenz")
    assert "sympy" in loaded
    assert found["lorenz"] == derived["lorenz"]
    assert "is damaged" in told
    # it is kept anew
    assert process(folder, "lorenz")[0] == []


@pytest.mark.parametrize("place", [0, -1])
def test_damage_is_told_wherever_it_is(shared, own, monkeypatch, place):
    known, _ = shared
    folder, file = own
    monkeypatch.setattr(record, "cache_folder", lambda: folder)
    content = bytearray(file.read_bytes())
    content[place] ^= 1
    file.write_bytes(content)
    with pytest.warns(UserWarning, match="is damaged"):
        assert not record.recall(known)


def _elsewhere(key, held):
    layout, single, *rest = held
    return [key, [layout, [[*code[:2], "../another"] for code in single], *rest]]


FOREIGN = {
    "another system": lambda found: found | {"key": ["roessler"]},
    "no table": lambda found: [1, 2],
    "nothing in it": lambda found: {"key": found["key"]},
    "a fact of no name": lambda found: found | {"facts": {"unheard of": 1}},
    "transitions that are none": lambda found: found | {"outline": found["outline"] | {"transitions": 3}},
    "kernels that are none": lambda found: found | {"kernels": [[[], [[], [], []]]]},
    "code elsewhere": lambda found: found | {"kernels": [_elsewhere(*one) for one in found["kernels"]]},
}


@pytest.mark.parametrize("change", FOREIGN.values(), ids=FOREIGN)
def test_a_record_of_another_form_is_as_good_as_none(shared, tmp_path, monkeypatch, change):
    known, path = shared
    assert record.recall(known)
    found = json.loads(cache.read(path))
    (tmp_path / "kernels").mkdir(mode=0o700)
    monkeypatch.setattr(record, "cache_folder", lambda: tmp_path)
    for text in (json.dumps(change(found)), json.dumps(found)[:-1]):
        cache.put(record.place(("lorenz",)), text.encode())
        assert not record.recall(model.Shared(("lorenz",)))
    cache.put(record.place(("lorenz",)), json.dumps(found).encode())
    assert record.recall(model.Shared(("lorenz",)))


def test_a_record_that_others_can_write_is_not_read(shared):
    known, path = shared
    path.chmod(0o666)
    try:
        with pytest.warns(UserWarning, match="others can write it"):
            assert not record.recall(known)
    finally:
        path.chmod(0o600)


def test_a_record_without_its_code_is_compiled_anew(first, own):
    folder, _ = own
    _, (_, derived, _) = first
    for code in (folder / "kernels").glob(f"*{cache.SUFFIX}"):
        code.unlink()
    assert process(folder, "lorenz")[1]["lorenz"] == derived["lorenz"]


def test_no_record_is_larger_than_it_may_be(tmp_path, monkeypatch):
    monkeypatch.setattr(record, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(model, "_listed", type(model._listed)())
    for most, expected in ((10, 0), (record.TUNING.record_bytes, 1)):
        monkeypatch.setattr(record, "TUNING", replace(record.TUNING, record_bytes=most))
        system = cd.build("saddle-reset")
        kernels_of(system)
        record.remember(system)
        assert len(list(tmp_path.rglob(f"*{cache.RECORD}"))) == expected


def test_another_definition_is_never_answered_by_an_old_record(own, tmp_path):
    """The exponents of Lorenz's model sum up to its divergence, -(sigma + 1 + beta), which the change makes less."""
    folder, _ = own
    package = tmp_path / "chaosdrill"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("*.pyc"))
    file = package / "systems" / "lorenz.py"
    text = file.read_text()
    assert "sigma*(y - x)" in text

    def divergence(loaded):
        found, results, _ = process(folder, "lorenz", package=package)
        assert found == loaded
        return float(np.frombuffer(bytes.fromhex(results["lorenz"][1]["lyapunov_exponent"])).sum())

    sigma, beta = 10.0, 8.0 / 3.0
    assert math.isclose(divergence([]), -(sigma + 1.0 + beta), rel_tol=1e-9)
    file.write_text(text.replace("sigma*(y - x)", "sigma*(y - 2*x)"))
    assert math.isclose(divergence(["sympy"]), -(2.0 * sigma + 1.0 + beta), rel_tol=1e-9)


@pytest.fixture
def outlined(monkeypatch):
    """Gives a system of the library by its outline alone, in a process that knows nothing of it."""

    def system(name):
        whole = systems.build(name)
        kernels_of(whole)
        record.remember(whole)
        monkeypatch.setattr(model, "_listed", type(model._listed)())
        found = systems.build(name)
        assert "whole" in vars(found)
        return whole, found

    return system


@pytest.mark.parametrize("name", [*CHOSEN, "relay-sliding", "print-hammer", "compass-gait", "boost-converter"])
def test_the_outline_gives_the_whole_system(outlined, name):
    whole, found = outlined(name)
    assert repr(found) == repr(whole)
    assert [t.marks_only() for t in found.transitions] == [t.marks_only() for t in whole.transitions]
    for attribute in ("autonomous", "forced", "start", "limits", "bounds", "labels", "exponent_parameters"):
        assert getattr(found, attribute) == getattr(whole, attribute)
    assert found.forcing_period() == whole.forcing_period()
    assert found._content() == whole._content()


def test_a_system_by_its_outline_is_one_like_any_other(outlined):
    _, drill = outlined("percussive-drill")
    with pytest.raises(SettingsError, match="damping ratio"):
        drill.with_parameters(xi=-0.1)
    with pytest.raises(AttributeError, match="colour"):
        _ = drill.colour
    other = pickle.loads(pickle.dumps(drill.with_parameters(eta=0.45)))
    assert other.parameters["eta"] == 0.45
    assert not other.shared
    assert other.with_initial(y=0.1).initial["y"] == 0.1
    assert [*other.placed.modes] == [*drill.modes]
    assert other.augmented(time=True).states == (*drill.states, drill.time)


def test_tables_of_an_outline_do_what_those_of_a_system_do(outlined):
    whole, found = outlined("percussive-drill")
    assert found.modes | {"more": 1} == dict(whole.modes) | {"more": 1}
    assert {"more": 1} | found.modes == {"more": 1} | dict(whole.modes)
    assert [*reversed(found.modes)] == [*reversed(whole.modes)]
    assert found.modes.copy() == whole.modes.copy()
    assert "states" not in vars(found)
    assert type(found.states) is type(whole.states) is tuple
    assert found.states == whole.states
    for table in (found.modes, found.quadratures, found.parameters):
        with pytest.raises(SettingsError, match="cannot be changed in place"):
            table.update(more=1)


def test_a_period_is_the_number_that_its_expression_gives():
    a, b = sympy.symbols("a b", real=True)
    x, t = sympy.symbols("x t", real=True)
    roots, powers = sympy.sqrt(a**2 + b / 3), sympy.Rational(2, 7) * sympy.exp(-b) / a**3
    for period in (2 * sympy.pi / a, roots, powers, a * sympy.E):
        numbers = {"a": 1.7, "b": 0.3}
        system = cd.HybridSystem(
            name="forced", states=(x,), time=t, parameters=numbers, period=period, modes={"on": {x: -x}}
        )
        expected = float(period.subs({a: 1.7, b: 0.3}).evalf(30))
        assert math.isclose(system.forcing_period(), expected, rel_tol=4e-16)
        assert forcing_periods(system, {"b": np.array([0.3, 0.3])}, 2) == pytest.approx([expected] * 2, rel=4e-16)


SCENE = """
[system.definition]
name = "belt-and-wall"
states = ["x", "v"]
period = "2*pi/omega"
[system.definition.modes.free]
x = "v"
v = "-x - 2*zeta*v + cos(omega*t)"
[system.definition.modes.soft]
x = "v"
v = "-k*x - 2*zeta*v + cos(omega*t)"
[system.definition.regions]
free = "x < 0.3"
soft = "x >= 0.3"
[[system.definition.transitions]]
name = "in"
source = "free"
target = "soft"
guard = "x - 0.3"
direction = 1
[[system.definition.transitions]]
name = "out"
source = "soft"
target = "free"
guard = "x - 0.3"
direction = -1
reset = { v = "e*v" }
[system.parameters]
zeta = 0.05
omega = 2.5
e = 0.8
k = 4.0
[system.initial]
x = 0.4
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 2
periods = 10
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.e = [0.7, 0.8]
transient = 2
periods = 10
max_extension = 0
"""

ELSEWHERE = SCENE.replace("x = 0.4", "x = 0.1")


def test_noise_has_the_numbers_of_its_system_whichever_was_derived_first():
    def noisy(low, **numbers):
        return cd.build("impact-oscillator", numbers).with_noise({"e": cd.Uniform(low, 0.9)}, at="impact", seed=5)

    noisy(0.6)
    found = noisy(0.7, zeta=0.02)
    assert found.parameters == {**found.parameters, "e_low": 0.7, "e_high": 0.9, "zeta": 0.02, "noise_seed": 5.0}
    assert found.limits["e_low"].refuses(-0.1)


def test_what_is_derived_has_the_numbers_of_its_system_whichever_was_derived_first():
    first = cd.build("impact-oscillator")
    lifted(first, tangent=False)
    Residual(first, ("zeta",), Numerics("taylor"))
    other = first.with_parameters(e=0.75, zeta=0.02).with_initial(x=-2.0, v=0.25)
    wide = lifted(other, tangent=False).system
    assert wide.parameters == other.parameters
    assert wide.initial == {**wide.initial, **other.initial}
    free = Residual(other, ("zeta",), Numerics("taylor")).system
    assert free.parameters == {name: value for name, value in other.parameters.items() if name != "zeta"}
    assert free.initial == {**other.initial, "zeta": 0.02}


def test_a_change_of_whatever_derives_makes_records_anew():
    derived = "|".join((RELATED, *record._FACTS))
    derives = re.compile(rf"function_of\(|\.relative\(|shared\[\"({derived})\"\] = ")
    files = {
        ".".join(path.relative_to(PACKAGE).with_suffix("").parts): path.read_text() for path in PACKAGE.rglob("*.py")
    }
    seen = {*record._FILES, *(name for name in files if name.rpartition(".")[0] in record._FOLDERS)}
    assert [name for name, text in files.items() if derives.search(text) and name not in seen] == []


SPECTRUM_OF = """
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 2
periods = 10
"""
OTHERS = {
    "a map": """
[system.map]
name = "two-slopes"
states = ["x"]
images.x = "a*Min(x, 1 - x)"
[system.parameters]
a = 1.9
[system.initial]
x = 0.3
""",
    "two fields": """
[system.filippov]
name = "relay"
states = ["x", "v"]
period = "2*pi"
surface = "v"
above = { x = "v", v = "-x - mu + 3*cos(t)" }
below = { x = "v", v = "-x + mu + 3*cos(t)" }
[system.parameters]
mu = 0.7
[system.initial]
x = 0.1
""",
    "a surface in the place of a state": """
[system.filippov]
states = ["x", "v"]
period = "2*pi"
surface = { s = "v + x/2" }
above = { x = "v", v = "-x - mu + 3*cos(t)" }
below = { x = "v", v = "-x + mu + 3*cos(t)" }
[system.parameters]
mu = 0.7
[system.initial]
x = 0.1
v = 0.3
""",
    "a drive": """
[system.definition]
name = "driven"
states = ["x", "v"]
period = "2*pi"
[system.definition.modes.only]
x = "v"
v = "-x - 0.1*v**3 + push"
[system.parameters]
push = 0.0
[system.drives.push]
pieces = "square"
[system.initial]
x = 0.4
""",
    "two fields that are driven": """
[system.filippov]
states = "x v"
surface = "v"
above = { x = "v", v = "u - x - S" }
below = { x = "v", v = "u - x + S" }
period = "2*pi/omega"
[system.parameters]
omega = 0.4
S = 0.6
u = 0.0
duty = 0.25
[system.drives.u]
pieces = { 0 = "1", duty = "-1" }
""",
    "a drill in SI units that is driven": """
[system]
model = "percussive-drill"
[system.effects]
drive = "harmonic"
friction = "coulomb"
rock = "moving"
contact = "none"
[system.si]
m1 = "250 kg"
m2 = "250 kg"
K = "4 MN/m"
C = "3.8 kN*s/m"
A = "2 kN"
B = "5.6 kN"
omega = "100 rad/s"
F_N = "10 kN"
mu_e = 0.8
mu_d = 0.48
[system.drives.b]
pieces = { "0" = "0.3", "0.5" = "0.2" }
""",
    "half of a map": """
[system.map]
states = ["x"]
images = { x = "x**3 - a*x" }
[system.parameters]
a = 2.4
[system.initial]
x = 0.3
[system.symmetry]
x = "-x"
""",
    "noise": """
[system.definition]
states = ["x", "v"]
period = "2*pi"
modes.only = { x = "v", v = "-x - 0.1*v**3 + a*cos(t)" }
transitions = [{ name = "wall", source = "only", target = "only", guard = "x - 0.3", direction = 1, reset.v = "-e*v" }]
[system.parameters]
a = 1.0
e = 0.8
[system.noise]
seed = 3
e = { distribution = "uniform", low = 0.7, high = 0.9, at = "wall" }
a = { distribution = "normal", mean = 1.0, deviation = 0.1, at = "period" }
""",
    "noise of a map": """
[system.map]
states = ["x"]
images = { x = "r*x*(1 - x)" }
[system.parameters]
r = 3.7
[system.initial]
x = 0.3
[system.noise]
r = { distribution = "uniform", low = 3.6, high = 3.8 }
""",
    "a drive of the library": """
[system]
model = "duffing"
[system.parameters]
delta = 0.3
[system.drives.delta]
pieces = { "0" = "0.3", "0.5" = "0.2" }
""",
}


SCENES = {"modes": SCENE, "modes that start elsewhere": ELSEWHERE}
SCENES |= {name: text + SPECTRUM_OF for name, text in OTHERS.items()}

RUN = """
import json, sys
import chaosdrill as cd
from chaosdrill.cli import main
results = []
for path in sys.argv[1:]:
    code = main(["run", path, "-o", path + ".nc"])
    bits = {}
    if code == 0:
        for node in cd.open(path + ".nc").subtree:
            kinds = {name: one for name, one in node.variables.items() if one.dtype.kind in "fiu"}
            bits |= {f"{node.path}/{name}": one.values.tobytes().hex() for name, one in kinds.items()}
    results.append([code, "sympy" in sys.modules or "numba" in sys.modules, bits])
print(json.dumps(results))
"""


def scene_process(folder, *texts):
    """What a new process makes of scenes: exit code, whether sympy or numba is loaded by then, bits; and its words."""
    files = [folder / f"{number}.toml" for number in range(len(texts))]
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    environment = {**os.environ, "CHAOSDRILL_CACHE_DIR": str(folder / "cache"), "PYTHONPATH": str(PACKAGE.parent)}
    command = [sys.executable, "-P", "-c", RUN, *(file.name for file in files)]
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, timeout=300)
    return json.loads(done.stdout.splitlines()[-1]), done.stderr


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A folder with the records of the scenes, and what two processes make of these, one after the other, by name.

    The first does not run the one that starts elsewhere.
    """
    folder = tmp_path_factory.mktemp("scenes")
    names = [name for name in SCENES if SCENES[name] is not ELSEWHERE]
    derived, _ = scene_process(folder, *(SCENES[name] for name in names))
    read, _ = scene_process(folder, *SCENES.values())
    return folder, dict(zip(names, derived, strict=True)), dict(zip(SCENES, read, strict=True))


@pytest.mark.parametrize("name", ["modes", *OTHERS])
def test_the_second_run_of_a_scene_needs_no_sympy_and_gives_the_same_bits(runs, name):
    _, derived, read = runs
    code, loaded, bits = derived[name]
    assert (code, loaded) == (0, True)
    assert len(bits) > 5
    assert read[name] == [0, False, bits]


def test_a_scene_that_starts_elsewhere_has_the_same_record(runs):
    code, loaded, bits = runs[2]["modes that start elsewhere"]
    assert (code, loaded) == (0, False)
    system = cd.parse_scene(ELSEWHERE).system
    assert system.initial == {"mode": "free", "x": 0.1, "v": 0.0}
    expected = cd.lyapunov_spectrum(system, transient=2, periods=10)["lyapunov_exponent"].values
    assert bits["/spectrum/lyapunov_exponent"] == expected.tobytes().hex()


WRONG = {
    "unknown name": ("modes", ("x < 0.3", "x < wall"), "unknown name 'wall'"),
    "unused parameter": ("modes", ("k = 4.0", "k = 4.0\nlost = 1.0"), "not used in the definition"),
    "unknown name of a map": ("a map", ("a*Min", "b*Min"), "unknown name 'b'"),
    "unused parameter of two fields": ("two fields", ("mu = 0.7", "mu = 0.7\nlost = 1.0"), "not used in the"),
    "unknown shape of a drive": ("a drive", ('"square"', '"circle"'), "circle"),
}


def test_a_record_hides_no_fault_of_another_scene(runs):
    """Each is met by a process that has read the records, but for a drive that is added, which is no fault."""
    folder, _, _ = runs
    changed = [SCENES[name].replace(*change) for name, change, _ in WRONG.values()]
    added = SCENE.replace("[system.initial]", "[system.drives.k]\npieces = 'square'\n[system.initial]")
    results, told = scene_process(folder, SCENE, *changed, added)
    assert [code for code, *_ in results] == [0, *[2] * len(WRONG), 0], told
    lines = told.splitlines()
    for number, (_, _, fault) in enumerate(WRONG.values(), start=1):
        assert any(line.startswith(f"{number}.toml:") and fault in line for line in lines), told
    assert [loaded for _, loaded, _ in results] == [False, *[True] * (len(WRONG) + 1)]
    assert results[-1][2] != results[0][2]


def test_scenes_of_the_same_equations_have_a_record_each(tmp_path, monkeypatch):
    monkeypatch.setattr(record, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(model, "_listed", type(model._listed)())
    for text in (SCENE, SCENE.replace("k = 4.0", "k = 5.0")):
        system = cd.parse_scene(text).system
        kernels_of(system)
        record.remember(system)
    assert len(list(tmp_path.rglob(f"*{cache.RECORD}"))) == 2
