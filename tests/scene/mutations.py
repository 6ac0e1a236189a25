"""Spoilt scenes, from a fixed seed, and what the command line makes of them.

    python tests/scene/mutations.py [500 [FIRST]]

checks and runs so many, each in a folder with files that are not to be lost, and prints a report as JSON. A run of more
than ``PATIENCE_S`` seconds is interrupted as by Ctrl-C. The exit code is 1 if anything went wrong.
"""

import contextlib
import io
import json
import os
import random
import re
import resource
import shutil
import signal
import string
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

SEED = 20260101
PATIENCE_S = {"check": 20.0, "run": 1.5}
MOST_BYTES = 3 * 2**30
"""Address space that the process may have, the compiler's included."""
MOST_GROWTH_MB = 400
"""By how much a spoilt scene may take more memory than a sound one."""

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
OWN = """\
[system.definition]
name = "a ball of one's own"
states = ["x", "v"]
time = "t"
period = "2*pi/omega"
[system.definition.modes.free]
x = "v"
v = "-x - 2*zeta*v + cos(omega*t)"
[system.definition.modes.rest]
x = 0
v = "0.0"
[[system.definition.transitions]]
name = "impact"
source = ["free"]
target = "free"
guard = "x - 0.3"
direction = 1
reset = { v = "-e*v" }
condition = "v > 1e-9 or x < 1"
[[system.definition.transitions]]
name = "stop"
source = "free"
target = "rest"
guard = "x - 0.3"
direction = 1
completes = "impact"
[system.definition.quadratures]
work = "zeta*v**2"
[system.definition.bounds]
x = [-10, inf]
[system.parameters]
zeta = 0.05
omega = 2.5
e = 0.8
[analysis.spectrum]
kind = "lyapunov-spectrum"
transient = 2
periods = 8
[analysis.diagram]
kind = "bifurcation-diagram"
sweep.e = [0.7, 0.8]
transient = 2
periods = 4
"""
SOUND = (DRILL, IN_SI, OSCILLATOR, OWN)

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
HOSTILE += ["9**9**9", "(" * 20_000 + "v" + ")" * 20_000, "v.__class__", "(3*x)**999999999", "1/0", "cos(t)**2 + x/v"]
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


def examine(count: int, first: int = 0) -> dict[str, object]:
    """Check and run spoilt scenes, from the number ``first`` on.

    Returns
    -------
    dict
        ``faults``: what went wrong, with the number of the scene; ``codes``: how often each exit code of check and run
        came; ``largest_mb``: memory of the largest process; ``seconds``.
    """
    from chaosdrill.cli import main

    folder = Path(tempfile.mkdtemp()).resolve()
    os.chdir(folder)
    Path("answer").mkdir()
    # what is loaded and compiled once is no fault of any scene
    Path("scene.toml").write_text(DRILL)
    with contextlib.redirect_stdout(io.StringIO()):
        main(["run", "scene.toml", "-o", "out.nc", "--json"])
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.monotonic()
    faults: list[str] = []
    codes: dict[str, Counter[int]] = {"check": Counter(), "run": Counter()}
    for number, (kind, data, arguments) in list(enumerate(mutations(first + count)))[first:]:
        began = time.monotonic()
        Path("scene.toml").write_bytes(data)
        Path("out.nc").write_bytes(b"the earlier archive")
        Path("neighbour.nc").write_bytes(b"of somebody else")
        for command in ("check", "run"):
            output = ["-o", "out.nc"] if command == "run" else []
            code, wrong = _call([command, "scene.toml", *output, "--json", *arguments], PATIENCE_S[command])
            codes[command][code] += 1
            faults += [f"{number} {command}: {text}" for text in wrong]
            if code not in ((0, 2) if command == "check" else (0, 1, 2, 130)):
                faults.append(f"{number} {command}: exit code {code}")
        if Path("scene.toml").read_bytes() != data or Path("neighbour.nc").read_bytes() != b"of somebody else":
            faults.append(f"{number}: a file was changed that is none of its own")
        if (Path("out.nc").read_bytes() == b"the earlier archive") == (code == 0):
            faults.append(f"{number}: code {code}, and the archive says otherwise")
        left = {path.name for path in folder.iterdir()} - {"scene.toml", "out.nc", "neighbour.nc", "answer"}
        # a process that was ended at once may leave a draft, which the next one removes
        if code != 130 and left:
            faults.append(f"{number}: left {sorted(left)}")
        for name in left:
            shutil.rmtree(name) if Path(name).is_dir() else Path(name).unlink()
        print(f"{number} {kind}: {code} in {time.monotonic() - began:.1f} s", file=sys.stderr)
    largest = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    if largest > before + 1024 * MOST_GROWTH_MB:
        faults.append(f"a process took {largest // 1024} MB, {(largest - before) // 1024} more than for a sound scene")
    return {
        "faults": faults,
        "codes": {command: dict(counts) for command, counts in codes.items()},
        "largest_mb": largest // 1024,
        "seconds": round(time.monotonic() - start, 1),
    }


def _call(arguments: list[str], patience: float) -> tuple[int, list[str]]:
    """Run a command in a process of its own; its exit code, and what was wrong with what it did."""
    child = os.fork()
    if not child:
        os._exit(_answer(arguments))
    code = _wait(child, patience)
    for _ in range(2):
        if code is None:
            os.kill(child, signal.SIGINT)
            code = _wait(child, 5.0)
    if code is None:
        os.kill(child, signal.SIGKILL)
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), ["could not be interrupted"]
    out, err = Path("answer/out").read_text(), Path("answer/err").read_text()
    wrong = [f"had {line}" for line in Path("answer/events").read_text().splitlines()]
    if "Traceback" in err:
        wrong.append(err)
    # a process that was ended at once says nothing any more
    if not (code == 130 and not out) and ("error" in json.loads(out)) != (code != 0):
        wrong.append(f"exit code {code} with {out[:200]}")
    return code, wrong


def _wait(child: int, seconds: float) -> int | None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    return None


def _answer(arguments: list[str]) -> int:
    """What a child does: the command, with all that it says and does written down."""
    from chaosdrill.cli import main

    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    watched = ("os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "os.fork", "socket.connect")
    with open("answer/events", "w") as events, open("answer/out", "w") as out, open("answer/err", "w") as err:
        sys.addaudithook(lambda event, given: event in watched and events.write(f"{event} {given!r:.200}\n"))
        sys.stdout, sys.stderr = out, err
        try:
            return main(arguments)
        except BaseException:
            traceback.print_exc()
            return -1 % 256


if __name__ == "__main__":
    report = examine(*map(int, sys.argv[1:] or ["500"]))
    print(json.dumps(report, indent=2))
    sys.exit(1 if report["faults"] else 0)
