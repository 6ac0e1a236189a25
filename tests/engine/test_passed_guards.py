"""Beyond which guards the motion may go on is a matter of each guard alone."""

import pytest

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


@pytest.mark.parametrize("factor", ["v*(u - 1/10)", "v*(u - 1/2)", "v*(u - 1)"])
def test_a_guard_is_passed_whatever_was_asked_of_others_before(factor):
    """The kick passes only at some u, which few states have: so it does in all twelve modes."""
    assert passes(kicked(factor)) == {(mode, 0) for mode in range(12)}


def test_guards_that_mirror_each_other_are_passed_alike():
    """Two equal masses: a guard of one, while the other slips or sticks, has a mirror image."""
    found = passes(cd.build("two-masses-on-belt"))
    assert ((1, 0) in found, (1, 1) in found) == ((3, 1) in found, (3, 2) in found)


def test_walls_are_no_passages_and_brakes_are():
    assert passes(kicked("-v/2", 1)) == frozenset()
    assert passes(kicked("v/2", 1)) == {(0, 0)}
