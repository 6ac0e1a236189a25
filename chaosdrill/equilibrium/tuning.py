"""Numbers that tune the search for equilibria and their continuation, with their reasons; none of them is physics."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Tuning:
    """What steers the numerics of this room; distances count each state in its size."""

    # Newton's method
    newton_steps: int = 40
    """Steps from a start, at most; near a double root each gains one binary digit."""
    rounded: float = 8.0
    """Times the rounding error of the rates that may be left of them at an equilibrium."""
    hybrid: float = 1e-12
    """Relative step at which Powell's hybrid method ends, which leads from a start to where Newton's begins."""
    settled: float = 1e-13
    """Step, in the sizes of the unknowns, that changes only the last digits."""
    farthest: float = 1e3
    """Step that leads to nowhere near the start."""
    same: float = 1e-8
    """Distance at which two equilibria count as one: half the digits, all that is left at a fold."""
    same_errors: float = 100.0
    """Times both errors by which one equilibrium may be found apart from itself."""

    # continuation
    first_step: float = 0.1
    """First step, as a part of the longest."""
    longest_step: float = 0.05
    """Longest way of the states, in their sizes."""
    shortest_step: float = 1e-9
    """Step, as a part of the longest, at which a branch is lost."""
    straight: float = 0.985
    """Cosine between neighbouring tangents from which on a step is short enough (ten degrees)."""
    nearest: float = 0.1
    """Correction, as a part of the step, above which the next equilibrium may be one of another branch."""
    growth: float = 1.5
    """Factor of the step after one that went well."""
    halvings: int = 12
    """Times that a step is halved to tell what happens in it one by one."""
    along: float = 1e-3
    """Step from a branch point onto the branch that crosses, as a part of the longest, or less."""
    beside: float = 1e-4
    """Part of the range of the parameter by which a branch is started beside a crossing."""
    most_branches: int = 32
    """Branches that are followed, at most."""
    level: float = 64.0
    """Rounding units of a component of a unit vector that is zero."""
    parts: tuple[float, ...] = (0.5, 0.4142, 0.6180)
    """Parts at which a stretch is divided, the next one where no point can be found there."""
    beyond: float = 0.1
    """Part of a chord by which an equilibrium may lie beyond its ends to be looked for on it."""

    # normal forms
    displaced: float = 1e-3
    """Way along the branch, as a part of the step, over which the change of a coefficient is looked at."""
    cycle_reach: float = 0.05
    """Amplitude of the predicted cycle, in the sizes of the states: its square is what the prediction leaves out."""
    cycle_points: int = 64
    """Points of the predicted cycle."""
    sliding: float = 1e-8
    """Part of its terms below which the way of a height is unknown: half the digits, as a fold has them."""
    cycle_range: float = 0.01
    """Its distance from the Hopf point, at most, as a part of the parameter's range."""


TUNING = Tuning()
