"""Sphinx settings, and the pages that follow from the package's own tables."""

import os
import sys
from functools import partialmethod
from pathlib import Path

from nbclient import NotebookClient

import chaosdrill
from chaosdrill.dataset import SCHEMA, Outcome
from chaosdrill.declared import ANALYSES, METHODS
from chaosdrill.plots import PICTURES
from chaosdrill.scene.in_si import UNITS
from chaosdrill.systems import EFFECTS, REGISTRY
from chaosdrill.systems.drill.si import MADE, QUANTITIES

sys.path.insert(0, str(Path(__file__).parent / "_ext"))
# commands on these pages are those of the environment that builds them
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])

project = "chaosdrill"
author = "The chaosdrill developers"
copyright = "2026, the chaosdrill developers"
version = release = chaosdrill.__version__

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "sphinx.ext.viewcode",
    "executed",
    "offline",
    "thumbnails",
    "public_names",
]
nitpicky = True
myst_enable_extensions = ["amsmath", "dollarmath"]
myst_heading_anchors = 3
# pages that hold code are run at every build: kept results would hide what a change of the package breaks
nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_merge_streams = True
# outputs come in pieces that end anywhere, and what merges them by the setting above ends each with a new line
NotebookClient.__init__ = partialmethod(NotebookClient.__init__, coalesce_streams=True)
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_validation_checks = {
    *("GL01", "GL03", "GL05", "GL06", "GL07", "GL08", "SS01", "SS02", "SS03", "SS04"),
    *("PR01", "PR02", "PR03", "PR04", "PR05", "PR06", "PR07", "PR10", "RT01", "RT02", "RT03", "YD01"),
}
# arguments of Python's own enumerations
numpydoc_validation_exclude = {r"\.Outcome$"}
exclude_patterns = ["_build", "generated/analyses.md", "jupyter_execute", "_examples"]
html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_title = f"chaosdrill {release}"

GENERATED = Path(__file__).parent / "generated"


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines) + "\n"


def write_tables() -> None:
    """Write the pages of names and of variables from the registries."""
    GENERATED.mkdir(exist_ok=True)
    names = ["# Names in scenes\n", "## Systems\n"]
    names.append(
        _table(
            ["group", "`model`", "description"], [[one.group, f"`{key}`", one.summary] for key, one in REGISTRY.items()]
        )
    )
    names.append("## Effects of the drill\n\nEffects that a scene leaves out are not simulated and cost nothing.\n")
    rows = [[f"`{effect}`", f"`{key}`", text] for effect, options in EFFECTS.items() for key, text in options.items()]
    names.append(_table(["effect", "option", "description"], rows))
    names.append("## Analyses\n")
    names.append(_table(["`kind`", "result"], [[f"`{key}`", entry.summary] for key, entry in ANALYSES.items()]))
    names.append("## Methods\n")
    names.append(_table(["`method`", "description"], [[f"`{key}`", entry.summary] for key, entry in METHODS.items()]))
    names.append("## Plots\n\n`chaosdrill plot` draws every plot that suits the contents of an archive.\n")
    names.append(_table(["`kind`", "plot", "shows"], [[f"`{p.kind}`", p.name, p.summary] for p in PICTURES]))
    (GENERATED / "names.md").write_text("\n".join(names), encoding="utf-8")

    functions = "\n".join(f".. autofunction:: chaosdrill.{entry.function}\n" for entry in ANALYSES.values())
    (GENERATED / "analyses.md").write_text(f"```{{eval-rst}}\n{functions}```\n", encoding="utf-8")

    variables = ["# Variables of an archive\n"]
    variables.append("Each group of an archive is the result of one analysis, named by the attribute `kind`.\n")
    for kind, table in SCHEMA.items():
        rows = [[f"`{v.name}`", ", ".join(v.dims), v.units, v.long_name, v.doc] for v in table.values()]
        variables += [f"## {kind}\n", _table(["variable", "dimensions", "units", "description", "note"], rows)]
    variables.append("## Root group of a scene in SI units\n\nScalars as given, and as simulated.\n")
    rows = [[f"`si_{name}`", entry.units, entry.label] for name, entry in QUANTITIES.items()]
    rows += [[f"`si_unit_of_{what}`", units, f"one dimensionless unit: {text}"] for units, what, text in UNITS.values()]
    rows += [[f"`dimensionless_{name}`", "1", made.formula] for name, made in MADE.items()]
    variables.append(_table(["variable", "units", "description"], rows))
    variables.append("## Outcomes\n\nA run that ends early has an outcome; it is not an error.\n")
    variables.append(_table(["code", "outcome", "advice"], [[str(int(o)), o.meaning, o.advice] for o in Outcome]))
    (GENERATED / "variables.md").write_text("\n".join(variables), encoding="utf-8")


write_tables()
