"""Covariant Lyapunov vectors by a forward and a backward pass over the triangular factors of the tangent map.

Forward, tangents are orthonormalised, and of each it is kept of which tangents at the start of a block it was made.
Backward, coordinates of the vectors are carried from the end of a block to its start by these (Ginelli et al. 2007,
doi:10.1103/PhysRevLett.99.130601). A tangent that an event removes keeps its place: backward, its coordinate is that of
the direction that this event removes, and no other vector has a part in it, which is the choice of one vector from each
class that the event does not tell apart.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from chaosdrill.analysis.arguments import tangent_count
from chaosdrill.analysis.judgement.recurrence import powers_of_two
from chaosdrill.analysis.judgement.statistics import error_of_exponents, in_blocks
from chaosdrill.analysis.measures.finite_times import density
from chaosdrill.analysis.measures.spectra import computed_exponents
from chaosdrill.analysis.spans import SLICE, Span, check_record
from chaosdrill.analysis.tuning import COVARIANT, WINDOWS
from chaosdrill.codegen import kernels_of
from chaosdrill.codegen.kinds import Pointer, int64, void
from chaosdrill.codegen.signatures import cube, integer_matrix, integers, matrix
from chaosdrill.dataset import Outcome
from chaosdrill.dataset.build import dataset
from chaosdrill.engine.jit import compiled
from chaosdrill.engine.layout import DONE, EVENT_COLUMNS
from chaosdrill.engine.lengths import lengths_by_size, sizes_of_states
from chaosdrill.engine.records import FLOW_SIGNATURE, machine_at, state_of
from chaosdrill.engine.run import Run
from chaosdrill.engine.setup import scratch_of
from chaosdrill.engine.shifts import shifts_of
from chaosdrill.engine.stepper import machine
from chaosdrill.engine.structure import examine
from chaosdrill.engine.tangents import log_growth
from chaosdrill.errors import SettingsError
from chaosdrill.model import HybridSystem

if TYPE_CHECKING:
    from chaosdrill.analysis.base import Job


@dataclass(frozen=True)
class _Blocks:
    """How a record, and what leads into it and out of it, is divided."""

    plan: Span  # the record after the transient
    interval: float  # length of a block in time
    parts: int  # blocks in a forcing period; 0 without forcing
    strobes: int  # forcing periods in a block, 1 where it is part of one
    before: int  # blocks that lead into the record
    record: int
    behind: int

    @property
    def total(self) -> int:
        """All blocks."""
        return self.before + self.record + self.behind


class _Chunk(NamedTuple):
    """What is kept of some blocks of the forward pass: at their starts, but for the growth."""

    frames: np.ndarray  # (blocks, m, n): orthonormal tangents, rows are exponents
    shares: np.ndarray  # (blocks, m, m): at their ends, see `chaosdrill.engine.layout.States`
    logs: np.ndarray  # (blocks, m): logarithms of growth over each
    lost: np.ndarray  # (blocks + 1, m): whether a tangent was lost; last at the end
    states: np.ndarray  # (blocks, n + 1): states and mode

    @classmethod
    def empty(cls, blocks: int, m: int, n: int) -> "_Chunk":
        """Room for a number of blocks."""
        return cls(
            np.zeros((blocks, m, n)),
            np.zeros((blocks, m, m)),
            np.zeros((blocks, m)),
            np.zeros((blocks + 1, m), dtype=np.int64),
            np.zeros((blocks, n + 1)),
        )

    def parts(self) -> list[tuple[int, "_Chunk"]]:
        """Views of stretches of the blocks, with their first ones."""
        firsts = range(0, len(self.logs), SLICE)
        return [(k, _Chunk(*(rows[k : k + SLICE + (rows is self.lost)] for rows in self))) for k in firsts]


class _Found(NamedTuple):
    """What comes of the record, at the start of each block but for the growth."""

    vector: np.ndarray  # (record, n, count)
    growth: np.ndarray  # (record, count): rates over each
    lost: np.ndarray  # (record, count)
    angle: np.ndarray  # (record, count - 1)
    states: np.ndarray  # (record, n + 1)

    @classmethod
    def empty(cls, record: int, n: int, count: int) -> "_Found":
        """Nothing found yet."""
        shapes = ((record, n, count), (record, count), (record, count), (record, max(count - 1, 0)), (record, n + 1))
        return cls(*(np.full(shape, np.nan) for shape in shapes))


class _Forward:
    """The forward pass over all blocks; what it finds is kept of the last chunk alone, the others are run again."""

    def __init__(self, run: Run, blocks: _Blocks, sizes: np.ndarray, job: "Job") -> None:
        self.run, self.blocks, self.sizes = run, blocks, sizes
        m, n = run.vectors.shape
        self.size = min(blocks.total, max(1, COVARIANT.kept // (m * (m + n + 3) + n + 1)))
        self.starts = range(0, blocks.total, self.size)
        again = [first for first in self.starts[:-1] if first + self.size > blocks.before]
        self._report, self._done = job.report(blocks.total + len(again) * self.size), 0
        self._kept: dict[int, list[np.ndarray]] = {}
        self.sums = np.zeros((blocks.total, m))
        """Logarithms of growth from the first block to the start of each, lengths being taken in the states' sizes."""
        self.known = sizes
        """Sizes that states have had by the end, as those by which a spectrum has its errors."""
        self._total = np.zeros(m)
        self._last: _Chunk | None = None

    def go(self) -> Outcome:
        """Run over all blocks."""
        outcome, _ = self.run.advance(0)
        for first in self.starts:
            if outcome != Outcome.OK:
                break
            self._kept[first] = [one.copy() for one in self.run.states]
            outcome, chunk = self._over(first)
            for begin, part in chunk.parts():
                growth = np.where(part.lost[1:] == 1, -np.inf, part.logs)
                along = self._total + np.vstack([np.zeros_like(self._total), np.cumsum(growth, axis=0)])
                self.sums[first + begin :][: len(growth)] = along[:-1] + self._in_sizes(part.frames)
                self._total = along[-1]
            self._last = chunk
        self.known = sizes_of_states(self.run.extents, shifts_of(self.run.system, but_of=()))
        return outcome

    def _in_sizes(self, frames: np.ndarray) -> np.ndarray:
        """Logarithms of the independent parts of tangents, lengths being taken in the states' sizes; 0 of lost ones."""
        # blocks last, along which numpy's loops are long
        rows = np.ascontiguousarray(frames.transpose(1, 2, 0)) / self.sizes[:, np.newaxis]
        found = np.zeros((len(rows), len(frames)))
        for i, row in enumerate(rows):
            for before in (*rows[:i], *rows[:i]):
                row -= np.einsum("nb,nb->b", row, before) * before
            length = np.sqrt(np.einsum("nb,nb->b", row, row))
            length[length == 0.0] = 1.0
            row /= length
            found[i] = np.log(length)
        return found.T

    def back(self) -> Iterator[tuple[int, _Chunk]]:
        """Parts of the chunks that reach into the record or lie behind it, the last one first, and their places."""
        chunk, self._last = self._last, None
        for first in reversed(self.starts):
            if first + self.size <= self.blocks.before:
                return
            if chunk is None:
                for one, before in zip(self.run.states, self._kept[first], strict=True):
                    one[...] = before
                _, chunk = self._over(first)
            yield from ((first + begin, part) for begin, part in reversed(chunk.parts()))
            chunk = None

    def _over(self, first: int) -> tuple[Outcome, _Chunk]:
        """Go on over the blocks of a chunk."""
        run, blocks = self.run, self.blocks
        m, n = run.vectors.shape
        q = len(run.system.quadratures)
        chunk = _Chunk.empty(min(self.size, blocks.total - first), m, n)
        scratch = scratch_of(run.system, m, run.method)
        functions = kernels_of(run.system).functions
        place = machine(functions, run.method, run.settings, run.tables, run.states, scratch)
        samples, events = np.zeros((0, n + q + 1)), np.zeros((0, EVENT_COLUMNS + 2 * n))
        run.settings["target"] = run.strobes
        for begin, part in chunk.parts():
            counts = np.array([first + begin, blocks.parts, blocks.strobes])
            code = _keep_blocks(run.flow, place, samples, events, counts, *part)
            if code != DONE:
                return Outcome(code), chunk
            self._done += len(part.logs)
            if self._report:
                self._report(self._done)
        return Outcome.OK, chunk


