"""What the commands print, for people and for scripts."""

import inspect
import json
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

import netCDF4
import numpy as np
import pytest
import xarray as xr

import chaosdrill
from chaosdrill.archive import open as open_archive
from chaosdrill.archive import save
from chaosdrill.cli import main
from chaosdrill.cli.run import advice, summary
from chaosdrill.dataset import Outcome
from chaosdrill.declared import ANALYSES
from chaosdrill.scene import parse_scene
from chaosdrill.systems import REGISTRY, build
from chaosdrill.workflow import compare

# ``check`` prints what a scene simulates and what it leaves out.


def test_equations_of_what_is_simulated(call, scene):
    answer = call("check", scene)
    assert answer.code == 0
    lines = [" ".join(line.split()) for line in answer.out.splitlines()]
    assert lines[0] == "Drill without a stop"
    assert "dy/dt = u - w" in lines
    assert "dw/dt = 0" in lines
    assert "event release (slip, stick -> slip)" in lines
    assert "eta = 0.8 forcing frequency over natural frequency" in lines
    assert "b = 0.7 (default) static load over the static friction force" in lines
    assert "period 2*pi/eta" in lines
    assert "periods 3" in lines


def test_what_is_left_out(call, scene):
    text = call("check", scene).out
    block = text[text.index("left out") : text.index("states")]
    offered = "newton, hunt-crossley, hunt-crossley-timed, compliant"
    assert block.split() == ["left", "out", "contact", "choose", "from", *offered.split()]
    assert "impact" not in text
    assert " r " not in text


def test_json(call, scene):
    answer = call("check", scene, "--json")
    described = json.loads(answer.out)
    assert described["valid"] is True
    assert list(described["states"]) == ["y", "u", "w"]
    assert described["modes"]["stick"]["dw/dt"] == "0"
    assert described["events"]["stick"]["direction"] == -1
    assert described["left_out"] == {"contact": "choose from newton, hunt-crossley, hunt-crossley-timed, compliant"}
    assert described["analyses"] == {"motion": {"kind": "trajectory", "periods": 3}}


def test_json_of_a_wrong_scene(call, scene):
    scene.write_text(scene.read_text().replace("eta = 0.8", "etta = 0.8").replace("periods = 3", "periods = 0"))
    answer = call("check", scene, "--json")
    assert answer.code == 2
    document = json.loads(answer.out)
    assert document["valid"] is False
    assert document["error"]["kind"] == "SceneError"
    assert document["error"]["message"] == answer.err.strip()
    assert document["problems"] == [
        {"line": 9, "field": "system.parameters.etta", "message": "unknown parameter; did you mean 'eta'?"},
        {"line": 12, "field": "analysis.motion.periods", "message": "must be at least 1, received 0"},
    ]


def test_a_system_without_effects(call, scene):
    scene.write_text('[system]\nmodel = "lorenz"\n')
    lines = call("check", scene).out.splitlines()
    assert lines[:2] == ["scene", "system     lorenz"]
    assert not any(line.startswith(("left out", "simulated", "event")) for line in lines)


# ``info`` tells what is in an archive, for people and for scripts.


@pytest.fixture
def path(tmp_path):
    spectrum = xr.Dataset(
        {
            "lyapunov_exponent": ("exponent", [0.0151, -np.inf], {"units": "1", "long_name": "Lyapunov exponent"}),
            "outcome": ((), np.int8(3), {"units": "1", "long_name": "outcome"}),
        },
        attrs={"kind": "lyapunov-spectrum", "system": "drill", "method": "taylor", "tolerance": 1e-12},
    )
    root = xr.Dataset(attrs={"title": "A spectrum", "versions": '{"chaosdrill": "0.1.0"}'})
    return save(xr.DataTree.from_dict({"/": root, "spectrum": spectrum}), tmp_path / "a.nc")


