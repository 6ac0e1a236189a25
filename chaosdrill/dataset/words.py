"""Results in words: meanings of codes, and events as a table. Importing this adds the accessor ``cd`` to datasets."""

from collections import Counter

import numpy as np
import pandas as pd
import xarray as xr

from chaosdrill.dataset.outcomes import ADVICE, flag_names, holds_codes
from chaosdrill.errors import ChaosdrillError

_MODES = ("mode_before", "mode_after")


@xr.register_dataset_accessor("cd")
class Words:
    """A result in words, as ``ds.cd``.

    It exists once a result has been computed or opened, or if xarray is imported before chaosdrill.

    Parameters
    ----------
    ds : xarray.Dataset
        What an analysis has returned, a group of an archive, or a part of it.
    """

    def __init__(self, ds: xr.Dataset) -> None:
        self._ds = ds

    @property
    def outcome(self) -> "str | xr.DataArray":
        """How the run ended, such as ``"chaotic"``; for many runs an array of such words in the shape of ``outcome``.

        Raises
        ------
        ChaosdrillError
            If the dataset has no outcome, or arithmetic has changed it, as in ``ds - ds``.
        """
        words = self.words("outcome")
        return words if words.ndim else str(words.values)

    @property
    def advice(self) -> str:
        """What the outcomes mean and what to try, a line for each with the number of its runs; after it the message.

        Raises
        ------
        ChaosdrillError
            As `outcome`.
        """
        counts = Counter(np.atleast_1d(self.words("outcome").values).ravel().tolist())
        many = sum(counts.values()) > 1
        lines = [
            f"{name}{f' ({count} of {counts.total()})' if many else ''}: {ADVICE.get(name, 'no outcome of a run')}"
            for name, count in counts.most_common()
        ]
        return "\n".join([*lines, *filter(None, [str(self._ds.attrs.get("message", ""))])])

    def words(self, name: str) -> xr.DataArray:
        """A variable of codes, such as ``mode``, ``event_kind`` or ``special_point``, as the words that they stand for.

        Parameters
        ----------
        name : str
            Name of the variable.

        Returns
        -------
        xarray.DataArray
            Texts with the dimensions and coordinates of the variable; ``"none"`` for -1 and for missing values, ``"code
            N"`` for a code without a meaning.

        Raises
        ------
        ChaosdrillError
            If the dataset has no such variable, if it does not hold codes, or if it was computed from codes: selected,
            sorted and joined codes remain codes; a difference, a mean or a maximum is a number.
        """
        if name not in self._ds.variables:
            raise ChaosdrillError(f"{self._what()} has no variable {name!r}; it has {', '.join(map(str, self._ds))}")
        codes = self._ds[name]
        if codes.size and not holds_codes(codes):
            if "flag_values" in codes.attrs:
                raise ChaosdrillError(
                    f"{name} was computed from codes and holds numbers, not codes; take the words before, as in "
                    f"ds.cd.words({name!r})"
                )
            known = [str(key) for key, variable in self._ds.variables.items() if holds_codes(variable)]
            raise ChaosdrillError(f"{name} holds numbers, not codes; variables with codes: {', '.join(known)}")
        names = {-1: "none"} | flag_names(codes)
        # where sets of runs do not overlap xarray fills them up with NaN
        values = np.nan_to_num(codes.values, nan=-1).ravel().astype(int).tolist()
        texts = [names.get(code, f"code {code}") for code in values]
        kept = {key: value for key, value in codes.attrs.items() if key == "long_name"}
        return xr.DataArray(np.array(texts, dtype=str).reshape(codes.shape), codes.coords, codes.dims, name, kept)

    @property
    def events(self) -> pd.DataFrame:
        """Events of a trajectory or of periodic orbits, one row each.

        Columns are ``time``, ``kind`` (name of the transition), ``speed``, modes before and after where they are known,
        and ``x_before`` and ``x_after`` for each state ``x``. Rows are numbered; where there are several runs or orbits
        these come first in the index.

        Raises
        ------
        ChaosdrillError
            If the dataset has no events, one of their variables is missing, or a selection removed the dimension
            ``event``.
        """
        ds = self._ds
        if "event_time" not in ds.variables:
            raise ChaosdrillError(f"{self._what()} has no events; trajectories and periodic orbits have them")
        needed = ("event_kind", "event_speed", "event_state_before", "event_state_after", "state")
        if missing := [name for name in needed if name not in ds.variables]:
            raise ChaosdrillError(
                f"{self._what()} has events without {', '.join(missing)}; take the table before a part"
            )
        if "event" not in ds.dims:
            raise ChaosdrillError(
                "one event alone has no dimension; select it as isel(event=[0]), or take the table and then its row"
            )
        columns = {name: ds[f"event_{name}"] for name in ("time", "kind", "speed")}
        columns |= {name: ds[f"event_{name}"] for name in _MODES if f"event_{name}" in ds.variables}
        columns |= {name: self.words(f"event_{name}") for name in columns if name in ("kind", *_MODES)}
        for state in np.atleast_1d(ds["state"].values):
            for side in ("before", "after"):
                states = ds[f"event_state_{side}"]
                columns[f"{state}_{side}"] = states.sel(state=state) if "state" in states.dims else states
        shape = ds["event_time"].shape
        numbers = np.broadcast_to(np.arange(ds.sizes["event"]), shape).ravel()
        index: pd.Index = pd.Index(numbers, name="event")
        if "orbit" in ds["event_time"].dims:
            orbits = np.repeat(ds["orbit"].values, shape[-1])
            index = pd.MultiIndex.from_arrays([orbits, numbers], names=["orbit", "event"])
        elif "run" in ds.coords:
            counts = np.atleast_1d(ds["event_count"].values)
            if counts.sum() != ds.sizes["event"]:
                raise ChaosdrillError(
                    "events of joined runs are in one row, from which xarray cannot select those of a run; take all "
                    "events, and those of one run from the table, as in joined.cd.events.loc[name]"
                )
            runs = np.repeat(np.atleast_1d(ds["run"].values), counts)
            of_each = np.concatenate([np.arange(count) for count in counts])
            index = pd.MultiIndex.from_arrays([runs, of_each], names=["run", "event"])
        found = pd.DataFrame({name: column.values.ravel() for name, column in columns.items()}, index=index)
        # orbits with fewer events than others are filled up
        return found[ds["event_kind"].values.ravel() != -1]

    def _what(self) -> str:
        kind = self._ds.attrs.get("kind")
        return "this dataset" if kind is None else f"this dataset of kind {kind}"
