"""From which states the runs of a sweep start: given ones, random ones, or those of the neighbour along the sweep."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chaosdrill.model.regions import own_mode

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem


@dataclass(frozen=True)
class Seeds:
    """Initial states that every point of a sweep starts from."""

    starts: np.ndarray  # (S, n): states
    modes: np.ndarray  # int (S,): modes, untold where the region of the state at each point tells it
    names: tuple[str, ...]  # "fixed 1", ..., "random 1", ...


def make_seeds(system: "HybridSystem", seeds: Any, random: Any, *, needed: bool = True) -> Seeds:
    """The seeds of a sweep from its settings ``seeds`` and ``random``, as they are read.

    The random states do not depend on how many there are.

    ``system``: its own values are those of states that a seed does not name. ``needed``: whether the system's own
    initial state is taken where neither is given.

    Raises `SettingsError` for a seed that cannot be used.
    """
    fixed = [] if seeds is None and (random is not None or not needed) else [{}] if seeds is None else seeds
    drawn = [] if random is None else draw(system, random)
    systems = [system.with_initial(**values) for values in (*fixed, *drawn)]
    names = [f"{kind} {k}" for kind, some in (("fixed", fixed), ("random", drawn)) for k in range(1, len(some) + 1)]
    starts = np.array([s.initial_values for s in systems])
    return Seeds(
        starts=starts.reshape(len(systems), len(system.state_names)),
        modes=np.array([own_mode(s) for s in systems], dtype=np.int64),
        names=tuple(names),
    )


def draw(system: "HybridSystem", box: dict[str, Any]) -> list[dict[str, Any]]:
    """Random initial values by name, each set from a stream of its own, in the order of the box's names."""
    mode = {"mode": box["mode"]} if "mode" in box else {}
    ranges = {name: ends for name, ends in box.items() if name in system.state_names}
    values = []
    for seed in range(box["count"]):
        generator = np.random.Generator(np.random.Philox(np.random.SeedSequence(box["seed"], spawn_key=(seed,))))
        drawn = generator.random(len(ranges))
        inside = {
            name: float(low + u * (high - low)) for (name, (low, high)), u in zip(ranges.items(), drawn, strict=True)
        }
        values.append(mode | inside)
    return values
