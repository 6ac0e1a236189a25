"""What an archive tells of itself: its contents, its systems, what to cite."""

import json
import re
from importlib.resources import files

import netCDF4
import numpy as np
import pytest
import sympy
import xarray as xr
from support.small_scenes import small_scene

import chaosdrill as cd
from chaosdrill.archive import save
from chaosdrill.cli import main
from chaosdrill.dataset.references import REFERENCES, package, references
from chaosdrill.errors import ArchiveError
from chaosdrill.model.definition import write_definition
from chaosdrill.plots import PICTURES
from chaosdrill.reports import report
from chaosdrill.scene import parse_scene
from chaosdrill.workflow import cite, info, run, verify

# The description of an archive tells its groups, its variables and where it came from.


@pytest.fixture
def described(tree, tmp_path):
    return info(save(tree, tmp_path / "result.nc"))


def test_origin(described, tmp_path):
    assert described["title"] == "made up"
    assert described["wall_time_s"] == 1.5
    assert described["bytes"] == (tmp_path / "result.nc").stat().st_size


def test_groups(described):
    assert list(described["groups"]) == ["/first", "/second"]
    first = described["groups"]["/first"]
    assert (first["kind"], first["system"], first["tolerance"]) == ("bifurcation-diagram", "ball", 1e-12)
    assert first["dimensions"] == {"e": 3, "seed": 1, "iterate": 4, "state": 2, "exponent": 2}
    assert first["outcomes"] == {"chaotic": 3}


def test_variables(described):
    variables = described["groups"]["/second"]["variables"]
    assert variables["section"] == {
        "dimensions": ["e", "seed", "iterate", "state"],
        "dtype": "float64",
        "units": "1",
        "long_name": "state on the section",
    }
    assert variables["state"]["dtype"] == "text"


def test_it_is_plain(described):
    assert json.loads(json.dumps(described)) == described


def test_versions_that_cannot_be_read_are_left_out(tree, tmp_path):
    tree.attrs["versions"] = "not JSON"
    for node in tree.subtree:
        node.attrs["versions"] = tree.attrs["versions"]
    assert info(save(tree, tmp_path / "result.nc"))["versions"] == {}


def test_what_was_altered_since_is_named(tree, tmp_path):
    path = save(tree, tmp_path / "result.nc")
    with netCDF4.Dataset(path, "a") as file:
        file["second/period"][2] = 7
        file["second"].settings = "{}"
    groups = info(path)["groups"]
    assert "altered" not in groups["/first"]
    assert groups["/second"]["altered"] == [":", "period"]


# An archive saved from Python holds the definition of its system, and is computed again from there.


HOSTILE = [
    "__import__('os').system('touch owned')",
    "(" * 10**6 + "v" + ")" * 10**6,
    "9**9**9",
    "v.__class__",
    "eval(v)",
]


def oscillator(rate=None):
    x, v, t, omega, e = sympy.symbols("x v t omega e", real=True)
    return cd.HybridSystem(
        name="of my own",
        states=(x, v),
        time=t,
        parameters={"omega": 3.3, "e": 0.8},
        modes={"free": {x: v, v: -x - 0.1 * v + sympy.cos(omega * t) if rate is None else rate(x, v, t)}},
        transitions=[cd.Transition("impact", "free", "free", guard=x - 0.3, direction=+1, reset={v: -e * v})],
        period=2 * sympy.pi / omega,
        initial={"mode": "free", "v": 0.3},
    )


