"""The same bits whoever runs the units; nothing runs twice; faults and interruptions come through."""

import os
import signal
import threading
from dataclasses import dataclass

import numpy as np
import pytest
from support.logistic_task import Faulty, Logistic

from chaosdrill.errors import SettingsError
from chaosdrill.sweep import execute


@pytest.mark.parametrize("workers", [1, 2, 5])
@pytest.mark.parametrize("kept", [False, True])
def test_same_bits(task, whole, same, tmp_path, workers, kept):
    found = execute(task, workers=workers, store=tmp_path / "parts" if kept else None)
    assert same(found, whole(task))


@pytest.mark.parametrize("units", [0, 1])
def test_few_units(whole, same, tmp_path, units):
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
