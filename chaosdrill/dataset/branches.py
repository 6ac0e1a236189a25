"""Special points of branches of periodic orbits, and the ways in which branches and attractors can end."""

from chaosdrill.annotations import DataArray
from chaosdrill.dataset.codes import Code
from chaosdrill.dataset.outcomes import flag_names


class Special(Code):
    """Kind of a point of a branch; archives store the number, with the names as CF flag meanings."""

    REGULAR = 0, "Nothing: the orbit changes smoothly with the parameter."
    FOLD = 1, "A multiplier is +1: the branch turns back, and the orbit meets another one and both vanish."
    PERIOD_DOUBLING = 2, "A multiplier is -1: an orbit of twice the period begins."
    NEIMARK_SACKER = 3, "A pair of multipliers crosses the unit circle: a torus begins."
    GRAZING = 4, "A guard is met at zero speed: an event appears or vanishes."
    EVENT_SWAP = 5, "Two events coincide; beyond, their order is reversed."
    OUTCOME_SWITCH = 6, "The condition between two outcomes is at its threshold; beyond it, the other holds."
    BRANCH_POINT = 7, "A multiplier is +1, and another branch crosses, as where a symmetry is broken."
    BORDER_COLLISION = 8, "Events coincide, all at nonzero speed: beyond, one or more appear or vanish."
    CUSP = 9, "Three orbits meet: two curves of folds touch and end."
    RESONANCE_1_1 = 10, "Two multipliers are +1: a curve of Neimark-Sacker points ends on a curve of folds."
    RESONANCE_1_2 = 11, "Two multipliers are -1: a curve of Neimark-Sacker points ends on one of period doublings."
    RESONANCE_1_3 = 12, "A pair of multipliers lies at the angle 2 pi/3: other orbits are born with the torus."
    RESONANCE_1_4 = 13, "A pair of multipliers lies at the angle pi/2: other orbits may be born with the torus."
    FOLD_FLIP = 14, "One multiplier is +1 and one is -1: curves of folds and of period doublings touch."
    GENERALISED_FLIP = 15, "The period doubling turns from soft to hard: a curve of folds of doubled orbits begins."
    CHENCINER = 16, "The Neimark-Sacker point turns from soft to hard: two tori meet near by."
    FOLD_NEIMARK_SACKER = 17, "A multiplier is +1 and a pair is on the unit circle."
    FLIP_NEIMARK_SACKER = 18, "A multiplier is -1 and a pair is on the unit circle."
    DOUBLE_NEIMARK_SACKER = 19, "Two pairs of multipliers are on the unit circle."
    GRAZING_FOLD = 20, "A guard is met at zero speed by an orbit with a multiplier +1."
    GRAZING_FLIP = 21, "A guard is met at zero speed by an orbit with a multiplier -1."
    GRAZING_NEIMARK_SACKER = 22, "A guard is met at zero speed by an orbit with a pair on the unit circle."
    LEVEL = 23, "A function of the orbit takes a requested value."
    OPTIMUM = 24, "A function of the orbit is largest or smallest."
    HOPF = 25, "The orbit has shrunk onto an equilibrium, of which a pair of eigenvalues is on the imaginary axis."
    CROSSING_SLIDING = 26, "A crossing reaches the part of the surface that slides: a stay on it begins or ends."
    GRAZING_SLIDING = 27, "The orbit touches the surface where motions slide: a stay on it begins or ends."
    ADDING_SLIDING = 28, "A stay on the surface touches the end of the part that slides: it parts, or two join."
    SWITCHING_SLIDING = 29, "The orbit reaches the surface at the end of the part that slides: it crosses it first."
    RESONANT_GRAZING = 30, "The first, second or third return after an event that grazes is as high as the guard."
    DEGENERATE_SLIDING = 31, "The tangency of a field is of third order: crossing- and switching-sliding meet."
    SLIDING_FOLD = 32, "A sliding bifurcation of an orbit with a multiplier +1."
    SLIDING_FLIP = 33, "A sliding bifurcation of an orbit with a multiplier -1."
    SLIDING_NEIMARK_SACKER = 34, "A sliding bifurcation of an orbit with a pair on the unit circle."


class Criticality(Code):
    """Kind of the motion born at a doubling, a pitchfork or a Neimark-Sacker point; archives store the number."""

    NONE = 0
    SUPERCRITICAL = 1, "Supercritical, or soft: the new motion attracts, beside the orbit that repels."
    SUBCRITICAL = 2, "Subcritical, or hard: the new motion repels, beside the orbit that attracts."
    TRANSCRITICAL = 3, "Transcritical: the two branches exchange their stability."
    UNDECIDED = 4, "Whether it is soft or hard is undecided."


class Onset(Code):
    """Kind of the motion that follows where a stable orbit grazes; archives store the number."""

    NONE = 0
    CONTINUOUS = 1, "The orbit goes on with the event, and attracts."
    PERIOD_ADDING = 2, "Periods add up without end towards the point, and the attractor grows from the orbit."
    PERIOD_ADDING_CHAOS = 3, "Periods add up without end towards the point, with chaos between them."
    CHAOS = 4, "A chaotic attractor grows from the orbit at once."
    JUMP = 5, "No attractor is left near the orbit: the motion jumps."
    UNDECIDED = 6, "What follows is undecided."


class BranchEnd(Code):
    """How a branch ended; archives store the number, with the names as CF flag meanings."""

    LIMIT = 0, "The parameter reached its limit; widen the range to continue."
    GRAZING = (
        1,
        "An event appears or vanishes at zero speed, and no orbit with the other sequence of events continues from "
        "there; the attractor beyond is not on this branch.",
    )
    EVENT_SWAP = 2, "Two events coincide, and no orbit with the other order continues from there."
    OUTCOME_SWITCH = 3, "An event has another outcome beyond, and no orbit with it continues from there."
    CLOSED = 4, "The branch returned to its start: it is a closed loop, and complete."
    MOST_POINTS = 5, "The maximum number of points was reached; raise max_points, or allow a larger step."
    ESCAPED = 6, "A state of the orbit left its bounds; widen them if larger states are meant."
    NO_CONVERGENCE = (
        7,
        "Newton's method found no orbit beyond this value, with no sign of grazing or of another change of events: "
        "it may end there, or be undefined. Try a tighter tolerance; see the smallest normal speed before the end.",
    )
    NO_EFFECT = 8, "The orbit does not depend on the parameter, so there is nothing to follow; choose another."
    JOINED = 9, "The branch meets another one that was already followed."
    DOUBLING = 10, "The doubled orbit shrank onto the orbit of half its period, at another period doubling."
    REST = 11, "The orbit shrank onto an equilibrium."


class AttractorEnd(Code):
    """Why the path of an attractor along a parameter ends; archives store the number."""

    LIMIT = 0, "The sweep ends here, and the attractor is still there."
    JUMP = 1, "Beyond, the motion goes to another attractor, and does not return when the parameter does: hysteresis."
    MERGER = 2, "Beyond, it has merged with another attractor; on the way back the motion may lead to either."
    SPLIT = 3, "Beyond, several attractors take its place, and the motion may lead to any of them."
    LOST = 4, "Beyond, the motion leads to no recognised attractor; it may have run away."


def count_special_points(kinds: DataArray) -> dict[str, int]:
    """Number of special points of each kind, of orbits or of equilibria, by the meanings that the variable has."""
    found = kinds.values.tolist()
    return {name: found.count(code) for code, name in flag_names(kinds).items() if code in found}
