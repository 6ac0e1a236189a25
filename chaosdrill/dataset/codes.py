"""Codes: words that archives store as numbers."""

from enum import IntEnum
from typing import Any, Self

from chaosdrill.names import remedy


class Code(IntEnum):
    """One of a few words with a sentence; archives store the number, with the names as CF flag meanings."""

    words: str
    """What it means and, where something can be done, what to try; empty where there is nothing to say."""

    def __new__(cls, number: int, words: str = "") -> Self:
        made = int.__new__(cls, number)
        made._value_, made.words = number, words
        return made

    @property
    def advice(self) -> str:
        """One sentence: what this word means and what to try."""
        return self.words

    @classmethod
    def _missing_(cls, value: object) -> Any:
        if isinstance(value, str):
            names = list(cls.__members__)
            near = names[[name.lower() for name in names].index(value.lower())] if value.upper() in names else ""
            way = f"write {cls.__name__}.{near}" if near else remedy(value, names)
            raise ValueError(f"{value!r:.60} is no number of {cls.__name__}; {way}")
        return None

    @property
    def meaning(self) -> str:
        """Name in lower case, as in ``flag_meanings``."""
        return self.name.lower()
