"""Pictures of results. Every module is imported here, so that all pictures are known."""

from importlib import import_module
from pathlib import Path

from chaosdrill.plots.animation import animate
from chaosdrill.plots.pictures import PICTURES, Picture, behind, plan, plot, plot_archive

__all__ = ["PICTURES", "Picture", "animate", "behind", "plan", "plot", "plot_archive"]

for _file in sorted(Path(__file__).parent.glob("[!_]*.py")):
    import_module(f"{__name__}.{_file.stem}")
