"""The last section points of a run, kept in a ring."""

from chaosdrill.engine.jit import inner


@inner
def keep(row, first, n, mode, window, taken):
    """Put a state and its mode into the ring, in the place of the oldest if it is full."""
    place = window[taken % window.shape[0]]
    for i in range(n):
        place[i] = row[first + i]
    place[n] = mode


@inner
def bring_in_order(window, taken, spare):
    """Turn the ring so that the oldest point comes first."""
    size = window.shape[0]
    if taken <= size:
        return
    for k in range(size):
        for i in range(window.shape[1]):
            spare[k, i] = window[(taken + k) % size, i]
    for k in range(size):
        for i in range(window.shape[1]):
            window[k, i] = spare[k, i]
