"""Attractors and the shares of their basins along a parameter: found at every value, carried to the neighbouring ones.

Fresh starts find attractors at every value. Each is then carried to both neighbours, and what it leads to there that no
start had found is carried on, until nothing new appears. Attractors at two neighbouring values are one if the motion
goes from the first to the second and from there back to the first. Nothing is compared across values, so that no
distance has to be chosen.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from chaosdrill.analysis.base import Job
from chaosdrill.analysis.grids.carried import ShareTask, StepTask, joined, on_the_map, part
from chaosdrill.analysis.grids.matching import number_attractors
from chaosdrill.analysis.grids.measuring import Arrays
from chaosdrill.analysis.grids.plan import Plan, make_plan
from chaosdrill.analysis.grids.points import Axis
from chaosdrill.analysis.grids.visits import merge
from chaosdrill.analysis.seeds import make_seeds
from chaosdrill.analysis.starts import any_ran, share_of, states_and_modes
from chaosdrill.analysis.tuning import ATTRACTORS
from chaosdrill.dataset import count_outcomes
from chaosdrill.dataset.branches import AttractorEnd
from chaosdrill.dataset.build import dataset
from chaosdrill.dataset.schema import names_of_rate
from chaosdrill.engine.period import forcing_periods
from chaosdrill.model import HybridSystem
from chaosdrill.sweep import execute

NEITHER = -1
"""In place of the attractor to which a motion leads: none that was recognised."""

_UP, _DOWN = 1, -1
_EXPONENTS = ("lyapunov_exponent", "lyapunov_error")


class Node(NamedTuple):
    """An attractor at a value: places of both."""

    value: int
    slot: int


@dataclass
class Search:
    """All attractors that are known at every value, and where the motion on them leads."""

    plan: Plan
    axis: Axis
    keeps: tuple[str, ...]
    job: Job
    known: list[Arrays]  # for every value what is kept of its attractors
    progress: "Told"
    leads: dict[tuple[Node, int], int] = field(default_factory=dict)
    """To which attractor of the neighbouring value, up or down, a motion leads."""
    rounds: int = 0

    def nodes(self) -> list[Node]:
        """All attractors at all values."""
        return [Node(value, slot) for value, one in enumerate(self.known) for slot in range(len(one["outcome"]))]

    def follow(self) -> None:
        """Carry all attractors to the neighbouring values, until nothing new appears there."""
        while todo := [
            (node, way)
            for node in self.nodes()
            for way in (_UP, _DOWN)
            if 0 <= node.value + way < len(self.known) and (node, way) not in self.leads
        ]:
            for (node, way), slot in zip(todo, self._carry(todo, grows=True), strict=True):
                self.leads[node, way] = slot

    def split(self, several: Iterable[tuple[Node, int]]) -> set[tuple[Node, int]]:
        """Which attractors lead to different ones at the neighbouring value, from different stretches of them."""
        asked = sorted(several)
        n = len(self.plan.system.state_names)
        of_state = np.repeat(np.arange(min(n, ATTRACTORS.most_probed)), ATTRACTORS.probes)
        beside = np.zeros((len(of_state), n))
        beside[np.arange(len(of_state)), of_state] = ATTRACTORS.probed * np.resize([1.0, -1.0], len(of_state))
        every = max(self.plan.transient, self.plan.periods // ATTRACTORS.probes, 1)
        ahead = np.resize(every * np.arange(1, ATTRACTORS.probes + 1), len(of_state))
        probes = [one for one in asked for _ in of_state]
        slots = self._carry(probes, np.tile(ahead, len(asked)), np.tile(beside, (len(asked), 1)))
        found: dict[tuple[Node, int], set[int]] = defaultdict(set)
        for one, slot in zip(probes, slots, strict=True):
            if slot != NEITHER:
                found[one].add(slot)
        sources: dict[tuple[Node, int], set[int]] = defaultdict(set)
        for (node, way), slot in self.leads.items():
            sources[Node(node.value + way, slot), -way].add(node.slot)
        return {one for one in asked if len(found[one] & sources[one]) > 1}

    def _carry(
        self,
        steps: list[tuple[Node, int]],
        ahead: np.ndarray | None = None,
        beside: np.ndarray | None = None,
        *,
        grows: bool = False,
    ) -> list[int]:
        """Attractors, by slot, to which motions lead at the next value up or down; new ones if the table may grow."""
        if not steps:
            return []
        self.rounds += 1
        origins = np.array([node.value for node, _ in steps])
        task = StepTask(
            self.plan,
            self.axis,
            self.keeps,
            origins,
            origins + np.array([way for _, way in steps]),
            joined([part(self.known[node.value], slice(node.slot, node.slot + 1)) for node, _ in steps]),
            np.zeros(len(steps), dtype=np.int64) if ahead is None else ahead,
            np.zeros((len(steps), len(self.plan.system.state_names))) if beside is None else beside,
        )
        found = self.progress.execute(task, self.job, f"round-{self.rounds}")
        slots = np.full(len(steps), NEITHER)
        for target in np.unique(task.targets).tolist():
            rows = np.flatnonzero(task.targets == target)
            slots[rows] = self._recognise(target, part(found, rows), grows)
        return list(map(int, slots))

    def _recognise(self, value: int, found: Arrays, grows: bool) -> np.ndarray:
        """On which attractors of a value some runs are."""
        known = self.known[value]
        count = len(known["outcome"])
        every = joined([known, found])
        numbers, leaders = number_attractors(every)
        if len(leaders) > 1 and (numbers[count:] > 0).any() and (leaders >= count).any():
            parameters = {self.axis.name: np.full(len(every["outcome"]), self.axis.values[value])}

            def begin(plan: Plan, which: np.ndarray) -> Any:
                rows = leaders[which]
                return on_the_map(plan, part(parameters, rows), part(every, rows))

            numbers, leaders = merge(self.plan, every, numbers, leaders, begin)
        slots = np.full(len(found["outcome"]), NEITHER)
        place = {int(number): slot for slot, number in reversed(list(enumerate(numbers[:count]))) if number}
        for row, number in enumerate(numbers[count:].tolist()):
            if number and number not in place and grows and len(known["outcome"]) < ATTRACTORS.carried_most:
                place[number] = len(known["outcome"])
                self.known[value] = known = joined([known, part(found, slice(row, row + 1))])
            slots[row] = place.get(number, NEITHER)
        return slots


@dataclass
class Told:
    """What has been done of all tasks, for one listener."""

    job: Job
    done: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)

    def execute(self, task: Any, job: Job, folder: str) -> Arrays:
        """Run one task more; its chunks are kept in a folder of their own."""
        before, earlier = self.done, Counter(self.outcomes)

        def tell(done: int, total: int, outcomes: Any) -> None:
            assert job.progress is not None
            job.progress(before + done, before + total, dict(earlier + Counter(outcomes)))

        found = execute(
            task,
            workers=job.workers,
            scheduler=job.scheduler,
            store=None if job.store is None else Path(job.store) / folder,
            progress=None if job.progress is None else tell,
        )
        self.done += task.total
        self.outcomes.update(count_outcomes(found["outcome"]))
        return found


@dataclass(frozen=True)
class Branch:
    """An attractor along the parameter."""

    nodes: tuple[Node, ...]  # at neighbouring values, upwards
    below: AttractorEnd
    above: AttractorEnd
    beyond: tuple[Node | None, ...]  # to what the motion leads below and above; None: to nothing, or to several


def branches_of(search: Search) -> list[Branch]:
    """Attractors along the parameter."""
    leads = search.leads
    several = Counter((Node(node.value + way, slot), -way) for (node, way), slot in leads.items() if slot != NEITHER)
    split = search.split(one for one, count in several.items() if count > 1)

    def next_of(node: Node, way: int) -> Node | None:
        slot = leads.get((node, way), NEITHER)
        return None if slot == NEITHER else Node(node.value + way, slot)

    def follows(node: Node, way: int) -> Node | None:
        other = next_of(node, way)
        if other is None or (node, way) in split or (other, -way) in split or next_of(other, -way) != node:
            return None
        return other

    def end(node: Node, way: int) -> AttractorEnd:
        if (node, way) not in leads:
            return AttractorEnd.LIMIT
        other = next_of(node, way)
        if (node, way) in split:
            return AttractorEnd.SPLIT
        if other is None:
            return AttractorEnd.LOST
        return AttractorEnd.MERGER if (other, -way) in split else AttractorEnd.JUMP

    found = []
    for node in search.nodes():
        if follows(node, _DOWN) is not None:
            continue
        nodes = [node]
        while (other := follows(nodes[-1], _UP)) is not None:
            nodes.append(other)
        ways = (node, _DOWN), (nodes[-1], _UP)
        beyond = tuple(None if one in split else next_of(*one) for one in ways)
        below, above = (end(*one) for one in ways)
        found.append(Branch(tuple(nodes), below, above, beyond))
    return found


def over_one_parameter(system: HybridSystem, given: Any, job: Job) -> xr.Dataset:
    """Attractors and the shares of their basins along a parameter; see `chaosdrill.attractors`."""
    return followed(system, given, job, *_starts(system, given))


def followed(system: HybridSystem, given: Any, job: Job, starts: np.ndarray, modes: np.ndarray) -> xr.Dataset:
    """Attractors along the parameter of ``given.sweep`` and to which of them each start leads, states (N, n)."""
    ((name, values),) = given.sweep.items()
    order = np.argsort(values, kind="stable")
    axis = Axis(name, values[order])
    plan = make_plan(system, given, job.numerics, swept=(name,))
    rates = {one: other for q in system.quadratures for one, other in _rate_names(str(q))}
    keeps = ("period", "outcome", *_EXPONENTS, "moments", "state", *rates)
    told = Told(job)
    fresh = told.execute(ShareTask(plan, axis, keeps, starts, modes), job, "starts")
    of_attractors = {key.removeprefix("of_"): found for key, found in fresh.items() if key.startswith("of_")}
    counts = fresh["reached"].max(axis=1)
    known = [
        {key: np.array(found[v, :count]) for key, found in of_attractors.items()} for v, count in enumerate(counts)
    ]
    search = Search(plan, axis, keeps, job, known, told)
    search.follow()
    hits = np.array([np.bincount(reached, minlength=ATTRACTORS.carried_most + 1) for reached in fresh["reached"]])
    branches = sorted(branches_of(search), key=partial(_rank, search, hits))[: ATTRACTORS.most_numbered]
    number = {node: k for k, branch in enumerate(branches, 1) for node in branch.nodes}

    at, per = np.argsort(order), (name, "attractor")
    columns = _columns(search, number, len(branches), rates)
    share, error = np.zeros((2, len(values), len(branches)))
    error[:] = np.nan
    reached = np.zeros_like(fresh["reached"])
    for (v, slot), k in number.items():
        share[v, k - 1], error[v, k - 1] = share_of(hits[v, slot + 1], len(starts))
        reached[v][fresh["reached"][v] == slot + 1] = k
    none, none_error = share_of((reached == 0).sum(axis=1), len(starts))
    for one in (share, error, none, none_error):
        one[~any_ran(fresh["outcome"])] = np.nan
    variables: dict[str, Any] = {
        "fraction": (per, share[at]),
        "fraction_error": (per, error[at]),
        "fraction_none": (name, none[at]),
        "fraction_none_error": (name, none_error[at]),
        **{key: ((*per, *dims), found[at]) for key, (dims, found) in columns.items()},
        **{key: ("attractor", found) for key, found in _ends(axis, branches, number).items()},
        "reached": ((name, "run"), reached[at]),
        "outcome": ((name, "run"), fresh["outcome"][at]),
        "initial_state": (("run", "state"), starts),
        "initial_mode": ("run", modes.astype(np.int8)),
    }
    if system.forced:
        variables["forcing_period"] = (name, forcing_periods(system, {name: values}, len(values)))
    coords: dict[str, Any] = {
        name: values,
        "attractor": np.arange(1, len(branches) + 1, dtype=np.int32),
        "run": np.arange(1, len(starts) + 1, dtype=np.int32),
        "state": list(system.state_names),
    }
    if plan.exponents:
        coords["exponent"] = np.arange(1, plan.exponents + 1, dtype=np.int32)
    return dataset(variables | coords, coords)


def _columns(
    search: Search, number: dict[Node, int], count: int, rates: dict[str, str]
) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """What is known of the attractors at every value, by the names in the dataset, with the further dimensions."""
    names: dict[str, tuple[str, tuple[str, ...], Any]] = {
        "period": ("attractor_period", (), 0),
        "outcome": ("attractor_outcome", (), -1),
        "state": ("attractor_state", ("state",), np.nan),
        **{key: (name, (), np.nan) for key, name in rates.items()},
    }
    if search.plan.exponents:
        of_exponents = zip(_EXPONENTS, ("attractor_exponent", "attractor_error"), strict=True)
        names |= {key: (name, ("exponent",), np.nan) for key, name in of_exponents}
    found = {}
    for key, (name, dims, nothing) in names.items():
        one = search.known[0][key]
        values = np.full((len(search.known), count, *one.shape[1:]), nothing, one.dtype)
        for (v, slot), k in number.items():
            values[v, k - 1] = search.known[v][key][slot]
        found[name] = (dims, values)
    return found


def _ends(axis: Axis, branches: list[Branch], number: dict[Node, int]) -> dict[str, np.ndarray]:
    """Where attractors begin and end, and what becomes of the motion there."""
    ends = {
        "first_value": np.array([axis.values[branch.nodes[0].value] for branch in branches], dtype=float),
        "last_value": np.array([axis.values[branch.nodes[-1].value] for branch in branches], dtype=float),
        "end_below": np.array([branch.below for branch in branches], dtype=np.int8),
        "end_above": np.array([branch.above for branch in branches], dtype=np.int8),
    }
    for i, side in enumerate(("below", "above")):
        beyond = (branch.beyond[i] for branch in branches)
        following = [0 if node is None else number.get(node, 0) for node in beyond]
        ends[f"next_{side}"] = np.array(following, dtype=np.int32)
    return ends


def _rate_names(quadrature: str) -> list[tuple[str, str]]:
    return list(zip(names_of_rate(quadrature), names_of_rate(quadrature, "attractor"), strict=True))


def _starts(system: HybridSystem, given: Any) -> tuple[np.ndarray, np.ndarray]:
    """Initial states and modes, those that are listed before those that are drawn."""
    parts = []
    if given.initial is not None:
        parts.append(states_and_modes(system, given.initial, settled=False))
    if given.random is not None:
        drawn = make_seeds(system, None, given.random)
        parts.append((drawn.starts, drawn.modes))
    states, modes = zip(*parts, strict=True)
    return np.concatenate(states), np.concatenate(modes)


def _rank(search: Search, hits: np.ndarray, branch: Branch) -> tuple[Any, ...]:
    """By the sum of the shares, then by where it begins and lies."""
    total = sum(int(hits[v, slot + 1]) for v, slot in branch.nodes)
    first = branch.nodes[0]
    state = search.known[first.value]["state"][first.slot]
    return (-total, first.value, tuple(np.nan_to_num(state).tolist()))
