"""Codes: words that archives store as numbers."""

from enum import IntEnum


class Code(IntEnum):
    """One of a few words; archives store the number, with the names as CF flag meanings."""

    @property
    def meaning(self) -> str:
        """Name in lower case, as in ``flag_meanings``."""
        return self.name.lower()
