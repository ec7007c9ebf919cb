"""Fits: the identified robot."""

from __future__ import annotations

import base64
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from truepose import _core
from truepose._arrays import Arrays, Floats, Frame, Path, each, floats, quaternions, spread_over, table
from truepose._core import InputError
from truepose._data import Data, taken, warn
from truepose._effect import Effect
from truepose._robot import Robot
from truepose._table import Table

if TYPE_CHECKING:
    from typing_extensions import Unpack


@dataclass(frozen=True)
class Residuals:
    """Measured minus predicted, in the measurement frame: `position` n × 3, m; `orientation` n × 3, rotation vectors, rad. NaN is not measured."""

    position: Floats
    orientation: Floats

    @property
    def distance(self) -> Floats:
        """3-D position error of each row, m; NaN where a component was not measured."""
        distances: Floats = np.linalg.norm(self.position, axis=1)
        return distances

    @property
    def rms(self) -> float:
        """Root mean square of the 3-D position error, m; NaN without positions."""
        known = self.distance[np.isfinite(self.distance)]
        return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")

    @property
    def max(self) -> float:
        """Largest 3-D position error, m; NaN without positions."""
        known = self.distance[np.isfinite(self.distance)]
        return float(known.max()) if known.size else float("nan")


@dataclass(frozen=True)
class HeldOut(Residuals):
    """Residuals of cross-validation: each row is predicted by a fit without its fold. Position errors in m."""

    fold_rms: Sequence[float] = ()


