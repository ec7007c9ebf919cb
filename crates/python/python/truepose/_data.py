"""Measurements of a robot."""

from __future__ import annotations

import os
import warnings as _warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from truepose import _core
from truepose._arrays import Arrays, Floats, Frame, Path, columns_of, table
from truepose._core import InputError
from truepose._robot import Robot
from truepose._table import Table

if TYPE_CHECKING:
    from typing_extensions import Unpack


class TrueposeWarning(UserWarning):
    """Something in the input is suspicious, and not wrong."""


class Measurements:
    """Measurements of a robot, read and checked once; every verb takes them in place of a table.

    Made by `truepose.read` (a file) and `truepose.measurements` (a frame, or arrays). All values are in SI units.
    """

    __slots__ = ("_core", "robot")

    def __init__(self, core: _core.Data, robot: Robot) -> None:
        self._core = core
        self.robot = robot

    def __len__(self) -> int:
        return len(self._core)

    @property
    def warnings(self) -> list[str]:
        """What is suspicious."""
        return self._core.warnings

    @property
    def visits(self) -> int:
        """Number of pose measurements (dwells of the robot)."""
        return self._core.counts[1]

    @property
    def configurations(self) -> int:
        """Number of different configurations (joint values and load)."""
        return self._core.counts[2]

    @property
    def q(self) -> Floats:
        """Joint variables, rad or m, n × dof."""
        return self._core.q

    @property
    def position(self) -> Floats:
        """Measured positions in the measurement frame, m, n × 3; NaN is not measured."""
        return self._core.position

    @property
    def orientation(self) -> Floats:
        """Measured orientations, quaternions w x y z, n × 4; NaN is not measured."""
        return self._core.orientation

    @property
    def payload(self) -> Floats:
        """Mass carried, kg; NaN where a wrench was measured."""
        return self._core.payload

    @property
    def target(self) -> list[str | None]:
        """Name of the measured target; None is the tool's origin."""
        return self._core.target

    @property
    def session(self) -> list[str | None]:
        """Name of the session (installation of robot and instrument); None in a table of one."""
        return self._core.session

    @property
    def landmark(self) -> list[str | None]:
        """Name of the landmark that was touched or measured with; None where a pose was measured."""
        return self._core.landmark

    @property
    def visit(self) -> NDArray[np.int64]:
        """Number of the pose measurement of each row, from 0."""
        return self._core.visit

    @property
    def configuration(self) -> NDArray[np.int64]:
        """Number of the configuration of each row, from 0: the groups that a cross-validation must not cut."""
        return self._core.configuration

    @property
    def channels(self) -> Mapping[str, Floats]:
        """Further columns by name (temperatures in degC)."""
        return self._core.channels

    @property
    def columns(self) -> Table:
        """What each column was understood as."""
        rows = self._core.columns
        low = [visited[0] if visited else np.nan for *_, visited in rows]
        high = [visited[1] if visited else np.nan for *_, visited in rows]
        names = {"column": 0, "unit": 1, "meaning": 2, "filled": 3}
        columns: dict[str, Any] = {header: [row[k] for row in rows] for header, k in names.items()}
        return Table({**columns, "lowest": low, "highest": high})

    def select(self, rows: ArrayLike) -> Measurements:
        """Some of the rows (numbers from 0, or a mask); pose measurements and directions of approach stay as they were."""
        chosen = np.asarray(rows)
        if chosen.dtype == bool:
            if chosen.shape != (len(self),):
                raise InputError(f"a mask of rows has to have {len(self)} values")
            chosen = np.flatnonzero(chosen)
        return Measurements(self._core.select([int(row) for row in np.sort(chosen)]), self.robot)

    def __repr__(self) -> str:
        return f"Measurements({len(self)} rows, {self.visits} pose measurements, {self.configurations} configurations)"


Data: TypeAlias = "Measurements | Frame | Path | None"
"""Measurements: a frame, a mapping from headers to columns, a file, or what `truepose.measurements` made; None: arrays as keywords."""


def read(
    robot: Robot,
    path: Path,
    *,
    convention: str | None = None,
    columns: Mapping[str, str] | None = None,
    ignore: Sequence[str] = (),
    positions_only: bool = False,
    measured: bool = True,
) -> Measurements:
    """Reads a file of measurements: CSV, Parquet or Excel.

    `convention`: that of its angles (``rpy``, ``abc``, ``wpr``, …); `columns`: our name → the file's header, such as ``{"A1": "Joint 1[deg]"}``;
    `ignore`: headers that are not read; `positions_only`: orientations are not used; `measured`: whether something has to be measured.
    """
    core = _core.read_data(
        robot._core, os.fspath(path), measured, convention, list((columns or {}).items()), list(ignore), positions_only
    )
    return Measurements(core, robot)


def measurements(
    robot: Robot,
    data: Frame | None = None,
    *,
    convention: str | None = None,
    columns: Mapping[str, str] | None = None,
    ignore: Sequence[str] = (),
    positions_only: bool = False,
    measured: bool = True,
    **arrays: Unpack[Arrays],
) -> Measurements:
    """Checks measurements in memory: a frame with the headers of files (``j1[deg]``, ``x[mm]`` …), or arrays in SI units as keywords.

    `convention` is that of columns with angles (``rpy``, ``abc``, ``wpr``, …); the other options are those of `read`.
    """
    if data is not None and arrays:
        raise InputError(f"give either a table or arrays, and not both (arrays: {', '.join(arrays)})")
    taken = table(data if data is not None else columns_of(robot, arrays))
    core = _core.take_data(
        robot._core, taken, measured, convention, list((columns or {}).items()), list(ignore), positions_only
    )
    return Measurements(core, robot)


def taken(robot: Robot, data: Data, arrays: Arrays, *, positions_only: bool = False, measured: bool = True) -> Measurements:
    """What a verb was given, as measurements; warnings are issued where they are read here."""
    if isinstance(data, Measurements):
        if arrays:
            raise InputError(f"give either measurements or arrays, and not both (arrays: {', '.join(arrays)})")
        if positions_only:
            raise InputError("positions_only belongs to truepose.read or truepose.measurements where these made the measurements")
        return data
    if isinstance(data, (str, os.PathLike)):
        if arrays:
            raise InputError(f"give either a file or arrays, and not both (arrays: {', '.join(arrays)})")
        made = read(robot, data, positions_only=positions_only, measured=measured)
    else:
        made = measurements(robot, data, positions_only=positions_only, measured=measured, **arrays)
    warn(made.warnings)
    return made


def warn(messages: Sequence[str]) -> None:
    """Passes warnings on."""
    for message in messages:
        _warnings.warn(message, TrueposeWarning, stacklevel=4)


__all__ = ["Data", "Measurements", "TrueposeWarning", "measurements", "read", "taken", "warn"]
