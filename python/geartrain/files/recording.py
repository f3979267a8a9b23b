"""Forces and torques over time as measurements: UFF 58 and MDF files, rainflow counts."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description
from .._core.extras import extra
from ..errors import InputError, shown
from .load_cycles import LoadCycles

__all__ = ["Channel", "Recording", "channels_of"]

Array = NDArray[np.float64]

#: Codes of universal files: of the quantity, of what its unit has of length and of force.
_UFF = {"N": (13, 0, 1), "N m": (13, 1, 1), "rpm": (19, 0, 0)}


class Channel(NamedTuple):
    """A quantity over time: its short name as ``'shaft 2'``, what it is, the bodies it is between, its unit and its values."""

    name: str
    what: str
    between: str
    unit: str
    values: Array

    @property
    def title(self) -> str:
        return f"{self.what}, {self.name}" + (f" ({self.between})" if self.between not in ("", self.name) else "")


class Recording:
    """Results over time: what motions and run-ups share."""

    def _recorded(self, periods: int, dense: int) -> tuple[Array, list[Channel], bool]:
        """Time [s], channels, and whether they repeat."""
        raise NotImplementedError

    def to_uff(self, path: str | os.PathLike[str], *, periods: int = 1) -> None:
        """Write mesh forces [N] and shaft torques [N m] over time as universal file, data set 58; needs pyuff.

        The file has the time step in a field of 13 columns, here with 8 digits: after 100 s times are off by at most 5 us.

        Parameters
        ----------
        path : path-like
            An existing file is replaced.
        periods : int
            Of a motion: periods of the fundamental.

        Raises
        ------
        ModuleNotFoundError
            Where pyuff is not installed.
        OSError
        """
        pyuff = extra("pyuff")
        time, channels, _ = self._recorded(periods, 1)
        # A path that cannot be written is an OSError here, and no exception of pyuff's own kind.
        open(path, "wb").close()
        target = pyuff.UFF(os.fspath(path))
        sets: list[dict[str, Any]] = [pyuff.prepare_164(
            units_code=1, units_description="SI", temp_mode=1, length=1.0, force=1.0, temp=1.0, temp_offset=273.15)]
        for number, channel in enumerate(channels, 1):
            kind, length, force = _UFF[channel.unit]
            sets.append(pyuff.prepare_58(
                binary=0, func_type=1, id1=channel.title[:80], id2="geartrain", id3="NONE", id4="NONE", id5="NONE", ver_num=0,
                load_case_id=0, rsp_ent_name="NONE", rsp_node=number, rsp_dir=0, ref_ent_name="NONE", ref_node=0, ref_dir=0,
                ord_data_type=4, num_pts=len(time), abscissa_spacing=1, abscissa_min=float(time[0]),
                abscissa_inc=float((time[-1] - time[0]) / (len(time) - 1)), z_axis_value=0.0, abscissa_spec_data_type=17,
                abscissa_len_unit_exp=0, abscissa_force_unit_exp=0, abscissa_temp_unit_exp=0, abscissa_axis_units_lab="s",
                ordinate_spec_data_type=kind, ordinate_len_unit_exp=length, ordinate_force_unit_exp=force, ordinate_temp_unit_exp=0,
                ordinate_axis_units_lab=channel.unit, orddenom_spec_data_type=0, orddenom_len_unit_exp=0, orddenom_force_unit_exp=0,
                orddenom_temp_unit_exp=0, orddenom_axis_units_lab="NONE", z_axis_spec_data_type=0, z_axis_len_unit_exp=0,
                z_axis_force_unit_exp=0, z_axis_temp_unit_exp=0, z_axis_axis_units_lab="NONE", data=channel.values, x=time))
        target.write_sets(sets, mode="overwrite")
        _put_step(os.fspath(path), time)

    def to_mdf(self, path: str | os.PathLike[str], *, periods: int = 1) -> None:
        """Write mesh forces [N] and shaft torques [N m] over time as ASAM MDF 4; needs asammdf.

        Parameters
        ----------
        path : path-like
            Ends in ``.mf4``. An existing file is replaced.
        periods : int
            Of a motion: periods of the fundamental.

        Raises
        ------
        ModuleNotFoundError
            Where asammdf is not installed.
        OSError
        """
        name = os.fspath(path)
        if not name.lower().endswith(".mf4"):
            raise InputError(f"path = {shown(name)}: must end in .mf4, as files of ASAM MDF 4 do")
        asammdf = extra("asammdf")
        time, channels, _ = self._recorded(periods, 1)
        # A folder that is not there is an OSError: asammdf would make it.
        open(name, "wb").close()
        with asammdf.MDF(version="4.10") as target:
            target.append([asammdf.Signal(samples=channel.values, timestamps=time, name=channel.title, unit=channel.unit)
                           for channel in channels], comment="geartrain", common_timebase=True)
            target.save(name, overwrite=True)

    def rainflow(self, of: str, *, periods: int = 0) -> LoadCycles:
        """Count the cycles of a torque or a force by the rainflow method (ASTM E1049-85); needs rainflow.

        Parameters
        ----------
        of : str
            ``'shaft 2'``, ``'mesh 1'``, ``'coupling 1'``, ``'bearing 1 x'``, or the name that results have for it, as
            ``'motor - pinion'``.
        periods : int
            Of a motion: periods of the fundamental; 0: its own period, which is counted as if it went on without end.

        Returns
        -------
        LoadCycles

        Examples
        --------
        >>> cycles = branch.at(0.9)[0].rainflow("shaft 2")
        >>> cycles.unit, cycles.count.sum(), round(cycles.damage_equivalent(exponent=6.0), 1)  # doctest: +SKIP
        """
        time, channels, repeats = self._recorded(periods or 1, 4)
        channel = _one_of(of, [channel for channel in channels if channel.unit != "rpm"])
        values = channel.values
        if not np.isfinite(values).all():
            raise InputError(f"of = {shown(of)}: is not determined, as rigid shafts side by side leave it so")
        if repeats:
            # From the largest value to the largest value of the next period there are whole cycles only.
            first = int(np.argmax(values))
            values = np.concatenate([values[first:], values[:first + 1]])
        step = (time[-1] - time[0]) / max(len(time) - 1, 1)
        rows = list(extra("rainflow").extract_cycles(values))
        found = np.array([row[:3] for row in rows], dtype=float).reshape(-1, 3)
        return LoadCycles(channel.title, channel.unit, float(step * (len(time) if repeats else len(time) - 1)), *found.T)


def _put_step(path: str, time: Array) -> None:
    """Write the time step of each data set 58 with 8 digits and a blank before them: pyuff writes 6 into the same field."""
    head = f"{4:10d}{len(time):10d}{1:10d}{time[0]:13.5e}"
    step = f"{(time[-1] - time[0]) / (len(time) - 1):.7e}".replace("e-0", "e-").rjust(13)
    if len(step) > 13:
        return
    with open(path, encoding="utf-8", newline="") as file:
        text = file.read()
    with open(path, "w", encoding="utf-8", newline="") as file:
        file.write(re.sub(f"(?m)^{re.escape(head)}.{{13}}", lambda _: head + step, text))


def channels_of(train: Description | None, mesh_force: Array, shaft_torque: Array) -> list[Channel]:
    """Forces of meshes and bearings, torques of couplings and shafts, (samples, meshes) and (samples, shafts), as channels."""
    names = train.mesh_labels if train else ("",) * mesh_force.shape[1]
    shafts = train.shaft_labels if train else ("",) * shaft_torque.shape[1]
    elements = train.mesh_elements if train else [f"mesh {place + 1}" for place in range(mesh_force.shape[1])]
    found = []
    for place, element in enumerate(elements):
        kind = element.split()[0]
        of, unit = ("torque", "N m") if kind == "coupling" else ("force", "N")
        found.append(Channel(element, f"{kind} {of}", names[place], unit, mesh_force[:, place]))
    found += [Channel(f"shaft {place + 1}", "shaft torque", shafts[place], "N m", shaft_torque[:, place])
              for place in range(shaft_torque.shape[1])]
    return found


def _one_of(of: Any, channels: Sequence[Channel]) -> Channel:
    for channel in channels:
        if of in (channel.name, channel.between):
            return channel
    raise InputError(f"of = {shown(of)}: must be one of {', '.join(repr(channel.name) for channel in channels)}")
