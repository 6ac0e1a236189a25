"""What equilibria are, and what happens to them along a parameter: words that archives store as numbers."""

from chaosdrill.dataset.codes import Code


class EquilibriumType(Code):
    """Type of an equilibrium by the eigenvalues of the directions that are free; archives store the number."""

    NONE = 0, "No equilibrium."
    NODE = 1, "All eigenvalues are real and of one sign."
    FOCUS = 2, "All real parts are of one sign, and a pair is complex."
    SADDLE = 3, "Eigenvalues are real and of both signs."
    SADDLE_FOCUS = 4, "Real parts are of both signs, and a pair is complex."
    CENTRE = 5, "Two eigenvalues, a pair whose real part is zero within its error."
    DEGENERATE = 6, "A real part is zero within its error, so that the linearisation does not decide."


class Admissibility(Code):
    """Whether the system has an equilibrium of a mode's rates; archives store the number."""

    ADMISSIBLE = 0, "It lies where its mode holds."
    VIRTUAL = 1, "A guard of its mode is crossed there: only the rates vanish, no motion rests."
    BOUNDARY = 2, "It lies on a guard of its mode, within its error."


class SpecialEquilibrium(Code):
    """Kind of a point of a branch of equilibria; archives store the number."""

    REGULAR = 0, "Nothing: the equilibrium moves smoothly with the parameter."
    FOLD = 1, "An eigenvalue is zero: the branch turns back, and two equilibria meet and vanish."
    BRANCH_POINT = 2, "An eigenvalue is zero, and another branch crosses."
    HOPF = 3, "A pair of eigenvalues crosses the imaginary axis: a cycle is born."
    BOUNDARY = 4, "The equilibrium meets a guard of its mode."


class Beyond(Code):
    """What a boundary equilibrium is followed by; archives store the number."""

    NONE = 0
    PERSISTENCE = 1, "Persistence: an equilibrium of another mode goes on from here."
    NONSMOOTH_FOLD = 2, "Nonsmooth fold: it meets an equilibrium of another mode, and both vanish."
    NO_PARTNER = 3, "No other mode has an equilibrium there: it ends."
    UNDECIDED = 4, "What follows is undecided."
