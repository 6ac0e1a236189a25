"""From which states the runs of a sweep start: given ones, random ones, or those of the neighbour along the sweep."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.analysis.arguments import real, whole
from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

MOST_SEEDS = 10_000

FOLLOW = {"forward": ("forward",), "backward": ("backward",), "both": ("forward", "backward")}
"""Directions in which a state can be followed along a sweep, by the word that asks for them."""


@dataclass(frozen=True)
class Seeds:
    """Initial states that every point of a sweep starts from.

    Attributes
    ----------
    starts : ndarray, shape (S, n)
        States.
    modes : ndarray of int, shape (S,)
        Modes.
    names : tuple of str
        ``fixed 1``, ..., ``random 1``, ...
    settings : dict
        The arguments as provenance keeps them.
    """

    starts: np.ndarray
    modes: np.ndarray
    names: tuple[str, ...]
    settings: dict[str, Any]


def make_seeds(system: "HybridSystem", seeds: Any, random: Any, *, needed: bool = True) -> Seeds:
    """Check the seeds of a sweep.

    Parameters
    ----------
    system : HybridSystem
    seeds : sequence of mappings, optional
        Initial values (and ``mode``) of each fixed seed; what one does not name is the system's own.
    random : mapping, optional
        ``{"count": 4, "seed": 1, "y": (-1, 1)}``: so many states, each drawn evenly from the box of the states named,
        by a generator that is given the number ``seed``. The states do not depend on how many there are.
    needed : bool
        Whether the system's own initial state is taken where neither is given.

    Raises
    ------
    SettingsError
        An argument that cannot be used.
    """
    fixed = [] if seeds is None and (random is not None or not needed) else seed_values(seeds)
    drawn = [] if random is None else random_values(system, random)
    systems = [system.with_initial(**values) for values in (*fixed, *drawn)]
    names = [f"{kind} {k}" for kind, some in (("fixed", fixed), ("random", drawn)) for k in range(1, len(some) + 1)]
    starts = np.array([[s.initial[x] for x in system.state_names] for s in systems], dtype=float)
    return Seeds(
        starts=starts.reshape(len(systems), len(system.state_names)),
        modes=np.array([system.mode_names.index(s.initial["mode"]) for s in systems], dtype=np.int64),
        names=tuple(names),
        settings={
            "seeds": None if seeds is None else fixed,
            "random": None if random is None else {str(key): value for key, value in random.items()},
        },
    )


def seed_values(seeds: Any) -> list[dict[str, Any]]:
    """The initial values of each seed by name, checked; without seeds, one that changes none."""
    if seeds is None:
        return [{}]
    listed = [] if isinstance(seeds, str | Mapping) or not isinstance(seeds, Iterable) else list(seeds)
    if not listed and isinstance(seeds, Sequence) and not isinstance(seeds, str):
        raise SettingsError("seeds is empty; give at least one initial state, or leave seeds out")
    if not listed or not all(isinstance(seed, Mapping) for seed in listed):
        raise SettingsError(f"seeds is {seeds!r}; it must be a list of initial values, as in [{{'x': 0.1}}]")
    return [{str(key): value for key, value in seed.items()} for seed in listed]


def random_values(system: "HybridSystem", random: Any) -> list[dict[str, Any]]:
    """Random initial values by name, each state drawn with a stream of its own."""
    example = {"count": 4, "seed": 1, system.state_names[0]: (-1, 1)}
    if not isinstance(random, Mapping):
        raise SettingsError(f"random is {random!r}; it must be a mapping, as in {example}")
    given = {str(key): value for key, value in random.items()}
    missing = [key for key in ("count", "seed") if key not in given]
    if missing:
        raise SettingsError(f"random lacks {missing[0]!r}; give it as in {example}")
    count = whole("random: count", given.pop("count"), 1)
    if count > MOST_SEEDS:
        raise SettingsError(f"random: count is {count}; at most {MOST_SEEDS} random seeds can be drawn")
    number = whole("random: seed", given.pop("seed"), 0)
    mode = {"mode": given.pop("mode")} if "mode" in given else {}
    box = {}
    for name, bounds in given.items():
        if name not in system.state_names:
            raise SettingsError(f"random names {name!r}; expected count, seed, mode or one of {system.state_names}")
        pair = [real(bound) for bound in bounds] if isinstance(bounds, Sequence | np.ndarray) else []
        if isinstance(bounds, str) or len(pair) != 2 or not np.isfinite(pair).all() or pair[0] >= pair[1]:
            raise SettingsError(f"random: {name} is {bounds!r}; it must be a pair of numbers (low, high), low < high")
        box[name] = pair
    if not box:
        raise SettingsError(f"random names no state; give the range of at least one, as in {example}")
    values = []
    for seed in range(count):
        generator = np.random.Generator(np.random.Philox(np.random.SeedSequence(number, spawn_key=(seed,))))
        drawn = generator.random(len(system.state_names))
        inside = {
            name: float(box[name][0] + u * (box[name][1] - box[name][0]))
            for name, u in zip(system.state_names, drawn, strict=True)
            if name in box
        }
        values.append(mode | inside)
    return values


def directions(follow: Any) -> tuple[str, ...]:
    """Directions in which the last state is followed along the sweep."""
    if follow is None:
        return ()
    if not isinstance(follow, str) or follow not in FOLLOW:
        raise SettingsError(f"follow is {follow!r}; expected one of {sorted(FOLLOW)}, or leave it out")
    return FOLLOW[follow]
