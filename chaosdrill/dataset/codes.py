"""Codes: words that archives store as numbers."""

from enum import IntEnum
from typing import Any, Self

from chaosdrill.names import remedy


class Code(IntEnum):
    """One of a few words with a sentence; archives store the number, with the names as CF flag meanings."""

    advice: str
    """What it means and, where something can be done, what to try; empty where there is nothing to say."""

    def __new__(cls, number: int, advice: str = "") -> Self:
        made = int.__new__(cls, number)
        made._value_, made.advice = number, advice
        return made

    @classmethod
    def _missing_(cls, value: object) -> Any:
        if isinstance(value, str):
            names = list(cls.__members__)
            near = names[[name.lower() for name in names].index(value.lower())] if value.upper() in names else ""
            way = f"write {cls.__name__}.{near}" if near else remedy(value, names)
            raise ValueError(f"{value!r:.60} is not a code of {cls.__name__}; {way}")
        return None

    @property
    def meaning(self) -> str:
        """Name in lower case, as in ``flag_meanings``."""
        return self.name.lower()
