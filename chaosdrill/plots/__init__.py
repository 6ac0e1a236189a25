"""Pictures of results. Every module is imported here, so that all pictures are known."""

from importlib import import_module

from chaosdrill.errors import SettingsError
from chaosdrill.package import modules

try:
    import matplotlib  # noqa: F401
except ValueError as fault:
    raise SettingsError(
        "matplotlib cannot start; correct or remove the variable MPLBACKEND, or a file 'matplotlibrc' in the working "
        f"directory, in $MATPLOTLIBRC or in the user's folder of settings ({fault!s:.200})"
    ) from fault

from chaosdrill.plots.animation import animate
from chaosdrill.plots.pictures import PICTURES, Picture, behind, plan, plot, plot_archive

__all__ = ["PICTURES", "Picture", "animate", "behind", "plan", "plot", "plot_archive"]

for _module in modules("plots"):
    import_module(f"{__name__}.{_module}")
