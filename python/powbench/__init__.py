"""powbench in Python: stores, events, simulated closings and rigs.

    import powbench
    store = powbench.open("lab.db")
    store.shots()                              # pandas.DataFrame, one row a shot
    store.waveforms(["pvdf_a", "laser"])       # xarray.Dataset (shot, time)
    powbench.extract({"pvdf_a": a}, 100e3, first_time=-0.02)
    powbench.simulate(60).events.quantities["t_ct1"]
    with powbench.Rig("sim:") as rig:
        rig.fire(60)

All values are SI except where a name says otherwise (`angle_deg`, `hold_time_ms`). What is not known is NaN or None, never
zero. Errors are sentences: `powbench.Error` is the base of BadInput, StoreError, WrongStore and RigError.
"""

from __future__ import annotations

from ._native import (
    BadInput,
    Closing,
    CoilEvents,
    Contact,
    ContactTrain,
    CoreEvents,
    Error,
    Events,
    Measured,
    Record,
    RigError,
    Shot,
    StoreError,
    WrongStore,
    __version__,
    channels,
    extract_options,
    quantities,
    rig_kinds,
)
from .closing import extract, simulate
from .frames import to_pandas, to_xarray
from .rig import Rig
from .store import Store, open

__all__ = [
    "BadInput",
    "Closing",
    "CoilEvents",
    "Contact",
    "ContactTrain",
    "CoreEvents",
    "Error",
    "Events",
    "Measured",
    "Record",
    "Rig",
    "RigError",
    "Shot",
    "Store",
    "StoreError",
    "WrongStore",
    "__version__",
    "channels",
    "extract",
    "extract_options",
    "open",
    "quantities",
    "rig_kinds",
    "simulate",
    "to_pandas",
    "to_xarray",
]
