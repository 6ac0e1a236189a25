"""Texts of pictures: labels from the attributes of the dataset, symbols, and numbers with their errors."""

import re
from functools import lru_cache

import numpy as np
from matplotlib import rcParams
from matplotlib.mathtext import MathTextParser

from chaosdrill.dataset.references import mapping
from chaosdrill.names import visible
from chaosdrill.plots._types import DataArray, Dataset
from chaosdrill.plots.tuning import TUNING
from chaosdrill.systems import REGISTRY

_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_LETTERS = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi psi "
    "omega Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega"
)
_GREEK = dict(zip(_LETTERS.split(), "αβγδεζηθικλμνξπρστυφχψωΓΔΘΛΞΠΣΦΨΩ", strict=True)) | {"eps": "ε", "lam": "λ"}
_COMPLETE = re.compile(r"[$(\[/]")
"""Pattern of a label that contains its unit, or is a formula."""
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def label(variable: DataArray, name: str | None = None) -> str:
    """Return ``long name (unit)`` of a variable or coordinate.

    A dimensionless variable has no bracket, nor has a name that contains its unit or is a formula.
    """
    return _with_unit(
        name if name is not None else str(variable.attrs.get("long_name", variable.name)),
        str(variable.attrs.get("units", "1")),
    )


def _with_unit(text: str, unit: str) -> str:
    text = visible(drawable(text) if "$" in text else text)
    return text if unit in ("1", "") or _COMPLETE.search(text) else f"{text} ({raised(unit)})"


def raised(unit: str) -> str:
    """Return a unit with its powers raised: ``m h⁻¹`` for ``m h-1``."""
    return re.sub(r"(?<=[A-Za-z])-?\d+", lambda power: power[0].translate(_RAISED), unit)


@lru_cache(maxsize=64)
def drawable(text: str) -> str:
    """Return a label whose formula matplotlib cannot read as the plain text that it was written in."""
    if text.replace(r"\$", "").count("$") % 2 or rcParams["text.usetex"]:
        return text
    try:
        MathTextParser("path").parse(text)
    except (ValueError, RecursionError):
        return re.sub(r"(?<!\\)\$", r"\\$", text)
    return text


def symbol(name: str) -> str:
    """Return a name as a symbol, as far as plain text can: Greek letters by their names, and digits as an index."""
    parts = re.fullmatch(r"([A-Za-z]+)([0-9]*)", name)
    letter = "" if parts is None else _GREEK.get(parts[1], parts[1] if len(parts[1]) == 1 else "")
    return name if parts is None or not letter else letter + parts[2].translate(_LOWERED)


def axis_label(dataset: Dataset, name: str) -> str:
    """Return the axis label of a coordinate, with its unit.

    A label given by the user stands alone; a name from a system of the library is followed by its symbol.
    """
    return label(dataset[name], _named(dataset, str(dataset[name].attrs.get("long_name", name)), name))


def _named(dataset: Dataset, text: str, name: str) -> str:
    if text in ("", name):
        return symbol(name)
    # a word such as ``amplitude`` says less than the long name
    word = name.isalpha() and name.islower() and len(name) > 3 and symbol(name) == name
    if word or (len(name) > 1 and name in text.split()) or _is_given(dataset, text, name):
        return text
    return f"{text} {symbol(name)}"


def _is_given(dataset: Dataset, text: str, name: str) -> bool:
    """Whether a label is the user's own: of their own system, or a replacement for one of the library's."""
    if str(dataset.attrs.get("system")) not in REGISTRY:
        return True
    known = _definition(str(dataset.attrs.get("definition"))).get("labels")
    return isinstance(known, dict) and known.get(name, name) != text


def is_map(dataset: Dataset) -> bool:
    """Whether a dataset is of a discrete map, by the definition that it holds."""
    return "images" in _definition(str(dataset.attrs.get("definition")))


_definition = lru_cache(maxsize=8)(mapping)


def strobe_words(dataset: Dataset) -> str:
    """Return in words when points of the strobe are taken."""
    return "every iterate" if is_map(dataset) else "once per forcing period"


def period_words(dataset: Dataset) -> tuple[str, str]:
    """Return the name of the period of the strobe, singular and plural."""
    return ("iterate", "iterates") if is_map(dataset) else ("forcing period", "forcing periods")


def time_unit(dataset: Dataset) -> tuple[float, str, str]:
    """Return the unit of lengths of time, the period of the strobe if there is one, and its names."""
    if "forcing_period" in dataset.variables:
        return float(dataset["forcing_period"]), *period_words(dataset)
    return 1.0, "unit of time", "units of time"


def state_label(dataset: Dataset, index: int) -> str:
    """Return the axis label of state number ``index``, as `axis_label`."""
    name = str(dataset["state"].values[index])
    known = "state_long_name" in dataset.variables
    text = _named(dataset, str(dataset["state_long_name"].values[index]) if known else name, name)
    return _with_unit(text, str(dataset["state_units"].values[index]) if "state_units" in dataset.variables else "1")


def seed_names(dataset: Dataset) -> list[str]:
    """Return the name of each seed in the archive, or its number."""
    if "seed" in dataset.variables:
        return [readable(str(name)) for name in np.atleast_1d(dataset["seed"].values)]
    return [f"seed {number + 1}" for number in range(dataset.sizes["seed"])]


def wrapped(text: str, width: int = 18) -> str:
    """Return a label in lines of at most ``width`` characters, for a short axis; formulas stay whole."""
    lines, room = [""], 0
    words = re.findall(r"(?:\$[^$]*\$|[^\s$]|\$)+", text)
    if len(words) > 1 and len(words[-1]) <= 2:
        # a symbol stands beside its name
        words[-2:] = [" ".join(words[-2:])]
    for word in words:
        if room and room + 1 + len(word) > width:
            lines, room = [*lines, ""], 0
        lines[-1] += " " * bool(room) + word
        room += bool(room) + len(word)
    return "\n".join(lines)


def readable(name: str) -> str:
    """Return a code's name as words; the signs of a mode, as in ``above+-``, stay."""
    return re.sub(r"_+|(?<=\w)-(?=\w)", " ", name).replace("-", "−")


def subscript(letter: str, number: int) -> str:
    """Return a letter with an index under it, as plain text that every backend can draw."""
    return letter + str(number).translate(_LOWERED)


def exponent_text(number: int, value: float, error: float) -> str:
    """Return an exponent by its number from 1, with its value and error."""
    return f"{subscript('λ', number)} = {uncertain(float(value), float(error))}"


def shorten(value: float) -> str:
    """Return a number for a legend: four significant digits, a true minus sign, and infinity by its symbol."""
    if np.isneginf(value):
        return "−∞"
    return f"{value:.4g}".replace("-", "−")


def uncertain(value: float, error: float) -> str:
    """Return ``value(error)`` with one digit of the error, in units of the value's last digit.

    If both are very small, a power of ten follows, as in ``2(4)e−15``. With an error that is zero or not a number, the
    value alone is given with six significant digits.
    """
    if not np.isfinite(value):
        return shorten(value)
    if not np.isfinite(error) or error <= 0 or error < 1e-10 * abs(value):
        return f"{value:.6g}".replace("-", "−")
    digits = max(0, int(np.ceil(-np.log10(error))))
    last = round(error * 10**digits)
    if last == 10:
        digits, last = max(0, digits - 1), 1
    if digits > TUNING.most_decimals and abs(round(value * 10**digits)) < 1000:
        return f"{round(value * 10**digits)}({last})e-{digits}".replace("-", "−")
    return f"{value:.{digits}f}({last})".replace("-", "−")
