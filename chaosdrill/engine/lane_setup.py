"""The arrays that lanes are stepped in."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.engine import layout as at
from chaosdrill.engine.lane_events import DEGREE
from chaosdrill.engine.lane_flow import ACTIVE
from chaosdrill.engine.lanes import LANES, aligned

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem


def block(system: "HybridSystem", m: int, constants: np.ndarray) -> tuple[np.ndarray, ...]:
    """Arrays of a block of lanes for a system with m tangents, in the order of ``engine.layout``.

    Parameters
    ----------
    system : HybridSystem
    m : int
        Number of tangents.
    constants : ndarray, shape (constants,)
        Those of one point; what varies from point to point is filled in later.
    """
    n, q, guards = len(system.states), len(system.quadratures), system.kernels.mode_table.shape[1]
    in_lanes = aligned(len(constants), LANES)
    in_lanes[:] = constants[:, np.newaxis]
    rows = system.kernels.rows + (m + m % 2) * n
    return (
        aligned(LANES), in_lanes, aligned(n, LANES), aligned(m, n, LANES), aligned(rows, at.COLUMNS, LANES),
        aligned(LANES), aligned(LANES), aligned(3, LANES), aligned(LANES), aligned(n + q, LANES), aligned(LANES),
        aligned(2 * guards, LANES), aligned(guards, LANES), aligned(guards, LANES), aligned(at.COLUMNS, LANES),
        aligned(DEGREE + 2, LANES), aligned(4, LANES),
    )  # fmt: skip


def bookkeeping(system: "HybridSystem", m: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Queues, results and plan of ``lane_flow`` for a system with m tangents."""
    guards = system.kernels.mode_table.shape[1]
    return (
        np.zeros((len(system.modes) * (m + 1), 2 + ACTIVE), dtype=np.int64),
        np.zeros((LANES + 1, LANES), dtype=np.int64),
        np.zeros((2 * guards, LANES), dtype=np.int64),
    )
