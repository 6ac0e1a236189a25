"""Pictures of results. Every module is imported here, so that all pictures are known."""

from importlib import import_module

from chaosdrill.package import modules
from chaosdrill.plots.animation import animate
from chaosdrill.plots.pictures import PICTURES, Picture, behind, plan, plot, plot_archive

__all__ = ["PICTURES", "Picture", "animate", "behind", "plan", "plot", "plot_archive"]

for _module in modules("plots"):
    import_module(f"{__name__}.{_module}")
