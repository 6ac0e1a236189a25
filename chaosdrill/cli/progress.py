"""Progress of long work on stderr: a bar on a terminal, now and then a line elsewhere."""

import shutil
import sys
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from time import monotonic
from typing import TextIO

BAR = 24
REDRAW_S = 0.1
LINE_S = 10.0
WINDOW_S = 30.0
"""Seconds of which the rate is taken, but for the last line, which has the mean."""


@dataclass(frozen=True)
class Pace:
    """How fast it goes: seconds since the beginning, and and items in some seconds of late."""

    elapsed_s: float = 0.0
    measured: int = 0
    measured_s: float = 0.0


class Progress:
    """Shows how far each analysis is, its rate, the time left and the counts by outcome.

    Parameters
    ----------
    stream : text stream, optional
        Where to; default: stderr.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self.stream = stream or sys.stderr
        self.live = self.stream.isatty()
        self.open_line = False

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, *_: object) -> None:
        self._end_line()

    def tell(self, line: str) -> None:
        """Show a line of its own."""
        self._end_line()
        self._write(line + "\n")

    def report(self, name: str) -> Callable[[int, int, dict[str, int] | None], None]:
        """Begin an analysis; what is returned takes items done, their total, and counts by outcome.

        The first call tells where the analysis begins, which after a resume is not at zero: rates count from there.
        """
        self._end_line()
        start = last = monotonic()
        seen: deque[tuple[float, int]] = deque()
        begun = start, 0
        if not self.live:
            self._write(f"{name}: begins\n")

        def show(done: int, total: int, outcomes: dict[str, int] | None = None) -> None:
            nonlocal last, begun
            now = monotonic()
            if not seen:
                begun = now, done
            if not seen or now - seen[-1][0] >= REDRAW_S:
                seen.append((now, done))
            # what was slow at the beginning, as the compiler is, says nothing about the time left
            while len(seen) > 1 and seen[1][0] <= now - WINDOW_S:
                seen.popleft()
            if done < total and now - last < (REDRAW_S if self.live else LINE_S):
                return
            last = now
            since, before = seen[0] if done < total else begun
            pace = Pace(now - start, done - before, now - since)
            self._show(progress_text(name, done, total, pace, outcomes, bar=self.live))

        return show

    def _show(self, text: str) -> None:
        if not self.live:
            self._write(text + "\n")
            return
        width = shutil.get_terminal_size().columns - 1
        self._write(f"\r{text[:width]:<{width}}")
        self.open_line = True

    def _end_line(self) -> None:
        if self.open_line:
            self._write("\n")
            self.open_line = False

    def _write(self, text: str) -> None:
        # a terminal that is gone, or a full disk, costs what is told and not the work
        with suppress(OSError):
            self.stream.write(text)
            self.stream.flush()


def progress_text(name: str, done: int, total: int, pace: Pace, outcomes: dict[str, int] | None, *, bar: bool) -> str:
    """One line on the state of one analysis."""
    share = done / total if total else 1.0
    parts = [f"{name}:"]
    if bar:
        filled = int(BAR * share)
        parts.append(f"[{'#' * filled}{'.' * (BAR - filled)}]")
    parts.append(f"{100 * share:3.0f} %  {done}/{total}")
    if pace.measured_s > 0 and pace.measured:
        rate = pace.measured / pace.measured_s
        parts.append(f" {rate:.3g}/s")
        if done < total:
            parts.append(f" {clock((total - done) / rate)} left")
    if done == total:
        parts.append(f" took {clock(pace.elapsed_s)}")
    if outcomes:
        parts.append(" " + ", ".join(f"{outcome} {count}" for outcome, count in outcomes.items() if count))
    return " ".join(parts)


def clock(seconds: float) -> str:
    """Hours, minutes and seconds as ``1:02:03``, without the hours below one."""
    hours, rest = divmod(round(seconds), 3600)
    minutes, left = divmod(rest, 60)
    return f"{hours}:{minutes:02}:{left:02}" if hours else f"{minutes}:{left:02}"
