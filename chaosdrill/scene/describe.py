"""Description of the simulation of a scene, as plain values, for ``chaosdrill check`` and reports."""

import os
from collections.abc import Mapping
from typing import Any

from chaosdrill.dataset.provenance import drawn
from chaosdrill.errors import SceneError
from chaosdrill.scene.check_made import noise_parameters
from chaosdrill.scene.load import load_scene
from chaosdrill.scene.scene import Scene
from chaosdrill.systems import EFFECTS, REGISTRY
from chaosdrill.systems.drill.effects import ABSENT
from chaosdrill.systems.drill.si import QUANTITIES
from chaosdrill.typed import PATH, TABLE, expecting, refuse


@expecting(SceneError, changes=TABLE)
def check(scene: str | os.PathLike[str] | Scene, changes: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Validate a scene and describe what it simulates, as ``chaosdrill check`` does.

    Parameters
    ----------
    scene : path-like or Scene
        As for `load_scene`, or what it returned.
    changes : mapping of str to value, optional
        As for `load_scene`; only with a path.

    Returns
    -------
    dict
        Plain values, ready for JSON: ``title``, ``system``, effects ``simulated`` and ``left_out``, ``noise``,
        ``symmetry`` (images of states), ``states``, ``initial_mode``, ``parameters``, ``map`` (images, of a map alone),
        ``modes`` (equations), ``events``, ``quadratures``, ``period``, ``si``, ``si_scales``, ``numerics``,
        ``analyses``, and ``changes``, the values that were set.

    Raises
    ------
    SceneError
        With every fault of the scene.
    """
    if not isinstance(scene, Scene):
        refuse(SceneError, "scene", scene, PATH)
    loaded = scene if isinstance(scene, Scene) else load_scene(scene, changes)
    loaded.check_period()
    return describe_scene(loaded)


def describe_scene(scene: Scene) -> dict[str, Any]:
    """Description of a scene as plain values: equations as text, numbers, names."""
    system = scene.system
    modes, transitions = ({}, ()) if system.discrete else (system.modes, system.transitions)
    labels, given = system.labels, {*scene.parameters, *noise_parameters(scene.noise)}
    return {
        "title": scene.title,
        "system": system.name,
        "simulated": _effects(scene, present=True),
        "left_out": _effects(scene, present=False),
        "noise": drawn(system.noise),
        "symmetry": dict(scene.symmetry),
        "states": {
            name: {"label": labels.get(name, ""), "initial": system.initial[name]} for name in system.state_names
        },
        "initial_mode": system.initial["mode"],
        "parameters": {
            name: {"label": labels.get(name, ""), "value": value, "given": name in given}
            for name, value in system.parameters.items()
        },
        # of a system whose record is kept images are read when they are asked for
        "map": {f"{state} next": str(image) for state, image in getattr(system, "images", {}).items()},
        "modes": {mode: {f"d{state}/dt": str(rate) for state, rate in field.items()} for mode, field in modes.items()},
        "events": {
            transition.name: {
                "from": list(transition.source),
                "to": transition.target,
                "guard": str(transition.guard),
                "direction": transition.direction,
                "condition": _texts(transition.conditions),
                "reset": {str(state): str(value) for state, value in transition.reset.items()},
                "priority": transition.priority,
                "kind": transition.kind,
            }
            for transition in transitions
        },
        "quadratures": {name: _texts(rates) for name, rates in system.quadratures.items()},
        "period": None if not system.forced or system.discrete else str(system.period),
        "si": {
            name: {"label": QUANTITIES[name].label, "value": value, "units": QUANTITIES[name].units}
            for name, value in scene.si.values.items()
        },
        "si_scales": dict(scene.scales),
        "numerics": dict(scene.numerics),
        "analyses": {name: {"kind": analysis.kind, **analysis.table} for name, analysis in scene.analyses.items()},
        "changes": dict(scene.changes),
    }


def _texts(expressions: Mapping[str, Any]) -> Any:
    from chaosdrill.model.definition import one_or_by_mode

    return one_or_by_mode({mode: str(expression) for mode, expression in expressions.items()})


def _effects(scene: Scene, *, present: bool) -> dict[str, str]:
    """Simulated effects with their option, or those left out with their options."""
    if scene.definition is not None or not REGISTRY[scene.model].effects:
        return {}
    chosen = {effect: option for effect, option in scene.effects.items() if option != ABSENT[effect]}
    if present:
        return {effect: f"{option}: {EFFECTS[effect][option]}" for effect, option in chosen.items()}
    others = {effect: [option for option in EFFECTS[effect] if option != ABSENT[effect]] for effect in EFFECTS}
    return {effect: f"choose from {', '.join(known)}" for effect, known in others.items() if effect not in chosen}
