"""How far long work is: a bar on a terminal or in a notebook, now and then a line elsewhere.

Compilation says so and counts into no rate but the last, which is that of the whole time. The time left comes from the
rate of the last seconds, and is not shown before there is one.
"""

import sys
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from functools import cache, partial, wraps
from importlib import import_module
from importlib.util import find_spec
from shutil import get_terminal_size
from threading import RLock
from time import monotonic
from typing import Any, ParamSpec, Self, TextIO, TypeVar

from chaosdrill.names import visible
from chaosdrill.tuning import TUNING

P = ParamSpec("P")
R = TypeVar("R")

Progress = Callable[[int, int, dict[str, int] | None], None]
"""Called with (done, total, counts by outcome so far)."""

BAR = "{{desc}}: {{percentage:3.0f}} %|{}| {{n_fmt}}/{{total_fmt}}{{postfix}}"

COLD = (
    "chaosdrill: compiling a part of the engine for this machine, once; this takes about 20 s of processor time "
    "('chaosdrill warm' compiles all parts beforehand)"
)


class Compilation:
    """The times in which anything is compiled, for those who count without them."""

    def __init__(self) -> None:
        self._lock, self._since, self._spent = RLock(), 0.0, 0.0
        self.under_way = 0
        """How many things are being compiled."""
        self.watchers: list[Callable[[], None]] = []
        """Called when a compilation begins while there was none, and when the last one ends."""

    def seconds(self) -> float:
        """Seconds so far in which something was compiled."""
        with self._lock:
            return self._spent + (monotonic() - self._since if self.under_way else 0.0)

    def count(self, by: int) -> None:
        """One thing more is compiled from now on (1), or one less (-1)."""
        with self._lock:
            spent, before, self.under_way = self.seconds(), self.under_way, self.under_way + by
            if before and self.under_way:
                return
            self._spent, self._since = spent, monotonic()
        for watcher in tuple(self.watchers):
            watcher()


COMPILATION = Compilation()


@contextmanager
def compiling() -> Iterator[None]:
    """While the block runs, code is compiled, or waited for."""
    COMPILATION.count(1)
    try:
        yield
    finally:
        COMPILATION.count(-1)


@cache
def tell_of_compilation() -> None:
    """Say in one line on standard error, once a process, that the engine is being compiled."""
    if sys.stderr is not None:
        _Patient(sys.stderr).line(COLD)


@cache
def hear_numba() -> None:
    """Have numba report when it compiles, from where it is imported on."""
    from numba.core import event

    class Listener(event.Listener):
        def on_start(self, event: Any) -> None:
            COMPILATION.count(1)

        def on_end(self, event: Any) -> None:
            COMPILATION.count(-1)

    event.register("numba:compile", Listener())


class Display:
    """Shows how far each of several pieces of work is, its rate, the time left and the counts by outcome.

    ``stream``: where to; default: stderr. ``notebook``: whether bars are widgets of a notebook. ``live``: whether to
    draw bars; default: if the stream is a terminal. ``delay``: seconds that a piece of work takes before anything but
    its compilation is shown.
    """

    def __init__(
        self, stream: TextIO | None = None, *, notebook: bool = False, live: bool | None = None, delay: float = 0.0
    ) -> None:
        self._stream = _Patient(stream or sys.stderr)
        self._live = self._stream.isatty() if live is None else live
        self._notebook, self._delay = notebook, delay
        self._meter: _Meter | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def tell(self, line: str) -> None:
        """Show a line of its own."""
        self._close()
        self._stream.line(visible(line))

    def report(self, name: str) -> Progress:
        """Begin a piece of work; what is returned takes items done, their total, and counts by outcome.

        The first call gives the start, which after a resume is not zero: rates count from there.
        """
        self._close()
        if "numba" in sys.modules:
            hear_numba()
        name = visible(name)
        if self._live:
            face: _Lines | _Bar = _Bar(name, self._stream, self._notebook)
        else:
            face = _Lines(name, self._stream)
        self._meter = _Meter(face, self._delay)
        COMPILATION.watchers.append(self._meter.turn)
        return self._meter

    def _close(self) -> None:
        if self._meter is not None:
            COMPILATION.watchers.remove(self._meter.turn)
            self._meter.face.close()
            self._meter = None


