"""What equilibria are, and what happens to them along a parameter: words that archives store as numbers."""

from chaosdrill.dataset.codes import Code


class EquilibriumType(Code):
    """Type of an equilibrium by the eigenvalues of the directions that are free; archives store the number."""

    NONE = 0
    NODE = 1
    FOCUS = 2
    SADDLE = 3
    SADDLE_FOCUS = 4
    CENTRE = 5
    DEGENERATE = 6

    @property
    def words(self) -> str:
        """What it means, in one sentence."""
        return _TYPES[self]


class Admissibility(Code):
    """Whether the system has an equilibrium of a mode's rates; archives store the number."""

    ADMISSIBLE = 0
    VIRTUAL = 1
    BOUNDARY = 2

    @property
    def words(self) -> str:
        """What it means, in one sentence."""
        return _WHERE[self]


class SpecialEquilibrium(Code):
    """Kind of a point of a branch of equilibria; archives store the number."""

    REGULAR = 0
    FOLD = 1
    BRANCH_POINT = 2
    HOPF = 3
    BOUNDARY = 4

    @property
    def words(self) -> str:
        """What happens there, in one sentence."""
        return _HAPPENS[self]


class Beyond(Code):
    """What a boundary equilibrium is followed by; archives store the number."""

    NONE = 0
    PERSISTENCE = 1
    NONSMOOTH_FOLD = 2
    NO_PARTNER = 3
    UNDECIDED = 4

    @property
    def words(self) -> str:
        """What follows, in one sentence; empty where the question does not arise."""
        return _BEYOND[self]


_TYPES = {
    EquilibriumType.NONE: "No equilibrium.",
    EquilibriumType.NODE: "All eigenvalues are real and of one sign.",
    EquilibriumType.FOCUS: "All real parts are of one sign, and a pair is complex.",
    EquilibriumType.SADDLE: "Eigenvalues are real and of both signs.",
    EquilibriumType.SADDLE_FOCUS: "Real parts are of both signs, and a pair is complex.",
    EquilibriumType.CENTRE: "Two eigenvalues, a pair whose real part is zero within its error.",
    EquilibriumType.DEGENERATE: "A real part is zero within its error, so that the linearisation does not decide.",
}

_WHERE = {
    Admissibility.ADMISSIBLE: "It lies where its mode holds.",
    Admissibility.VIRTUAL: "A guard of its mode is crossed there: only the rates vanish, no motion rests.",
    Admissibility.BOUNDARY: "It lies on a guard of its mode, within its error.",
}

_HAPPENS = {
    SpecialEquilibrium.REGULAR: "Nothing: the equilibrium moves smoothly with the parameter.",
    SpecialEquilibrium.FOLD: "An eigenvalue is zero: the branch turns back, and two equilibria meet and vanish.",
    SpecialEquilibrium.BRANCH_POINT: "An eigenvalue is zero, and another branch crosses.",
    SpecialEquilibrium.HOPF: "A pair of eigenvalues crosses the imaginary axis: a cycle is born.",
    SpecialEquilibrium.BOUNDARY: "The equilibrium meets a guard of its mode.",
}

_BEYOND = {
    Beyond.NONE: "",
    Beyond.PERSISTENCE: "Persistence: an equilibrium of another mode goes on from here.",
    Beyond.NONSMOOTH_FOLD: "Nonsmooth fold: it meets an equilibrium of another mode, and both vanish.",
    Beyond.NO_PARTNER: "No other mode has an equilibrium there: it ends.",
    Beyond.UNDECIDED: "What follows is undecided.",
}
