"""Where generated sources and compiled code are kept: one folder a user, keyed by content."""

import hashlib
import os
import tempfile
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent


def lasting_folder() -> Path | None:
    """``CHAOSDRILL_CACHE_DIR``, else the user's cache folder; None if it cannot be written."""
    named = os.environ.get("CHAOSDRILL_CACHE_DIR")
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()) / "chaosdrill"
    for folder in [Path(named)] if named else [base]:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except (OSError, RuntimeError):
            continue
    return None


@cache
def cache_folder() -> Path:
    """A folder that can be written: the lasting one, else a temporary one."""
    return lasting_folder() or Path(tempfile.mkdtemp(prefix="chaosdrill-"))


@cache
def code_key() -> str:
    """Key of the package's own numerical code: a change of any of it invalidates what was compiled before."""
    import llvmlite
    import numba

    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__}".encode())
    for folder in ("codegen", "engine"):
        for path in sorted((PACKAGE / folder).glob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