@dataclass(frozen=True, repr=False)
class Predictions:
    """Poses of the real robot: `position` of each row's target n × 3, m, `orientation` of the tool (w, x, y, z) n × 4 in the measurement frame.

    With 95 % a new measurement lies no farther than `within_95` (m) from the position. `extrapolates`: the row lies beyond the data of the fit. NaN
    orientations are not known to the fit.
    """

    position: Floats
    orientation: Floats
    within_95: Floats
    extrapolates: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.position)

    @property
    def pose(self) -> Floats:
        """Homogeneous transforms n × 4 × 4."""
        w, x, y, z = self.orientation.T
        result = np.zeros((len(self), 4, 4))
        result[:, 0, 0], result[:, 0, 1], result[:, 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        result[:, 1, 0], result[:, 1, 1], result[:, 1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        result[:, 2, 0], result[:, 2, 1], result[:, 2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        result[:, :3, 3] = self.position
        result[:, 3, 3] = 1.0
        return result

    @property
    def table(self) -> Table:
        """Under the headers of `truepose predict`."""
        columns: dict[str, Any] = {header: self.position[:, k] for k, header in enumerate(("x[m]", "y[m]", "z[m]"))}
        columns.update({header: self.orientation[:, k] for k, header in enumerate(("qw", "qx", "qy", "qz"))})
        return Table({**columns, "within_95[m]": self.within_95, "extrapolates": self.extrapolates.astype(np.float64)})

    def __repr__(self) -> str:
        return f"Predictions({len(self)} rows, {int(self.extrapolates.sum())} beyond the data of the fit)"


@dataclass(frozen=True, repr=False)
class Commands:
    """Joint commands that bring the real robot to desired poses, one a pose.

    `q` n × dof: the controller's joint values, rad or m (the nearest where `status` is not ``"ok"``); `status` is ``ok``, ``unreachable``, ``limit`` or
    ``not_converged``; `within_95`: with 95 % the robot ends no farther from the pose, m; `position_error`: what the exact model leaves, m;
    `corrected`: False where the nominal command is expected to be more accurate; `beyond`: inputs beyond the data of the fit, in words.
    """

    q: Floats
    status: Sequence[str]
    within_95: Floats
    position_error: Floats
    corrected: NDArray[np.bool_]
    beyond: Sequence[str]
    robot: Robot

    def __len__(self) -> int:
        return len(self.q)

    @property
    def ok(self) -> NDArray[np.bool_]:
        """Whether each pose is reached."""
        return np.array([status == "ok" for status in self.status], dtype=np.bool_)

    @property
    def table(self) -> Table:
        """Under the headers of `truepose compensate`, in rad and m; joints of poses that are not reached are NaN."""
        values = np.where(self.ok[:, None], self.q, np.nan)
        columns: dict[str, Any] = {f"{joint.name}[{joint.unit}]": values[:, k] for k, joint in enumerate(self.robot.joints)}
        return Table({**columns, "status": list(self.status), "within_95[m]": self.within_95, "beyond": list(self.beyond)})

    def __repr__(self) -> str:
        return f"Commands({len(self)} poses, {int(self.ok.sum())} ok)"


Poses: TypeAlias = "Frame | ArrayLike"
"""Desired poses: positions n × 3, transforms n × 4 × 4, or a table with `x y z`, optional orientation, target, load and seed."""


class Fit:
    """An identified robot: the model with its coefficients and their uncertainty.

    Made by `identify`, `Discovery.fit`, `transfer` and `load`. Immutable; pickles (through the bytes of its file, so that what belongs to the data of
    the fit, residuals and summaries, stays behind).
    """

    __slots__ = ("_core",)

    def __init__(self, core: _core.Fit) -> None:
        self._core = core

    # --- files

    @classmethod
    def load(cls, path: Path, *, effects: Iterable[type[Effect]] = ()) -> Fit:
        """Reads a fit file. `effects` are the classes of effects of your own that it contains."""
        return cls(_core.Fit.from_file(os.fspath(path), list(effects)))

    @classmethod
    def from_json(cls, text: str, *, effects: Iterable[type[Effect]] = ()) -> Fit:
        """Reads the text of a fit file."""
        return cls(_core.Fit.from_json(text, list(effects)))

    def save(self, path: Path) -> None:
        """Writes the fit file (JSON): the same bytes as those of the program on the same data."""
        _core.write_text(os.fspath(path), self.to_json())

    def to_json(self) -> str:
        """The text of the fit file."""
        return self._core.to_json()

    def __reduce__(self) -> tuple[Any, ...]:
        classes = tuple({type(effect) for effect in self._core.objects})
        return _unpickled, (self.to_json(), classes)

    # --- what it is

    @property
    def robot(self) -> Robot:
        """The nominal robot, with base, tool and targets where they were found."""
        return Robot(self._core.robot())

    @property
    def sessions(self) -> list[str]:
        """Names of the installations that the fit knows; empty where it is one."""
        return self._core.sessions

    def accept(self) -> Fit:
        """The same fit, for use although it does not fit the measurements that it was made from, or predicts unseen poses worse than base and tool
        alone. Verbs warn, and do not refuse it."""
        return Fit(self._core.accept())

    def in_session(self, name: str) -> Fit:
        """The fit in one of its installations, for `compensate`, `rewrite`, exports, `plan` and `monitor`. `predict` reads a column `session`."""
        return Fit(self._core.in_session(name))

    @property
    def landmarks(self) -> Mapping[str, Floats]:
        """Where landmarks were found that the robot touched: name → position in the measurement frame, m."""
        found: dict[str, Any] = self.provenance.get("landmarks_m", {})
        return {name: np.array(at, dtype=np.float64) for name, at in found.items()}

    @property
    def summary(self) -> dict[str, Any]:
        """What the program prints with ``--json``; empty for a fit that was loaded."""
        text = self._core.summary()
        found: dict[str, Any] = json.loads(text) if text else {}
        return found

    @property
    def provenance(self) -> dict[str, Any]:
        """How the fit came about: program, solver, rows, seed."""
        found: dict[str, Any] = json.loads(self._core.provenance())
        return found

    @property
    def verdict(self) -> str:
        """Whether the model is adequate, in a sentence; empty for a fit that was loaded."""
        return str(self.summary.get("verdict", ""))

    @property
    def warnings(self) -> list[str]:
        """What a user should know about the fit."""
        return [str(words) for words in self.summary.get("warnings", [])]

    @property
    def coefficients(self) -> Table:
        """All coefficients of the model: family, name, SI unit, value, standard deviation, and half width of the 95 % interval."""
        rows = self._core.coefficients()
        names = ("family", "name", "unit", "value", "sd", "half_width_95")
        return Table({name: [row[k] for row in rows] for k, name in enumerate(names)})

    @property
    def covariance(self) -> Floats:
        """Covariance of the coefficients, in their order; zero for those that the reduction left out."""
        return self._core.covariance

    @property
    def groups(self) -> Table:
        """The groups of errors that the data determines: what they contain, SI unit, value, half width of the 95 % interval. Empty for a loaded fit."""
        rows = self._core.groups() or []
        return Table({name: [row[k] for row in rows] for k, name in enumerate(("group", "unit", "value", "half_width_95"))})

    @property
    def parameters(self) -> Table:
        """The parameters of the robot as it is described: nominal, change, calibrated, half width of the 95 % interval, in the units of its file.

        The columns are empty where the description has no such numbers; `parameters_absent` says why.
        """
        rows = json.loads(self._core.parameters())["parameters"]
        names = ("part", "parameter", "unit", "nominal", "delta", "calibrated", "half_width_95", "remark")
        number = {"nominal", "delta", "calibrated", "half_width_95"}
        empty = {name: (np.nan if name in number else "") for name in names}
        return Table({name: [empty[name] if row.get(name) is None else row[name] for row in rows] for name in names})

    @property
    def parameters_absent(self) -> str | None:
        """Why there are no `parameters`, where there are none."""
        absent: str | None = json.loads(self._core.parameters()).get("absent")
        return absent

    @property
    def noise_sd(self) -> float:
        """Standard deviation of one component of a new position, m."""
        return self._core.noise[0]

    # --- residuals

    @property
    def residuals(self) -> Residuals:
        """Residuals on the data of the fit."""
        found = self._core.residuals()
        if found is None:
            raise InputError("a fit that was loaded has no residuals; see residuals_of")
        return Residuals(*found)

    @property
    def held_out(self) -> HeldOut:
        """Residuals of the cross-validation."""
        found = self._core.held_out()
        if found is None:
            raise InputError("there was no cross-validation: identify with folds=5, say")
        position, orientation, folds, _ = found
        return HeldOut(position, orientation, folds)

    def residuals_of(self, data: Data = None, **arrays: Unpack[Arrays]) -> Residuals:
        """Residuals of other measurements: a table or arrays, as in `identify`."""
        rows = taken(self.robot, data, arrays)
        return Residuals(*self._core.residuals_of(rows._core))

    # --- use

    def predict(self, data: Data | ArrayLike = None, **arrays: Unpack[Arrays]) -> Predictions:
        """Poses of the real robot at joint values: an array n × dof, a table, or arrays as keywords (``q=…, payload=…``)."""
        table: Any = data
        if isinstance(data, (np.ndarray, list, tuple)):
            arrays = {**arrays, "q": data}
            table = None
        rows = taken(self.robot, table, arrays, measured=False)
        found, said = self._core.predict(rows._core)
        warn(said)
        return Predictions(found["position"], found["orientation"], found["within_95"], found["extrapolates"])

    def compensate(
        self,
        poses: Poses,
        *,
        orientation: ArrayLike | None = None,
        seed: ArrayLike | None = None,
        target: str | Sequence[str | None] | None = None,
        payload: ArrayLike | None = None,
        com: ArrayLike = (0.0, 0.0, 0.0),
        channels: Mapping[str, ArrayLike] | None = None,
        hold: Sequence[str] = (),
    ) -> Commands:
        """Joint commands that bring the real robot to desired poses.

        `poses`: positions n × 3 (with an optional `orientation`: quaternions, rotation vectors or matrices) or transforms n × 4 × 4, in the
        measurement frame; or a table with the headers of files. The search begins at `seed` (n × dof or dof). `target`: which point of the tool.
        `hold`: joints that stay where `seed` (or the table) has them, such as a track.
        """
        columns = self._pose_columns(poses, orientation)
        if columns is None:
            core = table(poses, "poses")
        else:
            rows = len(next(iter(columns.values())))
            if seed is not None:
                values = spread_over("seed", seed, rows, self.robot.dof)
                columns.update({f"{joint.name}[{joint.unit}]": values[:, k] for k, joint in enumerate(self.robot.joints)})
            if target is not None:
                columns["target"] = [target] * rows if isinstance(target, str) else list(target)
            if payload is not None:
                columns["payload[kg]"] = each("payload", payload, rows)
                centre = spread_over("com", com, rows, 3)
                columns.update({header: centre[:, k] for k, header in enumerate(("cx[m]", "cy[m]", "cz[m]"))})
            for header, channel in (channels or {}).items():
                columns[header] = each(header, channel, rows)
            core = table(columns, "poses")
        found, said = self._core.compensate(core, [str(name) for name in hold])
        warn(said)
        return Commands(
            found["q"],
            found["status"],
            found["within_95"],
            found["position_error"],
            found["corrected"],
            found["beyond"],
            self.robot,
        )

    @staticmethod
    def _pose_columns(poses: Any, orientation: ArrayLike | None) -> dict[str, Any] | None:
        if isinstance(poses, Mapping) or hasattr(poses, "__arrow_c_stream__") or hasattr(poses, "iloc"):
            if orientation is not None:
                raise InputError("orientation belongs to positions n × 3; a table has columns for it")
            return None
        try:
            array = np.asarray(poses, dtype=np.float64)
        except (ValueError, TypeError) as error:
            raise InputError(f"poses are a table, positions n × 3 or transforms n × 4 × 4: {error}") from None
        if array.ndim == 3 or array.shape == (4, 4):
            array = floats("poses", array.reshape(-1, *array.shape[-2:]), None, 4, 4)
            return {"x[m]": array[:, 0, 3], "y[m]": array[:, 1, 3], "z[m]": array[:, 2, 3]} | quaternions(
                "poses", array[:, :3, :3], len(array)
            )
        array = floats("poses", array.reshape(-1, array.shape[-1]) if array.ndim == 1 else array, None, 3)
        columns: dict[str, Any] = {"x[m]": array[:, 0], "y[m]": array[:, 1], "z[m]": array[:, 2]}
        if orientation is not None:
            columns.update(quaternions("orientation", orientation, len(array)))
        return columns

    # --- exports

    def to_urdf(self, path: Path | None = None, *, urdf: Path | None = None, target: str | None = None) -> str:
        """The fitted geometry as a URDF; of an original `urdf` the joint origins are corrected, and everything else stays as it is.

        Raises InputError where the exported geometry would be less accurate than the nominal one. `target`: at which point that is evaluated.
        """
        return self._export("urdf", path, target, urdf=None if urdf is None else os.fspath(urdf))

    def to_dh(self, path: Path | None = None, *, modified: bool = False, hayati: bool = True, target: str | None = None) -> str:
        """The fitted geometry as a table of Denavit and Hartenberg's parameters (CSV); `modified`: Craig's."""
        return self._export("mdh" if modified else "dh", path, target, hayati=hayati)

    def to_yaml(self, kind: str = "ros", path: Path | None = None, *, target: str | None = None) -> str:
        """The fitted geometry as a kinematics file (YAML): ``ros`` (x y z roll pitch yaw of each joint), or in the form of a maker's ROS
        description: ``ur``, ``franka``, ``flexiv``, ``xarm``."""
        if kind == "ros":
            return self._export("ros", path, target)
        return self._export("ros-yaml", path, target, style=kind)

    def to_iso230(self, path: Path | None = None, *, entries: int = 181, target: str | None = None) -> str:
        """Component errors of each joint, named as in ISO 230-1 (CSV), with so many values of each joint."""
        return self._export("iso230", path, target, entries=entries)

    def _export(
        self,
        kind: str,
        path: Path | None,
        target: str | None,
        *,
        urdf: str | None = None,
        hayati: bool = True,
        entries: int = 181,
        style: str | None = None,
    ) -> str:
        text, _ = self._core.export(kind, style, target, urdf, hayati, entries)
        if path is not None:
            _core.write_text(os.fspath(path), text)
        return text

    def report(self, folder: Path) -> None:
        """Writes the report into a folder: `index.html`, its figures (SVG) and `identification.json`."""
        self._core.write_report(os.fspath(folder))

    @property
    def figures(self) -> dict[str, str]:
        """Figures of the report: name → SVG."""
        return dict(self._core.figures())

    # --- shown

    def __str__(self) -> str:
        return self._core.text() or repr(self)

    def __repr__(self) -> str:
        by = self.provenance.get("verb", "?")
        return f"Fit({self._core.robot().name!r}, {by}, {self.provenance.get('rows', '?')} rows)"

    def _repr_html_(self) -> str:
        summary = self.summary
        parts = [f"<p><b>{escape(self._core.robot().name)}</b></p>"]
        if self.verdict:
            parts.append(f"<p>{escape(self.verdict)}</p>")
        stages = summary.get("stages") or []
        if stages:
            parts.append(stage_table(stages))
        parts += [f"<p>⚠ {escape(words)}</p>" for words in self.warnings]
        if stages:
            parts += [image(svg) for svg in list(self.figures.values())[:2]]
        else:
            parts.append(self.coefficients._repr_html_())
        return "".join(parts)


def load(path: Path, *, effects: Iterable[type[Effect]] = ()) -> Fit:
    """Reads a fit file. `effects` are the classes of effects of your own that it contains."""
    return Fit.load(path, effects=effects)


def _unpickled(text: str, classes: Iterable[type[Effect]]) -> Fit:
    return Fit.from_json(text, effects=classes)


def stage_table(stages: Sequence[Mapping[str, Any]]) -> str:
    """RMS of the position error of each stage, mm."""
    rows = ""
    for stage in stages:
        held_out = stage.get("test_set") or stage.get("held_out")
        cells = [stage["name"], f"{stage['train']['rms_mm']:.4g}", "" if not held_out else f"{held_out['rms_mm']:.4g}"]
        rows += "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in cells) + "</tr>"
    return (
        "<table><thead><tr><th>3-D position error, RMS</th><th>training, mm</th><th>held out, mm</th></tr></thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def image(svg: str) -> str:
    """A figure that keeps its styles to itself."""
    data = base64.b64encode(svg.encode()).decode()
    return f'<img alt="figure" style="width: 100%; max-width: 46em" src="data:image/svg+xml;base64,{data}">'
