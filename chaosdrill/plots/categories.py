"""Categories of cells and points: their colour, hatching and name, and how points are sorted into them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb

from chaosdrill.dataset.outcomes import MEASURED, flag_names
from chaosdrill.plots._types import Dataset, Integers
from chaosdrill.plots.labels import readable
from chaosdrill.plots.palette import ATTRACTOR_COLOURS, BELOW, LONGER_COLOUR, OTHER_OUTCOME, OUTCOMES, PERIOD_COLOURS


@dataclass(frozen=True)
class Category:
    """How cells of one category are drawn and named."""

    name: str  # entry of the legend
    colour: str  # colour of the cells
    hatch: str = ""  # hatching over them, in matplotlib's letters
    short: str = ""  # text to write into large regions; none if empty

    @property
    def ink(self) -> str:
        """Black or white, whichever is readable on the colour."""
        red, green, blue = (part**2.2 for part in to_rgb(self.colour))
        return "black" if 0.2126 * red + 0.7152 * green + 0.0722 * blue > 0.2 else "white"


MINUS_INFINITY = Category("−∞ (all directions lost at events)", BELOW[0], "ooo")
POSITIVE = Category("positive", "#FFFFFF", "....")
# lines, since circles and dots beside those of a section look like results
NO_RESULT = Category("no result", "#FFFFFF", "////")
"""Where a run did not reach its end, or lacks the number: the same in every picture."""
NO_ATTRACTOR = Category("none", "#FFFFFF", "xx")
UNRECOGNISED = Category("attractor not recognised", "#FFFFFF", "|||")
FURTHER = Category("further attractors", "#BBBBBB", "---")
PERIOD_NOT_FOUND = Category("period not found", OUTCOMES["periodic"][0], "ooo")
MOTIONS = tuple(outcome.meaning for outcome in MEASURED)
"""Outcomes of runs that reached their end."""
ATTRACTED = tuple(name for name in MOTIONS if name not in ("open", "transient"))
"""Outcomes of runs that settled on a known motion."""


def outcome_category(name: str) -> Category:
    """Return the category of an outcome by its name."""
    short = "" if name == "ok" else readable(name)
    return Category(readable(name), *OUTCOMES.get(name, (OTHER_OUTCOME, "")), short)


def attractor_category(number: int, text: str) -> Category:
    """Return the category of an attractor by its place in the legend, from 0: colours repeat with hatching."""
    turn, place = divmod(number, len(ATTRACTOR_COLOURS))
    return Category(text, ATTRACTOR_COLOURS[place], ("", "////", "....")[turn % 3], str(number + 1))


def by_outcome(dataset: Dataset) -> tuple[Integers, list[Category]]:
    """Each point's category by how it ended, as an index in the shape of ``outcome``, and the categories that occur."""
    codes = dataset["outcome"].values
    return classify([(codes == code, outcome_category(name)) for code, name in flag_names(dataset["outcome"]).items()])


def by_period(dataset: Dataset) -> tuple[Integers, list[Category]]:
    """The same by period, and by how it ended for a point without one."""
    codes, period = dataset["outcome"].values, dataset["period"].values
    names = {name: code for code, name in flag_names(dataset["outcome"]).items()}
    cycle = (period > 0) & np.isin(codes, [names.get("ok", -1), names.get("periodic", -1)])
    table: list[tuple[Any, Category]] = [
        (cycle & (period == n), Category(f"period {n}", colour, short=str(n)))
        for n, colour in enumerate(PERIOD_COLOURS, start=1)
    ]
    longer = cycle & (period > len(PERIOD_COLOURS))
    if longer.any():
        first, last = period[longer].min(), period[longer].max()
        text = f"period {first}" if first == last else f"periods {first} to {last}"
        table.append((longer, Category(text, LONGER_COLOUR, short=f"≥ {first}" if first < last else str(first))))
    for name, code in names.items():
        category = outcome_category(name)
        if name == "periodic":
            category = PERIOD_NOT_FOUND
        elif name == "ok":
            category = Category("no period found", category.colour, category.hatch)
        table.append((~cycle & (codes == code), category))
    return classify(table)


def classify(table: list[tuple[Any, Category]]) -> tuple[Integers, list[Category]]:
    """Return the index of each point's category, and the categories that occur, from disjoint masks."""
    present = [(mask, category) for mask, category in table if mask.any()]
    codes = np.zeros(table[0][0].shape, dtype=np.int64)
    for index, (mask, _) in enumerate(present):
        codes[mask] = index
    return codes, [category for _, category in present]
