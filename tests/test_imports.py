"""The order of the rooms: imports run downward, nothing imports itself by way of another, no function takes too much.

The table is in ``pyproject.toml``, where `lint-imports` reads it as well.
"""

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest

import chaosdrill
from chaosdrill.analysis.registry import FUNCTIONS

PACKAGE = Path(chaosdrill.__file__).parent
TUNING = PACKAGE.parent / "pyproject.toml"
FILES = sorted(PACKAGE.rglob("*.py"))

MOST_ARGUMENTS = 12
"""Of a function; those of an analysis are the fields of its settings, which travel as one record."""

AS_TEXT = {"capture_output": True, "text": True, "check": False}

_LINT = "from importlinter.cli import lint_imports_command; lint_imports_command()"


@cache
def tree(file):
    return ast.parse(file.read_text())


def order():
    """The room's place by its name, 0 at the top."""
    contract, *_ = tomllib.loads(TUNING.read_text())["tool"]["importlinter"]["contracts"]
    return {name.strip(): place for place, layer in enumerate(contract["layers"]) for name in layer.split(":")}


def lint(folder):
    """What import-linter says of the package in a folder."""
    pytest.importorskip("importlinter")
    command = [sys.executable, "-c", _LINT, "--no-cache", "--config", str(TUNING)]
    return subprocess.run(command, cwd=folder, env={"PYTHONPATH": ":".join([str(folder), *sys.path])}, **AS_TEXT)


def test_imports_run_downward():
    done = lint(PACKAGE.parent)
    assert done.returncode == 0, done.stdout


PLANTED = {
    "model/places.py": "def late():\n    from chaosdrill.codegen import kernels_of\n    return kernels_of\n",
    "dataset/label.py": "if TYPE_CHECKING:\n    import chaosdrill.analysis.base\n",
    "analysis/judgement/words.py": "def late():\n    from chaosdrill.analysis.grids import plan\n    return plan\n",
    "archive/write.py": "import chaosdrill\n\n\ndef late():\n    from chaosdrill.workflow import run\n",
}


def test_an_arrow_back_is_found(tmp_path):
    shutil.copytree(PACKAGE, tmp_path / "chaosdrill", ignore=shutil.ignore_patterns("__pycache__"))
    for file, planted in PLANTED.items():
        with (tmp_path / "chaosdrill" / file).open("a") as source:
            source.write("\n\n" + planted)
    done = lint(tmp_path)
    assert done.returncode == 1
    for file in PLANTED:
        assert f"chaosdrill.{file.replace('/', '.').removesuffix('.py')} ->" in done.stdout, file


def circles(package, exempt=()):
    """Files of each folder of a package that import themselves by way of others, wherever imports and names stand."""
    grimp = pytest.importorskip("grimp")
    graph = grimp.build_graph(package.name, cache_dir=None)
    modules = {}
    for file in package.rglob("*.py"):
        parts = file.relative_to(package.parent).with_suffix("").parts
        modules[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    for module, file in modules.items():
        for node in ast.walk(tree(file)):
            # grimp does not see those that are imported by their names
            late = isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module")
            named = node.args[0] if late else None
            if isinstance(named, ast.Constant) and named.value in modules and named.value != module:
                graph.add_import(importer=module, imported=named.value)
    folders = [name for name, file in modules.items() if file.name == "__init__.py" and name not in exempt]
    return {folder: found for folder in folders if (found := graph.nominate_cycle_breakers(folder))}


def test_no_file_imports_itself_by_way_of_another():
    assert circles(PACKAGE) == {}


@pytest.mark.parametrize(
    "back",
    [
        "def late():\n    from package.upper import a\n    return a\n",
        "if TYPE_CHECKING:\n    from package.upper import a\n",
        "def late():\n    return import_module('package.upper').a\n",
    ],
)
def test_a_circle_is_found(tmp_path, monkeypatch, back):
    package = tmp_path / "package"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "upper.py").write_text("import package.lower\n\na = 1\n")
    (package / "lower.py").write_text(back)
    monkeypatch.syspath_prepend(tmp_path)
    assert list(circles(package)) == ["package"]


def test_no_text_names_a_room_above():
    places, back = order(), []
    for file in FILES:
        room = file.relative_to(PACKAGE).with_suffix("").parts[0]
        if room == "__init__":
            continue
        for node in ast.walk(tree(file)):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                named = re.fullmatch(r"chaosdrill\.(\w+)[\w.:]*", node.value)
                if named and named[1] in places and places[named[1]] < places[room]:
                    back.append(f"{file}:{node.lineno}: {node.value}")
    assert back == []


def test_no_function_takes_more_than_a_dozen_arguments():
    found = []
    for file in FILES:
        for node in ast.walk(tree(file)):
            if isinstance(node, ast.FunctionDef):
                names = [one.arg for one in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
                if len([name for name in names if name not in ("self", "cls")]) > MOST_ARGUMENTS:
                    found.append(f"{file}:{node.lineno}: {node.name}")
    assert found == []


def test_no_room_has_the_name_of_an_analysis():
    # it would stand in its place once it is imported
    rooms = {file.stem for file in (PACKAGE / "analysis").glob("*.py")} | {
        folder.name for folder in (PACKAGE / "analysis").iterdir() if folder.is_dir()
    }
    assert not rooms & set(FUNCTIONS)
