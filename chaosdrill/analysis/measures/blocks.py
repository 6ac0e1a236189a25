"""A run over the blocks of its record: growth, integrals and states at their ends, in few calls."""

import math
from collections.abc import Callable
from time import perf_counter

import numpy as np

from chaosdrill.codegen.kinds import Pointer, int64
from chaosdrill.codegen.signatures import cube, integers, matrix
from chaosdrill.dataset import Outcome
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.layout import DONE, EVENLY, EVENT_COLUMNS, FULL
from chaosdrill.engine.lengths import lengths_by_size
from chaosdrill.engine.records import FLOW_SIGNATURE, machine_at, state_of
from chaosdrill.engine.run import Run

HEARD = 0.05
"""Seconds that a call may take before the next ones are longer no more: an interruption is heard between calls."""


class Blocks:
    """The blocks of a record, and what is kept at their ends; what the run does not reach stays NaN.

    ``run``: at the beginning of the record. ``ends``, int, shape (B,): ends of the blocks, in periods from there.
    ``exponents``: number of tangents whose growth is kept.
    """

    def __init__(self, run: Run, ends: np.ndarray, exponents: int) -> None:
        self._run = run
        self._targets = (run.strobes + ends).astype(np.int64)
        n, q = len(run.x), len(run.system.quadratures)
        # logarithms of growth but for its last factors, and the product of these
        self._growth = np.full((2, len(ends), exponents), np.nan)
        self.integrals, self.states = np.full((len(ends), q), np.nan), np.full((len(ends), n), np.nan)
        # of the beginning of the record, too; rows of lost tangents are 0
        self._vectors = np.zeros((len(ends) + 1, exponents, n))
        self._exponent_of = np.zeros(self._vectors.shape[:2], dtype=np.int64)
        self._keep_vectors(0)
        self._done = np.zeros(1, dtype=np.int64)
        self._no_samples = np.zeros((0, len(run.x) + len(run.system.quadratures) + 1))
        self._no_events = np.zeros((0, EVENT_COLUMNS + 2 * len(run.x)))

    def sums(self) -> np.ndarray:
        """Logarithms of growth at the beginning and at the end of each block, -inf for what was lost; (B + 1, m)."""
        logs, grown = self._growth
        return np.concatenate([np.zeros_like(logs[:1]), logs + np.log(grown)])

    def sums_by_size(self, sizes: np.ndarray | None = None) -> np.ndarray:
        """The same of lengths in parts of the ``sizes`` of the states, those by now by default: `lengths_by_size`."""
        size = self._run.extents if sizes is None else sizes
        return self.sums() + lengths_by_size(self._vectors, self._exponent_of, size)

    def go_on(
        self,
        last: int,
        samples: np.ndarray | None = None,
        events: np.ndarray | None = None,
        *,
        drain: Callable[[], None] | None = None,
        report: Callable[[], None] | None = None,
    ) -> Outcome:
        """Continue until ``last`` blocks are done.

        ``samples``, ``events``: buffers as in `Run.advance`, the first with room for all samples. ``drain``: takes what
        is in the buffer of events, whenever it is full and at the end. ``report``: called now and then.
        """
        outcome, several = Outcome.OK, 1
        self._run.states.run["sample_rows"] = 0
        while self._done[0] < last and outcome == Outcome.OK:
            begin = perf_counter()
            outcome = self._call(min(self._done[0] + several, last), samples, events)
            several = min(several * 2, last) if perf_counter() - begin < HEARD else max(several // 2, 1)
            if drain:
                drain()
            if report:
                report()
        return outcome

    def _keep_vectors(self, k: int) -> None:
        live = min(self._run.live, self._vectors.shape[1])
        if self.states.size:
            self._vectors[k, :live] = self._run.vectors[:live]
            self._exponent_of[k, :live] = self._run.states.exponent_of[0, :live]

    def _call(self, last: int, samples: np.ndarray | None, events: np.ndarray | None) -> Outcome:
        run = self._run
        if run.refused != Outcome.OK:
            return run.refused
        run.settings["recording"] = 0 if samples is None else EVENLY
        run.states.run["event_rows"] = 0
        code = _through(
            run.flow,
            run.machine,
            last,
            self._targets,
            self._done,
            self._no_samples if samples is None else samples,
            self._no_events if events is None else events,
            self._growth,
            self.integrals,
            self.states,
            self._vectors,
            self._exponent_of,
        )
        return Outcome.OK if code in (DONE, FULL) else Outcome(code)


@compiled(
    int64(
        *(Pointer("Flow", FLOW_SIGNATURE), int64, int64, integers, integers),
        *(matrix, matrix, cube, matrix, matrix, cube, int64[:, ::1]),
    )
)
def _through(go_on, place, last, targets, done, samples, events, growth, integrals, states, vectors, exponent_of):
    """Continue the only run of a machine, which is given by its address, block by block, as ``flow`` does."""
    settings = machine_at(place).settings[0]
    state = state_of(machine_at(place).states, 0)
    for k in range(done[0], last):
        settings.target = targets[k]
        code = go_on(place, 0, samples, events)
        if code != DONE:
            return code
        for i in range(growth.shape[2]):
            growth[0, k, i] = -math.inf if state.lost[i] == 1 else state.logs[i]
            growth[1, k, i] = state.grown[i]
        for i in range(integrals.shape[1]):
            integrals[k, i] = state.sums[0, i] + state.sums[1, i]
        for i in range(states.shape[1]):
            states[k, i] = state.x[i]
        for i in range(min(vectors.shape[1], state.run[0].live)):
            exponent_of[k + 1, i] = state.exponent_of[i]
            for a in range(vectors.shape[2]):
                vectors[k + 1, i, a] = state.vectors[i, a]
        done[0] = k + 1
    return DONE