class _Meter:
    """What is known of one piece of work."""

    def __init__(self, face: "_Lines | _Bar", delay: float) -> None:
        self.face = face
        self._start = self._drawn = monotonic()
        self._visible_from = self._start + delay
        self._compiled_before = COMPILATION.seconds()
        self._begun: tuple[float, int] | None = None
        self._seen: deque[tuple[float, int]] = deque()
        self._rate: float | None = None
        self._done, self._total, self._outcomes = 0, 0, dict[str, int]()

    def __call__(self, done: int, total: int, outcomes: dict[str, int] | None = None) -> None:
        """Take note of how far it is, and show it if it is time to."""
        now = monotonic()
        worked = now - COMPILATION.seconds()
        if self._begun is None:
            self._begun = worked, done
        # until the first piece of it is done, the others' needs are loaded
        elif done > self._begun[1] and (not self._seen or worked - self._seen[-1][0] >= TUNING.redraw_s):
            self._seen.append((worked, done))
            while self._seen[0][0] < worked - TUNING.window_s and len(self._seen) > 2:
                self._seen.popleft()
        self._done, self._total, self._outcomes = done, total, outcomes or {}
        since, before = self._seen[0] if self._seen else (worked, done)
        if done == total:
            # the rate over all the time that the last line names
            worked, since, before = now, self._start, self._begun[1]
        if worked > since and done > before:
            self._rate = (done - before) / (worked - since)
        if (done == total or now - self._drawn >= self.face.every_s) and now >= self._visible_from:
            self._draw()

    def turn(self) -> None:
        """Show that compilation has begun, or is over."""
        if self.face.tells_compilation and (COMPILATION.under_way or monotonic() >= self._visible_from):
            self._draw()

    def _draw(self) -> None:
        self._drawn = monotonic()
        self.face.show(self._done, None if self._begun is None else self._total, self._words())

    def _words(self) -> list[str]:
        """What to report besides the amount of work done."""
        over = self._begun is not None and self._done == self._total
        if COMPILATION.under_way and not over:
            return ["compiling"]
        words = []
        if self._rate is not None:
            words.append(f"{self._rate:.3g}/s" if self._rate < 1000 else f"{self._rate:.0f}/s")
            if not over:
                words.append(f"{clock((self._total - self._done) / self._rate)} left")
        if over:
            words.append(f"took {clock(monotonic() - self._start)}")
            if (compiled := COMPILATION.seconds() - self._compiled_before) >= TUNING.worth_s:
                words.append(f"{clock(compiled)} of it compiling")
        counts = ", ".join(f"{outcome} {count}" for outcome, count in self._outcomes.items() if count)
        return [*words, *filter(None, [counts])]


class _Lines:
    """A line now and then, as suits a file."""

    every_s = TUNING.line_s
    tells_compilation = False

    def __init__(self, name: str, stream: "_Patient") -> None:
        self._name, self._stream = name, stream
        stream.line(f"{name}: started")

    def show(self, done: int, total: int | None, words: list[str]) -> None:
        part = f"{100 * done / total if total else 100:3.0f} %"
        self._stream.line("  ".join([f"{self._name}: {part}", f"{done}/{total}", *words]))

    def close(self) -> None:
        pass


class _Bar:
    """A bar that is redrawn; the name alone while the amount of work is unknown."""

    every_s = TUNING.redraw_s
    tells_compilation = True

    def __init__(self, name: str, stream: "_Patient", notebook: bool) -> None:
        self._made = partial(_bar_class(notebook), desc=name, file=stream)
        self._notebook = notebook
        self._bar: Any = None

    def show(self, done: int, total: int | None, words: list[str]) -> None:
        if self._bar is None or self._bar.total != total:
            if self._bar is not None:
                self._bar.leave = False
            self.close()
            form = BAR.format("{bar}" if self._notebook else "{bar:20}") if total is not None else "{desc}{postfix}"
            self._bar = self._made(total=total, initial=done, bar_format=form, leave=total is not None)
        self._bar.n = done
        if not self._notebook:
            self._bar.ncols = get_terminal_size().columns - 1
        self._bar.set_postfix_str(", ".join(words))

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


class _Patient:
    """A stream that may be gone or full: then the message is lost, and the work continues."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def line(self, text: str) -> None:
        """Write a line."""
        self.write(f"{text}\n")
        self.flush()

    def write(self, text: str) -> None:
        """Write, if that is possible."""
        with suppress(OSError, ValueError):
            self._stream.write(text)

    def flush(self) -> None:
        """Flush, if that is possible."""
        with suppress(OSError, ValueError):
            self._stream.flush()


@cache
def _bar_class(notebook: bool) -> Any:
    module = import_module("tqdm.notebook" if notebook else "tqdm.std")

    class Bar(module.tqdm):  # type: ignore[name-defined]
        # no thread of tqdm's own is to draw
        monitor_interval = 0

    Bar.set_lock(RLock())
    return Bar


_call: ContextVar[tuple[str, ExitStack]] = ContextVar("call")


def watched(function: Callable[P, R]) -> Callable[P, R]:
    """Have what `teller` shows end with the function, however that ends."""
    name = function.__name__.replace("_", " ")

    @wraps(function)
    def run(*arguments: P.args, **keywords: P.kwargs) -> R:
        with ExitStack() as stack:
            stack.callback(_call.reset, _call.set((name, stack)))
            return function(*arguments, **keywords)

    return run


def teller(progress: Progress | bool | None) -> Progress | None:
    """The receiver of progress reports from the function at work, which is `watched`.

    ``progress``: who receives reports; True: standard error or the notebook; None: the same where somebody looks, once
    it takes longer than a second; False: none.
    """
    if callable(progress) or progress is False:
        return progress or None
    notebook = _in_notebook()
    terminal = sys.stderr is not None and sys.stderr.isatty()
    if progress is None and not (notebook or terminal):
        return None
    name, stack = _call.get()
    display = Display(
        notebook=notebook and find_spec("ipywidgets") is not None,
        live=notebook or terminal,
        delay=TUNING.delay_s if progress is None else 0.0,
    )
    return stack.enter_context(display).report(name)


def _in_notebook() -> bool:
    """Whether somebody who could also be asked for input looks at a notebook; who only has it run looks at nothing."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    kernel = getattr(shell, "kernel", None)
    return kernel is not None and bool(kernel.get_parent().get("content", {}).get("allow_stdin"))


def clock(seconds: float) -> str:
    """Hours, minutes and seconds as ``1:02:03``, without the hours below one."""
    hours, rest = divmod(round(seconds), 3600)
    minutes, left = divmod(rest, 60)
    return f"{hours}:{minutes:02}:{left:02}" if hours else f"{minutes}:{left:02}"