@pytest.fixture(scope="module")
def results():
    """One of every kind of call: numbers of NumPy and sympy, arrays, seeds and random states among the arguments."""
    system = oscillator()
    return {
        "motion": cd.trajectory(system.with_parameters(e=0.5), periods=np.int64(3), samples=sympy.Integer(5)),
        "section": cd.poincare_section(system, periods=8, transient=20, at="impact"),
        "spectrum": cd.lyapunov_spectrum(
            system.with_initial(x=0.1), periods=64, transient=20, blocks=8, tolerance=1e-9
        ),
        "diagram": cd.bifurcation_diagram(
            system,
            {"omega": np.linspace(3.3, 3.4, 3)},
            transient=20,
            periods=16,
            random={"count": 2, "seed": 3, "x": (-0.1, 0.1)},
            seeds=[{"x": 0.05, "mode": "free"}],
        ),
        "chart": cd.parameter_chart(system, {"omega": [3.3, 3.4], "e": [0.7, 0.8]}, transient=20, periods=16),
        "basins": cd.basins(system, {"x": [-0.3, 0.2], "v": np.array([-0.5, 0.5])}, transient=20, periods=16),
        "orbit": cd.periodic_orbit(system, start="search", max_period=1),
        "branch": cd.continue_orbit(system, {"omega": (3.3, 3.35)}, transient=300),
        "precision": cd.work_precision(system, methods=["taylor"], tolerances=[1e-6], periods=8, repeats=1),
    }


@pytest.fixture
def archive(results, tmp_path):
    return cd.save(xr.DataTree.from_dict(results), tmp_path / "python.nc")


@pytest.fixture
def small(results, tmp_path):
    return cd.save(results["spectrum"], tmp_path / "small.nc")


def test_every_kind_is_computed_again(archive):
    result = verify(archive, workers=2)
    assert result.equal, result.table()
    assert result.exact
    assert len({check.group for check in result.checks}) == 9
    assert {group["repeatable"] for group in info(archive)["groups"].values()} == {"from the definition of its system"}


def test_the_definition_is_there_for_every_system(tmp_path):
    ds = cd.trajectory(cd.drill(), periods=1, samples=2)
    definition = json.loads(ds.attrs["definition"])
    assert definition["modes"]["stick"]["w"] == "0"
    assert verify(cd.save(ds, tmp_path / "drill.nc")).equal


def test_an_altered_value_is_found(results, tmp_path):
    two = {name: results[name] for name in ("motion", "chart")}
    archive = cd.save(xr.DataTree.from_dict(two), tmp_path / "two.nc")
    with netCDF4.Dataset(archive, "a") as file:
        file["chart/lyapunov_exponent"][0, 1, 0, 0] += 1e-12
    (difference,) = verify(archive).differences
    assert (difference.group, difference.variable, difference.differing) == ("/chart", "lyapunov_exponent", 1)


def test_an_altered_value_that_was_saved_again_is_found(small, tmp_path):
    ds = cd.open(small).to_dataset()
    ds["lyapunov_exponent"][0] += 1e-12
    result = verify(cd.save(ds, tmp_path / "again.nc"))
    assert [d.variable for d in result.differences] == ["lyapunov_exponent"]


@pytest.mark.parametrize(("old", "new"), [('"-e*v"', '"-e**2*v"'), ("0.1*v", "0.2*v")])
def test_an_altered_equation_is_found(small, tmp_path, old, new):
    ds = cd.open(small).to_dataset()
    assert old in ds.attrs["definition"]
    ds.attrs["definition"] = ds.attrs["definition"].replace(old, new)
    result = verify(cd.save(ds, tmp_path / "again.nc"))
    assert "lyapunov_exponent" in {d.variable for d in result.differences}


def test_attributes_of_ones_own_are_welcome(results, tmp_path):
    ds = results["spectrum"].assign_attrs(creator_name="me", license="CC0")
    ds["lyapunov_exponent"].attrs["note"] = "the first is chaotic"
    assert verify(cd.save(ds, tmp_path / "mine.nc")).equal


def test_an_archive_of_a_scene_may_say_who_made_it(tmp_path):
    tree = run(parse_scene(small_scene("motion"), "one.toml"))
    tree.attrs |= {"creator_name": "me", "license": "CC0", "id": "doi:10.5281/zenodo.1"}
    tree["motion"].attrs["project"] = "drilling"
    tree["motion"]["states"].attrs["note"] = "a cycle"
    path = cd.save(tree, tmp_path / "published.nc")
    assert verify(path).equal
    # nothing that was there may say otherwise
    tree["motion"].attrs["system"] = "another"
    assert {d.variable for d in verify(cd.save(tree, path)).differences} == {":system"}


