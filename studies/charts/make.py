"""Charts of the drill, where it runs away, two ways to drill, basins, and whether chaos drills faster.

    python studies/charts/make.py [--docs]          (or: python3 studies/run.py charts)

The scenes run through the command line, as a user would run them, and go on where an earlier run was cut short; an
archive that is already there is not made again. Pictures and tables are written to ``studies/charts/out/``, with
``--docs`` to the documentation, too. The exit code is 0 if every claim of the page holds.
"""

import argparse
import shutil
import sys
import time
from pathlib import Path

import agreement
import branches
import escapes
import known_regimes
import limits
import rates
import starts
from findings import Claim, read, table
from running import chaosdrill, page, say

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
DOCS = HERE.parent.parent / "docs"
SCENES = {
    "eta_b": "chart",
    "eta_a": "chart",
    "as_printed": "chart",
    "escape": "chart",
    "hysteresis": "diagram",
    "basins": "basins",
}
"""Scenes, and the analysis of each that is drawn."""

CHARTS = {"eta_b": "(η, b)", "eta_a": "(η, a)", "as_printed": "(η, b), ξ = 0.12"}
PICTURES = (
    "eta_b-chart-isoperiodic-chart",
    "eta_a-chart-isoperiodic-chart",
    "eta_b-chart-lyapunov-chart",
    "eta_b-chart-progression-chart",
    "escape-chart-outcome-chart",
    "hysteresis",
    "basins",
)
"""Pictures that the page shows."""

SAMPLE = 60
"""Points of each chart that are computed again by the independent program, a third of them by ``dop853``, too."""


def main() -> int:
    """Run every scene, draw, compare; return the exit code of the first command that fails, else 1 if a claim does."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--docs", action="store_true", help="write the page of the documentation and its pictures, too")
    given = parser.parse_args()
    started = time.monotonic()
    OUT.mkdir(exist_ok=True)
    for number, (scene, group) in enumerate(SCENES.items(), 1):
        say(f"[{number}/{len(SCENES)}] {scene}.toml")
        archive = OUT / f"{scene}.nc"
        if not archive.is_file():
            code = chaosdrill("run", HERE / f"{scene}.toml", "-o", archive, "--workers", "2", "--resume")
            if code:
                return code
        code = chaosdrill("plot", archive, "--group", group, "-o", OUT / f"{scene}.png")
        if code:
            return code
    parts, claims = findings()
    for name, text in parts.items():
        (OUT / f"{name}.md").write_text(text, encoding="utf-8")
    print(parts["claims"])
    if given.docs:
        (DOCS / "charts.md").write_text(page(HERE / "page.md", parts), encoding="utf-8")
        for picture in PICTURES:
            shutil.copy(OUT / f"{picture}.png", DOCS / "_static" / f"charts_{picture.replace('-', '_')}.png")
    say(f"done in {time.monotonic() - started:.0f} s; archives, pictures and tables are in {OUT}")
    return 0 if all(claim.holds for claim in claims) else 1


def findings() -> tuple[dict[str, str], list[Claim]]:
    """Return the tables of the page by name, and all claims."""
    charts = {scene: read(OUT / f"{scene}.nc", "chart") for scene in CHARTS}
    claims = []
    for scene, name in CHARTS.items():
        claims += limits.standing(charts[scene], name) + limits.running_away(charts[scene], name)
    claims += known_regimes.claims({0.06: charts["eta_b"], 0.12: charts["as_printed"]})
    say("where it runs away")
    claims += escapes.claims(OUT / "escape.nc")
    say("branches")
    diagram = read(OUT / "hysteresis.nc", "diagram")
    claims += branches.claims(diagram)
    say("basins")
    basins, more = starts.compare(read(OUT / "basins.nc", "basins"))
    claims += more
    say("does chaos drill faster?")
    found = rates.compare(charts["eta_b"])
    claims += rates.claims(charts["eta_b"], found)
    say("points computed again")
    again = {CHARTS[scene]: agreement.compare(charts[scene], SAMPLE) for scene in CHARTS}
    claims += agreement.claims(again)
    parts = {
        "claims": table(["claim", "found", "holds"], ([c.text, c.found, "yes" if c.holds else "no"] for c in claims)),
        "branches": branches.tables(diagram),
        "basins": basins,
        "rates": rates.tables(charts["eta_b"], found),
        "agreement": agreement.tables(again),
    }
    return parts, claims


if __name__ == "__main__":
    sys.exit(main())
