"""Events of any array, and closings that are only computed."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any, Mapping, Union

from . import _native

if TYPE_CHECKING:
    import numpy.typing as npt

_File = Union[str, "os.PathLike[str]"]


def _path(file: _File | None) -> str:
    """A file for C++: absolute, because a plan's own paths are relative to the plan."""
    return "" if file is None else os.path.abspath(os.fspath(file))


def extract(
    data: _native.Record | Mapping[str, npt.ArrayLike],
    sample_rate: float | None = None,
    *,
    first_time: float | None = None,
    mains_hertz: float = math.nan,
    calibration: str = "",
    **options: Any,
) -> _native.Events:
    """Events of one closing, as `powbench events` extracts them.

    data: a Record, or channels by name (`powbench.channels()` lists them), each a one-dimensional array in SI, all of one
        length; nan is a lost sample. Arrays are divided into the counts of a converter (at least 64 000 steps over their
        range, or the converter's own where the values lie on its grid).
    sample_rate: Hz, 1e3 .. 2.5e6, of arrays.
    first_time: s after switch-on of the first sample, of arrays: -0.02 where the record begins 20 ms before it.
    mains_hertz: nominal mains frequency; nan: 50 Hz is where the fit begins.
    calibration: its name; without one every result carries the flag no_calibration.
    options: extraction options by name, `powbench.extract_options()` lists them with default and meaning.

    Raises BadInput for unknown channels or options, unequal lengths and impossible numbers; ValueError for an option out of
    its range. Other threads run meanwhile.
    """
    if isinstance(data, _native.Record):
        if sample_rate is not None or first_time is not None:
            raise _native.BadInput("extract: a Record has its own clock; sample_rate and first_time go with arrays")
        return _native.extract_record(data, options)
    if sample_rate is None or first_time is None:
        raise _native.BadInput("extract: arrays need sample_rate (Hz) and first_time (s after switch-on)")
    record = _native.record_from_arrays(dict(data), sample_rate, first_time, mains_hertz, calibration)
    return _native.extract_record(record, options)


def simulate(
    angle_deg: float,
    *,
    supply_volts: float = 230,
    mains_hertz: float = 50,
    hold_time_ms: float = 100,
    ambient_degC: float = 20,
    seed: int = 1,
    specimen: _File | None = None,
    sensors: _File | None = None,
) -> _native.Closing:
    """One simulated closing, as `powbench sim` makes it: plant, virtual sensors without noise, extraction.

    Arguments and their ranges are those of the plan file (`powbench plan template plan`).
    specimen: specimen file (TOML); None: the reference contactor. sensors: rig file (TOML); None: the built-in rig.

    Raises BadInput with every mistake. Other threads run meanwhile.
    """
    args = _native.ClosingArgs(
        angle_deg, supply_volts, mains_hertz, hold_time_ms, ambient_degC, 1.0, seed, _path(specimen)
    )
    return _native.simulate_closing(args, _path(sensors))
