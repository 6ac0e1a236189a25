"""Names that somebody misspelt."""

from collections.abc import Iterable
from difflib import get_close_matches


def remedy(word: str, known: Iterable[str]) -> str:
    """The likely fix of an unknown name: the nearest known one, or all of them."""
    known = list(known)
    lowered = {name.lower(): name for name in known}
    close = get_close_matches(word[:100].lower(), lowered, n=1)
    if close:
        return f"did you mean {lowered[close[0]]!r}?"
    return f"known here: {', '.join(known)}" if known else "there are none here"