def vectors(system: HybridSystem, given: Any, job: "Job") -> xr.Dataset:
    """Covariant vectors of a record; see `covariant_vectors`."""
    count, n = tangent_count(system, given.exponents), len(system.state_names)
    structure = examine(system)
    m = computed_exponents(structure, count)
    blocks = _divided(given.span(system, job.numerics), given)
    check_record(blocks.record, count * (n + 4) + n + 1, "periods, or a longer interval")
    lead = Run(system, blocks.plan.unit, job.numerics)
    outcome = blocks.plan.settle(lead)
    sizes = powers_of_two(lead.sizes)
    run = _with_tangents(lead, _orthonormal(structure.general(m) * sizes), structure.deficient, blocks, job)
    forward, found = _Forward(run, blocks, sizes, job), _Found.empty(blocks.record, n, count)
    if outcome == Outcome.OK:
        outcome = forward.go()
    complete = outcome == Outcome.OK
    if complete:
        _backward(forward, found)
    start = lead.elapsed + blocks.before * blocks.interval
    errors = _errors(forward, job)[:, :count] if complete else np.full_like(found.growth, np.nan)
    message = blocks.plan.message or run.stopped(outcome)
    over = ("time", "vector")
    means = _means(found, run, forward, job)
    return dataset(
        {
            "vector": (("time", "state", "vector"), found.vector * _signs(found.vector)),
            "vector_error": (over, errors),
            "local_growth": (over, found.growth),
            "lost": (over, (found.lost == 1).astype(np.int8)),
            "lyapunov_exponent": ("vector", means[0]),
            "lyapunov_error": ("vector", means[1]),
            "states": (("time", "state"), found.states[:, :n]),
            "mode": ("time", np.nan_to_num(found.states[:, n], nan=-1).astype(np.int8)),
            **_angles(found, given.bins),
            "outcome": ((), np.int8(outcome)),
            **({"forcing_period": ((), blocks.plan.unit)} if blocks.plan.periodic else {}),
            "interval": ((), blocks.interval),
            "time": start + np.arange(blocks.record) * blocks.interval,
            "state": list(system.state_names),
            "split": np.arange(1, found.angle.shape[1] + 1, dtype=np.int32),
        },
        attrs={"message": message} if message else {},
    )


