"""How invariant curves end, and how they break, as codes with their meanings."""

from chaosdrill.dataset.codes import Code


class CurveEnd(Code):
    """How a branch of an invariant manifold ended; archives store the number."""

    LENGTH = 0
    MOST_POINTS = 1
    MOST_ITERATES = 2
    LIMIT_SET = 3
    NO_IMAGE = 4
    NO_PREIMAGE = 5
    RANK_LOSS = 6
    LEFT = 7
    NOT_STARTED = 8

    @property
    def advice(self) -> str:
        """One sentence: what this end means and what to try."""
        return _ENDS[self]


class CurveBreak(Code):
    """Why a curve has a corner or a jump; archives store the number."""

    GRAZING = 0
    CHANGE_OF_EVENTS = 1
    NO_IMAGE = 2
    NO_PREIMAGE = 3
    UNEXPLAINED = 4

    @property
    def words(self) -> str:
        """What happens there, in one sentence."""
        return _BREAKS[self]


_ENDS = {
    CurveEnd.LENGTH: "The length asked for was reached; raise length to go on.",
    CurveEnd.MOST_POINTS: "The largest number of points was reached; raise max_points, or allow a larger spacing.",
    CurveEnd.MOST_ITERATES: (
        "The curve has been followed over the largest number of iterates of its first segment; a multiplier close to 1 "
        "makes it grow slowly."
    ),
    CurveEnd.LIMIT_SET: "The curve ends at what it tends to, an attractor or a repeller, and grows no longer.",
    CurveEnd.NO_IMAGE: "No motion from what is left of the curve meets the section again: it escapes, stops or fails.",
    CurveEnd.NO_PREIMAGE: (
        "What is left of the curve has no preimage next to the curve: the map folds there, or no motion leads to it."
    ),
    CurveEnd.RANK_LOSS: "Sticking, or a reset that keeps no speed, takes what is left of the curve to a single point.",
    CurveEnd.LEFT: "What is left of the curve is outside the region; widen it to go on.",
    CurveEnd.NOT_STARTED: (
        "The map is not smooth close to the orbit, as where that grazes, and a first segment has no direction."
    ),
}

_BREAKS = {
    CurveBreak.GRAZING: "A guard is met at zero speed on one side: the direction jumps.",
    CurveBreak.CHANGE_OF_EVENTS: "Other events, or another order of them, on both sides.",
    CurveBreak.NO_IMAGE: "Motions beyond end: the curve is cut.",
    CurveBreak.NO_PREIMAGE: "No motion leads to what is beyond: the curve is cut.",
    CurveBreak.UNEXPLAINED: "The curve jumps where the events stay the same, as where a map itself jumps.",
}
