"""Fourteen cases on which hybrid-system codes fail: the failure, the closed form and the result of the package.

    python studies/hard_cases/make.py [--docs]          (or: python3 studies/run.py hard_cases)

Writes one table to ``studies/hard_cases/out/``; ``--docs`` also writes the page of the documentation. The exit code is
0 if every result of the package is within the error that its case allows.
"""

import argparse
import csv
import importlib
import sys
import time
from pathlib import Path
from types import ModuleType

from tools import Finding

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
PAGE = HERE.parent.parent / "docs" / "hard_cases.md"
HEAD = ["", "exact", "chaosdrill", "off by", "elsewhere"]
INTRODUCTION = """\
# Hard cases

Programs for hybrid systems fail on the following cases, mostly without a warning. Each section says what goes wrong,
and compares the exact value with the result of this package. *Off by* bounds the difference, relative for numbers above
one. *Elsewhere* is what the program or method in brackets returned when it was run.

`python3 studies/run.py hard_cases --docs` runs all cases and writes this page; `tests/hard_cases/` asserts the numbers.
"""


def cases() -> dict[int, ModuleType]:
    """Return the modules of all cases by their number."""
    names = sorted(path.stem for path in HERE.glob("case_*.py"))
    return {int(name.split("_")[1]): importlib.import_module(name) for name in names}


def title(case: ModuleType) -> str:
    """Return the first line of a case's description."""
    return str(case.__doc__).strip().partition("\n")[0]


def prose(case: ModuleType) -> str:
    """Return a case's description without its title."""
    return str(case.__doc__).strip().partition("\n")[2].strip()


def table(rows: list[list[str]]) -> str:
    """Return a Markdown table with the common head."""
    return "".join("| " + " | ".join(cells) + " |\n" for cells in [HEAD, ["---"] * len(HEAD), *rows])


def page(found: dict[int, tuple[ModuleType, list[Finding]]]) -> str:
    """Return the page of the documentation."""
    parts = [INTRODUCTION]
    for number, (case, findings) in found.items():
        parts.append(f"## {number}. {title(case)}\n\n{prose(case)}\n\n{table([f.cells() for f in findings])}")
    return "\n".join(parts)


def main() -> int:
    """Run the cases, write the tables, and return 1 if any figure is off."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--docs", action="store_true", help=f"write {PAGE.relative_to(HERE.parent.parent)}, too")
    given = parser.parse_args()
    OUT.mkdir(exist_ok=True)
    found = {}
    for number, case in cases().items():
        begin = time.monotonic()
        found[number] = (case, case.findings())
        bad = [f.quantity for f in found[number][1] if not f.holds]
        verdict = "holds" if not bad else "OFF: " + "; ".join(bad)
        print(f"{number:2d}. {title(case)}: {verdict} ({time.monotonic() - begin:.1f} s)", file=sys.stderr, flush=True)
    with (OUT / "hard_cases.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["case", "quantity", "right", "chaosdrill", "off", "elsewhere"])
        for number, (_, findings) in found.items():
            writer.writerows([number, f.quantity, f.right, f.ours, f.off, f.elsewhere] for f in findings)
    rows = [
        [f"{n}. {title(case)}: {cells[0]}", *cells[1:]]
        for n, (case, fs) in found.items()
        for cells in (f.cells() for f in fs)
    ]
    (OUT / "hard_cases.md").write_text(table(rows), encoding="utf-8")
    if given.docs:
        PAGE.write_text(page(found), encoding="utf-8")
    print(table(rows))
    return 0 if all(f.holds for _, findings in found.values() for f in findings) else 1


if __name__ == "__main__":
    sys.exit(main())
