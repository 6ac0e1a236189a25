"""Rebuild the system of a result."""

import os
from typing import TYPE_CHECKING, Any

from chaosdrill.annotations import Dataset, DataTree
from chaosdrill.errors import ArchiveError, ChaosdrillError
from chaosdrill.names import brief
from chaosdrill.systems import REGISTRY
from chaosdrill.workflow.run_scene import system_of

if TYPE_CHECKING:
    from chaosdrill.model import HybridSystem

_TOLD_BY = ("definition", "parameters", "initial")


def system(result: "Dataset | DataTree | str | os.PathLike[str]") -> "HybridSystem":
    """The system of a dataset or an archive, with its parameters and its initial state.

    Parameters
    ----------
    result : xarray.Dataset, xarray.DataTree or path-like
        The result of an analysis, a part of it, an archive as `open` returns it, or a file.

    Returns
    -------
    HybridSystem
        The same equations and numbers, to the last bit.

    Raises
    ------
    ArchiveError
        If the attributes hold no system, or if the groups of an archive hold several.
    """
    import xarray as xr

    if isinstance(result, str | os.PathLike):
        from chaosdrill.archive import open as open_archive

        if result in REGISTRY and not os.path.exists(result):
            raise ArchiveError(f"{result}: there is no such archive; chaosdrill.build({result!r}) builds that system")
        result = open_archive(result)
    if isinstance(result, xr.Dataset):
        return _built(result, "the dataset")
    if not isinstance(result, xr.DataTree):
        raise ArchiveError(f"result is {brief(result)}; it must be a dataset, an archive, or the name of its file")
    groups = [node for node in result.subtree if "kind" in node.attrs]
    if not groups:
        raise ArchiveError("the archive holds no result of an analysis, and so no system")
    kinds: dict[tuple[Any, ...], str] = {}
    for node in groups:
        kinds.setdefault(tuple(node.attrs.get(name) for name in _TOLD_BY), node.path.strip("/"))
    if len(kinds) > 1:
        first = next(iter(kinds.values()))
        raise ArchiveError(
            f"the groups have several systems: those of {', '.join(kinds.values())} differ; name one, as in "
            f"system(tree[{first!r}].to_dataset())"
        )
    return _built(groups[0].to_dataset(), groups[0].path)


def _built(ds: Dataset, what: str) -> "HybridSystem":
    if "definition" not in ds.attrs:
        reason = str(ds.attrs.get("definition_missing", "its attributes, which contain the system, are missing"))
        raise ArchiveError(f"{what} has no system: {reason:.500}")
    try:
        return system_of(ds)
    except ArchiveError:
        raise
    except ChaosdrillError as fault:
        raise ArchiveError(f"the system of {what} cannot be built: {fault}") from fault
