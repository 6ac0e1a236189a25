"""Progress: a bar on a terminal, plain lines elsewhere, with rate, time left and counts by outcome."""

import io

import pytest

from chaosdrill.cli import progress
from chaosdrill.cli.progress import Pace, Progress, clock, progress_text


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def now(monkeypatch):
    """A clock that moves only when it is told to."""
    time = [100.0]
    monkeypatch.setattr(progress, "monotonic", lambda: time[0])
    return time


def test_line_elsewhere(now):
    stream = io.StringIO()
    with Progress(stream) as shown:
        show = shown.report("diagram")
        now[0] += 20
        show(50, 200, {"chaotic": 30, "periodic": 20, "escaped": 0})
        now[0] += 1
        show(60, 200, {"chaotic": 40})
        now[0] += 59
        show(200, 200, None)
    assert stream.getvalue().splitlines() == [
        "diagram: begins",
        "diagram:  25 %  50/200  chaotic 30, periodic 20",
        "diagram: 100 %  200/200  2.5/s  took 1:20",
    ]


def test_what_was_there_before_makes_no_rate(now):
    stream = io.StringIO()
    with Progress(stream) as shown:
        show = shown.report("diagram")
        show(9000, 10_000, {"periodic": 9000})
        now[0] += 10
        show(9020, 10_000, {"periodic": 9000, "chaotic": 20})
    assert stream.getvalue().splitlines() == [
        "diagram: begins",
        "diagram:  90 %  9020/10000  2/s  8:10 left  periodic 9000, chaotic 20",
    ]


def test_time_left_forgets_a_slow_beginning(now):
    stream = io.StringIO()
    with Progress(stream) as shown:
        show = shown.report("chart")
        show(0, 1000, {})
        now[0] += 120
        show(1, 1000, {"chaotic": 1})
        for done in range(101, 1000, 100):
            now[0] += 10
            show(done, 1000, {"chaotic": done})
    last = stream.getvalue().splitlines()[-1]
    assert last == "chart:  90 %  901/1000  10/s  0:10 left  chaotic 901"


def test_bar_on_a_terminal(now, monkeypatch):
    monkeypatch.setenv("COLUMNS", "72")
    stream = Terminal()
    with Progress(stream) as shown:
        show = shown.report("spectrum")
        now[0] += 10
        show(1, 10, None)
        now[0] += 8
        show(5, 10, None)
        show(6, 10, None)
        now[0] += 10
        show(10, 10, {"chaotic": 1})
    _, first, second = stream.getvalue().removesuffix("\n").split("\r")[1:]
    assert first.rstrip() == "spectrum: [############............]  50 %  5/10  0.5/s  0:10 left"
    assert second.startswith("spectrum: [########################] 100 %  10/10")
    assert len(first) == len(second) == 71
    assert stream.getvalue().endswith("\n")


def test_the_next_analysis_begins_on_its_own_line(now):
    stream = Terminal()
    with Progress(stream) as shown:
        shown.report("first")(1, 1, None)
        shown.report("second")(1, 1, None)
    assert [line.split(":")[0].strip() for line in stream.getvalue().splitlines() if line.strip()] == [
        "first",
        "second",
    ]


@pytest.mark.parametrize(("seconds", "text"), [(0, "0:00"), (59.6, "1:00"), (61, "1:01"), (3723, "1:02:03")])
def test_clock(seconds, text):
    assert clock(seconds) == text


def test_nothing_to_do():
    assert progress_text("empty", 0, 0, Pace(), None, bar=False) == "empty: 100 %  0/0  took 0:00"
