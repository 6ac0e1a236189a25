"""The last line of an archive: the SHA-256 of all that precedes it.

The libraries that read HDF5 may stop the whole process on a damaged file. One that ends with the right line is as it
was written and safe to open; any other is tried in a process of its own first. HDF5 ignores what follows its own end of
file, and removes it when a file is opened for writing and closed again.
"""

import subprocess
import sys
from hashlib import sha256
from pathlib import Path

from chaosdrill.errors import ArchiveError

_MARK = b"\nchaosdrill sha256 "
LENGTH = len(_MARK) + 64 + 1

PATIENCE = 60.0
"""Seconds that a file may take to be read, and as many more for every gigabyte."""

AT_WORK = 20
"""The same of the processor's time: on some damaged files the library goes round for ever."""

_BLOCK = 2**20


def seal(file: Path) -> None:
    """Append the line to a file."""
    digest = _digest(file, file.stat().st_size)
    with file.open("ab") as stream:
        stream.write(_MARK + digest.encode() + b"\n")


def is_sealed(file: Path) -> bool:
    """Whether a file ends with the right line."""
    size = file.stat().st_size - LENGTH
    if size <= 0:
        return False
    with file.open("rb") as stream:
        stream.seek(size)
        line = stream.read(LENGTH)
    return line.startswith(_MARK) and line[len(_MARK) : -1].decode("ascii", "replace") == _digest(file, size)


def try_reading(file: Path) -> None:
    """Read a file in a process of its own, so that a crash of the library ends that one.

    Raises
    ------
    ArchiveError
        If it cannot be read there.
    """
    size = 1 + file.stat().st_size / 2**30
    patience, at_work = PATIENCE * size, int(AT_WORK * size)
    command = [sys.executable, "-I", "-c", _TRIAL, str(at_work), str(file), *map(str, sys.path)]
    try:
        trial = subprocess.run(command, capture_output=True, timeout=patience, check=False, stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired as fault:
        raise ArchiveError(f"{file}: truncated or damaged: it cannot be read to its end") from fault
    if trial.returncode:
        lines = trial.stdout.decode(errors="replace").strip().splitlines()
        reason = lines[-1] if lines else "the NetCDF library crashes on it, or never ends"
        raise ArchiveError(f"{file}: {reason}")


# -I keeps the working directory off the path; what follows the file are the paths of this process. The limit holds also
# where nobody is left to end the trial
_TRIAL = """
import resource, sys
from pathlib import Path
resource.setrlimit(resource.RLIMIT_CPU, (int(sys.argv[1]),) * 2)
sys.path[:] = [path for path in sys.argv[3:] if path]
from chaosdrill.dataset.layout import check_layout, read_through
from chaosdrill.errors import ArchiveError
file = Path(sys.argv[2])
try:
    check_layout(file)
    read_through(file)
except ArchiveError as fault:
    print(str(fault).removeprefix(f"{file}: "))
    sys.exit(1)
except Exception as fault:
    print(f"truncated or damaged: {fault}")
    sys.exit(1)
"""


def _digest(file: Path, size: int) -> str:
    total = sha256()
    with file.open("rb") as stream:
        while size > 0 and (block := stream.read(min(_BLOCK, size))):
            total.update(block)
            size -= len(block)
    return total.hexdigest()
