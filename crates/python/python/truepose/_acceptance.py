"""Acceptance tests after ISO 9283."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from truepose import _core
from truepose._arrays import Arrays, Path
from truepose._data import Data, taken
from truepose._fit import Fit
from truepose._robot import Robot

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Acceptance:
    """Figures of ISO 9283 (AP, RP, …) with their uncertainty, as measured and, with a fit, without what its model predicts."""

    __slots__ = ("_core", "_summary")

    def __init__(self, core: _core.Acceptance) -> None:
        self._core = core
        self._summary: dict[str, Any] = json.loads(core.summary())

    @property
    def summary(self) -> dict[str, Any]:
        """acceptance.json."""
        return self._summary

    @property
    def fails(self) -> bool:
        """Whether a figure does not conform to its limit: with the identified model where a fit is given."""
        return self._core.fails()

    @property
    def figures(self) -> dict[str, str]:
        """Figures of the report: name → SVG."""
        return dict(self._core.figures())

    def report(self, folder: Path) -> None:
        """Writes the report into a folder: `index.html`, its figures (SVG) and `acceptance.json`."""
        self._core.write_report(os.fspath(folder))

    def __str__(self) -> str:
        return self._core.text()

    def __repr__(self) -> str:
        return f"Acceptance({self._summary['robot']!r}, {self._summary['rows']} rows)"


def iso9283(
    robot: Robot | Fit,
    data: Data = None,
    *,
    align: str | None = None,
    instrument: float = 0.0,
    path: bool = False,
    spec: Mapping[str, float] | None = None,
    **arrays: Unpack[Arrays],
) -> Acceptance:
    """Pose accuracy, repeatability and the other figures of ISO 9283 from repeated poses, with their uncertainty.

    `robot`: as described, or a fit: then the same figures with the displacement that its model predicts taken off as well. `data`: each pose repeated;
    optional columns `pose`, `cycle`, `direction`, `speed`, `command_x` …. `align`: frames of instrument and robot, ``described`` (of a fit: as found)
    or ``best-fit``; `instrument`: standard uncertainty of a measured position in each axis that the readings of one pose share, m; `path`: the rows are
    points of a path, whose repeats `cycle` numbers; `spec`: limits, m, such as ``{"AP": 0.5e-3}`` (AP, RP, vAP, AD, RD, dAP, dRP, AT, RT).
    """
    fit = robot if isinstance(robot, Fit) else None
    nominal = robot.robot if isinstance(robot, Fit) else robot
    rows = taken(nominal, data, arrays)
    limits = [(str(name), float(limit)) for name, limit in (spec or {}).items()]
    return Acceptance(_core.iso9283(nominal._core, None if fit is None else fit._core, rows._core, align, float(instrument), path, limits))
