"""Once a transient is over averages start anew, and so do tangents that were lost."""

import math

from numba import int64, void

from chaosdrill.codegen.signatures import matrix
from chaosdrill.engine.jit import compiled, inner
from chaosdrill.engine.layout import EVALUATIONS, LIVE, MODE, RANK_CHECK, STEPS, TIES
from chaosdrill.engine.stepper import integers

INDEPENDENT = 1e-6
"""A direction counts as new if more than this part of it is orthogonal to the live tangents."""

_integer_matrix = int64[:, ::1]


@compiled(void(matrix, _integer_matrix, integers))
def pin(vectors, pins, carried):
    """Drop the tangents that the present mode leaves no freedom; ``pins`` holds 1 for a state that a mode pins."""
    row = pins[carried[MODE]]
    for i in range(vectors.shape[0]):
        for a in range(vectors.shape[1]):
            if row[a] == 1:
                vectors[i, a] = 0.0
    carried[RANK_CHECK] = 1


@compiled(void(matrix, matrix, integers, integers, integers))
def revive(vectors, frame, slots, dead, carried):
    """Start the tangents anew that were lost before, behind the others, which go on.

    A rank that was lost once in a transient says nothing about the attractor.
    """
    m, n = vectors.shape
    live = carried[LIVE]
    for slot in range(m):
        if dead[slot] == 0:
            continue
        slots[live] = slot
        row = vectors[live]
        length = 1.0
        for candidate in range(n + 1):
            before = 0.0
            for a in range(n):
                unit = 1.0 if a == candidate - 1 else 0.0
                row[a] = frame[slot, a] if candidate == 0 else unit
                before += row[a] * row[a]
            for _ in range(2):
                for j in range(live):
                    dot = 0.0
                    for a in range(n):
                        dot += vectors[j, a] * row[a]
                    for a in range(n):
                        row[a] -= dot * vectors[j, a]
            length = 0.0
            for a in range(n):
                length += row[a] * row[a]
            length = math.sqrt(length)
            if length > INDEPENDENT * math.sqrt(before) > 0.0:
                break
        for a in range(n):
            row[a] /= length
        dead[slot] = 0
        live += 1
    carried[LIVE] = m


@inner
def forget(frame, pins, vectors, slots, dead, logs, sums, counts, grazing, carried):
    """Start all averages of a run anew, and the tangents that were lost before."""
    logs[:] = 0.0
    counts[:] = 0
    sums[:, :] = 0.0
    grazing[:] = math.inf
    carried[TIES] = 0
    carried[STEPS] = 0
    carried[EVALUATIONS] = 0
    if carried[LIVE] < frame.shape[0]:
        revive(vectors, frame, slots, dead, carried)
        pin(vectors, pins, carried)