def _backward(forward: _Forward, found: _Found) -> None:
    """Carry vectors back from the end, whatever they are there, and keep what they are in the record."""
    ahead, blocks = np.eye(forward.sums.shape[1]), forward.blocks
    for first, chunk in forward.back():
        coordinates, growth = np.zeros_like(chunk.shares), np.zeros_like(chunk.logs)
        _go_back(chunk.shares, chunk.logs, chunk.lost, ahead, coordinates, growth)
        _take(found, first - blocks.before, chunk, coordinates, growth / blocks.interval)


def _divided(plan: Span, given: Any) -> _Blocks:
    """The record, and what leads into it and out of it, in blocks of the interval between two vectors.

    Raises `SettingsError` for an interval that does not divide the record.
    """
    if plan.periodic:
        wanted = given.interval or math.ceil(plan.count / COVARIANT.most)
        parts, strobes = max(1, round(1 / wanted)), max(1, round(wanted))
        if given.interval is None:
            plan = replace(plan, count=plan.count - plan.count % strobes)
        if plan.count % strobes:
            raise SettingsError(
                f"interval is {wanted:g}, which does not divide the record of {plan.count} forcing periods; "
                "take periods that are a multiple of it"
            )
        unit, record, interval = plan.unit, plan.count * parts // strobes, plan.unit * strobes / parts
        usual = min(max(COVARIANT.lead * plan.count, COVARIANT.leads[0]), COVARIANT.leads[1])
    else:
        record = COVARIANT.parts if given.interval is None else max(1, round(plan.length / given.interval))
        unit = interval = plan.length / record
        plan, parts, strobes = replace(plan, unit=unit, count=record), 0, 1
        unit, usual = 1.0, COVARIANT.lead * record * interval
    before, behind = (
        math.ceil((usual if lead is None else lead) * unit / interval * (1 - 1e-12))
        for lead in (given.forward, given.backward)
    )
    return _Blocks(plan, interval, parts, strobes, before, record, behind)