def test_text(call, path):
    answer = call("info", path)
    assert answer.code == 0
    lines = [" ".join(line.split()) for line in answer.out.splitlines()]
    assert "title A spectrum" in lines
    assert "versions chaosdrill 0.1.0" in lines
    assert "/spectrum lyapunov-spectrum system drill, method taylor, tolerance 1e-12" in lines
    assert "outcomes chaotic 1" in lines
    assert "lyapunov_exponent(exponent) float64 [1] Lyapunov exponent" in lines


def test_numbers_of_the_root(call, tmp_path):
    mass = xr.Dataset({"si_m1": ((), 250.0, {"units": "kg", "long_name": "mass of the bit"})})
    group = xr.Dataset({"x": ("t", [1.0])}, attrs={"kind": "trajectory"})
    path = save(xr.DataTree.from_dict({"/": mass, "motion": group}), tmp_path / "si.nc")
    assert "si_m1 250.0 [kg] mass of the bit" in [
        " ".join(line.split()) for line in call("info", path).out.splitlines()
    ]
    assert json.loads(call("info", path, "--json").out)["quantities"] == {
        "si_m1": {"value": 250.0, "units": "kg", "long_name": "mass of the bit"}
    }


def test_json_of_info(call, path):
    described = json.loads(call("info", path, "--json").out)
    assert described["groups"]["/spectrum"]["dimensions"] == {"exponent": 2}


@pytest.mark.parametrize(
    "versions", [{}, {"versions": '{"chaosdrill": "0.1.0", "numpy": "2.4"}'}], ids=["none", "some"]
)
def test_a_tree_from_python_has_the_versions_of_its_groups(call, tmp_path, versions):
    group = xr.Dataset({"x": ("t", [1.0])}, attrs={"kind": "trajectory", **versions})
    path = save(xr.DataTree.from_dict({"a": group, "b": group}), tmp_path / "a.nc")
    lines = [line.split() for line in call("info", path).out.splitlines() if line.startswith("  versions")]
    assert lines == ([["versions", "chaosdrill", "0.1.0,", "numpy", "2.4"]] if versions else [])


def test_versions_in_which_groups_differ(call, tmp_path):
    groups = {n: xr.Dataset(attrs={"kind": "trajectory", "versions": f'{{"numpy": "2.{n}"}}'}) for n in "45"}
    path = save(xr.DataTree.from_dict(groups), tmp_path / "a.nc")
    assert json.loads(call("info", path, "--json").out)["versions"] == {"numpy": "2.4 and 2.5"}


def test_what_was_altered_of_the_root_has_a_line(call, path):
    import netCDF4

    with netCDF4.Dataset(path, "a") as file:
        file.title = "Another"
    assert "  altered       :  (since the archive was written)" in call("info", path).out.splitlines()


# ``list`` names what a scene may name.


@pytest.mark.parametrize("topic", ["systems", "effects", "analyses", "methods"])
def test_a_line_each(call, topic):
    answer = call("list", topic)
    assert answer.code == 0
    for line in answer.out.splitlines():
        if topic == "systems" and line.endswith(":"):
            continue
        name, summary = line.strip().split("  ", 1)
        assert name.strip()
        assert summary.strip(), line


def test_every_system_listed_can_be_a_scene(call):
    systems = json.loads(call("list", "systems", "--json").out)
    assert "percussive-drill" in systems
    for name in systems:
        assert parse_scene(f'[system]\nmodel = "{name}"\n').model == name


def test_effects_with_their_options(call):
    effects = json.loads(call("list", "effects", "--json").out)
    assert {"drive", "friction", "rock", "contact"} <= effects.keys()
    assert {"none", "newton", "hunt-crossley"} <= effects["contact"].keys()


def test_methods(call):
    assert {"taylor", "dop853", "radau", "rk4"} <= json.loads(call("list", "methods", "--json").out).keys()


def test_systems_are_listed_in_groups(call):
    lines = call("list", "systems").out.splitlines()
    assert lines.index("neurons:") < lines.index("walkers:")
    (izhikevich,) = [k for k, line in enumerate(lines) if line.strip().startswith("izhikevich ")]
    assert lines.index("neurons:") < izhikevich < lines.index("walkers:")


