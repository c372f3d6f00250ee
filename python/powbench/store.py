"""A store for reading: campaigns, shots, waveforms."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Sequence, Union

from . import _native
from .frames import TIME, channel_attrs

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_SHOT_UNITS = {
    "angle": "deg",
    "angle_reached": "deg",
    "u_angle_reached": "deg",
    "supply": "V",
    "mains": "Hz",
    "hold_time": "s",
    "ambient": "K",
}


class Store:
    """The file that `powbench run --db` writes, opened for reading. It may grow meanwhile; threads may share it."""

    def __init__(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Raises WrongStore when no store is there, StoreError when it is damaged."""
        self._store = _native.Store(os.fspath(path))

    @property
    def path(self) -> str:
        return self._store.path

    def __repr__(self) -> str:
        return f"<powbench.Store {self.path}>"

    def campaigns(self) -> pd.DataFrame:
        """One row a campaign, by id: name, created (UTC), origin, rig, finished, number of measured and simulated shots,
        and the resolved plan and specimen (TOML)."""
        import pandas as pd

        table = pd.DataFrame(self._store.campaigns())
        if table.empty:
            return table
        table["created"] = pd.to_datetime(table["created"], utc=True)
        return table.set_index("campaign")

    def shots(self, campaign: int | None = None, kind: str | None = "measured") -> pd.DataFrame:
        """One row a shot, by id; of a shot that was repeated the last attempt.

        campaign: its id; None: the newest. kind: measured, simulated, or None for both.
        Columns: kind, number, repeat, attempt, outcome, reason, started (UTC), record_sha256 (empty: no record); what was
        asked: angle, supply, mains, hold_time, ambient; angle_reached; and each quantity of `powbench.quantities()`, with
        `u_` before its name for the standard uncertainty. `attrs["units"]` holds the units. NaN: not observed.
        """
        import pandas as pd

        table = pd.DataFrame(self._store.shots(campaign, kind)).set_index("shot")
        table["started"] = pd.to_datetime(table["started"], utc=True)
        units = dict(_SHOT_UNITS)
        for symbol, (unit, _) in _native.quantities().items():
            units[symbol] = units["u_" + symbol] = unit
        table.attrs["units"] = units
        return table

    def compare(self, campaign: int | None = None) -> pd.DataFrame:
        """Measured and simulated values of each quantity at each angle, as `powbench compare` prints them (SI)."""
        import pandas as pd

        return pd.DataFrame(self._store.compare(campaign))

    def record(self, shot: int) -> _native.Record:
        """The record of one shot, its samples checked against their hash. Raises WrongStore, StoreError."""
        return self._store.record(shot)

    def events(self, shot: int) -> _native.Events | None:
        """The newest events of one shot; None where it has no record."""
        return self._store.events(shot)

    def waveforms(
        self,
        channels: Sequence[str] | None = None,
        *,
        campaign: int | None = None,
        kind: str = "measured",
        shots: Sequence[int] | None = None,
        dtype: str = "float32",
        threads: int | None = None,
    ) -> xr.Dataset:
        """Channels of many shots: a variable (shot, time) for each channel, SI, NaN where samples were lost.

        channels: names; None: all. shots: ids; None: those of the campaign (None: the newest) that have a record.
        dtype: float32 (holds each count; rounds by less than 6e-8 of the value) or float64.
        Coordinates: shot; time, s after switch-on of the nominal sample; fire_offset (shot), s: a sample was taken at
        time + fire_offset; angle (shot), deg, as commanded.

        Every record is checked against its hash. Raises BadInput when the shots do not share a time axis, StoreError when one
        is damaged. Reads on `threads` threads (None: all cores) without the interpreter.
        """
        import numpy as np
        import xarray as xr

        if dtype not in ("float32", "float64"):
            raise _native.BadInput(f"dtype = '{dtype}': allowed float32, float64")
        table = self._store.shots(campaign, kind) if shots is None else None
        if table is not None:
            has_record = [i for i, sha in enumerate(table["record_sha256"]) if sha]
            ids = [table["shot"][i] for i in has_record]
            angles = np.asarray(table["angle"])[has_record]
        else:
            ids = [int(s) for s in shots or ()]
            angles = None
        names = list(_native.channels() if channels is None else channels)
        read = self._store.waveforms(ids, names, dtype == "float64", threads or os.cpu_count() or 1)
        time = (np.arange(read["samples"]) - read["fire_sample"]) / read["sample_rate"]
        coords = {
            "shot": ("shot", ids),
            "time": ("time", time, TIME),
            "fire_offset": ("shot", read["fire_offset"], {"units": "s", "long_name": "from switch-on to the sample at time 0"}),
        }
        if angles is not None:
            coords["angle"] = ("shot", angles, {"units": "deg", "long_name": "commanded closing angle"})
        variables = {name: (("shot", "time"), read["arrays"][name], channel_attrs(name)) for name in names}
        return xr.Dataset(variables, coords=coords, attrs={"store": self.path, "sample_rate_hz": read["sample_rate"]})


def open(path: Union[str, "os.PathLike[str]"]) -> Store:  # noqa: A001 - powbench.open, as in netCDF4 and zarr
    """Opens a store for reading. Raises WrongStore when none is there, StoreError when it is damaged."""
    return Store(path)
