"""Analyses called from Python show how far they are where somebody looks, and nowhere else."""

import inspect
import io
import sys
from dataclasses import replace

import pytest
from support.short_calls import short_calls

import chaosdrill as cd
from chaosdrill import progress
from chaosdrill.declared import ANALYSES
from chaosdrill.errors import SettingsError

REST = cd.HybridSystem(name="rest", states="x", parameters={"k": 1.0}, modes={"on": {"x": "1 - k*x"}})
CALLS = short_calls(("x", [0.0, 0.1]), ("v", [0.1, 0.2]), ("omega", [3.3, 3.4]), ("zeta", [0.1, 0.2]))
CALLS["equilibria"] = {"sweep": {"k": (0.5, 2.0)}, "region": {"x": (0, 3)}}


def call(name, system, **shown):
    return getattr(cd, name)(REST if name == "equilibria" else system, **CALLS[name], **shown)


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture(scope="module")
def oscillator():
    return cd.build("impact-oscillator", {"omega": 3.3})


@pytest.fixture
def look(monkeypatch):
    """Function that makes standard error a terminal on which what takes long enough is shown, and returns it."""

    def begin(delay=0.0):
        monkeypatch.setattr(progress, "TUNING", replace(progress.TUNING, delay_s=delay))
        monkeypatch.setattr("sys.stderr", Terminal())
        return sys.stderr

    return begin


def test_every_analysis_is_called():
    assert {entry.function for entry in ANALYSES.values()} == set(CALLS)


@pytest.mark.parametrize("name", CALLS)
def test_lines_for_who_asks(oscillator, name, capsys):
    call(name, oscillator, progress=True)
    begins, *_, last = capsys.readouterr().err.splitlines()
    name = name.replace("_", " ")
    assert begins == f"{name}: started"
    assert last.startswith(f"{name}: 100 %")


@pytest.mark.parametrize("name", ["lyapunov_spectrum", "bifurcation_diagram"])
def test_a_bar_for_who_looks(oscillator, name, look):
    terminal = look()
    call(name, oscillator, progress=False)
    told = []
    call(name, oscillator, progress=lambda *given: told.append(given))
    assert told[-1][0] == told[-1][1]
    assert not terminal.getvalue()
    call(name, oscillator)
    assert f"{name.replace('_', ' ')}: 100 %|####################|" in terminal.getvalue()
    assert terminal.getvalue().endswith("\n")


def test_nothing_where_nobody_looks(oscillator, capsys):
    call("bifurcation_diagram", oscillator)
    assert capsys.readouterr() == ("", "")


def test_what_is_over_at_once_is_not_shown(oscillator, look):
    cd.trajectory(oscillator, periods=1)
    terminal = look(delay=60.0)
    cd.lyapunov_spectrum(oscillator, periods=4)
    assert not terminal.getvalue()


def test_a_run_that_ends_early_ends_its_bar(look):
    terminal = look()
    runaway = cd.HybridSystem(
        name="runaway",
        states=["x"],
        parameters={},
        modes={"all": {"x": "x**2"}},
        initial={"x": 1.0},
        bounds={"x": (-5, 5)},
    )
    assert cd.trajectory(runaway, duration=10.0)["outcome"] == cd.Outcome.ESCAPED
    # what only said that it compiles is wiped out
    assert terminal.getvalue()[-1:] in ("", "\r", "\n")
    assert not progress.COMPILATION.watchers


@pytest.mark.parametrize("value", [3, "yes", []])
def test_what_is_no_progress_is_refused(oscillator, value):
    with pytest.raises(SettingsError, match=r"progress is .* it must be True, False or a function"):
        cd.trajectory(oscillator, periods=1, progress=value)


def test_archives_do_not_hold_whether_one_looked(oscillator):
    settings = [cd.trajectory(oscillator, periods=1, progress=p).attrs["settings"] for p in (None, False, print)]
    assert settings[0] == settings[1] == settings[2]


def test_signatures_stay():
    assert list(inspect.signature(cd.trajectory).parameters)[:2] == ["system", "periods"]


NOTEBOOK = """
from dataclasses import replace
import chaosdrill as cd
from chaosdrill import progress
progress.TUNING = replace(progress.TUNING, delay_s=0.0)
system = cd.build("impact-oscillator", {"omega": 3.3})
ds = cd.lyapunov_spectrum(system, periods=50)
"""


def test_a_notebook_is_looked_at_if_it_could_be_asked():
    """Programs that run notebooks, as for these pages, let no cell ask for input."""
    pytest.importorskip("ipykernel")
    from jupyter_client.manager import start_new_kernel

    said = []

    def hear(message):
        content = message["content"]
        said[-1] += content.get("text", "") + str(content.get("data", "")) + "".join(content.get("traceback", ()))

    manager, client = start_new_kernel(kernel_name="python3")
    try:
        for looks in (False, True):
            said.append("")
            client.execute_interactive(NOTEBOOK, allow_stdin=looks, output_hook=hear, timeout=120)
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)
    assert not said[0]
    assert "lyapunov spectrum: 100 %" in said[1]