@pytest.mark.parametrize("kind", list(ANALYSES))
def test_settings_of_an_analysis(call, kind):
    found = json.loads(call("list", "analyses", kind, "--json").out)
    assert tuple(found) == ANALYSES[kind].told()
    text = " ".join(inspect.getdoc(getattr(chaosdrill, ANALYSES[kind].function)).split())
    for name, line in found.items():
        kept, _, meaning = line.partition(": ")
        assert meaning, "every setting says what it means"
        assert f" {name} : {kept} {meaning} " in text, "in the words of the docstring"
    if "tolerance" in found:
        default = inspect.signature(getattr(chaosdrill, ANALYSES[kind].function)).parameters["tolerance"].default
        assert found["tolerance"].startswith(f"float, default {default:g}: ")


def test_settings_of_what_has_none(call):
    assert "did you mean 'basins'" in call("list", "analyses", "basin").err
    assert "only analyses have settings" in call("list", "systems", "basins").err


@pytest.mark.parametrize("name", sorted(REGISTRY))
def test_a_new_scene_is_the_system_as_it_is(call, name):
    scene = parse_scene(call("new", name).out)
    system = build(name)
    assert scene.system.parameters == system.parameters
    assert scene.system.initial == system.initial
    assert list(scene.analyses) == ["run", "spectrum"]


def test_a_new_scene_for_scripts(call):
    answer = call("new", "lorenz", "--json")
    assert (answer.code, answer.err) == (0, "")
    assert json.loads(answer.out) == {"system": "lorenz", "scene": call("new", "lorenz").out}
    refused = call("new", "lorentz", "--json")
    assert refused.code == 2
    assert "did you mean 'lorenz'" in json.loads(refused.out)["error"]["message"]


def test_a_folder_that_has_been_removed_is_told(call, scene, tmp_path, monkeypatch):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    answer = call("run", "scene.toml", "-o", "out.nc")
    assert answer.code == 1
    assert answer.err == "the working directory has been removed; change to another one\n"


@pytest.fixture
def archive(tmp_path):
    """A spectrum that says little, from no scene."""
    ds = xr.Dataset(
        {
            "lyapunov_exponent": ("exponent", np.array([0.5, -1.0])),
            "lyapunov_error": ("exponent", np.array([0.01, 0.02])),
        },
        attrs={"kind": "lyapunov-spectrum"},
    )
    return save(xr.DataTree.from_dict({"spectrum": ds}), tmp_path / "result.nc")


def test_prints_the_page_it_wrote(call, archive, tmp_path):
    page = tmp_path / "page.html"
    answer = call("report", archive, "-o", page, "--json")
    assert answer.code == 1
    told = json.loads(answer.out)
    assert told["path"] == str(page)
    assert told["groups"] == ["spectrum"]
    assert told["bytes"] == page.stat().st_size
    # it has no history, of which the picture of convergence is made
    assert [fault.split(":")[0:2] for fault in told["faults"]] == [["spectrum", " convergence"]]
    assert "could not be shown: spectrum: convergence" in answer.err


def test_the_backend_of_a_notebook_is_not_loaded(archive):
    command = [sys.executable, "-m", "chaosdrill", "report", str(archive)]
    environment = dict(os.environ, MPLBACKEND="module://matplotlib_inline.backend_inline")
    told = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300).stderr
    assert "convergence" in told
    assert "backend" not in told


def test_exit_codes(call, archive, tmp_path):
    assert call("report", tmp_path / "none.nc").code == 1
    assert call("report", archive, "-o", tmp_path / "page.png").code == 2
    assert "a report is a file" in call("report", archive, "-o", "-").err
    assert call("report").code == 2


# ``run`` prints the numbers that fit on a line, and advice for points without a result.


FLAGS = {"flag_values": [*map(int, Outcome)], "flag_meanings": " ".join(outcome.meaning for outcome in Outcome)}