def _orthonormal(rows: np.ndarray) -> np.ndarray:
    """Orthonormal rows of the same spans; by projections, which keep the digits of states in small units."""
    found = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    for i, row in enumerate(found):
        for before in (*found[:i], *found[:i]):
            row -= (before @ row) * before
        row /= np.linalg.norm(row)
    return found


def _with_tangents(lead: Run, frame: np.ndarray, deficient: Any, blocks: _Blocks, job: "Job") -> Run:
    """A run with tangents in general position that goes on from where another one stands, block by block."""
    run = Run(lead.system, lead.period, job.numerics, tangents=frame, with_shares=True, deficient=deficient)
    run.continue_from(lead)
    if blocks.parts == 0:
        run.begin_at(lead.elapsed)
    elif blocks.parts > 1:
        step = float(run.standing["fixed_step"])
        run.change_period(blocks.interval)
        run.fix_step(min(step, blocks.interval))
    return run


@compiled(
    int64(
        *(Pointer("Flow", FLOW_SIGNATURE), int64, matrix, matrix, integers),
        *(cube, cube, matrix, integer_matrix, matrix),
    )
)
def _keep_blocks(go_on, place, samples, events, counts, frames, shares, logs, lost, states):
    """Continue the only run of a machine block by block, as ``flow`` does, which is given by its address.

    ``counts`` are the number of the first block, blocks in a forcing period, and forcing periods in a block.
    """
    machine = machine_at(place)
    settings, state = machine.settings[0], state_of(machine.states, 0)
    run = state.run[0]
    blocks, m, n = frames.shape
    first, parts, strobes = counts[0], counts[1], counts[2]
    interval = run.period
    for k in range(blocks):
        states[k, n] = run.mode
        for a in range(n):
            states[k, a] = state.x[a]
        for i in range(m):
            lost[k, i] = state.lost[i]
            state.logs[i] = 0.0
            state.grown[i] = 1.0
            for j in range(m):
                state.shares[i, j] = 1.0 if i == j else 0.0
        for i in range(run.live):
            for a in range(n):
                frames[k, state.exponent_of[i], a] = state.vectors[i, a]
        if parts > 1:
            # the clock of the field restarts with every forcing period, but every part is one to the run
            run.origin = ((first + k) % parts) * interval
        settings.target += strobes
        code = go_on(place, 0, samples, events)
        if code != DONE:
            return code
        for i in range(m):
            logs[k, i] = log_growth(state, i)
            for j in range(m):
                shares[k, i, j] = state.shares[i, j]
    for i in range(m):
        lost[blocks, i] = state.lost[i]
    return DONE


