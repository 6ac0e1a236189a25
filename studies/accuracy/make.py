"""Accuracy versus run time: the package and other programs, and the method of the paper.

    python studies/accuracy/make.py [PART ...] [--against NAME COMMAND] [--rounds N]
    (or: python3 studies/run.py accuracy ...)

Parts (all of them if none is named) and what they write into ``studies/accuracy/out/``:

    ratios         time of a forcing period by several programs, in one interleaved run  ratios.md, ratios.csv
    start_up       time to the first result with empty and with warm caches              start_up.md
    paper_method   digits and verdicts of the paper's method on its four cases           paper_method.md, .png
    exponents      error of exponents over that of event times; cost over tolerance      exponents.md, .png
    implicit       radau beside explicit methods and scipy's Radau in stiff problems   implicit.md, .png
    stiff_contact  a mapped against a resolved contact, and tangents through it          stiff_contact.md, .png
    effects_cost   an absent effect against a system without it                          effects_cost.md
    long_run       a million periods against a thousand runs of a thousand               long_run.md
    work_precision cost of a digit by every method, on the drill in chaos                work_precision.md, .png
    exact_flow     the closed form of a linear mode in the place of its series           exact_flow.md

``--against`` adds a program to the ratios: its name, and a command in which ``{eta}``, ``{periods}`` and
``{tolerance}`` stand for numbers and ``[--lyap]`` for the flag that asks for two tangents. It prints one line of JSON
with ``us_per_period`` and, if it can, the last ``strobe``. ``--keep`` writes the ratios beside this script, too, and
the picture of ``work_precision`` into the documentation, for which the machine should be idle.
"""

import argparse
import sys
import time
from pathlib import Path

import effects_cost
import exponents
import implicit
import long_run
import paper_method
import ratios
import start_up
import stiff_contact
from programs import Outside

import chaosdrill as cd
from chaosdrill.plots.style import style

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
DOCS = HERE.parent.parent / "docs" / "_static"


def make_ratios(given: argparse.Namespace) -> str:
    """Run the comparison on one core."""
    ratios.one_core()
    against = [Outside(name, command) for name, command in given.against]
    results = ratios.compare(against, given.rounds, say)
    if given.keep:
        ratios.write(HERE, results, given.rounds)
    return ratios.write(OUT, results, given.rounds)


def make_paper_method(given: argparse.Namespace) -> str:
    """Tabulate the errors, scan steps and bisections, draw."""
    with style():
        paper_method.draw(paper_method.scan()).savefig(OUT / "paper_method.png")
    return paper_method.table()


def make_exponents(given: argparse.Namespace) -> str:
    """Measure the exponents' errors and the cost of a tolerance, draw."""
    late, cost = exponents.late_events(), exponents.cost()
    with style():
        exponents.draw(late, cost).savefig(OUT / "exponents.png")
    return exponents.table(late, cost)


def make_stiff_contact(given: argparse.Namespace) -> str:
    """Measure both contacts and the ways through one, draw."""
    found, ways = stiff_contact.over_stiffness(), stiff_contact.through()
    with style():
        stiff_contact.draw(found, ways).savefig(OUT / "stiff_contact.png")
    return stiff_contact.table(found, ways)


def make_implicit(given: argparse.Namespace) -> str:
    """Measure what an accuracy costs in stiff problems, draw."""
    found = implicit.compare(given.rounds)
    with style():
        implicit.draw(found).savefig(OUT / "implicit.png")
    return implicit.table(found)


def make_work_precision(given: argparse.Namespace) -> str:
    """Measure the cost of a digit, draw; the picture stands in ``docs/accuracy.md``."""
    cost = cd.work_precision(cd.drill(eta=0.448), transient=500, periods=256, repeats=given.rounds)
    archive = cd.save(cost, OUT / "work_precision.nc")
    for folder in (OUT, *([DOCS] if given.keep else [])):
        cd.plot_archive(archive, folder / "work_precision.png")
    return str(cost.attrs["recommendation"]) + "\n"


def make_exact_flow(given: argparse.Namespace) -> str:
    """Compare the two; what is compiled for it is compiled now."""
    import exact_flow

    return exact_flow.table(exact_flow.compare(given.rounds))


PARTS = {
    "start_up": lambda given: start_up.table(start_up.start_up()),
    "effects_cost": lambda given: effects_cost.table(effects_cost.compare(given.rounds)),
    "long_run": lambda given: long_run.table(long_run.compare()),
    "paper_method": make_paper_method,
    "exponents": make_exponents,
    "implicit": make_implicit,
    "stiff_contact": make_stiff_contact,
    "work_precision": make_work_precision,
    "exact_flow": make_exact_flow,
    "ratios": make_ratios,
}


def main() -> int:
    """Run the parts that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--against", nargs=2, action="append", default=[], metavar=("NAME", "COMMAND"))
    parser.add_argument("--rounds", type=int, default=7, help="interleaved rounds of a comparison")
    parser.add_argument(
        "--keep",
        action="store_true",
        help="write the ratios, and the picture of work_precision, where they are read",
    )
    given = parser.parse_args()
    OUT.mkdir(exist_ok=True)
    for part in given.parts or PARTS:
        begin = time.monotonic()
        say(part)
        text = PARTS[part](given)
        (OUT / f"{part}.md").write_text(text, encoding="utf-8")
        print(f"## {part}\n\n{text}", flush=True)
        say(f"{part}: {time.monotonic() - begin:.0f} s")
    return 0


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