def test_attributes_of_what_was_opened_are_plain(every_kind, small):
    for tree in (cd.open(every_kind), cd.open(small)):
        for node in tree.subtree:
            json.dumps(node.attrs)


def test_the_system_of_an_archive(every_kind, results, tmp_path):
    tree = cd.open(every_kind)
    for held in (every_kind, str(every_kind), tree, tree["motion"], tree["motion"].to_dataset().isel(time=0)):
        system = cd.system(held)
        assert (system.name, system.state_names) == ("impact-oscillator", ("x", "v"))
        assert system.parameters == json.loads(tree["motion"].attrs["parameters"])
    again = cd.system(results["motion"])
    assert dict(write_definition(again)) == json.loads(results["motion"].attrs["definition"])


def test_an_archive_without_a_system_or_with_several_is_told(results, tmp_path):
    one = results["motion"]
    other = one.assign_attrs(parameters=one.attrs["parameters"].replace("0.", "0.1", 1))
    with pytest.raises(ArchiveError, match=r"several systems: those of a, b differ; name one, as in .*'a'"):
        cd.system(xr.DataTree.from_dict({"a": one, "b": other}))
    for wrong, told in ((xr.Dataset(), "has no system"), (xr.DataTree(), "no result"), (3, "it must be a dataset")):
        with pytest.raises(ArchiveError, match=told):
            cd.system(wrong)


def test_dates_come_back_and_are_drawn(results, tmp_path):
    start = np.datetime64("2020-01-01T12:00:00", "ns")
    dated = results["motion"].assign_coords(when=start)
    seconds = (1e9 * dated["time"].values).astype("timedelta64[ns]")
    dated = dated.assign_coords(time=start + seconds)
    path = cd.save(dated, tmp_path / "dated.nc")
    again = cd.open(path).to_dataset()
    np.testing.assert_array_equal(again["time"].values, dated["time"].values)
    assert again["when"].values == start
    assert "altered" not in cd.info(path)["groups"]["/"]
    axes = cd.plot(again).figure.axes[-1]
    assert axes.get_xlim()[0] <= 0 < axes.get_xlim()[1] < 1e6
    assert len(cd.plot_archive(path, tmp_path / "dated.png")) == 2
    with pytest.raises(ArchiveError, match="time holds dates"):
        cd.cut(again, 0, 1)
    spans = results["motion"].assign_coords(time=seconds)
    with pytest.raises(ArchiveError, match=r"time holds spans of time.*ds\['time'\] / numpy.timedelta64"):
        cd.save(spans, tmp_path / "spans.nc")


def test_other_versions_are_told_and_compared_by_what_can_be(results, tmp_path):
    ds = results["motion"]
    versions = json.loads(ds.attrs["versions"]) | {"numpy": "1.0"}
    result = verify(cd.save(ds.assign_attrs(versions=json.dumps(versions)), tmp_path / "other.nc"))
    assert result.equal
    assert not result.exact
    assert [note for note in result.notes if "numpy 1.0" in note]