def test_exponents_and_scalars():
    dataset = xr.Dataset(
        {
            "lyapunov_exponent": ("exponent", [0.0151, -0.088, -np.inf]),
            "lyapunov_history": (("block", "exponent"), np.zeros((4, 3))),
            "progression_rate": ((), 0.0048),
            "outcome": ((), np.int8(3), FLAGS),
        }
    )
    assert summary(dataset) == [
        "lyapunov_exponent 0.0151 -0.088 -inf",
        "progression_rate 0.0048",
        "outcome chaotic",
    ]
    assert advice(dataset) == []


def test_outcomes_of_many_points():
    codes = np.array([[3, 1], [4, 1], [4, 1]], dtype=np.int8)
    dataset = xr.Dataset({"outcome": (("eta", "seed"), codes, FLAGS)})
    assert summary(dataset) == ["outcome periodic 3, chaotic 1, escaped 2"]
    assert advice(dataset) == [f"escaped (2 of 6): {Outcome.ESCAPED.advice}"]


# A run that ends early has an outcome, which is a result: exit code 0, the outcome on stdout, advice on stderr.


def test_a_start_beyond_a_guard(call, scene, tmp_path):
    scene.write_text(scene.read_text().replace("[analysis.motion]", "[system.initial]\ny = 5.0\n[analysis.motion]"))
    scene.write_text(scene.read_text().replace('"moving"', '"moving"\ncontact = "newton"'))
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert answer.code == 0
    assert "outcome invalid_start" in answer.out
    assert "beyond a guard" in answer.err
    assert (tmp_path / "out.nc").exists()


def test_a_run_that_escapes(call, scene, tmp_path):
    scene.write_text(
        scene.read_text().replace("eta = 0.8", "eta = 0.8\nb = 3.0").replace("periods = 3", "periods = 300")
    )
    answer = call("run", scene, "-o", tmp_path / "out.nc")
    assert answer.code == 0
    assert "outcome escaped" in answer.out
    assert "left its bounds" in answer.err
    assert (tmp_path / "out.nc").exists()


def test_the_help_says_so(call):
    text = " ".join(call("run", "--help").out.split())
    assert "exit code is 0 even for a run that ends early" in text
    whole = call("--help").out
    assert "0 success, whatever the outcome" in " ".join(whole.split())
    # what a command does fits its line
    assert "..." not in whole.partition("Commands:")[2]


# Orbits and branches from a scene to an archive, whose words ``run`` prints, and back again.


SCENE = """\
[system]
model = "impact-oscillator"
parameters = { wall = 0.0, zeta = 0.0, omega = 2.6 }
[analysis.orbit]
kind = "periodic-orbit"
period = 2
[analysis.all]
kind = "periodic-orbit"
start = "search"
max_period = 1
[analysis.branch]
kind = "continuation"
sweep.omega = { start = 2.62, stop = 2.68 }
doublings = 1
"""


@pytest.fixture(scope="module")
def archive_of_orbits(tmp_path_factory):
    """The archive, and what its run printed."""
    folder = tmp_path_factory.mktemp("orbits")
    (folder / "orbits.toml").write_text(SCENE.replace("2.62", "2.58"))
    path = folder / "orbits.nc"
    with redirect_stdout(StringIO()) as out, redirect_stderr(StringIO()) as err:
        assert main(["run", str(folder / "orbits.toml"), "-o", str(path)]) == 0
    return path, out.getvalue(), err.getvalue()


def test_what_happens_is_printed(archive_of_orbits):
    _, out, err = archive_of_orbits
    lines = out.splitlines()
    assert "orbit: period 1" in lines
    assert "orbit: stable yes" in lines
    assert any(line.startswith("all: orbit 1: period 1, stable, (") for line in lines)
    assert any(line.startswith("branch: branch 0: period 1, ") for line in lines)
    assert any(line.startswith("branch:   period doubling at omega = 2.65334772786 ") for line in lines)
    assert any(line.startswith("branch: branch 1: period 2, ") for line in lines)
    assert any(line.startswith("branch:   end: the parameter reached its limit") for line in lines)
    assert "orbit: its period is 1, not 2" in err.splitlines()


def test_the_archive_is_verified(call, archive_of_orbits):
    answer = call("verify", archive_of_orbits[0])
    assert answer.code == 0
    assert answer.out.strip().endswith("equal, bit for bit")


