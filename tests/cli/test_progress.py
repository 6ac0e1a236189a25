"""Progress: a bar on a terminal, plain lines elsewhere, with rate, time left and counts by outcome."""

import errno
import io
import re
import time
from dataclasses import replace
from itertools import groupby

import numba
import pytest

from chaosdrill import progress
from chaosdrill.codegen.kinds import float64
from chaosdrill.progress import Display, clock, compiling, teller, watched


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def now(monkeypatch):
    """A clock that moves only when it is told to."""
    time = [100.0]
    monkeypatch.setattr(progress, "monotonic", lambda: time[0])
    monkeypatch.setattr(progress, "COMPILATION", progress.Compilation())
    monkeypatch.setenv("COLUMNS", "120")
    return time


def drawn(stream):
    """What stood on a terminal, one after the other, without the bars."""
    texts = [text.strip() for text in re.split(r"[\r\n]", stream.getvalue()) if text.strip()]
    return [text for text, _ in groupby(re.sub(r"\|[^|]*\|", "", text) for text in texts)]


def test_lines_elsewhere(now):
    stream = io.StringIO()
    with Display(stream) as shown:
        show = shown.report("diagram")
        show(0, 200, {})
        now[0] += 20
        show(50, 200, {"chaotic": 30, "periodic": 20, "escaped": 0})
        now[0] += 1
        show(60, 200, {"chaotic": 40})
        now[0] += 59
        show(200, 200, None)
    assert stream.getvalue().splitlines() == [
        "diagram: started",
        "diagram:  25 %  50/200  chaotic 30, periodic 20",
        "diagram: 100 %  200/200  2.5/s  took 1:20",
    ]


def test_what_was_there_before_makes_no_rate(now):
    stream = io.StringIO()
    with Display(stream) as shown:
        show = shown.report("diagram")
        show(9000, 10_000, {"periodic": 9000})
        now[0] += 10
        show(9010, 10_000, {"periodic": 9000, "chaotic": 10})
        now[0] += 10
        show(9030, 10_000, {"periodic": 9000, "chaotic": 30})
    assert stream.getvalue().splitlines() == [
        "diagram: started",
        "diagram:  90 %  9010/10000  periodic 9000, chaotic 10",
        "diagram:  90 %  9030/10000  2/s  8:05 left  periodic 9000, chaotic 30",
    ]


def test_no_rate_before_there_is_one(now):
    stream = Terminal()
    with Display(stream) as shown:
        show = shown.report("chart")
        for done in (0, 0, 8):
            show(done, 1000, {})
            now[0] += 60
            show(done, 1000, {})
    assert drawn(stream)
    assert not re.search("/s|left", stream.getvalue())


def test_time_left_is_that_of_the_last_seconds(now):
    stream = io.StringIO()
    with Display(stream) as shown:
        show = shown.report("chart")
        show(0, 1000, {})
        now[0] += 120
        for done in range(100, 400, 100):
            show(done, 1000, {"chaotic": done})
            now[0] += 100
        for done in range(401, 1000, 100):
            show(done, 1000, {"chaotic": done})
            now[0] += 10
    last = stream.getvalue().splitlines()[-1]
    assert last == "chart:  90 %  901/1000  10/s  0:10 left  chaotic 901"


def test_compilation_says_so_and_makes_no_rate(now):
    """As a cold first diagram: what is left was three hours, because the compiler counted."""
    stream = Terminal()
    with Display(stream) as shown:
        show = shown.report("diagram")
        show(0, 10_000, {})
        with compiling():
            now[0] += 20
            with compiling():
                now[0] += 20
        now[0] += 0.5
        show(8, 10_000, {"periodic": 8})
        now[0] += 1
        with compiling():
            now[0] += 30
        now[0] += 1
        show(1008, 10_000, {"periodic": 1008})
        now[0] += 18
        show(10_000, 10_000, {"periodic": 10_000})
    assert drawn(stream) == [
        "diagram:   0 % 0/10000",
        "diagram:   0 % 0/10000, compiling",
        "diagram:   0 % 0/10000",
        "diagram:   0 % 8/10000, periodic 8",
        "diagram:   0 % 8/10000, compiling",
        "diagram:   0 % 8/10000, periodic 8",
        "diagram:  10 % 1008/10000, 500/s, 0:18 left, periodic 1008",
        "diagram: 100 % 10000/10000, 110/s, took 1:30, 1:10 of it compiling, periodic 10000",
    ]


def test_compilation_before_anyone_knows_how_much_there_is_to_do(now):
    stream = Terminal()
    with Display(stream, delay=1.0) as shown:
        show = shown.report("spectrum")
        with compiling():
            now[0] += 20
        show(1, 4, None)
        now[0] += 20
        show(4, 4, None)
    texts = drawn(stream)
    assert texts[:2] == ["spectrum", "spectrum, compiling"]
    assert texts[-1] == "spectrum: 100 % 4/4, 0.075/s, took 0:40, 0:20 of it compiling"