@pytest.mark.parametrize("text", HOSTILE, ids=lambda text: text[:12])
def test_hostile_text_runs_no_code(small, tmp_path, monkeypatch, text):
    monkeypatch.chdir(tmp_path)
    ds = cd.open(small).to_dataset()
    definition = json.loads(ds.attrs["definition"])
    definition["modes"]["free"]["x"] = text
    ds.attrs["definition"] = json.dumps(definition)
    with pytest.raises(
        ArchiveError, match=r"nothing in it can be computed again:\n/: definition: modes.free.x: "
    ) as caught:
        verify(cd.save(ds, "hostile.nc"))
    assert len(str(caught.value)) < 700
    assert not (tmp_path / "owned").exists()


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("definition", "[" * 100_000, "definition: not JSON"),
        ("definition", "[]", "definition: expected a table"),
        ("definition", '{"states": ["x"]}', "definition: modes: missing"),
        ("parameters", '{"omega": "big", "e": 1}', "parameter 'omega' is 'big'"),
        ("parameters", '{"omega": 3.3}', "unknown name 'e'"),
        ("initial", '{"mode": "gone"}', "initial mode 'gone'"),
        ("settings", '{"periods": 64, "store": "/etc"}', "no argument 'store'"),
        ("settings", '{"periods": "many"}', "periods is 'many'"),
        ("settings", '{"periods": 1e300}', "periods is 1e+300"),
        ("kind", "os.system", "not the result of an analysis"),
    ],
)
def test_what_cannot_be_read_is_named(small, tmp_path, name, value, told):
    ds = cd.open(small).to_dataset().assign_attrs({name: value})
    with pytest.raises(ArchiveError) as caught:
        verify(cd.save(ds, tmp_path / "wrong.nc"))
    assert told in str(caught.value)


def test_older_archives_say_that_they_have_none(small, tmp_path):
    ds = cd.open(small).to_dataset()
    del ds.attrs["definition"]
    older = cd.save(ds.assign_attrs(format_version=2), tmp_path / "older.nc")
    assert cd.open(older).attrs["kind"] == "lyapunov-spectrum"
    with pytest.raises(ArchiveError, match="no attribute 'definition', as in archives written by versions of"):
        verify(older)
    assert info(older)["groups"]["/"]["repeatable"].startswith("no: it has no attribute 'definition'")


def test_parts_are_told_to_be_parts(results, tmp_path):
    motion = results["motion"]
    tree = {"whole": motion, "part": cd.cut(motion, 0.0, 1.0), "both": cd.join({"a": motion, "b": motion})}
    result = verify(cd.save(xr.DataTree.from_dict(tree), tmp_path / "parts.nc"))
    told = {d.group: d.what for d in result.differences}
    assert set(told) == {"/part", "/both"}
    assert told["/part"].endswith("it was derived from the result of an analysis: cut to times 0.0 to 1.0")
    assert "join of 2 runs" in told["/both"]


def test_a_system_that_no_text_can_hold(tmp_path):
    ds = cd.trajectory(oscillator(lambda x, v, t: -x * sympy.Float("0.1", 40)), periods=1, samples=2)
    assert "definition" not in ds.attrs
    path = cd.save(ds, tmp_path / "digits.nc")
    with pytest.raises(ArchiveError, match=r"its system cannot be written as text: .* as text would be read as"):
        verify(path)


# What is cited is what was used.


@pytest.fixture(scope="module")
def keys(every_kind):
    return [reference.key for reference in cite(every_kind)]


def test_the_package_comes_first_and_everything_once(keys):
    assert keys[0] == "chaosdrill"
    assert len(keys) == len(set(keys))


def test_methods_analyses_and_system(keys):
    for key in ("jorba2005", "hairer1993", "mueller1995", "benettin1980", "keller1977", "auerbach1987", "shaw1983"):
        assert key in keys, key


def test_what_was_not_used_is_not_cited(keys):
    assert not {"hunt1975", "lorenz1963", "feigenbaum1978"} & set(keys)


def test_a_drill_with_contact():
    drill = {"kind": "trajectory", "system": "percussive-drill", "method": "rk4"}
    assert [r.key for r in references(drill | {"parameters": '{"a": 0.1}'})] == ["drilling"]
    assert [r.key for r in references(drill | {"parameters": '{"n": 1.5, "k": 1e5}'})] == ["drilling", "hunt1975"]


def test_derivatives_of_a_cycle():
    for chosen, cited in (("true", True), ('["e"]', True), ("false", False)):
        attributes = {"kind": "periodic-orbit", "settings": f'{{"derivatives": {chosen}}}'}
        assert ("khan2011" in [r.key for r in references(attributes)]) is cited


