"""The engine compiled beforehand, for containers and clusters whose processes are not to wait for it."""

from importlib import import_module
from pathlib import Path

from chaosdrill.codegen import addresses, kept
from chaosdrill.codegen.cache import put
from chaosdrill.engine.jit import COMPILED
from chaosdrill.package import modules


def warm(folder: Path | None = None, elsewhere: tuple[str, ...] = ()) -> list[Path]:
    """Compile all of the engine, and the special functions of systems, for this machine.

    Parameters
    ----------
    folder : pathlib.Path, optional
        Where the code is put, beside where it is always kept. A process finds it there if the folder is named by
        ``CHAOSDRILL_WARM_DIR``; nothing needs to be written then.
    elsewhere : tuple of str
        Modules beside those of the engine whose compiled functions are wanted.

    Returns
    -------
    list of pathlib.Path
        The files that hold the code.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    for name in (*(f"chaosdrill.engine.{name}" for name in modules("engine")), *elsewhere):
        import_module(name)
    if folder is not None:
        folder.mkdir(mode=0o755, parents=True, exist_ok=True)
    own = (one for one in COMPILED if kept.is_own(one.py_func))
    codes = {kept.engine_path(one.py_func.__module__, one.__name__): one.compile for one in own}
    found = []
    for path, code_of in (codes | addresses.kept_codes()).items():
        code = code_of()
        if folder is not None:
            path = folder / path.name
            put(path, code)
            path.chmod(0o644)
        found.append(path)
    return found
