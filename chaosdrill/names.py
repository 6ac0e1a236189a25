"""Names that somebody misspelt."""

from collections.abc import Iterable
from difflib import get_close_matches

LONGEST = 100
MOST_SHOWN = 100
"""What a message shows of names: so many letters of each, and so many of them."""


def remedy(word: str, known: Iterable[str]) -> str:
    """The likely fix of an unknown name: the nearest known one, or all of them."""
    known = list(known)
    lowered = {name.lower(): name for name in known}
    close = get_close_matches(word[:LONGEST].lower(), lowered, n=1)
    if close:
        return f"did you mean {shortened(lowered[close[0]])!r}?"
    shown = [shortened(name) for name in known[:MOST_SHOWN]]
    more = len(known) - len(shown)
    return f"known here: {', '.join(shown)}{f' and {more} more' if more else ''}" if known else "there are none here"


def shortened(name: str) -> str:
    """A name as a message shows it."""
    return name if len(name) <= LONGEST else f"{name[:LONGEST]}..."
