"""The arrays that lanes are stepped in."""

from typing import TYPE_CHECKING

import numpy as np

from chaosdrill.codegen import kernels_of
from chaosdrill.engine import layout as at
from chaosdrill.engine.lane_events import BERNSTEIN
from chaosdrill.engine.lanes import LANES, aligned
from chaosdrill.engine.tuning import LANE

if TYPE_CHECKING:
    from chaosdrill.model.system import HybridSystem


def block(system: "HybridSystem", m: int, constants: np.ndarray) -> at.Block:
    """Arrays of a block of lanes for a system with m tangents.

    Parameters
    ----------
    system : HybridSystem
    m : int
        Number of tangents.
    constants : ndarray, shape (constants,)
        Those of one point; what varies from point to point is filled in later.
    """
    n, q, guards = len(system.state_names), len(system.quadratures), kernels_of(system).key_table.shape[1]
    in_lanes = aligned(len(constants), LANES)
    in_lanes[:] = constants[:, np.newaxis]
    rows = kernels_of(system).rows + (m + m % 2) * n
    # one more column than is used: of rows whose length is a power of two, few would find room in the cache together
    columns = at.COLUMNS + 1
    return at.Block(
        t=aligned(LANES),
        c=in_lanes,
        x=aligned(n, LANES),
        v=aligned(m, n, LANES),
        ws=aligned(rows, columns, LANES),
        scale=aligned(n, LANES),
        weights=aligned(n, LANES),
        metric=aligned(n, LANES),
        h=aligned(LANES),
        reach=aligned(LANES),
        gap=aligned(3, LANES),
        out=aligned(n + q, LANES),
        period=aligned(LANES),
        scaled=aligned(guards, at.COLUMNS, LANES),
        total=aligned(guards, LANES),
        later=aligned(guards, LANES),
        wanted=aligned(guards, LANES),
        alone=aligned(LANES),
        which=aligned(LANES),
        sign=aligned(guards, LANES),
        shift=aligned(guards, LANES),
        times=aligned(guards, LANES),
        backs=aligned(guards, LANES),
        polynomial=aligned(at.COLUMNS, LANES),
        bernstein=aligned(BERNSTEIN, LANES),
    )


def room(system: "HybridSystem", m: int, constants: np.ndarray, row: np.ndarray, spare: np.ndarray) -> at.LaneRoom:
    """What ``lane_flow`` works in for a system with m tangents; see `block` and `chaosdrill.engine.layout.LaneRoom`."""
    return at.LaneRoom(
        queues=np.zeros((len(system.modes) * (m + 1), 2 + LANE.active), dtype=np.int64),
        ends=np.zeros((LANES + 1, LANES), dtype=np.int64),
        row=row,
        spare=spare,
        block=block(system, m, constants),
    )
