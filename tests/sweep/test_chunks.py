"""Sizes of chunks follow the cost of units; no unit is left out or given twice."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from chaosdrill.sweep.chunks import AIM_S, FINE_S, FIRST, ChunkSizes, Gaps


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
    assert max(spent for *_, spent in chunks) <= AIM_S * 1.001
    assert workers == 7 or sorted(spent for *_, spent in chunks)[len(chunks) // 2] > 0.5 * AIM_S
    assert len(chunks) < 200
    assert max(clocks) - min(clocks) < 2 * FINE_S


def test_few_chunks_are_short():
    chunks, _ = simulate([0.0005] * 30_000, 2)
    assert [count for _, count, _ in chunks[:2]] == [FIRST, FIRST]
    assert all(spent >= FINE_S / 2 for *_, spent in chunks[4:-1])
    assert len(chunks) < 40


def test_few_units_go_out_one_by_one_at_first():
    chunks, _ = simulate([0.001] * 20, 4)
    assert [count for _, count, _ in chunks[:4]] == [1] * 4


def test_units_of_several_seconds_go_out_one_by_one():
    chunks, _ = simulate([5.0] * 30, 2)
    assert [count for _, count, _ in chunks] == [1] * 30


def test_chunks_shrink_at_once_where_units_become_expensive():
    chunks, clocks = simulate([0.001] * 10_000 + [0.1] * 500, 2)
    late = [count for first, count, _ in chunks if first > 10_400]
    assert max(late) <= AIM_S / 0.1
    assert max(clocks) - min(clocks) < 2 * AIM_S


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
