"""Robot programs with compensated points."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from truepose import _core
from truepose._arrays import Path, floats
from truepose._core import InputError
from truepose._fit import Fit
from truepose._table import Table

Place: TypeAlias = "str | ArrayLike"
"""A frame: its name, ``x,y,z,roll,pitch,yaw`` as on the command line (``"900mm,0mm,50mm,0,0,90"``), those six numbers in m and rad, or 4 × 4."""

Places: TypeAlias = "Place | Mapping[str, Place] | None"
"""One place for all points, or one for each name of the program."""


@dataclass(frozen=True, repr=False)
class Rewritten:
    """A robot program whose points are replaced by compensated ones, or all programs of a folder.

    `program`: its text in the encoding of the original (of a folder: empty); `others`: texts of the further files that have points of it, of a folder those
    of all programs, by their paths; `corrections`: a row for each point, in m and rad; `summary`: what the program prints with
    ``--json``; `notes`: what is to be known of it; `refused`: programs of a folder that are not compensated, and why.
    """

    program: bytes
    corrections: Table
    summary: dict[str, Any]
    notes: list[str]
    others: dict[str, bytes] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    folder: str | None = None

    @property
    def outcomes(self) -> NDArray[np.str_]:
        """What became of each point: ``corrected``, ``not significant`` or ``refused``."""
        return np.asarray(self.corrections["outcome"], dtype=np.str_)

    @property
    def offsets(self) -> list[dict[str, Any]]:
        """Values of frames and tools that correct the points: name, kind, value (in the form of the language), points, RMS before and after in mm."""
        return list(self.summary["offsets"])

    def save(self, path: Path) -> None:
        """Writes the program; of a folder all programs, to the same places in the folder `path`."""
        if self.folder is not None:
            for name, text in self.others.items():
                place = os.path.join(os.fspath(path), os.path.relpath(name, self.folder))
                os.makedirs(os.path.dirname(place), exist_ok=True)
                with open(place, "wb") as file:
                    file.write(text)
            return
        with open(os.fspath(path), "wb") as file:
            file.write(self.program)

    def __repr__(self) -> str:
        names, counts = np.unique(self.outcomes, return_counts=True)
        return f"Rewritten({', '.join(f'{count} {name}' for name, count in zip(names, counts))})"


def rewrite(
    fit: Fit,
    program: Path,
    *,
    others: Sequence[Path] = (),
    language: str | None = None,
    frames: Places = None,
    tools: Places = None,
    taught: Mapping[str, Path | tuple[Path, str]] | None = None,
    measured: Sequence[str] = (),
    cad: Sequence[str] = (),
    external: Mapping[str, str] | None = None,
    work: Mapping[str, str] | None = None,
    limit: float = 10e-3,
    mark: bool = False,
    leave: Sequence[str] = (),
    dry_run: bool = False,
    offsets: bool = False,
    controller_base: Place | None = None,
    controller_flange: Place | None = None,
    start: ArrayLike | None = None,
    payload: float | None = None,
    com: ArrayLike = (0.0, 0.0, 0.0),
    channels: Mapping[str, float] | None = None,
    ignore_external: bool = False,
    turn_axes: Sequence[int] = (),
    pulses: Sequence[float] = (),
) -> Rewritten:
    """A robot program with compensated points: KUKA .src .dat, ABB .mod, FANUC .ls, Universal Robots .script, Yaskawa .jbi, Stäubli .dtx. A
    folder is a controller's backup: all its programs, with its frames, tools and loads.

    `others`: further files of the program with motions, declarations or frames, whose points are compensated, too; `language`: krl, rapid, fanuc, urscript, inform, val3 (default: by the
    ending of the name); `frames`, `tools`: values of frames and tools by their names in the program, or one for points whose frame is not known;
    `taught`: frames and tools that were taught by touching with the uncorrected robot, with the file of the joints at which it was touched, or with that and the tool
    that touched; `measured`, `cad`: names of those that were measured, or are of a drawing; `external`: external axes of the program that are joints of the fit;
    `work`: frames on a positioner, with the tool of the fit that is there;
    `limit`: largest correction, m; `mark`: points that cannot be compensated stay as they are (otherwise: InputError); `leave`: names of
    points that do, with or without a value in the files; `dry_run`: all points do; `offsets`: other values of frames and tools in `Rewritten.offsets`, in place of a program;
    `controller_base`, `controller_flange`: those of the controller in the robot description's; `start`: joint values before the program, rad or m;
    `payload`, `com`: load carried, kg, m; `channels`: values that the model reads; `ignore_external`: external axes move nothing; `turn_axes`: axes of
    FANUC's three turn numbers; `pulses`: pulses per degree (per mm) of each axis, for INFORM.
    """
    first: list[float] = []
    if start is not None:
        joints = fit.robot.joints
        values = floats("start", np.atleast_1d(np.asarray(start)), len(joints))
        first = [float(v) * 1e3 if j.unit == "m" else float(np.degrees(v)) for v, j in zip(values, joints)]
    centre = floats("com", com, 3)
    load = None if payload is None else (float(payload), (float(centre[0]), float(centre[1]), float(centre[2])))
    touched = [(str(name), *((os.fspath(of[0]), str(of[1])) if isinstance(of, tuple) else (os.fspath(of), None))) for name, of in (taught or {}).items()]
    texts, found, summary, notes, refused = _core.rewrite(
        fit._core, os.fspath(program), [os.fspath(other) for other in others], language, _places("frames", frames), _places("tools", tools),
        touched, [str(name) for name in measured], [str(name) for name in cad], [(str(axis), str(joint)) for axis, joint in (external or {}).items()],
        [(str(name), str(tool)) for name, tool in (work or {}).items()],
        float(limit), mark, [str(name) for name in leave], dry_run, offsets, _six("controller_base", controller_base), _six("controller_flange", controller_flange), first, load,
        [(str(name), float(value)) for name, value in (channels or {}).items()], ignore_external, list(turn_axes), list(pulses),
    )  # fmt: skip
    columns: dict[str, Any] = {name: found[name] for name in ("point", "line", "kind", "frame", "tool", "outcome", "reason")}
    columns = {"file": [os.fspath(file) for file in found["file"]], **columns} if len(texts) > 1 else columns
    columns.update({f"{axis}[m]": found["position"][:, k] for k, axis in enumerate("xyz")})
    columns.update({f"d{axis}[m]": found["displacement"][:, k] for k, axis in enumerate("xyz")})
    columns.update({"rotation[rad]": found["rotation"], "within_95[m]": found["within_95"]})
    folder = os.fspath(program) if os.path.isdir(program) else None
    (_, text), *further = texts if folder is None else [("", b""), *texts]
    others_of = {os.fspath(file): other for file, other in further}
    return Rewritten(text, Table(columns), json.loads(summary), notes, others_of, {os.fspath(file): words for file, words in refused}, folder)


_Pose: TypeAlias = tuple[float, float, float, float, float, float]


def _places(what: str, given: Places) -> list[str | tuple[str | None, _Pose]]:
    if given is None:
        return []
    if isinstance(given, Mapping):
        return [_place(what, str(name), place) for name, place in given.items()]
    return [_place(what, None, given)]


def _place(what: str, name: str | None, place: Place) -> str | tuple[str | None, _Pose]:
    if isinstance(place, str):
        return place if name is None else f"{name}={place}"
    return name, _numbers(what, place)


def _six(what: str, place: Place | None) -> _Pose | None:
    if isinstance(place, str):
        raise InputError(f"{what}: six numbers (x y z roll pitch yaw, m and rad) or a transform 4 × 4 are needed")
    return None if place is None else _numbers(what, place)


def _numbers(what: str, place: ArrayLike) -> _Pose:
    array = np.asarray(place, dtype=np.float64) if not isinstance(place, np.ndarray) else place
    if array.shape == (4, 4):
        r = array[:3, :3]
        pitch = float(np.arctan2(-r[2, 0], np.hypot(r[0, 0], r[1, 0])))
        roll, yaw = float(np.arctan2(r[2, 1], r[2, 2])), float(np.arctan2(r[1, 0], r[0, 0]))
        x, y, z = (float(v) for v in array[:3, 3])
        return x, y, z, roll, pitch, yaw
    if array.shape != (6,):
        raise InputError(f"{what} has the shape {array.shape}; it has to be six numbers (x y z roll pitch yaw, m and rad) or 4 × 4")
    a, b, c, d, e, f = (float(v) for v in array)
    return a, b, c, d, e, f
