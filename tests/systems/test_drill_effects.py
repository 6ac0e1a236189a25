"""An effect that is left out leaves no state, no guard, no parameter and no term."""

import inspect

import pytest
from support.drills import CHOICES, POSSIBLE, WITH_EVERY_PAIR, built, label

import chaosdrill as cd
from chaosdrill import systems

OWN = {
    "drive": {"harmonic": {"a", "eta", "phi"}, "lobes": {"a", "lobes", "spin", "phi"}},
    "friction": {
        "coulomb": {"mu"},
        "stribeck": {"mu", "g"},
        "coulomb-two-sided": {"mu"},
        "stribeck-two-sided": {"mu", "g"},
    },
    "rock": {"moving": {"eps"}},
    "contact": {
        "newton": {"r", "e"},
        **{law: {"r", "lam", "n", "k"} for law in ("hunt-crossley", "hunt-crossley-timed", "compliant")},
    },
}
PHASES = {
    "none": "",
    "newton": "held",
    "hunt-crossley": "held",
    "hunt-crossley-timed": "held contact",
    "compliant": "contact",
}
"""Modes of a contact besides free flight."""


def symbols(system):
    """Names of all symbols in the system's expressions."""
    found = [rate for rates in system.quadratures.values() for rate in rates.values()]
    for field in system.modes.values():
        found += field.values()
    for transition in system.transitions:
        found += [transition.guard, *transition.reset.values()]
        found += transition.conditions.values()
    return {s.name for e in found for s in e.free_symbols}


@pytest.mark.parametrize("effects", WITH_EVERY_PAIR, ids=label)
def test_parameters_are_those_of_the_chosen_effects(effects):
    expected = {"b", "xi"}.union(*(OWN[effect].get(option, set()) for effect, option in effects.items()))
    system = built(effects)
    assert set(system.parameters) == expected == set(systems.parameters("percussive-drill", effects))
    assert symbols(system) - set(system.state_names) - {"t"} == expected


def test_every_option_stands_in_the_docstring():
    told = inspect.getdoc(cd.drill)
    assert all(f'"{option}"' in told for options in systems.EFFECTS.values() for option in options)


@pytest.mark.parametrize("effects", WITH_EVERY_PAIR, ids=label)
def test_what_is_left_out_leaves_no_trace(effects):
    system = built(effects)
    kinds = {t.kind for t in system.transitions}
    assert ("t" in symbols(system)) == (system.time is not None) == (system.period is not None)
    assert (system.time is not None) == (effects["drive"] != "none")
    assert ("w" in system.state_names) == bool(system.quadratures) == (effects["rock"] == "moving")
    assert ("impact" in kinds) == (effects["contact"] != "none")
    assert ({"slip", "stick"} <= kinds) == (effects["friction"] != "none")
    assert ("turn" in kinds) == effects["friction"].endswith("two-sided")
    assert ("timer" in system.state_names) == (effects["contact"] == "hunt-crossley-timed")
    assert ("depth" in system.state_names) == (effects["contact"] == "compliant")


@pytest.mark.parametrize("effects", WITH_EVERY_PAIR, ids=label)
def test_modes_are_those_of_the_rock_in_every_phase_of_the_contact(effects):
    rests = effects["friction"] != "none" or effects["rock"] == "fixed"
    rock = ["stick"] * rests + ["slip"] * (effects["rock"] == "moving")
    rock += ["slip-back"] * effects["friction"].endswith("two-sided")
    expected = {*rock, *(f"{mode}-{phase}" for mode in rock for phase in PHASES[effects["contact"]].split())}
    if effects["contact"] == "hunt-crossley-timed":
        # which way the rock goes on is decided when the contact is over
        expected -= {"slip-back-contact"}
    system = built(effects)
    assert set(system.modes) == expected
    reached = {system.initial["mode"], *(t.target for t in system.transitions)}
    if effects["drive"] != "none":
        assert reached == expected


@pytest.mark.parametrize("effects", [c for c in CHOICES if c not in POSSIBLE], ids=label)
def test_friction_on_a_rock_that_never_moves_is_refused(effects):
    with pytest.raises(cd.ModelError, match="choose rock 'moving', or friction 'none'"):
        systems.parameters("percussive-drill", effects)


def test_an_absent_effect_is_not_simulated():
    system = systems.build("percussive-drill", effects={})
    assert system.state_names == ("y", "u")
    assert system.transitions == ()
    assert set(system.parameters) == {"b", "xi"}


def test_without_a_choice_the_paper_is_simulated():
    assert systems.parameters("percussive-drill") == cd.drill().parameters
    assert cd.drill().parameters["xi"] == 0.06
    held = {"hold-stick", "hold-slip", "part-stick", "part-slip", "release-held", "stick-held"}
    assert {t.name for t in cd.drill().transitions} == {"release", "stick", "weak-hit", "strong-hit", "hit"} | held


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"etta": 1.0}, "unknown parameter 'etta'; did you mean 'eta'"),
        ({"contact": "newton", "lam": 1.0}, "'lam' is not used with contact='newton'.*contact='hunt-crossley'"),
        ({"drive": "none", "eta": 1.0}, "'eta' is not used with drive='none'.*drive='harmonic'"),
        ({"friction": "coulomb", "g": 1.0}, "'g' is not used with friction='coulomb'.*friction='stribeck'"),
        (
            {"friction": "none", "rock": "fixed", "mu": 0.2},
            "'mu' is not used with friction='none', rock='fixed'; leave it out, or choose friction='coulomb', rock='m",
        ),
        ({"contact": "newtn"}, "contact: there is no 'newtn'; did you mean 'newton'"),
        ({"rock": "soft"}, "rock: there is no 'soft'; known here: fixed, moving"),
    ],
)
def test_what_cannot_be_used_is_refused_with_the_remedy(options, message):
    with pytest.raises(cd.ModelError, match=message):
        cd.drill(**options)