def test_a_cascade():
    assert "feigenbaum1978" in [r.key for r in references({"kind": "continuation"}, ["feigenbaum_ratio"])]


@pytest.mark.parametrize("settings", ["", "[]", "not JSON", "[" * 100_000, 3.0, "null"])
def test_settings_that_cannot_be_read_add_nothing(settings):
    assert references({"kind": "trajectory", "settings": settings}) == ()


def test_every_kind_and_method_is_known():
    from chaosdrill.declared import ANALYSES, METHODS
    from chaosdrill.systems import REGISTRY

    assert {key for entry in ANALYSES.values() for key in entry.cites} <= REFERENCES.keys()
    assert {key for entry in METHODS.values() for key in entry.cites} <= REFERENCES.keys()
    assert {key for entry in REGISTRY.values() for key in entry.cites} <= REFERENCES.keys()


@pytest.mark.parametrize("reference", REFERENCES.values(), ids=REFERENCES)
def test_entries_are_whole(reference):
    assert reference.title
    if reference.doi:
        assert re.fullmatch(r"10\.\d{4,5}/\S+", reference.doi)
        assert reference.text().endswith(f"doi:{reference.doi}")
    assert reference.bibtex().count("{") == reference.bibtex().count("}")
    assert "None" not in reference.text() + reference.bibtex()


@pytest.mark.parametrize(
    ("key", "line"),
    [
        ("mueller1995", r"  journal = {Chaos, Solitons \& Fractals},"),
        ("mueller1995", "  pages = {1671--1681},"),
        ("denhartog1931", "  author = {J. P. {Den Hartog}},"),
        ("dibernardo2008", "  author = {M. di Bernardo and C. J. Budd and A. R. Champneys and P. Kowalczyk},"),
    ],
)
def test_bibtex_can_be_typeset_and_sorted(key, line):
    assert line in REFERENCES[key].bibtex().splitlines()


def test_the_list_of_references_is_printed_as_it_is_kept():
    kept = files("chaosdrill.dataset").joinpath("references.bib").read_text(encoding="utf-8")
    assert "\n\n".join(reference.bibtex() for reference in REFERENCES.values()) + "\n" == kept


def test_bibtex_of_the_package_has_no_given_names():
    assert "  author = {{The chaosdrill developers}}," in package().bibtex().splitlines()