@compiled(void(cube, matrix, integer_matrix, matrix, cube, matrix))
def _go_back(shares, logs, lost, ahead, coordinates, growth):
    """Carry the vectors from the end of some blocks to their start.

    ``ahead`` are their coordinates by the tangents at the end, one vector a row, and becomes those at the start;
    ``coordinates`` and the logarithms of ``growth`` are filled for each block. A vector whose tangent is lost by the
    end is that which the block removes.
    """
    blocks, m = logs.shape
    for b in range(blocks):
        k = blocks - 1 - b
        here = coordinates[k]
        for i in range(m):
            gone = lost[k + 1, i] == 1
            most = -math.inf
            for j in range(m):
                if ahead[i, j] != 0.0 and lost[k + 1, j] == 0:
                    most = max(most, logs[k, i] - logs[k, j])
            for c in range(m):
                here[i, c] = shares[k, i, c] if gone else 0.0
            for j in range(0 if gone else m):
                if ahead[i, j] != 0.0 and lost[k + 1, j] == 0:
                    part = ahead[i, j] * math.exp(logs[k, i] - logs[k, j] - most)
                    for c in range(m):
                        here[i, c] += part * shares[k, j, c]
            length = 0.0
            for c in range(m):
                length += here[i, c] * here[i, c]
            length = math.sqrt(length)
            for c in range(m):
                here[i, c] /= length
            growth[k, i] = -math.inf if gone else logs[k, i] - most - math.log(length)
        for i in range(m):
            for c in range(m):
                ahead[i, c] = here[i, c]


def _take(found: _Found, first: int, chunk: _Chunk, coordinates: np.ndarray, growth: np.ndarray) -> None:
    """Keep what the blocks of a chunk say of the record, in which the first of them has this number."""
    low, high = max(0, -first), min(len(growth), len(found.growth) - first)
    if low >= high:
        return
    to, of, count = slice(first + low, first + high), slice(low, high), found.growth.shape[1]
    coordinates, lost = coordinates[of, :count], chunk.lost[low:high, :count]
    found.vector[to] = (coordinates @ chunk.frames[of]).swapaxes(1, 2)
    found.growth[to], found.lost[to], found.states[to] = growth[of, :count], lost, chunk.states[of]
    found.angle[to] = between(coordinates, lost == 1)


def between(coordinates: np.ndarray, lost: np.ndarray) -> np.ndarray:
    """Smallest angles between the span of the first vectors, 1, 2 and so on, and that of the others.

    ``coordinates``, shape (K, count, m): of each vector in orthonormal directions, the first k of which span the first
    k vectors. ``lost``, bool, shape (K, count): vectors that are left out.

    Returns, shape (K, count - 1): in radians, from 0 to pi/2; NaN where one side has no vector.
    """
    angles = np.full((len(lost), max(lost.shape[1] - 1, 0)), np.nan)
    same = bool((lost == lost[:1]).all())
    for pattern in lost[:1] if same else np.unique(lost, axis=0):
        rows = slice(None) if same else (lost == pattern).all(axis=1)
        live, those = np.flatnonzero(~pattern), coordinates[rows]
        for first in range(1, len(live)):
            inside = live[:first]
            outside = np.setdiff1d(np.arange(coordinates.shape[2]), inside)
            if len(live) - first == 1:
                # the parts of a single vector on either side; small angles are known by their sines
                vector = those[:, live[first]]
                sine, cosine = (np.einsum("ki,ki->k", part, part) for part in (vector[:, outside], vector[:, inside]))
                found = np.arctan2(np.sqrt(sine), np.sqrt(cosine))
            else:
                basis = np.linalg.qr(those[:, live[first:]].swapaxes(1, 2))[0]
                along, across = basis[:, inside], basis[:, outside]
                back = along.swapaxes(1, 2)
                square = np.linalg.eigvalsh(along @ back if first < len(live) / 2 else back @ along)[:, -1]
                cosine = np.sqrt(np.clip(square, 0, 1))
                found = np.arccos(cosine)
                small = cosine > 0.8
                found[small] = np.arcsin(np.linalg.svd(across[small], compute_uv=False)[:, -1])
            angles[rows, live[first] - 1] = found
    return angles


