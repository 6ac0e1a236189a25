"""What an editor and mypy see of the package: signatures, by a stub that says what the functions take.

Run as a program this file writes the stub.
"""

import ast
import os
import subprocess
import sys
from inspect import Parameter, formatannotation
from pathlib import Path

import pytest

import chaosdrill as cd
from chaosdrill.analysis.registry import FUNCTIONS

STUB = Path(cd.__file__).with_suffix(".pyi")

USES = """\
import chaosdrill as cd
system = cd.drill(eta=0.8, m1="250 kg")
reveal_type(cd.trajectory)
run = cd.trajectory(system, periods=3)
reveal_type(run)
reveal_type(cd.plot(run))
reveal_type(system.with_initial(y=0.1))
cd.trajectory(system, periode=3)
cd.trajectory(system, periods="3")
cd.bifurcation_diagram(system, transient=100, periods=20)
cd.trajektory(system)
system.with_parametres(eta=0.9)
"""


def stub() -> str:
    """Text of the stub: names from where they live, and the signatures of the analyses."""
    lines = ["import os", "from typing import Any", "import xarray as xr"]
    homes = {(home, name, f" as {name}") for name, home in cd._HOME.items() if name not in FUNCTIONS}
    homes.add(("chaosdrill.progress", "Progress", ""))
    lines += [f"from {home} import {name}{public}" for home, name, public in sorted(homes)]
    lines += ["__version__: str"]
    for name in FUNCTIONS:
        parameters, keyword_only = [], False
        for one in getattr(cd, name).__signature__.parameters.values():
            if one.kind is Parameter.KEYWORD_ONLY and not keyword_only:
                parameters.append("    *,")
                keyword_only = True
            kind = one.annotation if isinstance(one.annotation, str) else formatannotation(one.annotation)
            default = "" if one.default is Parameter.empty else f" = {one.default!r}".replace("'", '"')
            parameters.append(f"    {one.name}: {kind.replace('typing.', '')}{default},")
        lines += [f"def {name}(", *parameters, ") -> xr.Dataset: ..."]
    return "\n".join(lines) + "\n"


def test_the_stub_says_what_the_functions_take():
    stored, current = (sorted(map(ast.dump, ast.parse(text).body)) for text in (STUB.read_text("utf-8"), stub()))
    assert stored == current, "run this file as a program, then ruff"


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What mypy says of a program, by lines of it, and of the package."""
    folder = tmp_path_factory.mktemp("uses")
    (folder / "uses.py").write_text(USES, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--config-file", str(STUB.parents[1] / "pyproject.toml")]
    command += ["--cache-dir", os.devnull, "-p", "chaosdrill", "-m", "uses"]
    # mypy does not follow the hooks of an editable installation
    environment = {**os.environ, "PYTHONPATH": str(STUB.parents[1]), "MYPYPATH": str(folder)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
    lines = [line.split(":", 2) for line in done.stdout.splitlines() if ": error: " in line or ": note: " in line]
    found: dict[int, str] = {}
    for _, number, text in (line for line in lines if Path(line[0]).name == "uses.py"):
        found[int(number)] = found.get(int(number), "") + text
    return found, [":".join(line)[:300] for line in lines if Path(line[0]).name != "uses.py"]


@pytest.mark.parametrize(
    ("use", "words"),
    [
        ("reveal_type(cd.trajectory)", "def (system: chaosdrill.model.system.HybridSystem, *, periods: int | None ="),
        ("reveal_type(run)", '"xarray.core.dataset.Dataset"'),
        ("reveal_type(cd.plot(run))", '"matplotlib.axes._axes.Axes"'),
        ("reveal_type(system.with", '"chaosdrill.model.system.HybridSystem"'),
        ("cd.trajectory(system, periode", 'Unexpected keyword argument "periode"'),
        ('cd.trajectory(system, periods="3"', "incompatible type"),
        ("cd.bifurcation_diagram(system, tr", 'Missing positional argument "sweep"'),
        ("cd.trajektory", "Module has no attribute"),
        ("system.with_parametres", "has no attribute"),
    ],
)
def test_mypy_sees(told, use, words):
    number = next(i for i, line in enumerate(USES.splitlines(), 1) if line.startswith(use))
    assert words in told[0].get(number, "nothing")


def test_mypy_has_nothing_against_what_is_right(told):
    right = [i for i, line in enumerate(USES.splitlines(), 1) if line.startswith(("import", "system = ", "run = "))]
    assert not set(right) & told[0].keys()


def test_mypy_has_nothing_against_the_package(told):
    assert told[1] == []


if __name__ == "__main__":
    STUB.write_text(stub(), encoding="utf-8")
