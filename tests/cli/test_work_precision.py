"""A scene asks what accuracy costs: advice on stdout, a verified archive, a picture."""

import pytest

from chaosdrill.cli import main

SCENE = """\
[system]
model = "impact-oscillator"
[system.parameters]
wall = 0.0
zeta = 0.0
[analysis.cost]
kind = "work-precision"
periods = 32
transient = 2000
methods = ["taylor"]
tolerances = [1e-4, 1e-10]
repeats = 1
"""


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cost")
    (folder / "scene.toml").write_text(SCENE)
    return folder


def test_the_whole_road(archive, capsys):
    assert main(["run", str(archive / "scene.toml"), "-o", str(archive / "cost.nc")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "cost: outcome ok 2" in lines
    assert any(
        line.startswith("cost: 8 digits of ") and "multipliers" in line and "use taylor" in line for line in lines
    )
    # times differ from run to run, and no comparison asks for the same
    assert main(["verify", str(archive / "cost.nc")]) == 0
    assert main(["plot", str(archive / "cost.nc"), "-o", str(archive / "cost.png")]) == 0
    assert (archive / "cost.png").stat().st_size > 10_000
