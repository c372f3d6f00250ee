"""A rig: single closings and plans."""

from __future__ import annotations

import os
from types import TracebackType
from typing import Any, Union

from . import _native
from .closing import _path


class Rig:
    """A rig by its URI, as `powbench run --rig` names it: sim:, sim:RIG.toml, qemu:, ip:ADDRESS, usb:..., serial:PORT,BAUD.

    Use it in a `with` block. Everything goes the way of the command line: the rig's lease, its interlocks, its sealed
    account of each shot. A coil is energised by `fire` and `run` alone. Ctrl-C during either switches the coil off.
    """

    def __init__(self, uri: str, *, specimen: Union[str, "os.PathLike[str]", None] = None) -> None:
        """specimen: file of the contactor on a simulated rig; None: that of its rig file. Raises RigError, BadInput."""
        self._rig = _native.Rig(uri, _path(specimen))

    def __enter__(self) -> Rig:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def info(self) -> dict[str, Any]:
        """What the rig says of itself: model, serial, firmware, origin, channels as {name: (unit, SI unit per count)}."""
        return self._rig.info()

    def status(self) -> dict[str, str]:
        """state (idle, armed, firing, captured, fault), fault, phase, owner and last_error at this moment; any thread."""
        return self._rig.status()

    def fire(
        self,
        angle_deg: float,
        *,
        supply_volts: float = 230,
        mains_hertz: float = 50,
        hold_time_ms: float = 100,
        ambient_degC: float = 20,
        angle_tolerance_deg: float = 1,
        seed: int = 1,
    ) -> _native.Shot:
        """One closing: claim, arm, fire, read, extract, judge the angle. Nothing is stored; `run` stores.

        Arguments and their ranges are those of the plan file. Voltage, frequency, ambient and seed are set on rigs with a
        programmable source, elsewhere only noted. What a rig may do is no exception: see outcome and reason of the result.
        Raises BadInput for arguments, RigError when the rig is closed.
        """
        return self._rig.fire(
            _native.ClosingArgs(
                angle_deg, supply_volts, mains_hertz, hold_time_ms, ambient_degC, angle_tolerance_deg, seed, ""
            )
        )

    def run(
        self,
        plan: Union[str, "os.PathLike[str]"],
        db: Union[str, "os.PathLike[str]"],
        *,
        resume: bool = False,
        progress: str = "none",
    ) -> dict[str, Any]:
        """Fires a plan and stores every shot, as `powbench run PLAN --rig URI --db DB` does.

        resume: go on with the newest campaign of this plan. progress: none, auto, bar or lines, to stderr.
        Returns campaign, planned, done, the number of shots of each outcome, and why it stopped early, else None.
        Raises BadInput, StoreError, RigError.
        """
        return self._rig.run(os.fspath(plan), os.fspath(db), resume, progress)

    def stop(self) -> str:
        """Coil off, whoever owns the rig; any thread, also while it fires. Returns the rig's state afterwards."""
        return self._rig.stop()

    def close(self) -> None:
        """Gives the rig back."""
        self._rig.close()
