"""The package's own files, which may lie in a folder or in a zip file."""

from pathlib import PurePath
from pkgutil import get_data, iter_modules

_HOME = PurePath(__file__).parent


def modules(folder: str) -> list[str]:
    """Names of the modules in a folder of the package, such as ``"engine"``, in order, without private ones."""
    found = iter_modules([str(_HOME / folder)])
    return sorted(one.name for one in found if not one.name.startswith("_") and not one.ispkg)


def source(module: str) -> bytes:
    """The source of a module, such as ``"chaosdrill.engine.jit"``."""
    held = get_data("chaosdrill", f"{module.partition('.')[2].replace('.', '/')}.py")
    assert held is not None
    return held
