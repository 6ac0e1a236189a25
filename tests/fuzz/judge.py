"""What the command line makes of an input, and what is wrong with that."""

import json
import os
import signal
import sys
import time
import traceback
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

LONGEST_MESSAGE = 50_000
GRACE_S = 5.0


def command(arguments, codes):
    """Run a command in this process.

    Returns
    -------
    code : int
        Its exit code; -1 if it raised.
    wrong : list of str
        What is wrong with the way in which it ended.
    """
    out, err = StringIO(), StringIO()
    code = -1
    try:
        with redirect_stdout(out), redirect_stderr(err):
            code = _main(arguments)
    except BaseException:
        return code, [f"{arguments[0]}: {traceback.format_exc()[-4000:]}"]
    return code, [f"{arguments[0]}: {text}" for text in _judged(arguments, code, out.getvalue(), err.getvalue(), codes)]


def command_apart(arguments, codes, folder, patience, watching):
    """The same in a process of its own, which is watched, and interrupted as by Ctrl-C after ``patience`` seconds."""

    def watched():
        with watching:
            return _main(arguments)

    return apart(watched, folder, patience, lambda *told: _judged(arguments, *told, codes, apart=True))


def apart(work, folder, patience, judged):
    """Exit code of a function run in a process of its own, and what is wrong with it."""
    child = os.fork()
    if not child:
        os._exit(_answer(work, folder))
    code = wait(child, patience)
    for _ in range(2):
        if code is None:
            os.kill(child, signal.SIGINT)
            code = wait(child, GRACE_S)
    if code is None:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        return -1, ["run: could not be interrupted"]
    out, err = ((folder / name).read_text(errors="replace") for name in ("stdout", "stderr"))
    # a process that was ended at once says nothing any more
    if code == 130 and not out:
        return code, []
    return code, [f"run: {text}" for text in judged(code, out, err)]


def _main(arguments):
    from chaosdrill.cli import main

    return main([str(argument) for argument in arguments])


def _judged(arguments, code, out, err, codes, apart=False):
    wrong = []
    if code not in codes:
        wrong.append(f"exit code {code}: {err[-1000:]}")
    if "Traceback" in err:
        wrong.append(err[-4000:])
    # verify tells differences where others tell results
    if code and not (err + out).strip():
        wrong.append(f"exit code {code} without a word")
    # nothing that is done in this process computes more than a sound input does
    if "not enough memory" in err and not apart:
        wrong.append(err[-1000:])
    if len(err) > LONGEST_MESSAGE:
        wrong.append(f"a message of {len(err)} letters: {err[:500]}")
    if "--json" in arguments:
        try:
            if ("error" in json.loads(out)) != (code != 0):
                wrong.append(f"exit code {code} with {out[:300]}")
        except ValueError:
            wrong.append(f"exit code {code}, and no JSON: {out[:300]!r}")
    return wrong


def wait(child, seconds):
    """Exit code of a process, or None if it has not ended after this number of seconds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    return None


def _answer(work, folder):
    """What a child does: the work, with all that it says written down."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with Path(folder, "stdout").open("w") as out, Path(folder, "stderr").open("w") as err:
        sys.stdout, sys.stderr = out, err
        try:
            return work() or 0
        except KeyboardInterrupt:
            return 130
        except BaseException:
            traceback.print_exc()
            return 255
