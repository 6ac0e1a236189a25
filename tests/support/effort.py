"""The work of a call, counted: the same on every machine, whatever else runs there."""

import sys


class Effort:
    """Counts the calls of functions, Python's and its libraries', within a ``with`` block."""

    calls = 0

    def __enter__(self):
        self._before = sys.getprofile()
        sys.setprofile(self._seen)
        return self

    def __exit__(self, *raised):
        sys.setprofile(self._before)

    def _seen(self, frame, event, argument):
        self.calls += event in ("call", "c_call")
