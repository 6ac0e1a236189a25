"""Spoilt scenes, from a fixed seed, and what the command line makes of them.

    python tests/scene/mutations.py 500

checks and runs so many, each in a folder with files that are not to be lost, and prints a report as JSON. A run of more
than ``PATIENCE_S`` is interrupted as by Ctrl-C. The exit code is 1 if anything went wrong.
"""

import contextlib
import io
import json
import os
import random
import re
import resource
import signal
import string
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

SEED = 20260101
PATIENCE_S = 3.0
MOST_BYTES = 3 * 2**30
"""Address space that the process may have, the compiler's included."""
MOST_GROWTH_MB = 400
"""By how much all scenes together may raise the memory that is really used."""

DRILL = """\
title = "A short drilling"
[system]
model = "percussive-drill"
effects = { drive = "harmonic", friction = "stribeck", rock = "moving", contact = "hunt-crossley" }
[system.parameters]
eta = 0.8
[system.initial]
y = 0.0
[numerics]
method = "taylor"
tolerance = 1e-9
[analysis.motion]
kind = "trajectory"
periods = 3
samples = 20
[analysis.section]
kind = "poincare-section"
at = "strobe"
transient = 4
periods = 4
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.eta = { start = 0.6, stop = 0.9, num = 3 }
seeds = [{ y = 0.0 }, { y = 0.1, mode = "stick" }]
transient = 3
periods = 8
"""
IN_SI = """\
[system]
model = "percussive-drill"
effects = { drive = "lobes", friction = "coulomb", rock = "moving" }
[system.si]
m1 = "250 kg"
m2 = "0.125 t"
K = "4 MN/m"
C = "3.8 kN*s/m"
A = "2 kN"
B = "5.6 kN"
rpm = "90 rpm"
lobes = 3
F_N = "10 kN"
mu_e = 0.8
mu_d = 0.48
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 2
periods = 8
[analysis.starts]
kind = "basins"
grid.y = [0.0, 0.1]
grid.u = { start = -0.1, stop = 0.1, num = 2 }
transient = 2
periods = 4
"""
OSCILLATOR = """\
[system]
model = "impact-oscillator"
parameters.omega = 2.5
[analysis.orbit]
kind = "periodic-orbit"
start = "attractor"
period = 1
transient = 3
[analysis.chart]
kind = "parameter-chart"
sweep = { omega = [2.4, 2.5], zeta = [0.04, 0.05] }
random = { count = 2, seed = 1, x = [-0.1, 0.1] }
transient = 3
periods = 6
[analysis.cost]
kind = "work-precision"
methods = ["taylor"]
tolerances = [1e-6]
transient = 2
periods = 2
repeats = 1
"""
SOUND = (DRILL, IN_SI, OSCILLATOR)

NUMBERS = ["1e308", "-1e308", "1e400", "9" * 30, "-" + "9" * 30, "1" * 5000, "0", "-1", "-0.0", "nan", "inf", "-inf"]
NUMBERS += ["0x7fffffffffffffff", "9223372036854775808", "5e-324", "1_000_000_000", "1e10", "2.5", "1e-300"]
OTHERS = [
    "true",
    '"text"',
    '""',
    "[]",
    "{}",
    "[[]]",
    "[1, 'a', {}]",
    "1979-05-27T07:32:00Z",
    "07:32:00",
    "1e3",
    "'''\n'''",
]
HOSTILE = [
    "__import__('os').system('touch owned')",
    "os.system",
    "$(touch owned)",
    "../../../etc/passwd",
    "{0.__class__}",
]
HOSTILE += ["%s%s%n", "\\u0000", "\\U0001F600", "x" * 100_000, "chaosdrill.cli.main:main", "sin(x)", "exec('1/0')", "-"]


