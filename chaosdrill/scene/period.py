"""A scene whose forcing has no period cannot be run; its line is told before anything is."""

from typing import TYPE_CHECKING

from chaosdrill.errors import SettingsError

if TYPE_CHECKING:
    from chaosdrill.scene import Scene


def check_period(scene: "Scene") -> None:
    """Refuse a scene whose parameters make the forcing period infinite, zero or negative.

    Raises
    ------
    SceneError
        With the lines of the parameters that decide on the period.
    """
    from chaosdrill.scene.problems import InvalidSceneError, Problem

    system = scene.system
    try:
        system.forcing_period()
    except SettingsError as fault:
        names = sorted(p.name for p in system.period.free_symbols) if system.period is not None else []
        places = [place for name in names if (place := ("system", "parameters", name)) in scene.lines]
        problems = [Problem(place, str(fault)) for place in places] or [Problem(("system",), str(fault))]
        raise InvalidSceneError(scene.name, problems, scene.lines) from fault
