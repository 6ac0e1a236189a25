"""Beyond which guards the motion may go on is a matter of each guard alone."""

import chaosdrill as cd
from chaosdrill.engine.structure import passes


def kicked(factor, modes=12):
    """A body that each mode kicks where it meets x = 0, its speed being multiplied by a factor."""
    names = [f"m{i}" for i in range(modes)]
    return cd.HybridSystem(
        states="x v u",
        modes={name: {"x": "v", "v": "0", "u": "0"} for name in names},
        transitions=[cd.Transition(f"kick{i}", name, name, "x", -1, {"v": factor}) for i, name in enumerate(names)],
        initial={"mode": "m0", "x": 1.0, "v": -1.0},
    )


def test_a_guard_is_passed_whatever_was_asked_of_others_before():
    """The kick passes only where u > 2, which few states are: all twelve guards are looked at there, or none."""
    found = passes(kicked("v*(u - 2)"))
    assert len({(mode, 0) in found for mode in range(12)}) == 1


def test_walls_are_no_passages_and_brakes_are():
    assert passes(kicked("-v/2", 1)) == frozenset()
    assert passes(kicked("v/2", 1)) == {(0, 0)}