def _bytes(text: str, rng: random.Random) -> bytes:
    data = bytearray(text.encode())
    for _ in range(rng.choice([1, 1, 2, 4, 32])):
        at = rng.randrange(len(data) + 1)
        data[at : at + rng.randrange(3)] = rng.randbytes(rng.randrange(3))
    return bytes(data)


def _truncated(text: str, rng: random.Random) -> bytes:
    return text.encode()[: rng.randrange(len(text))]


def _value(text: str, rng: random.Random, new: str) -> bytes:
    """Something else in place of a value."""
    place = rng.choice(list(re.finditer(r'(?<== )("[^"]*"|[-\d.e]+)', text)))
    return (text[: place.start()] + new + text[place.end() :]).encode()


def _number(text: str, rng: random.Random) -> bytes:
    return _value(text, rng, rng.choice(NUMBERS))


def _plausible(text: str, rng: random.Random) -> bytes:
    """Numbers that may be allowed, but are far from what one would give."""
    return _value(
        text, rng, rng.choice(["1000000", "1", "3", "1e-15", "0.01", "100", "1e6", "10000000000", "0.3", "2"])
    )


def _other_type(text: str, rng: random.Random) -> bytes:
    return _value(text, rng, rng.choice(OTHERS))


def _hostile(text: str, rng: random.Random) -> bytes:
    return _value(text, rng, f'"{rng.choice(HOSTILE)}"')


def _nested(text: str, rng: random.Random) -> bytes:
    depth = rng.choice([3, 50, 300, 1000, 30_000])
    opening, closing = rng.choice([("[", "]"), ("{ a = ", " }"), ("[{ a = ", " }]")])
    if rng.random() < 0.3:
        return (text + f"[{'.'.join(['a'] * depth)}]\nb = 1\n").encode()
    return _value(text, rng, opening * depth + "1" + closing * rng.choice([depth, depth - 1]))


def _doubled(text: str, rng: random.Random) -> bytes:
    lines = text.splitlines()
    line = rng.choice(lines)
    lines.insert(rng.randrange(len(lines) + 1), rng.choice([line, line, line.upper(), line.replace("=", ".x =")]))
    return "\n".join(lines).encode()


def _reordered(text: str, rng: random.Random) -> bytes:
    lines = text.splitlines() + rng.choice(SOUND).splitlines()[: rng.randrange(20)]
    for _ in range(rng.choice([1, 2, 10])):
        lines.insert(rng.randrange(len(lines)), lines.pop(rng.randrange(len(lines))))
    return "\n".join(lines[rng.randrange(3) :]).encode()


def _renamed(text: str, rng: random.Random) -> bytes:
    place = rng.choice(list(re.finditer(r"[A-Za-z_]\w*", text)))
    new = rng.choice(
        [place.group()[::-1], "", rng.choice(re.findall(r"\w+", text)), '"' + rng.choice(HOSTILE)[:60] + '"']
    )
    return (text[: place.start()] + new + text[place.end() :]).encode()


KINDS = (_bytes, _truncated, _number, _plausible, _other_type, _hostile, _nested, _doubled, _reordered, _renamed)


def _change(rng: random.Random) -> str:
    """An argument of ``--set`` that makes little sense."""
    key = rng.choice(
        ["system.parameters.eta", "system", "analysis.motion.periods", "a.b.c", "'", "", "system.model.x", "é"]
    )
    garbage = "".join(rng.choices(string.printable, k=rng.randrange(12))).replace("\0", "")
    return f"{key}={rng.choice([*NUMBERS, *OTHERS, *HOSTILE, garbage, garbage])}"


def mutations(count: int) -> list[tuple[str, bytes, list[str]]]:
    """So many spoilt scenes: the way in which each is spoilt, its bytes, and further arguments of the command."""
    rng = random.Random(SEED)
    made = []
    for number in range(count):
        text, kind = rng.choice(SOUND), KINDS[number % len(KINDS)]
        arguments = ["--set", _change(rng)] if rng.random() < 0.1 else []
        made.append((kind.__name__.strip("_"), text.encode() if arguments else kind(text, rng), arguments))
    return made


