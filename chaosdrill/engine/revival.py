"""Once a transient is over averages start anew, and so do tangents that were lost; states are put where a mode is."""

import math

from chaosdrill.codegen.kinds import int64, void
from chaosdrill.codegen.signatures import matrix
from chaosdrill.engine.jit import compiled, inner
from chaosdrill.engine.layout import CHECKED
from chaosdrill.engine.records import machine_at, state_of, time_of
from chaosdrill.engine.tangents import normals_of
from chaosdrill.engine.tuning import TANGENTS


@inner
def pin(state, constrained):
    """Drop the tangents that the present mode leaves no freedom; ``constrained`` is 1 for a state that a mode pins."""
    row = constrained[state.run[0].mode]
    for i in range(state.vectors.shape[0]):
        for a in range(state.vectors.shape[1]):
            if row[a] == 1:
                state.vectors[i, a] = 0.0
    state.run[0].rank_check = CHECKED


@inner
def _revive(state, frame):
    """Start the tangents anew that were lost before, behind the others, which go on.

    A rank that was lost once in a transient says nothing about the attractor.
    """
    vectors, exponent_of, lost = state.vectors, state.exponent_of, state.lost
    m, n = vectors.shape
    live = state.run[0].live
    for exponent in range(m):
        if lost[exponent] == 0:
            continue
        exponent_of[live] = exponent
        row = vectors[live]
        length = 1.0
        for candidate in range(n + 1):
            before = 0.0
            for a in range(n):
                unit = 1.0 if a == candidate - 1 else 0.0
                row[a] = frame[exponent, a] if candidate == 0 else unit
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
            if length > TANGENTS.independent * math.sqrt(before) > 0.0:
                break
        for a in range(n):
            row[a] /= length
        state.sooner[live] = 0.0
        lost[exponent] = 0
        live += 1
    state.run[0].live = m


@inner
def forget(state, frame, constrained):
    """Start all averages of a run anew, and the tangents that were lost before."""
    run = state.run[0]
    state.logs[:] = 0.0
    state.grown[:] = 1.0
    state.counts[:] = 0
    state.sums[:, :] = 0.0
    state.grazing[:] = math.inf
    run.ties = 0
    run.events_in_period = 0
    run.steps = 0
    run.evaluations = 0
    if run.live < frame.shape[0]:
        _revive(state, frame)
        pin(state, constrained)


@compiled(void(int64, int64, matrix))
def forget_run(place, p, frame):
    """The same for run p; ``place`` is the address of the `chaosdrill.engine.layout.Machine`."""
    machine = machine_at(place)
    forget(state_of(machine.states, p), frame, machine.tables.constrained)


@compiled(void(int64, int64))
def put_run(place, p):
    """Put run p onto the surfaces that its mode holds, by the shortest way in the scales of the states.

    ``place`` is the address of the `chaosdrill.engine.layout.Machine`.
    """
    machine = machine_at(place)
    state, scratch, normals = state_of(machine.states, p), machine.scratch, machine.scratch.normals
    run, x, n = state.run[0], state.x, state.x.size
    for _ in range(TANGENTS.onto_surfaces):
        for a in range(n):
            scratch.metric[a] = state.scale[a]
        found = normals_of(machine.functions, machine.tables, run.mode, time_of(run), state, n, scratch)
        for j in range(found):
            for a in range(n):
                x[a] -= normals[j, n + 1] * normals[j, a] * scratch.metric[a]
