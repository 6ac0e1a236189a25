"""Run every scene under studies/ and verify its archive with code that is compiled anew, as on a machine of another's.

    python studies/archives/make.py [SCENE.toml ...] [--workers N]               (or: python3 studies/run.py archives)

Archives are written to ``studies/archives/out/``, where one that is there is not made again, and so is ``verified.md``:
a line for each scene. No scene named means all of them, which takes about half an hour on two cores. The exit code is 0
if every archive is what its scene gives.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

STUDIES = Path(__file__).resolve().parent.parent
OUT = Path(__file__).resolve().parent / "out"
COMMAND = (sys.executable, "-m", "chaosdrill")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", metavar="SCENE.toml", nargs="*", type=Path)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()
    scenes = [scene.resolve() for scene in arguments.scenes] or sorted(STUDIES.glob("*/*.toml"))
    OUT.mkdir(exist_ok=True)
    rows = []
    with tempfile.TemporaryDirectory() as cold:
        for number, scene in enumerate(scenes, 1):
            name = f"{scene.parent.name}/{scene.stem}"
            print(f"[{number}/{len(scenes)}] {name}", file=sys.stderr, flush=True)
            rows.append((name, *checked(scene, OUT / f"{name.replace('/', '-')}.nc", arguments.workers, Path(cold))))
    text = table(rows)
    (OUT / "verified.md").write_text(text, encoding="utf-8")
    print(text)
    return 0 if all(row[1] for row in rows) else 1


def checked(scene: Path, archive: Path, workers: int, cold: Path) -> tuple[bool, str, float, float]:
    """Return whether an archive is what its scene gives, in what sense, and the seconds of the run and of the check."""
    began = time.perf_counter()
    many = ("--workers", str(workers))
    if not archive.is_file():
        code = subprocess.call(
            [*COMMAND, "run", str(scene), "-o", str(archive), *many, "--resume"], stdout=subprocess.DEVNULL
        )
        if code:
            return False, f"exit code {code}", time.perf_counter() - began, float("nan")
    made = time.perf_counter() - began
    elsewhere = {"CHAOSDRILL_CACHE_DIR": str(cold / "kernels"), "NUMBA_CACHE_DIR": str(cold / "engine")}
    found = subprocess.run(
        [*COMMAND, "verify", str(archive), *many, "--json"], stdout=subprocess.PIPE, env={**os.environ, **elsewhere}
    )
    took = time.perf_counter() - began - made
    if found.returncode not in (0, 1):
        return False, f"exit code {found.returncode}", made, took
    result = json.loads(found.stdout)
    if not result["equal"]:
        names = sorted({f"{item['group']}/{item['variable']}" for item in result["differences"]})
        return False, "differs: " + ", ".join(names), made, took
    return True, "bit for bit" if result["exact"] else "as far as it can be compared", made, took


def table(rows: list[tuple[str, bool, str, float, float]]) -> str:
    """The lines of all scenes as a Markdown table."""
    lines = ["| scene | archive is what its scene gives | run | verified |", "|---|---|---|---|"]
    for name, equal, sense, made, took in rows:
        lines.append(f"| `{name}.toml` | {'yes, ' if equal else 'NO: '}{sense} | {made:.0f} s | {took:.0f} s |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.exit(main())
