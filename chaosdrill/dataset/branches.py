"""Special points of branches of periodic orbits, and the ways in which branches and attractors can end."""

from typing import Any

from chaosdrill.dataset.codes import Code


class Special(Code):
    """Kind of a point of a branch; archives store the number, with the names as CF flag meanings."""

    REGULAR = 0
    FOLD = 1
    PERIOD_DOUBLING = 2
    NEIMARK_SACKER = 3
    GRAZING = 4
    EVENT_SWAP = 5
    OUTCOME_SWITCH = 6
    BRANCH_POINT = 7
    BORDER_COLLISION = 8
    CUSP = 9
    RESONANCE_1_1 = 10
    RESONANCE_1_2 = 11
    RESONANCE_1_3 = 12
    RESONANCE_1_4 = 13
    FOLD_FLIP = 14
    GENERALISED_FLIP = 15
    CHENCINER = 16
    FOLD_NEIMARK_SACKER = 17
    FLIP_NEIMARK_SACKER = 18
    DOUBLE_NEIMARK_SACKER = 19
    GRAZING_FOLD = 20
    GRAZING_FLIP = 21
    GRAZING_NEIMARK_SACKER = 22
    LEVEL = 23
    OPTIMUM = 24
    HOPF = 25
    CROSSING_SLIDING = 26
    GRAZING_SLIDING = 27
    ADDING_SLIDING = 28
    SWITCHING_SLIDING = 29
    RESONANT_GRAZING = 30
    DEGENERATE_SLIDING = 31
    SLIDING_FOLD = 32
    SLIDING_FLIP = 33
    SLIDING_NEIMARK_SACKER = 34

    @property
    def words(self) -> str:
        """What happens there, in one sentence."""
        return _HAPPENS[self]


class Criticality(Code):
    """Kind of the motion born at a doubling, a pitchfork or a Neimark-Sacker point; archives store the number."""

    NONE = 0
    SUPERCRITICAL = 1
    SUBCRITICAL = 2
    TRANSCRITICAL = 3
    UNDECIDED = 4

    @property
    def words(self) -> str:
        """What follows there, in one sentence; empty where the question does not arise."""
        return _BORN[self]


class Onset(Code):
    """Kind of the motion that follows where a stable orbit grazes; archives store the number."""

    NONE = 0
    CONTINUOUS = 1
    PERIOD_ADDING = 2
    PERIOD_ADDING_CHAOS = 3
    CHAOS = 4
    JUMP = 5
    UNDECIDED = 6

    @property
    def words(self) -> str:
        """What follows there, in one sentence; empty where the question does not arise."""
        return _FOLLOWS[self]


class BranchEnd(Code):
    """How a branch ended; archives store the number, with the names as CF flag meanings."""

    LIMIT = 0
    GRAZING = 1
    EVENT_SWAP = 2
    OUTCOME_SWITCH = 3
    CLOSED = 4
    MOST_POINTS = 5
    ESCAPED = 6
    NO_CONVERGENCE = 7
    NO_EFFECT = 8
    JOINED = 9
    DOUBLING = 10
    REST = 11

    @property
    def advice(self) -> str:
        """One sentence: what this end means and what to try."""
        return _ADVICE[self]


class AttractorEnd(Code):
    """Why the path of an attractor along a parameter ends; archives store the number."""

    LIMIT = 0
    JUMP = 1
    MERGER = 2
    SPLIT = 3
    LOST = 4

    @property
    def advice(self) -> str:
        """One sentence: what happens there."""
        return _BEYOND[self]


def count_special_points(codes: Any) -> dict[str, int]:
    """Number of special points of each kind in an array of codes, by meaning."""
    found = codes.tolist()
    return {kind.meaning: found.count(kind) for kind in Special if kind in found}


