"""Names and texts of others, as messages show them."""

import re
from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches
from typing import Any

from chaosdrill.tuning import TUNING


def remedy(word: str, known: Iterable[str]) -> str:
    """The likely fix of an unknown name: the nearest known one, or all of them."""
    known = list(known)
    lowered = {name.lower(): name for name in known}
    given = word[: TUNING.letters].lower()
    # a name among other words is meant before one that merely resembles them
    words = [part for part in re.split(r"[^a-z0-9]+", given) if len(part) >= TUNING.least_part and part in lowered]
    alike = {name: SequenceMatcher(None, given, name).ratio() for name in get_close_matches(given, lowered)}
    close = [name for name, ratio in alike.items() if ratio > TUNING.close or name[0] == given[0]]
    if words and not (close and alike[close[0]] > TUNING.nearly):
        close = words
    if close:
        return f"did you mean {shortened(lowered[close[0]])!r}?"
    longer = [name for name in known if len(word) >= TUNING.least_part and given in name.lower()]
    if 0 < len(longer) <= TUNING.most_meant:
        *others, last = (repr(shortened(name)) for name in longer)
        return f"did you mean {', '.join(others)}{' or ' if others else ''}{last}?"
    shown = [shortened(name) for name in known[: TUNING.names_shown]]
    more = len(known) - len(shown)
    return f"known here: {', '.join(shown)}{f' and {more} more' if more else ''}" if known else "there are none here"


def shortened(name: str) -> str:
    """A name as a message shows it."""
    return name if len(name) <= TUNING.letters else f"{name[: TUNING.letters]}..."


_UNSEEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ufff9-\ufffb]")
"""What a terminal obeys instead of showing it, and what turns the order of letters round; lines and tabs may stay."""


def no_parameter(key: str, known: Iterable[str], unused: str) -> str:
    """Say why a system has no such parameter: other effects use it, or it is unknown; with the remedy."""
    return f"parameter {key!r} is {unused}" if unused else f"unknown parameter {key!r}; {remedy(key, known)}"


def shown(value: object) -> str:
    """What `repr` writes of a value, on one line, also where Python refuses: integers of thousands of digits."""
    try:
        return re.sub(r"\s*\n\s*", " ", repr(value))
    except (ValueError, MemoryError, RecursionError):
        if isinstance(value, int):
            return f"an integer of {int(value.bit_length() * 0.30103) + 1} digits"
        return f"{type(value).__name__} that Python cannot write out"


def brief(value: object, most: int = 60) -> str:
    """The beginning of what `repr` writes of a value, on one line; an ellipsis stands for the rest."""
    text = shown(value)
    return f"{text[: most - 3].rstrip()}..." if len(text) > most else text


def names_in(value: Any) -> Any:
    """The names in a text, parted by blanks, commas or semicolons; what is no text stays as it is."""
    return value.replace(",", " ").replace(";", " ").split() if isinstance(value, str) else value


def key_text(key: object) -> str:
    """The name that a key stands for: text, or a symbol."""
    return shown(key) if isinstance(key, int) else str(key)


def visible(text: str) -> str:
    """A text with the codes of what a terminal would obey: ``\\x1b`` for the character that begins its commands."""
    return _UNSEEN.sub(lambda found: f"\\x{ord(found[0]):02x}" if found[0] < "\u0100" else _escaped(found[0]), text)


def visible_json(text: str) -> str:
    """The same for a text of JSON, which says as much as before."""
    return _UNSEEN.sub(lambda found: _escaped(found[0]), text)


def _escaped(letter: str) -> str:
    return f"\\u{ord(letter):04x}"


def event_words(transitions: Iterable[Any]) -> list[str]:
    """Words by which the events of transitions can be named: their names and their kinds."""
    return list(dict.fromkeys(word for one in transitions for word in (one.name, str(one.kind))))
