"""The path of an orbit, as points so close that straight lines between them show it."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine import shooting as at
from chaosdrill.orbits.tuning import TUNING

if TYPE_CHECKING:
    from chaosdrill.orbits.orbit import Orbit
    from chaosdrill.orbits.problem import Problem


def path(problem: "Problem", orbit: "Orbit") -> tuple[np.ndarray, np.ndarray]:
    """Points of one period from its first strobe on, as close as a straight line between neighbours needs.

    Each is met by the dense output of the segment that it lies on, so that an unstable orbit is not left. Halves are
    taken until the middle of every stretch is within ``TUNING.chord`` of its chord, in parts of each state's extent, or
    as near as states are known.

    Returns: ``times``, shape (m,): since the first strobe; both sides of an event have one time. ``states``, shape (m,
    d).
    """
    strobe, begin = problem.first_strobe(orbit), 0.0
    grids, segments = [], list(problem.segment_by_segment(orbit))
    for one, _ in segments:
        length = float(one.durations[0])
        grid = np.linspace(0.0, length, TUNING.path_parts + 1)
        if begin < strobe < begin + length:
            grid = np.union1d(grid, strobe - begin)
        grids.append(grid)
        begin += length
    pieces = [problem.at([one], grid[np.newaxis])[0][0] for (one, _), grid in zip(segments, grids, strict=True)]
    whole = np.concatenate(pieces)
    # what rests moves by rounding alone
    allowed = np.maximum(TUNING.chord * np.ptp(whole, axis=0), problem.solved_to(whole))
    begin, times, states, jumps = 0.0, [], [], []
    for (one, _), grid, piece in zip(segments, grids, pieces, strict=True):
        grid, piece = _refined(problem, one, grid, piece, allowed)
        times.append(begin + grid)
        states.append(piece)
        jumps.append(one.segments[0, at.SEGMENT_END] >= 0)
        begin += float(one.durations[0])
    # where no event lies between two segments the end of one is the start of the next
    jumps[-1] |= not strobe
    kept = np.concatenate([np.arange(len(one)) < len(one) - (not jump) for one, jump in zip(times, jumps, strict=True)])
    clock, found = np.concatenate(times)[kept], np.concatenate(states)[kept]
    first = int(np.flatnonzero(np.abs(clock - strobe) <= TUNING.same_instant * begin)[-1]) if strobe else 0
    last = first + 1 if strobe or orbit.segments[-1, at.SEGMENT_END] >= 0 else 0
    clock = np.concatenate([clock[first:], clock[:last] + begin]) - strobe
    again = found[:last] if orbit.drift is None else found[:last] + orbit.drift
    return clock, np.concatenate([found[first:], again])


def _refined(
    problem: "Problem", one: "Orbit", grid: np.ndarray, states: np.ndarray, allowed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """More points of a segment, where straight lines between those that there are do not show it."""
    bent = np.ones(len(grid) - 1, dtype=bool)
    for _ in range(TUNING.path_halvings):
        places = np.flatnonzero(bent)
        middles = (grid[places] + grid[places + 1]) / 2
        found = problem.at([one], middles[np.newaxis])[0][0]
        off = (np.abs(found - (states[places] + states[places + 1]) / 2) > allowed).any(axis=1)
        bent = np.zeros(len(grid) + len(middles) - 1, dtype=bool)
        new = places + np.arange(len(places))
        bent[new], bent[new + 1] = off, off
        grid, states = np.insert(grid, places + 1, middles), np.insert(states, places + 1, found, axis=0)
        if not off.any():
            break
    return grid, states
