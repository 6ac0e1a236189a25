"""Chunks of fitting size, the same bits whoever runs them, in bounded memory."""

import os
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.logistic_task import Faulty, Logistic

from chaosdrill.errors import SettingsError
from chaosdrill.sweep import execute
from chaosdrill.sweep.task import ChunkSizes, Gaps
from chaosdrill.sweep.tuning import TUNING

# The same bits whoever runs the units; nothing runs twice; faults and interruptions come through.


@pytest.mark.parametrize("workers", [1, 2, 5])
@pytest.mark.parametrize("kept", [False, True])
def test_workers_and_stores_change_no_bit(task, whole, same, tmp_path, workers, kept):
    found = execute(task, workers=workers, store=tmp_path / "parts" if kept else None)
    assert same(found, whole(task))


@pytest.mark.parametrize("units", [0, 1])
def test_fewer_units_than_workers_are_all_computed(whole, same, tmp_path, units):
    task = Logistic(units=units)
    for store in (None, tmp_path / "parts"):
        found = execute(task, workers=2, store=store)
        assert found["orbit"].shape == (units, 40)
        assert units == 0 or same(found, whole(task))


@dataclass(frozen=True)
class Recorded(Logistic):
    """Takes note of the units that ran."""

    def run(self, first, count):
        RAN.extend(range(first, first + count))
        return super().run(first, count)


RAN: list[int] = []


@pytest.mark.parametrize("workers", [1, 3])
def test_every_unit_runs_once(workers):
    RAN.clear()
    execute(Recorded(units=3000, iterations=2), workers=workers)
    assert sorted(RAN) == list(range(3000))


MOST_RAN = threading.Event()


@dataclass(frozen=True)
class Stalled(Recorded):
    """Unit 3 does not end before three quarters of all have run."""

    def run(self, first, count):
        found = super().run(first, count)
        if len(RAN) > 0.75 * self.units:
            MOST_RAN.set()
        if first <= 3 < first + count:
            assert MOST_RAN.wait(60)
        return found


def test_expensive_units_do_not_stall_the_rest():
    RAN.clear()
    MOST_RAN.clear()
    execute(Stalled(units=400, iterations=1, pause=0.0025), workers=2)
    assert sorted(RAN) == list(range(400))


def test_progress_counts_points_by_outcome(task, whole):
    told = []
    execute(task, workers=2, progress=lambda *seen: told.append(seen))
    codes, counts = np.unique(whole(task)["code"], return_counts=True)
    assert told[0] == (0, 500, {})
    assert told[-1] == (500, 500, {f"code {code}": count for code, count in zip(codes, counts, strict=True)})
    assert [done for done, *_ in told] == sorted(done for done, *_ in told)
    assert all(sum(outcomes.values()) == done for done, _, outcomes in told)


def test_progress_counts_points_of_units_that_hold_several():
    told = []
    execute(Logistic(units=6, points_per_unit=50), progress=lambda *seen: told.append(seen[:2]))
    assert told[0] == (0, 300)
    assert told[-1] == (300, 300)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_fault_comes_through_and_stops_the_rest(workers):
    told = []
    with pytest.raises(ZeroDivisionError, match="unit 200"):
        execute(Faulty(units=100_000, pause=0.0002), workers=workers, progress=lambda *seen: told.append(seen[0]))
    assert max(told) < 5000


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("workers", [1, 2])
def test_an_interruption_keeps_what_has_finished(tmp_path, whole, same, workers):
    task = Logistic(units=1200, pause=0.002)
    timer = threading.Timer(0.1, os.kill, [os.getpid(), signal.SIGINT])

    def progress(done, total, outcomes):
        if done and not timer.ident:
            timer.start()

    with pytest.raises(KeyboardInterrupt):
        execute(task, workers=workers, store=tmp_path, progress=progress)
    told = []
    found = execute(Logistic(units=1200), store=tmp_path, progress=lambda *seen: told.append(seen))
    assert 0 < told[0][0] < 1200
    assert same(found, whole(Logistic(units=1200)))


@dataclass(frozen=True)
class Undeclared(Logistic):
    """Returns another dtype than it declares."""

    def run(self, first, count):
        return super().run(first, count) | {"code": np.zeros(count)}


def test_arrays_that_the_task_does_not_declare_are_refused():
    with pytest.raises(TypeError, match="its task declares"):
        execute(Undeclared())


def test_workers_and_a_scheduler_exclude_each_other(task):
    with pytest.raises(SettingsError, match="has workers of its own; leave workers out"):
        execute(task, workers=2, scheduler="tcp://127.0.0.1:1")


def test_results_may_be_changed_without_changing_the_store(task, whole, same, tmp_path):
    found = execute(task, store=tmp_path)
    found["orbit"][:] = 0
    assert same(execute(task, store=tmp_path), whole(task))


# Sizes of chunks follow the cost of units; no unit is left out or given twice.


def simulate(costs, workers):
    """Hand out chunks to workers that take ``costs[k]`` seconds a unit; returns chunks and the times workers end."""
    sizes, gaps = ChunkSizes(100), Gaps(len(costs))
    clocks, running, chunks = [0.0] * workers, [], []
    while gaps.left or running:
        while gaps.left and len(running) < workers:
            worker = min(set(range(workers)) - {w for _, w, *_ in running}, key=clocks.__getitem__)
            first, count = gaps.take(sizes.next(gaps.left, workers))
            spent = sum(costs[first : first + count])
            clocks[worker] += spent
            running.append((clocks[worker], worker, count, spent))
            chunks.append((first, count, spent))
        running.sort()
        _, _, count, spent = running.pop(0)
        sizes.learn(count, spent)
    return chunks, clocks


