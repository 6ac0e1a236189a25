"""Chunks on threads: results in order, errors come through, what has not begun is dropped."""

import threading

import pytest

from chaosdrill.analysis.workers import ordered_map


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_results_come_in_order(workers):
    gate = threading.Event()

    def work(k):
        # with several workers the first chunk waits for the second
        if workers > 1 and k == 0:
            assert gate.wait(10)
        if k == 1:
            gate.set()
        return k * k

    assert list(ordered_map(work, range(50), workers)) == [k * k for k in range(50)]


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_comes_through_and_stops_the_rest(workers):
    begun = []

    def work(k):
        begun.append(k)
        if k == 3:
            raise ZeroDivisionError
        return k

    results = ordered_map(work, range(10_000), workers)
    with pytest.raises(ZeroDivisionError):
        list(results)
    assert len(begun) < 100


def test_chunks_are_taken_as_they_are_needed():
    taken = []

    def source():
        for k in range(1000):
            taken.append(k)
            yield k

    results = ordered_map(lambda k: k, source(), 2)
    assert next(results) == 0
    results.close()
    assert len(taken) < 20
