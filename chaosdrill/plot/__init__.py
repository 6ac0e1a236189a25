"""Pictures of what is in an archive: one file a picture."""

from chaosdrill.plot.pictures import PICTURES, Picture, behind, plan, plot_archive

__all__ = ["PICTURES", "Picture", "behind", "plan", "plot_archive"]