@pytest.mark.parametrize("workers", [1, 2, 7])
def test_cheap_units_come_in_chunks_of_about_a_second(workers):
    chunks, clocks = simulate([0.002] * 20_000, workers)
    assert max(spent for *_, spent in chunks) <= TUNING.chunk_s * 1.001
    assert workers == 7 or sorted(spent for *_, spent in chunks)[len(chunks) // 2] > 0.5 * TUNING.chunk_s
    assert len(chunks) < 200
    assert max(clocks) - min(clocks) < 2 * TUNING.last_chunk_s


def test_few_chunks_are_short():
    chunks, _ = simulate([0.0005] * 30_000, 2)
    assert [count for _, count, _ in chunks[:2]] == [TUNING.first_units, TUNING.first_units]
    assert all(spent >= TUNING.last_chunk_s / 2 for *_, spent in chunks[4:-1])
    assert len(chunks) < 40


def test_few_units_go_out_one_by_one_at_first():
    chunks, _ = simulate([0.001] * 20, 4)
    assert [count for _, count, _ in chunks[:4]] == [1] * 4


@pytest.mark.parametrize("units", [5, 20])
def test_one_worker_begins_with_what_kernels_step_together(units):
    chunks, _ = simulate([0.001] * units, 1)
    assert chunks[0][1] == min(units, TUNING.first_units)


def test_units_of_several_seconds_go_out_one_by_one():
    chunks, _ = simulate([5.0] * 30, 2)
    assert [count for _, count, _ in chunks] == [1] * 30


def test_chunks_shrink_at_once_where_units_become_expensive():
    chunks, clocks = simulate([0.001] * 10_000 + [0.1] * 500, 2)
    late = [count for first, count, _ in chunks if first > 10_400]
    assert max(late) <= TUNING.chunk_s / 0.1
    assert max(clocks) - min(clocks) < 2 * TUNING.chunk_s


def test_a_first_chunk_that_waits_for_a_compiler_is_soon_forgotten():
    sizes = ChunkSizes(100)
    sizes.learn(1, 30.0)
    spent = 0.0
    while (count := sizes.next(10**6, 2)) < 400:
        sizes.learn(count, 0.002 * count)
        spent += 0.002 * count
    assert spent < 3.0


def test_results_of_a_chunk_stay_small():
    assert ChunkSizes(10**6).most == 16
    assert ChunkSizes(10**9).most == 1


@given(
    units=st.integers(0, 400),
    finished=st.lists(st.tuples(st.integers(0, 380), st.integers(1, 40)), max_size=8),
    sizes=st.lists(st.integers(1, 60), min_size=1, max_size=5),
)
def test_gaps_are_what_is_not_finished(units, finished, sizes):
    finished = [(first, min(count, units - first)) for first, count in finished if first < units]
    gaps = Gaps(units, finished)
    given_out = []
    for k in range(10**4):
        if not gaps.left:
            break
        first, count = gaps.take(sizes[k % len(sizes)])
        assert 1 <= count <= sizes[k % len(sizes)]
        given_out += range(first, first + count)
    done = {k for first, count in finished for k in range(first, first + count)}
    assert given_out == [k for k in range(units) if k not in done]


# A chart of a million points is computed and written in bounded memory.


CHART = """
import resource, sys
from dataclasses import dataclass
import netCDF4, numpy as np, xarray as xr
from chaosdrill.archive import save
from chaosdrill.sweep import execute

SIDE = 1000
COLUMNS = {"period": ("i2", ()), "outcome": ("i1", ())}
COLUMNS |= {"lyapunov_exponent": ("f8", (3,)), "lyapunov_error": ("f8", (3,))}
COLUMNS |= {f"rate {k}": ("f8", ()) for k in range(5)}

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

@dataclass(frozen=True)
class Chart:
    units: int = SIDE * SIDE
    points_per_unit: int = 1
    total: int = SIDE * SIDE

    def columns(self):
        return COLUMNS

    def run(self, first, count):
        random = np.random.default_rng(first)
        return {name: (100 * random.random((count, *shape))).astype(dtype) for name, (dtype, shape) in COLUMNS.items()}

    def counts(self, arrays):
        return {"done": len(arrays["outcome"])}

    def fingerprint(self):
        return {}

KIND = {"kind": "parameter-chart"}
# the libraries load parts of themselves with the first file
save(xr.Dataset({"x": ("a", np.zeros(1000))}, attrs=KIND), sys.argv[2])
before = peak()
found = execute(Chart(), store=sys.argv[1])
computed = peak()
shape = {name: ("a", "b", *("c" for _ in array.shape[1:])) for name, array in found.items()}
chart = {n: (shape[n], a.reshape(SIDE, SIDE, *a.shape[1:])) for n, a in found.items()}
save(xr.Dataset(chart, attrs=KIND), sys.argv[2])
print(computed - before, peak() - before)
"""


def test_memory_of_a_million_points(tmp_path):
    command = [sys.executable, "-c", CHART, str(tmp_path / "parts"), str(tmp_path / "out.nc")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    computing, writing = map(float, done.stdout.split())
    # in MB; the results are 91 MB, of which none need be in memory before they are written
    assert computing < 40
    assert writing < 200
