"""A scene names things; it never causes code to be imported or evaluated."""

import subprocess
import sys

import pytest

HOSTILE = ["os", "os.system", "__import__('os')", "chaosdrill.cli.main:main", "../percussive-drill", ""]

SNITCH = """
import sys
from chaosdrill.errors import SceneError
from chaosdrill.scene import parse_scene
before = None
class Snitch:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in ("secret", "antigravity", "this"):
            print("imported", name)
sys.meta_path.insert(0, Snitch())
try:
    parse_scene(sys.stdin.read())
except SceneError as fault:
    print(str(fault).count(chr(10)) + 1, "faults")
print(sorted(set(sys.modules) & {"numba", "sympy", "xarray", "matplotlib", "netCDF4", "dask"}))
"""


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize(
    ("old", "field"),
    [
        ('"percussive-drill"', "system.model"),
        ('"stribeck"', "system.effects.friction"),
        ('"taylor"', "numerics.method"),
        ('"lyapunov-spectrum"', "analysis.spectrum.kind"),
    ],
)
def test_only_known_names(sound, faults, old, field, name):
    assert f": {field}: unknown " in faults(sound.replace(old, f'"{name}"', 1))[0]


def run(text):
    return subprocess.run(
        [sys.executable, "-c", SNITCH], input=text, capture_output=True, text=True, timeout=60, check=True
    ).stdout.splitlines()


def test_module_names_are_not_imported(sound):
    text = sound.replace("percussive-drill", "antigravity").replace("taylor", "secret.method")
    assert run(text) == ["2 faults", "[]"]


def test_a_sound_scene_is_read_without_heavy_imports(sound):
    assert run(sound) == ["[]"]
