"""Lengths of tangents that no unit changes: in parts of the sizes of the states."""

import math
from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine.tuning import TANGENTS

if TYPE_CHECKING:
    from chaosdrill.engine.shifts import Shifts


def extents(extent: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Sizes of states by their largest values at strobes, which no step changes; where these show next to nothing of a
    state by its ``scale``, which depends on the steps of a method."""
    return np.where(extent >= TANGENTS.shown * scale, extent, np.fmax(extent, scale))


def sizes_of_states(sizes: np.ndarray, shifts: "Shifts") -> np.ndarray:
    """Sizes of states, shape (..., n); an angle has that of its circle, however often it has turned."""
    for turn in shifts.turns:
        sizes = np.where(turn != 0, np.abs(turn) / (2 * np.pi), sizes)
    return sizes


def lengths_by_size(vectors: np.ndarray, exponent_of: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Logarithms of the lengths of tangents in parts of sizes, each of what the tangents before it do not span.

    In others states of different units are added, so that what has grown depends on the units by as much as they
    differ, and a length may fall at certain ends of blocks: that of the flow at the apex of a flight, where nothing but
    the speed changes.

    ``vectors``, shape (..., B, m, n), are tangents at B ends of blocks, in the order in which they were
    orthonormalised, 0 behind the last; ``exponent_of``, shape (..., B, m), their exponents; ``sizes``, shape (..., n),
    those of the states, 0 or infinite where not known. The result, shape (..., B, m), is by exponents, 0 of those that
    have no tangent.
    """
    known = (sizes > 0) & (sizes < math.inf)
    # all by one factor, which differences do not see: states may have decayed to 1e-300
    largest = sizes.max(axis=-1, keepdims=True, initial=0.0, where=known)
    of_largest = sizes / np.where(largest > 0, largest, 1.0)
    parts = np.where(known, np.maximum(of_largest, TANGENTS.finest), 1.0)
    scaled, found = vectors / parts[..., np.newaxis, np.newaxis, :], np.zeros(vectors.shape[:-1])
    for i in range(scaled.shape[-2]):
        row = scaled[..., i, :]
        for j in range(i):
            row -= np.einsum("...n,...n->...", row, scaled[..., j, :])[..., np.newaxis] * scaled[..., j, :]
        length = np.sqrt(np.einsum("...n,...n->...", row, row))
        length[~(length > 0)] = 1.0
        row /= length[..., np.newaxis]
        place = exponent_of[..., i, np.newaxis]
        here = np.maximum(place, 0)
        added = np.take_along_axis(found, here, -1) + np.where(place >= 0, np.log(length)[..., np.newaxis], 0.0)
        np.put_along_axis(found, here, added, -1)
    return found