def test_the_last_rate_is_that_of_all_the_time_it_names(now):
    stream = io.StringIO()
    with Display(stream) as shown:
        show = shown.report("chart")
        now[0] += 10
        show(0, 60, {})
        with compiling():
            now[0] += 10
        now[0] += 10
        show(60, 60, {})
    rate, minutes, seconds = re.search(r"60/60  (.*)/s  took (\d):(\d\d)", stream.getvalue()).groups()
    assert float(rate) * (60 * int(minutes) + int(seconds)) == 60


def test_a_file_hears_nothing_of_compilation(now):
    stream = io.StringIO()
    with Display(stream) as shown:
        shown.report("spectrum")
        with compiling():
            now[0] += 60
    assert stream.getvalue() == "spectrum: started\n"


def test_every_compiler_is_heard(monkeypatch, tmp_path):
    """Time in any compiler is no work, and on a terminal it is said while it lasts."""
    from chaosdrill.codegen.kept import object_code
    from chaosdrill.engine.jit import compiled

    monkeypatch.setattr("chaosdrill.codegen.kept.cache_folder", lambda: tmp_path)
    stream = Terminal()
    with Display(stream) as shown:
        show = shown.report("work")
        show(0, 1000)
        before = progress.COMPILATION.seconds()
        start = time.monotonic()
        numba.njit("f8(f8)")(lambda x: x + 2.0)
        took = time.monotonic() - start
        spent = progress.COMPILATION.seconds() - before
        assert 0 < spent <= took
        assert "compiling" in stream.getvalue()
        stream.truncate(0)
        assert compiled(float64(float64))(lambda x: x + 3.0)(1.0) == 4.0
        assert "compiling" in stream.getvalue()
        stream.truncate(0)
        object_code("define double @f(double %x) { ret double %x }")
        assert "compiling" in stream.getvalue()
        stream.truncate(0)
        object_code("define double @f(double %x) { ret double %x }")
        assert not stream.getvalue()


def test_bar_on_a_terminal(now, monkeypatch):
    monkeypatch.setenv("COLUMNS", "72")
    stream = Terminal()
    with Display(stream) as shown:
        show = shown.report("spectrum")
        now[0] += 10
        show(1, 10, None)
        now[0] += 8
        show(3, 10, {"a word that is cut where the line ends": 3})
        now[0] += 4
        show(5, 10, None)
        show(6, 10, None)
        now[0] += 8
        show(10, 10, {"chaotic": 1})
    lines = [line.rstrip() for line in stream.getvalue().removesuffix("\n").split("\r")]
    assert "spectrum:  50 %|##########          | 5/10, 0.5/s, 0:10 left" in lines
    assert lines[-1] == "spectrum: 100 %|####################| 10/10, 0.3/s, took 0:30, chaotic"
    assert max(map(len, lines)) == 71
    assert stream.getvalue().endswith("\n")


def test_the_next_analysis_begins_on_its_own_line(now):
    stream = Terminal()
    with Display(stream) as shown:
        shown.report("first")(1, 1, None)
        shown.report("second")(1, 1, None)
        shown.tell("told")
    lines = [line.split("\r")[-1].split(":")[0].strip() for line in stream.getvalue().split("\n") if line.strip()]
    assert lines == ["first", "second", "told"]


@pytest.mark.parametrize("terminal", [False, True])
def test_a_stream_that_is_gone_costs_no_work(terminal):
    class Gone(io.StringIO):
        def isatty(self):
            return terminal

        def write(self, *_):
            raise OSError(errno.EIO, "gone")

        flush = write

    with Display(Gone()) as shown:
        show = shown.report("spectrum")
        show(1, 2, None)
        show(2, 2, None)


@pytest.mark.parametrize("fault", [KeyboardInterrupt, ZeroDivisionError])
def test_a_bar_ends_with_the_work_however_that_ends(monkeypatch, fault):
    stream = Terminal()
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setattr(progress, "TUNING", replace(progress.TUNING, delay_s=0.0))

    @watched
    def long_work(report=None):
        show = teller(report)
        show(0, 3)
        time.sleep(2 * progress.TUNING.redraw_s)
        show(1, 3)
        raise fault

    with pytest.raises(fault):
        long_work()
    assert drawn(stream)[-1].startswith("long work:  33 %")
    assert stream.getvalue().endswith("\n")
    assert not progress.COMPILATION.watchers


@pytest.mark.parametrize(("seconds", "text"), [(0, "0:00"), (59.6, "1:00"), (61, "1:01"), (3723, "1:02:03")])
def test_clock(seconds, text):
    assert clock(seconds) == text


def test_nothing_to_do():
    stream = io.StringIO()
    with Display(stream) as shown:
        shown.report("empty")(0, 0, None)
    assert stream.getvalue().splitlines() == ["empty: started", "empty: 100 %  0/0  took 0:00"]