def _signs(vector: np.ndarray) -> np.ndarray:
    """Signs that make the largest component of each vector positive where the record begins, shape (count,)."""
    largest = np.abs(vector[0]).argmax(axis=0)
    return np.where(np.take_along_axis(vector[0], largest[np.newaxis], axis=0)[0] < 0, -1.0, 1.0)


def _errors(forward: _Forward, job: "Job") -> np.ndarray:
    """What the start of the forward pass and the end of the backward one may still be of each vector, and the method.

    Parts of a faster direction die out backward, those of a slower one forward, as the ratio of their growths: of
    neighbours, which are the slowest to. Between the directions of a spiral either grows in turn, and none dies out: a
    difference of growths counts where it stays beyond those met soon after the start.
    """
    sums = forward.sums
    found = np.zeros_like(sums)
    live = np.flatnonzero(np.isfinite(sums[-1]))
    soon = (np.arange(len(sums)) * COVARIANT.beginning).astype(int)
    with np.errstate(invalid="ignore", over="ignore"):
        for one, other in pairwise(live):
            ahead = sums[:, one] - sums[:, other]
            most, least = np.maximum.accumulate(ahead), np.minimum.accumulate(ahead[::-1])[::-1]
            late = least[::-1][soon][::-1]
            found[:, one] += np.where(least > most[soon], np.exp(ahead[0] - ahead), 1.0)
            found[:, other] += np.where(late > most, np.exp(ahead - ahead[-1]), 1.0)
        # what an event removes is known from it
        for one in np.setdiff1d(np.arange(sums.shape[1] - 1), live):
            ahead = sums[:, one] - sums[:, one + 1]
            found[:, one] = np.exp(-np.where(np.isfinite(ahead), ahead, np.inf))
    found = np.minimum(found + job.numerics.global_error, 1.0)
    record = slice(forward.blocks.before, forward.blocks.before + forward.blocks.record)
    return np.where(np.isneginf(sums), 0.0, found)[record]


def _means(found: _Found, run: Run, forward: _Forward, job: "Job") -> tuple[np.ndarray, np.ndarray]:
    """Mean rates of growth and their errors, of lengths in the states' sizes as those of a spectrum."""
    means, errors, blocks = found.growth.mean(axis=0), np.full(found.growth.shape[1], np.nan), forward.blocks
    kept = np.isfinite(means)
    if kept.any():
        rates, each = in_blocks(found.growth[:, kept], WINDOWS.blocks), -(-blocks.record // WINDOWS.blocks)
        # of the end of the record no vectors are kept: lengths there count as those at the start of its last block
        ends = np.minimum(np.append(np.arange(len(rates) + 1) * each, blocks.record), blocks.record - 1)
        vectors = found.vector[ends][:, :, kept].swapaxes(1, 2)[..., np.newaxis, :]
        lengths = lengths_by_size(vectors, np.zeros(vectors.shape[:-1], dtype=int), forward.known)[..., 0]
        rates += np.diff(lengths[:-1], axis=0) / (each * blocks.interval)
        apart = np.abs(lengths[-1] - lengths[0]) / (blocks.record * blocks.interval)
        errors[kept] = error_of_exponents(rates, job.numerics, run.steps, blocks.total * blocks.interval, apart)
    return means, errors


def _angles(found: _Found, bins: int) -> dict[str, Any]:
    """The angles, the smallest of them, and their distributions."""
    splits = found.angle.shape[1]
    histogram, error = np.full((2, splits, bins), np.nan)
    smallest = np.full(splits, np.nan)
    for s in range(splits):
        known = found.angle[:, s][np.isfinite(found.angle[:, s])]
        if len(known):
            histogram[s], error[s], _ = density(known, bins, (0.0, np.pi / 2))
            smallest[s] = known.min()
    return {
        "angle": (("time", "split"), found.angle),
        "smallest_angle": ("split", smallest),
        "angle_histogram": (("split", "bin"), histogram),
        "angle_histogram_error": (("split", "bin"), error),
        "bin_centre": ("bin", (np.arange(bins) + 0.5) * (np.pi / 2 / bins)),
    }