def test_command_line(every_kind, capsys):
    assert main(["cite", str(every_kind)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any("doi:10.1016/0960-0779(94)00170-U" in line for line in lines)
    assert main(["cite", "--json", str(every_kind)]) == 0
    found = json.loads(capsys.readouterr().out)["references"]
    assert len(found) == len(lines)
    assert {"key": "mueller1995", "year": 1995}.items() <= next(r for r in found if r["key"] == "mueller1995").items()
    assert main(["cite", "--bibtex", str(every_kind)]) == 0
    assert capsys.readouterr().out.count("\n@") == len(lines) - 1
    assert main(["cite", "--bibtex", "--json", str(every_kind)]) == 2


# A report shows every kind of analysis, nothing of it at the page's end as a fault.


# a caption that only this kind of analysis has, where its numbers stand
CAPTIONS = {
    "trajectory": "Events on the way",
    "poincare-section": "Multipliers of the cycle",
    "lyapunov-spectrum": "Events counted",
    "bifurcation-diagram": "Motions along",
    "parameter-chart": "Cycles and other motions",
    "basins": "Attractors",
    "periodic-orbit": "Accuracy of the orbits",
    "continuation": "Branches",
    "work-precision": "Work and precision",
}


@pytest.fixture(scope="module")
def made(every_kind, tmp_path_factory):
    return report(every_kind, tmp_path_factory.mktemp("report") / "page.html")


def test_all_parts_are_there(made, every_group):
    assert made.faults == ()
    assert made.groups == tuple(every_group)
    assert made.pictures >= len({dataset.attrs["kind"] for dataset in every_group.values()})
    assert made.charts == 2


def test_each_kind_has_its_own_table(made, every_group):
    text = made.path.read_text(encoding="utf-8")
    parts = text.split('<section id="analysis-')[1:]
    assert len(parts) == len(every_group)
    kinds = {d.attrs["kind"] for d in every_group.values()}
    assert set(CAPTIONS) <= kinds == {p.kind for p in PICTURES} - {"equilibria"}
    for part, dataset in zip(parts, every_group.values(), strict=True):
        assert f"<caption>{CAPTIONS.get(dataset.attrs['kind'], '')}" in part


# Digests that are damaged or gone are reported; a group that another program wrote has none.


@pytest.mark.parametrize("held", ["{", "[]", None])
def test_digests_that_are_damaged_or_deleted_are_told(tmp_path, held, capsys):
    tree = xr.DataTree.from_dict({"one": xr.Dataset({"x": ("t", [1.0])}, attrs={"kind": "trajectory"})})
    path = cd.save(tree, tmp_path / "a.nc")
    with netCDF4.Dataset(path, "a") as file:
        file["one"].delncattr("digests") if held is None else file["one"].setncattr("digests", held)
    group = info(path)["groups"]["/one"]
    found = {name: group[name] for name in ("altered", "without_digests") if name in group}
    assert found == ({"without_digests": True} if held is None else {"altered": [":digests"]})
    assert main(["info", str(path)]) == 0
    told = capsys.readouterr()
    assert ("unknown: the values have no digests" if held is None else ":digests") in told.out
    assert told.err.startswith("not sealed: /one has no digests") == (held is None)


def test_an_archive_whose_digests_were_deleted_is_told_by_all_that_read_it(tmp_path, capsys):
    path = cd.save(cd.trajectory(cd.build("ueda"), periods=1), tmp_path / "a.nc")
    assert main(["verify", str(path)]) == 0
    assert "sealed" not in "".join(capsys.readouterr())
    with netCDF4.Dataset(path, "a") as file:
        file.delncattr("digests")
    for command in (["info", "--json"], ["verify"], ["verify", "--json"], ["report"]):
        assert main([*command, str(path)]) == 0
        told = capsys.readouterr()
        assert told.err.splitlines()[-1].startswith("not sealed: / has no digests")
        assert ("sealed" in told.out) == (command != ["report"])
    page = path.with_suffix(".html").read_text(encoding="utf-8")
    assert '<p class="fault">not sealed' in page
    for read in (cd.open, cd.system, cd.cite, lambda it: main(["plot", str(it)])):
        with pytest.warns(UserWarning, match="a.nc: not sealed: / has no digests") as told:
            read(path)
        assert len(told) == 1
    # as the sentence says
    with pytest.warns(UserWarning, match="not sealed"):
        cd.save(cd.open(path), path)
    assert cd.verify(path).unsealed == ""


def test_altered_values_are_told_once_by_all_that_read_them(tmp_path, capsys):
    path = cd.save(cd.trajectory(cd.build("ueda"), periods=1), tmp_path / "a.nc")
    cd.open(path)
    with netCDF4.Dataset(path, "a") as file:
        file["states"][0] = 7.0
    with pytest.warns(UserWarning, match="altered") as told:
        cd.open(path)
    assert told[0].filename == __file__, "the line that opened it"
    for read in (cd.open, cd.system, cd.cite):
        with pytest.warns(UserWarning, match=r"a.nc: altered since the archive was written: states$") as told:
            read(path)
        assert len(told) == 1
    capsys.readouterr()
    with pytest.warns(UserWarning, match="altered since the archive was written: states") as told:
        assert main(["plot", str(path)]) == 0
    assert len(told) == 1
    for command in ("info", "report"):
        assert main([command, str(path)]) == 0
        assert "".join(capsys.readouterr()).count("since the archive was written") == 1


def test_a_system_of_the_library_is_no_archive():
    with pytest.raises(cd.ArchiveError, match=re.escape("chaosdrill.build('lorenz') builds that system")):
        cd.system("lorenz")
