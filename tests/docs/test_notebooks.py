"""Pages that are notebooks show their pictures in a kernel that nobody has prepared."""

import math
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CELL = re.compile(r"^```\{code-cell\}[^\n]*\n(?:---\n.*?^---\n)?(.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Function that runs cells in one kernel and returns their outputs."""
    nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
    nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
    pytest.importorskip("ipykernel", reason="ipykernel is not installed")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    # a kernel chooses the backend for itself
    monkeypatch.delenv("MPLBACKEND", raising=False)

    def executed(cells):
        notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
        client = nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3")
        client.execute(cwd=str(tmp_path))
        return [cell["outputs"] for cell in notebook.cells]

    return executed


def _pictures(outputs):
    return sum("image/png" in output.get("data", {}) for output in outputs)


FEW = """
import chaosdrill as cd
import matplotlib.pyplot as plt
motion = cd.trajectory(cd.build("impact-oscillator"), periods=3, samples=16)
"""


@pytest.mark.filterwarnings("ignore")
def test_every_picture_of_a_fresh_kernel_shows(run):
    cells = [FEW, "cd.plot(motion);", "cd.plot(motion, 'phase-portrait');", "plt.plot([1, 2]);", "cd.plot(motion);"]
    assert [_pictures(outputs) for outputs in run(cells)] == [0, 1, 1, 1, 1]


@pytest.mark.filterwarnings("ignore")
def test_every_picture_of_the_neuron_shows(run):
    """All cells of the page, each of which shows as many pictures as it draws."""
    cells = CELL.findall((ROOT / "docs" / "neuron.md").read_text(encoding="utf-8"))
    drawn = [len(re.findall(r"cd\.plot\(|plt\.subplots\(", cell)) for cell in cells]
    assert sum(drawn) == 6
    assert [_pictures(outputs) for outputs in run(cells)] == drawn


def test_the_first_hour_has_no_stumble(tmp_path, monkeypatch, capsys):
    """The cells run in order, their numbers are right, and each mistake is answered with a remedy."""
    monkeypatch.chdir(tmp_path)
    names = {}
    for cell in CELL.findall((ROOT / "docs" / "first_hour.md").read_text(encoding="utf-8")):
        exec(cell, names)
    answers = [line for line in capsys.readouterr().out.splitlines() if "Error: " in line]
    assert len(answers) == len(names["slips"])
    ways = r"did you mean|pass |give |write |name the others|its value is|save\(ds|the order is"
    assert all(re.search(ways, one) for one in answers)
    # closed forms of the heated room
    assert abs(names["off"] - 2 * math.log(16 / 14)) < 1e-12
    assert abs(names["cycles"] - names["expected"]).max() < 1e-12
    # areas shrink by the damping and, at impacts, by the restitution
    spectrum, own = names["spectrum"], names["hitter"].parameters
    rate = float(spectrum["impacts_per_period"] / spectrum["forcing_period"])
    shrinking = -2 * own["zeta"] + 2 * math.log(own["e"]) * rate
    assert abs(float(spectrum["lyapunov_exponent"].sum()) - shrinking) < 1e-9
