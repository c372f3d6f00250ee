"""Records as xarray, events as pandas. Both libraries are imported when they are first needed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Sequence

from . import _native

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

TIME = {"units": "s", "long_name": "time after switch-on"}


def channel_attrs(name: str) -> dict[str, Any]:
    unit, meaning = _native.channels()[name]
    return {"units": unit, "long_name": meaning}


def to_xarray(record: _native.Record, channels: Sequence[str] | None = None) -> xr.Dataset:
    """One record: a float64 variable (time) for each channel, SI, nan where samples were lost.

    `time` is s after switch-on, exact for this shot. Each variable's attrs hold units, long_name, and scale, offset, delay_s,
    corner_hertz and the clip limits of its counts; those of the dataset what the closing was asked to be, and the rig.
    """
    import xarray as xr

    names = list(record.channels if channels is None else channels)
    variables = {}
    for name in names:
        facts = record.channel(name)
        attrs = channel_attrs(name)
        attrs.update({k: v for k, v in facts.items() if k not in ("unit", "meaning")})
        variables[name] = ("time", record.values(name), attrs)
    attrs = dict(record.conditions)
    attrs.update(sample_rate_hz=record.sample_rate, rig=record.rig, firmware=record.firmware, calibration=record.calibration)
    return xr.Dataset(variables, coords={"time": ("time", record.times(), TIME)}, attrs=attrs)


def to_pandas(events: _native.Events) -> pd.DataFrame:
    """Every contact of every channel: one row a contact, times in s after switch-on, each with its standard uncertainty.

    Columns: channel, contact (1 first), touch, u_touch, release, u_release, peak, u_peak, impulse, u_impulse, flags.
    `attrs["units"]` holds the unit of each.
    """
    import pandas as pd

    values = ("touch", "release", "peak", "impulse")
    rows = []
    for channel in ("pvdf_a", "pvdf_b", "contact_voltage"):
        for i, contact in enumerate(getattr(events, channel).contacts, 1):
            row: dict[str, Any] = {"channel": channel, "contact": i}
            for value in values:
                measured = getattr(contact, value)
                row[value], row["u_" + value] = measured.value, measured.u
            row["flags"] = ", ".join(contact.flags)
            rows.append(row)
    columns = ["channel", "contact"] + [p + v for v in values for p in ("", "u_")] + ["flags"]
    table = pd.DataFrame(rows, columns=columns)
    units = {"touch": "s", "release": "s", "peak": "N", "impulse": "N s"}
    table.attrs["units"] = {p + v: unit for v, unit in units.items() for p in ("", "u_")}
    return table