_HAPPENS = {
    Special.REGULAR: "Nothing: the orbit changes smoothly with the parameter.",
    Special.FOLD: "A multiplier is +1: the branch turns back, and the orbit meets another one and both vanish.",
    Special.PERIOD_DOUBLING: "A multiplier is -1: an orbit of twice the period begins.",
    Special.NEIMARK_SACKER: "A pair of multipliers crosses the unit circle: a torus begins.",
    Special.GRAZING: "A guard is met at zero speed: an event appears or vanishes.",
    Special.EVENT_SWAP: "Two events coincide; beyond, their order is reversed.",
    Special.OUTCOME_SWITCH: "The condition between two outcomes is at its threshold; beyond it, the other holds.",
    Special.BRANCH_POINT: "A multiplier is +1, and another branch crosses, as where a symmetry is broken.",
    Special.BORDER_COLLISION: "Events coincide, all at nonzero speed: beyond, one or more appear or vanish.",
    Special.CUSP: "Three orbits meet: two curves of folds touch and end.",
    Special.RESONANCE_1_1: "Two multipliers are +1: a curve of Neimark-Sacker points ends on a curve of folds.",
    Special.RESONANCE_1_2: "Two multipliers are -1: a curve of Neimark-Sacker points ends on one of period doublings.",
    Special.RESONANCE_1_3: "A pair of multipliers lies at the angle 2 pi/3: other orbits are born with the torus.",
    Special.RESONANCE_1_4: "A pair of multipliers lies at the angle pi/2: other orbits may be born with the torus.",
    Special.FOLD_FLIP: "One multiplier is +1 and one is -1: curves of folds and of period doublings touch.",
    Special.GENERALISED_FLIP: "The period doubling turns from soft to hard: a curve of folds of doubled orbits begins.",
    Special.CHENCINER: "The Neimark-Sacker point turns from soft to hard: two tori meet near by.",
    Special.FOLD_NEIMARK_SACKER: "A multiplier is +1 and a pair is on the unit circle.",
    Special.FLIP_NEIMARK_SACKER: "A multiplier is -1 and a pair is on the unit circle.",
    Special.DOUBLE_NEIMARK_SACKER: "Two pairs of multipliers are on the unit circle.",
    Special.GRAZING_FOLD: "A guard is met at zero speed by an orbit with a multiplier +1.",
    Special.GRAZING_FLIP: "A guard is met at zero speed by an orbit with a multiplier -1.",
    Special.GRAZING_NEIMARK_SACKER: "A guard is met at zero speed by an orbit with a pair on the unit circle.",
    Special.LEVEL: "A function of the orbit takes a requested value.",
    Special.OPTIMUM: "A function of the orbit is largest or smallest.",
    Special.HOPF: "The orbit has shrunk onto an equilibrium, of which a pair of eigenvalues is on the imaginary axis.",
    Special.CROSSING_SLIDING: "A crossing reaches the part of the surface that slides: a stay on it begins or ends.",
    Special.GRAZING_SLIDING: "The orbit touches the surface where motions slide: a stay on it begins or ends.",
    Special.ADDING_SLIDING: "A stay on the surface touches the end of the part that slides: it parts, or two join.",
    Special.RESONANT_GRAZING: "The first, second or third return after an event that grazes is as high as the guard.",
    Special.SWITCHING_SLIDING: "The orbit reaches the surface at the end of the part that slides: it crosses it first.",
    Special.DEGENERATE_SLIDING: "The tangency of a field is of third order: crossing- and switching-sliding meet.",
    Special.SLIDING_FOLD: "A sliding bifurcation of an orbit with a multiplier +1.",
    Special.SLIDING_FLIP: "A sliding bifurcation of an orbit with a multiplier -1.",
    Special.SLIDING_NEIMARK_SACKER: "A sliding bifurcation of an orbit with a pair on the unit circle.",
}

_BORN = {
    Criticality.NONE: "",
    Criticality.SUPERCRITICAL: "Supercritical, or soft: the new motion attracts, beside the orbit that repels.",
    Criticality.SUBCRITICAL: "Subcritical, or hard: the new motion repels, beside the orbit that attracts.",
    Criticality.TRANSCRITICAL: "Transcritical: the two branches exchange their stability.",
    Criticality.UNDECIDED: "Whether it is soft or hard is undecided.",
}

_FOLLOWS = {
    Onset.NONE: "",
    Onset.CONTINUOUS: "The orbit goes on with the event, and attracts.",
    Onset.PERIOD_ADDING: "Periods add up without end towards the point, and the attractor grows from the orbit.",
    Onset.PERIOD_ADDING_CHAOS: "Periods add up without end towards the point, with chaos between them.",
    Onset.CHAOS: "A chaotic attractor grows from the orbit at once.",
    Onset.JUMP: "No attractor is left near the orbit: the motion jumps.",
    Onset.UNDECIDED: "What follows is undecided.",
}

_ADVICE = {
    BranchEnd.LIMIT: "The parameter reached its limit; widen the range to continue.",
    BranchEnd.GRAZING: (
        "An event appears or vanishes at zero speed, and no orbit with the other sequence of events continues from "
        "there; the attractor beyond is not on this branch."
    ),
    BranchEnd.EVENT_SWAP: "Two events coincide, and no orbit with the other order continues from there.",
    BranchEnd.OUTCOME_SWITCH: "An event has another outcome beyond, and no orbit with it continues from there.",
    BranchEnd.CLOSED: "The branch returned to its start: it is a closed loop, and complete.",
    BranchEnd.MOST_POINTS: "The maximum number of points was reached; raise max_points, or allow a larger step.",
    BranchEnd.ESCAPED: "A state of the orbit left its bounds; widen them if larger states are meant.",
    BranchEnd.NO_CONVERGENCE: (
        "Newton's method found no orbit at the smallest step, with no sign of grazing or of another change of events; "
        "try a smaller step or a tighter tolerance, and look at the smallest normal speed before the end."
    ),
    BranchEnd.NO_EFFECT: "The orbit does not depend on the parameter, so there is nothing to follow; choose another.",
    BranchEnd.JOINED: "The branch meets another one that was already followed.",
    BranchEnd.DOUBLING: "The doubled orbit shrank onto the orbit of half its period, at another period doubling.",
    BranchEnd.REST: "The orbit shrank onto an equilibrium, at a Hopf bifurcation.",
}

_BEYOND = {
    AttractorEnd.LIMIT: "The sweep ends here, and the attractor is still there.",
    AttractorEnd.JUMP: (
        "Beyond, the motion goes to another attractor, and does not return when the parameter does: hysteresis."
    ),
    AttractorEnd.MERGER: "Beyond, it has merged with another attractor; on the way back the motion may lead to either.",
    AttractorEnd.SPLIT: "Beyond, several attractors take its place, and the motion may lead to any of them.",
    AttractorEnd.LOST: "Beyond, the motion leads to no recognised attractor; it may have run away.",
}