def examine(count: int) -> dict[str, object]:
    """Check and run spoilt scenes.

    Returns
    -------
    dict
        ``faults``: what went wrong, with the number of the scene; ``codes``: how often each exit code of check and run
        came; ``largest_mb``: by how much memory grew; ``seconds``.
    """
    from chaosdrill.cli import main

    forbidden: list[str] = []
    watched = ("os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "os.fork", "socket.connect")
    folder = Path(tempfile.mkdtemp()).resolve()
    os.chdir(folder)
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGALRM, interrupt)
    faults: list[str] = []
    codes: dict[str, Counter[int]] = {"check": Counter(), "run": Counter()}

    def call(number: int, *arguments: str) -> int:
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            signal.setitimer(signal.ITIMER_REAL, PATIENCE_S)
            try:
                code = main(arguments)
            except BaseException:
                faults.append(f"{number}: {arguments}: {traceback.format_exc()}")
                code = -1
            finally:
                signal.setitimer(signal.ITIMER_REAL, 0)
        document = json.loads(out.getvalue()) if out.getvalue() else {"error": None}
        if code >= 0 and ("error" in document) != (code != 0):
            faults.append(f"{number}: {arguments}: code {code} with {out.getvalue()[:200]}")
        if "Traceback" in err.getvalue():
            faults.append(f"{number}: {arguments}: {err.getvalue()}")
        codes[arguments[0]][code] += 1
        return code

    # what is loaded once is no fault of any scene
    Path("scene.toml").write_text(DRILL)
    with contextlib.redirect_stdout(io.StringIO()):
        main(["run", "scene.toml", "-o", "out.nc", "--json"])
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.monotonic()

    def watch(event: str, arguments: tuple[object, ...]) -> None:
        if event in watched:
            forbidden.append(f"{event} {arguments!r:.200}")

    sys.addaudithook(watch)
    for number, (_, data, arguments) in enumerate(mutations(count)):
        Path("scene.toml").write_bytes(data)
        Path("out.nc").write_bytes(b"the earlier archive")
        Path("neighbour.nc").write_bytes(b"of somebody else")
        call(number, "check", "scene.toml", "--json", *arguments)
        code = call(number, "run", "scene.toml", "-o", "out.nc", "--json", *arguments)
        if Path("scene.toml").read_bytes() != data or Path("neighbour.nc").read_bytes() != b"of somebody else":
            faults.append(f"{number}: a file was changed that is none of its own")
        if (Path("out.nc").read_bytes() == b"the earlier archive") == (code == 0):
            faults.append(f"{number}: code {code}, and the archive says otherwise")
        left = {path.name for path in folder.iterdir()} - {"scene.toml", "out.nc", "neighbour.nc"}
        if left - {"out.nc.parts"} or (left and code in (0, 2)):
            faults.append(f"{number}: left {sorted(left)}")
        _remove_parts(folder / "out.nc.parts")
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    faults += [f"the scene had {event}" for event in forbidden]
    if grown > MOST_GROWTH_MB:
        faults.append(f"memory grew by {grown:.0f} MB")
    return {
        "faults": faults,
        "codes": {command: dict(counts) for command, counts in codes.items()},
        "grown_mb": round(grown),
        "seconds": round(time.monotonic() - start, 1),
    }


def _remove_parts(folder: Path) -> None:
    """Forget an interrupted run."""
    for path in sorted(folder.rglob("*"), reverse=True) if folder.is_dir() else ():
        path.rmdir() if path.is_dir() else path.unlink()
    if folder.is_dir():
        folder.rmdir()


if __name__ == "__main__":
    report = examine(int(sys.argv[1]) if len(sys.argv) > 1 else 500)
    print(json.dumps(report, indent=2))
    sys.exit(1 if report["faults"] else 0)
