"""The package works where Python leaves docstrings out, and from a zip file."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import chaosdrill

PACKAGE = Path(chaosdrill.__file__).parent

SPECTRUM = """
import chaosdrill as cd
if "per period" not in cd.list_names("analyses", "trajectory")["samples"]:
    raise SystemExit("the settings of an analysis have lost their words")
ds = cd.lyapunov_spectrum(cd.build("lorenz"), duration=2.0)
print(cd.__file__, cd.system(cd.open(cd.save(ds, "result.nc"))).name, len(cd.list_names("methods")))
cd.report("result.nc"), cd.plot_archive("result.nc")
"""


def run(script, folder, *options, path=PACKAGE.parent, **more):
    """What a process prints that runs a script in a folder."""
    environment = {**os.environ, "PYTHONPATH": str(path), **more}
    command = [sys.executable, *options, "-c", script]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_without_docstrings(tmp_path):
    place, name, _ = run(SPECTRUM, tmp_path, "-OO")
    assert (place, name) == (str(PACKAGE / "__init__.py"), "lorenz")


def test_from_a_zip_file(tmp_path):
    packed = tmp_path / "packed.zip"
    with zipfile.ZipFile(packed, "w") as archive:
        for file in PACKAGE.rglob("*"):
            if file.is_file() and "__pycache__" not in file.parts:
                archive.write(file, file.relative_to(PACKAGE.parent))
    # the engine is there but for a small part, which is compiled from the source in the zip file
    left_out = "blocks._through"
    for folder in ("warm", "cache"):
        (tmp_path / folder).mkdir(mode=0o700)
    for code in PACKAGE.rglob("*.code"):
        if not code.name.startswith(left_out):
            shutil.copy(code, tmp_path / "warm")
    folders = {"CHAOSDRILL_WARM_DIR": str(tmp_path / "warm"), "CHAOSDRILL_CACHE_DIR": str(tmp_path / "cache")}
    place, name, methods = run(SPECTRUM, tmp_path, path=packed, **folders)
    assert place.startswith(str(packed))
    assert list(tmp_path.glob(f"cache/engine/{left_out}*"))
    assert (name, int(methods)) == ("lorenz", 4)
    assert (tmp_path / "result.html").exists()
