"""The nominal robot."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from truepose import _core
from truepose._arrays import Floats, Path, floats, joint_values
from truepose._core import InputError


@dataclass(frozen=True)
class Joint:
    """A moving joint: its name, the SI unit of its values, and the limits of the controller's values."""

    name: str
    unit: str
    limits: tuple[float, float] | None


@dataclass(frozen=True)
class Target:
    """A point on the tool that is measured: its position in the tool's frame, m, and whether that is known."""

    name: str
    position: tuple[float, float, float]
    known: bool


@dataclass(frozen=True)
class Observability:
    """What a set of postures determines of constant errors.

    `rank`: number of directions that are determined, with their `singular_values`, largest first. `o1` to `o5`: the usual indices of them (Borm and
    Menq; Driels and Pathre; Nahvi et al.; Sun and Hollerbach), larger is better. `weakest`: the columns with the largest shares in the direction
    that is determined worst.
    """

    postures: int
    rank: int
    singular_values: Floats
    o1: float
    o2: float
    o3: float
    o4: float
    o5: float
    weakest: dict[str, float]


class Robot:
    """A serial robot as its maker describes it: joints from base to tool, base, tool, targets and gravity.

    Made by `from_toml`, `from_urdf`, `from_dh` and `named`. Immutable; pickles.
    """

    __slots__ = ("_core",)

    def __init__(self, core: _core.Robot) -> None:
        if not isinstance(core, _core.Robot):
            raise InputError("make a robot with Robot.from_toml, Robot.from_urdf or Robot.from_dh")
        self._core = core

    @classmethod
    def _of(cls, core: _core.Robot) -> Robot:
        return cls(core)

    @classmethod
    def from_toml(cls, path: Path) -> Robot:
        """Reads a robot description (TOML) with what it says of sessions, landmarks and cameras; see docs/files.md, section 1."""
        return cls(_core.Robot.from_file(os.fspath(path), None, None))

    @classmethod
    def from_urdf(
        cls,
        path: Path,
        *,
        base: str | None = None,
        tip: str | None = None,
        base_known: bool = False,
        tool_known: bool = False,
    ) -> Robot:
        """Reads a URDF between two links; by default from its root to its only leaf.

        A URDF states neither where an instrument stood nor which point of the tool it measured: both are found from measured positions, unless
        `base_known` (the data is in the frame of the base link) and `tool_known` (the measured point is the tip link) declare them known.
        """
        return cls(_core.Robot.from_file(os.fspath(path), base, tip, (bool(base_known), bool(tool_known))))

    @classmethod
    def from_text(cls, text: str) -> Robot:
        """Reads the text of a robot description (TOML)."""
        return cls(_core.Robot.from_text("robot", text))

    @classmethod
    def named(cls, name: str) -> Robot:
        """A robot of the library, with its maker's published dimensions: ``"ur10e"``, ``"panda"`` … (`library` lists them)."""
        return cls(_core.Robot.named(name))

    @staticmethod
    def library() -> dict[str, str]:
        """Robots of the library: name → maker and model."""
        return dict(_core.Robot.library())

    @classmethod
    def from_dh(
        cls,
        joints: Sequence[Mapping[str, Any]],
        *,
        name: str = "robot",
        modified: bool = False,
        base: Mapping[str, Any] | None = None,
        tool: Mapping[str, Any] | None = None,
        targets: Mapping[str, Sequence[float] | None] | None = None,
        gravity: Sequence[float] | None = None,
        length: str = "m",
        angle: str = "rad",
    ) -> Robot:
        """A robot of a table of Denavit and Hartenberg's parameters.

        Each joint is a mapping with `theta`, `d`, `a`, `alpha` (0 where absent) and, where wanted, `name` (j1, j2, …), `type` (``"revolute"``,
        ``"prismatic"`` or ``"fixed"``), `limits`, `mass` in kg and `com`. `modified`: Craig's convention. `base` and `tool` have `xyz` and `rpy`, or
        ``{"known": False}`` where they are to be found from the data; `targets` are points of the tool (None: unknown). `length` and `angle` are
        the units of all these numbers: m, mm, in; rad, deg.

        Examples
        --------
        >>> scara = tp.Robot.from_dh([{"a": 0.4}, {"a": 0.3, "limits": (-2.5, 2.5)}, {"type": "prismatic"}, {}])
        """
        lines = [f"name = {_text(name)}"]
        if gravity is not None:
            lines.append(f"gravity = {_value(list(gravity))}")
        lines += ["[units]", f"length = {_text(length)}", f"angle = {_text(angle)}"]
        for word, placed in (("base", base), ("tool", tool)):
            if placed is not None:
                lines += [f"[{word}]", *_keys(placed, {"xyz", "rpy", "known"}, f"{word}")]
        for number, joint in enumerate(joints, 1):
            keys = {"theta", "d", "a", "alpha", "name", "type", "limits", "mass", "com"}
            for key in joint:
                if key not in keys:
                    raise InputError(f"joint {number}: unknown key `{key}` (known: {', '.join(sorted(keys))})")
            row = {key: _value(joint.get(key, 0.0)) for key in ("theta", "d", "a", "alpha")}
            order = ("alpha", "a", "theta", "d") if modified else ("theta", "d", "a", "alpha")
            cells = ", ".join(f"{key} = {row[key]}" for key in order)
            lines += ["[[joints]]", f"name = {_text(str(joint.get('name', f'j{number}')))}"]
            lines += [f"type = {_text(str(joint.get('type', 'revolute')))}", f"{'mdh' if modified else 'dh'} = {{ {cells} }}"]
            lines += [f"{key} = {_value(joint[key])}" for key in ("limits", "mass", "com") if joint.get(key) is not None]
        for target, position in (targets or {}).items():
            lines += ["[[targets]]", f"name = {_text(target)}"]
            lines.append("known = false" if position is None else f"xyz = {_value(list(position))}")
        return cls.from_text("\n".join(lines) + "\n")

    @property
    def name(self) -> str:
        """The robot's name."""
        return self._core.name

    @property
    def joints(self) -> list[Joint]:
        """The moving joints, from base to tool."""
        return [Joint(*joint) for joint in self._core.joints]

    @property
    def dof(self) -> int:
        """Number of moving joints."""
        return len(self._core.joints)

    @property
    def frames(self) -> list[str]:
        """Names of the frames: ``base``, each joint's, ``tool``."""
        return self._core.frames

    @property
    def targets(self) -> list[Target]:
        """Declared points of the tool."""
        return [Target(name, (p[0], p[1], p[2]), known) for name, p, known in self._core.targets]

    @property
    def warnings(self) -> list[str]:
        """What is suspicious about the description."""
        return self._core.warnings

    def fk(self, q: ArrayLike) -> Floats:
        """Poses of the nominal tool in the measurement frame, n × 4 × 4, at the controller's joint values `q` (n × dof, rad or m)."""
        return self._core.fk(joint_values(self, q))

    def jacobian(self, q: ArrayLike) -> Floats:
        """Joint Jacobians n × 6 × dof: velocity and angular velocity of the nominal tool, in the measurement frame, per unit of each joint value."""
        values = joint_values(self, q)
        return self._core.jacobian(values).reshape(len(values), 6, self.dof)

    def error_gram(self, q: ArrayLike) -> tuple[Floats, Floats]:
        """Σ JᵀJ over the rows of `q` of the error Jacobian J (Eq. 7 of the paper), of its rows of position and of rotation, each 6k × 6k.

        k joints, the fixed ones included (`error_columns` names the columns). No Jacobian is kept in memory: a million postures take a fraction
        of a second. Sums of parts add up.
        """
        position, rotation = self._core.jacobian_gram(joint_values(self, q))
        return position, rotation

    @property
    def error_columns(self) -> list[str]:
        """Names of the columns of `error_gram`: ``"j1 x"`` … ``"j1 rz"``, ``"j2 x"`` …; m and rad, in the axes of the joint's frame."""
        return [f"{frame} {axis}" for frame in self.frames[1 : 1 + self._core.joint_frames] for axis in ("x", "y", "z", "rx", "ry", "rz")]

    def observability(
        self,
        q: ArrayLike,
        *,
        position_sd: float = 1e-4,
        orientation_sd: float | None = None,
        length: float = 1e-3,
        angle: float = 1e-3,
    ) -> Observability:
        """How well these postures determine constant errors of all joints' frames, before anything is measured.

        `position_sd` and `orientation_sd`: standard deviations of one measured component, m and rad (None: orientations are not measured). `length`
        and `angle`: expected sizes of errors, m and rad.

        Examples
        --------
        >>> robot = tp.Robot.named("ur10e")
        >>> robot.observability(robot.spread(50)).rank
        21
        """
        values = joint_values(self, q)
        found = self._core.observability(values, (position_sd, orientation_sd), (length, angle))
        singular, (o1, o2, o3, o4, o5), weakest = found
        shares = dict(sorted(zip(self.error_columns, weakest), key=lambda pair: -pair[1])[:3])
        return Observability(len(values), len(singular), np.array(singular), o1, o2, o3, o4, o5, shares)

    def error_variances(self, q: ArrayLike, covariance: ArrayLike) -> Floats:
        """Variances of the tool's position (x, y, z, m²) and rotation (rx, ry, rz, rad²) for each row of `q`, n × 6.

        `covariance`: of constant errors of the joints' frames in the order of `error_columns`, in m and rad.
        """
        size = len(self.error_columns)
        return self._core.error_variances(joint_values(self, q), floats("covariance", covariance, size, size))

    def spread(self, count: int) -> Floats:
        """Joint values spread evenly over the limits, count × dof: poses for a trial, always the same."""
        return self._core.lattice(count)

    def to_toml(self) -> str:
        """The robot as a TOML description, in m and rad."""
        return self._core.to_toml()

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self._core.to_bytes(),)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Robot) and self._core.to_bytes() == other._core.to_bytes()

    def __hash__(self) -> int:
        return hash(self._core.to_bytes())

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, {', '.join(joint.name for joint in self.joints)})"


def _unpickled(text: str) -> Robot:
    return Robot(_core.Robot.from_bytes(text))


def _text(text: str) -> str:
    escaped = "".join(f"\\u{ord(c):04x}" if ord(c) < 32 or c in '"\\' or ord(c) == 127 else c for c in text)
    return f'"{escaped}"'


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (str, os.PathLike)):
        return _text(os.fspath(cast("str", value)))
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_text(str(key))} = {_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        number = float(value)
        return repr(number) if np.isfinite(number) else ("nan" if np.isnan(number) else ("inf" if number > 0 else "-inf"))
    try:
        return "[" + ", ".join(_value(item) for item in value) + "]"
    except TypeError:
        raise InputError(f"{type(value).__name__} is no value of a model or a robot") from None


def _keys(values: Mapping[str, Any], known: set[str], what: str) -> list[str]:
    for key in values:
        if key not in known:
            raise InputError(f"{what}: unknown key `{key}` (known: {', '.join(sorted(known))})")
    return [f"{key} = {_value(value)}" for key, value in values.items()]