def test_special_points_are_counted(call, archive_of_orbits):
    answer = call("info", archive_of_orbits[0], "--json")
    described = json.loads(answer.out)["groups"]
    assert described["/branch"]["special_points"] == {"period_doubling": 1}
    assert described["/orbit"]["outcomes"] == {"periodic": 1}


def test_the_default_tolerance_is_that_of_the_function(archive_of_orbits, call):
    described = json.loads(call("info", archive_of_orbits[0], "--json").out)["groups"]
    assert described["/branch"]["tolerance"] == 1e-13


def test_where_the_branch_starts_is_checked(call, tmp_path):
    path = tmp_path / "outside.toml"
    path.write_text(SCENE)
    answer = call("check", path)
    assert answer.code == 2
    assert "outside.toml:13: analysis.branch.sweep.omega: the branch starts at the value of the system" in answer.err


# A scene asks what accuracy costs: advice on stdout, a verified archive, a picture.


PRECISION_SCENE = """\
[system]
model = "impact-oscillator"
[system.parameters]
wall = 0.0
zeta = 0.0
[analysis.cost]
kind = "work-precision"
periods = 32
transient = 2000
methods = ["taylor"]
tolerances = [1e-4, 1e-10]
repeats = 1
"""


@pytest.fixture(scope="module")
def archive_of_precision(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cost")
    (folder / "scene.toml").write_text(PRECISION_SCENE)
    return folder


def test_the_whole_road(archive_of_precision, capsys):
    assert main(["run", str(archive_of_precision / "scene.toml"), "-o", str(archive_of_precision / "cost.nc")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "cost: outcome ok 2" in lines
    assert any(
        line.startswith("cost: 8 digits of ") and "multipliers" in line and "use taylor" in line for line in lines
    )
    # times differ from run to run, and no comparison asks for the same
    assert main(["verify", str(archive_of_precision / "cost.nc")]) == 0
    assert main(["plot", str(archive_of_precision / "cost.nc"), "-o", str(archive_of_precision / "cost.png")]) == 0
    assert (archive_of_precision / "cost.png").stat().st_size > 10_000


# The whole road: one scene in, one labelled archive out, the same again, and pictures of it.


ROAD_SCENE = """\
title = "A short drilling"
[system]
model = "percussive-drill"
[system.effects]
drive = "harmonic"
friction = "stribeck"
rock = "moving"
contact = "hunt-crossley"
[system.parameters]
eta = 0.8
[analysis.motion]
kind = "trajectory"
periods = 3
[analysis.section]
kind = "poincare-section"
transient = 60
periods = 4
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 10
periods = 64
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.eta = { start = 0.6, stop = 0.9, num = 5 }
seeds = [{ y = 0.0 }, { y = 0.1, mode = "stick" }]
transient = 10
periods = 16
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the scene and the archives of two runs, with one worker and with two."""
    folder = tmp_path_factory.mktemp("road")
    (folder / "scene.toml").write_text(ROAD_SCENE)
    for workers in (1, 2):
        arguments = ["run", str(folder / "scene.toml"), "-o", str(folder / f"{workers}.nc"), "--workers", str(workers)]
        assert main(arguments) == 0
    return folder


def test_a_group_for_each_analysis(folder):
    tree = open_archive(folder / "1.nc")
    assert {name: node.attrs["kind"] for name, node in tree.children.items()} == {
        "motion": "trajectory",
        "section": "poincare-section",
        "spectrum": "lyapunov-spectrum",
        "diagram": "bifurcation-diagram",
    }
    assert tree.attrs["scene"] == ROAD_SCENE
    assert tree.attrs["title"] == "A short drilling"
    assert tree.attrs["Conventions"] == "CF-1.11, ACDD-1.3"


def test_plain_netcdf_finds_names_and_units(folder):
    with netCDF4.Dataset(folder / "1.nc") as file:
        for group in file.groups.values():
            for name, variable in group.variables.items():
                assert variable.long_name, (group.name, name)
                assert variable.units, (group.name, name)
                if name in group.dimensions:
                    assert "_FillValue" not in variable.ncattrs()


def test_plain_xarray_reads_it(folder):
    with xr.open_datatree(folder / "1.nc") as tree:
        assert dict(tree["diagram"].sizes)["eta"] == 5
        assert dict(tree["diagram"].sizes)["seed"] == 2
        np.testing.assert_allclose(tree["diagram/eta"], np.linspace(0.6, 0.9, 5), rtol=1e-15)


def test_numbers_of_the_paper(folder):
    # strobe point of eta = 0.8 and mean progression, from quadruple precision
    tree = open_archive(folder / "1.nc")
    expected = [0.5117707419326684, 0.2579689590074009, 0.3668787222623992]
    np.testing.assert_allclose(tree["section/section"].values[-1], expected, rtol=1e-8)
    assert int(tree["section/period"]) == 1
    assert float(tree["section/progression_rate"]) == pytest.approx(0.1163908540290498, rel=1e-8)


def test_the_number_of_workers_changes_no_bit(folder):
    assert compare(open_archive(folder / "2.nc"), open_archive(folder / "1.nc")) == []


def test_verify_finds_it_equal(folder, capsys):
    assert main(["verify", str(folder / "1.nc")]) == 0
    assert "equal, bit for bit" in capsys.readouterr().out


def test_verify_says_where_an_altered_archive_differs(folder, capsys, tmp_path):
    altered = tmp_path / "altered.nc"
    altered.write_bytes((folder / "1.nc").read_bytes())
    with netCDF4.Dataset(altered, "a") as file:
        values = file["spectrum/lyapunov_exponent"]
        values[0] = values[0] + 1e-3
    assert main(["verify", str(altered)]) == 1
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert rows[1] == ["group", "variable", "differing", "max", "|difference|"]
    assert rows[2:] == [["/spectrum", "lyapunov_exponent", "1", "of", "3", "0.001", "values", "differ"]]
    assert main(["verify", "--json", str(altered)]) == 1
    found = json.loads(capsys.readouterr().out)
    assert not found["equal"]
    assert [item["variable"] for item in found["differences"]] == ["lyapunov_exponent"]


def test_an_altered_scene_is_found_by_its_hash(folder, capsys, tmp_path):
    altered = tmp_path / "altered.nc"
    altered.write_bytes((folder / "1.nc").read_bytes())
    with netCDF4.Dataset(altered, "a") as file:
        file.scene = file.scene.replace("periods = 3", "periods = 2")
    assert main(["verify", str(altered)]) == 1
    out = capsys.readouterr().out
    assert ":scene_sha256" in out
    assert "/motion" in out
    assert "/spectrum" not in out


def test_pictures(folder, capsys):
    assert main(["plot", str(folder / "1.nc"), "-o", str(folder / "figure.png")]) == 0
    written = capsys.readouterr().out.splitlines()
    assert len(written) >= 4
    for path in written:
        with open(path, "rb") as file:
            assert file.read(8) == b"\x89PNG\r\n\x1a\n"


def test_the_state_of_pictures(folder, capsys):
    command = ["plot", str(folder / "1.nc"), "-o", str(folder / "state.svg"), "--group", "diagram"]
    labels = {"y": "stretch of the spring y", "u": "speed of the bit u"}
    for state in labels:
        assert main([*command, "--state", state]) == 0
        drawn = (folder / "state.svg").read_text(encoding="utf-8")
        assert {name for name, label in labels.items() if label in drawn} == {state}
    capsys.readouterr()
    assert main([*command, "--state", "z"]) == 2
    assert "state names 'z'; states are y, u, w" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "expected"), [("chaosdrill ver", "verify"), ("chaosdrill list eff", "effects")])
def test_a_shell_completes_commands_and_topics(monkeypatch, capsys, words, expected):
    """As the documentation says; click answers through these variables."""
    monkeypatch.setenv("_CHAOSDRILL_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(len(words.split()) - 1))
    with pytest.raises(SystemExit):
        main([])
    assert capsys.readouterr().out.split() == [f"plain,{expected}"]
