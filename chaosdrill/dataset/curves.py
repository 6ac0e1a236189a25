"""How invariant curves end, and how they break, as codes with their meanings."""

from chaosdrill.dataset.codes import Code


class CurveEnd(Code):
    """How a branch of an invariant manifold ended; archives store the number."""

    LENGTH = 0, "The length asked for was reached; raise length to go on."
    MOST_POINTS = 1, "The largest number of points was reached; raise max_points, or allow a larger spacing."
    MOST_ITERATES = (
        2,
        "The curve has been followed over the largest number of iterates of its first segment; a multiplier close to "
        "1 makes it grow slowly.",
    )
    LIMIT_SET = 3, "The curve ends at what it tends to, an attractor or a repeller, and grows no longer."
    NO_IMAGE = 4, "No motion from what is left of the curve meets the section again: it escapes, stops or fails."
    NO_PREIMAGE = (
        5,
        "What is left of the curve has no preimage next to the curve: the map folds there, or no motion leads to it.",
    )
    RANK_LOSS = 6, "Sticking, or a reset that keeps no speed, takes what is left of the curve to a single point."
    LEFT = 7, "What is left of the curve is outside the region; widen it to go on."
    NOT_STARTED = (
        8,
        "The map is not smooth close to the orbit, as where that grazes, and a first segment has no direction.",
    )


class CurveBreak(Code):
    """Why a curve has a corner or a jump; archives store the number."""

    GRAZING = 0, "A guard is met at zero speed on one side: the direction jumps."
    CHANGE_OF_EVENTS = 1, "Other events, or another order of them, on both sides."
    NO_IMAGE = 2, "Motions beyond end: the curve is cut."
    NO_PREIMAGE = 3, "No motion leads to what is beyond: the curve is cut."
    UNEXPLAINED = 4, "The curve jumps where the events stay the same, as where a map itself jumps."
