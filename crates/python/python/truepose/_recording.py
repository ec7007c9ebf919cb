"""Recordings of ROS 2 as measurements: joint states and tracked poses, aligned in time, averaged where the robot stood still.

The decoders are existing packages: ``mcap-ros2-support`` for a bare MCAP file, ``rosbags`` for the folder of a rosbag2.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from truepose import _core
from truepose._arrays import Frame
from truepose._core import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Recording:
    """Measurements from a recording, one row for each standstill."""

    columns: dict[str, Array]
    """Columns of a table of measurements: joints in rad or m, ``time[s]``, ``x[m]`` … and, where it was recorded, ``qw`` …"""
    start: Array
    """When each standstill begins, s, in the clock of the joints."""
    end: Array
    """When it ends, s."""
    samples: NDArray[np.int64]
    """Tracked poses that each row is the mean of."""
    scatter: Array
    """Standard deviation of one component of these positions, m; NaN for a single one."""
    lag: float
    """By how much the clock of the poses is late, s: a pose with the stamp t shows the robot at t - lag."""
    correlation: float
    """Correlation of the speeds of joints and pose at that lag; below 0.5 the lag is not to be trusted, and is taken as 0."""

    def __len__(self) -> int:
        return len(self.start)

    def __repr__(self) -> str:
        return f"Recording({len(self)} standstills, lag {1e3 * self.lag:.1f} ms, correlation {self.correlation:.2f})"


def read_mcap(
    path: str | PathLike[str],
    joints: str = "/joint_states",
    poses: str = "/tracker/pose",
    *,
    names: Sequence[str] | None = None,
    slides: Sequence[str] = (),
    still: float = 2e-4,
    dwell: float = 0.5,
    settle: float = 0.2,
    lag: float | None = None,
) -> Recording:
    """Reads an MCAP file, or the folder of a rosbag2, as measurements.

    ``joints`` is a topic of ``sensor_msgs/JointState``, ``poses`` one of ``PoseStamped``, ``PointStamped``, ``TransformStamped`` or
    ``Odometry``, all in m and rad. A standstill is where every joint stays within ``still`` (rad or m) for ``dwell`` seconds or longer; its
    first ``settle`` seconds are left out. Stamps of the headers are used; where these are zero, the time of recording.

    The lag of the poses behind the joints is found by correlating the two speeds, unless it is given. ``names`` are the joints of the table
    in its order; all of the first message otherwise. ``slides`` are those of them that are prismatic.

    Raises ``InputError`` where the file, a topic or a joint is missing, the messages are of another type, or the robot never stood still.
    """
    file = Path(path)
    if not file.exists():
        raise InputError(f"{file}: there is no such file")
    stated, tracked = [], []
    seen: set[str] = set()
    for topic, stamp, message in _messages(file):
        seen.add(topic)
        if topic == joints:
            stated.append((_stamp(message, stamp), message))
        if topic == poses:
            tracked.append((_stamp(message, stamp), message))
    for topic, found in ((joints, stated), (poses, tracked)):
        if not found:
            known = ", ".join(sorted(seen)) or "none"
            raise InputError(f"{file}: no message of the topic {topic} (topics: {known})")
    stated.sort(key=lambda pair: pair[0])
    tracked.sort(key=lambda pair: pair[0])
    wanted = list(names) if names is not None else [str(name) for name in _field(file, joints, stated[0][1], "name")]
    q = np.array([_joints(file, joints, message, wanted) for _, message in stated])
    located = [_pose(file, poses, message) for _, message in tracked]
    tq, tp = np.array([t for t, _ in stated]), np.array([t for t, _ in tracked])
    zero = min(tq[0], tp[0])
    units = ["m" if name in slides else "rad" for name in wanted]
    headers = [f"{name}[{unit}]" for name, unit in zip(wanted, units, strict=True)]
    return align(headers, tq - zero, q, tp - zero, located, still=still, dwell=dwell, settle=settle, lag=lag)


_FACTORS = {"rad": 1.0, "deg": np.pi / 180.0, "mrad": 1e-3, "m": 1.0, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "s": 1.0, "ms": 1e-3, "min": 60.0}
_NO_JOINT = {"x", "y", "z", "qw", "qx", "qy", "qz", "rx", "ry", "rz", "cx", "cy", "cz", "sx", "sy", "sz", "srx", "sry", "srz", "time", "distance"}


def standstills(
    log: Frame,
    *,
    joints: Sequence[str] | None = None,
    still: float = 2e-4,
    dwell: float = 0.5,
    settle: float = 0.2,
    lag: float | None = None,
) -> Recording:
    """Finds the standstills in a log: joints, measured positions and ``time[s]`` in each row, the robot moving or not.

    ``log`` is a frame (pandas, polars, pyarrow) or a dict of arrays with the column names of measurements, such as ``j1[deg]``, ``x[mm]``.
    ``joints`` are the names of the joint columns; all other columns in a unit of an angle or a length otherwise. A standstill is where every
    joint stays within ``still`` (rad or m) for ``dwell`` seconds or longer; its first ``settle`` seconds are left out. The lag of the
    instrument behind the joints is found by correlating the two speeds, unless it is given. ``truepose dwell`` does the same with a file.

    Raises ``InputError`` where a column is missing, or the robot never stood still.
    """
    columns = _numbers(log)
    bare = {header.split("[")[0].strip(): header for header in columns}
    for needed in ("time", "x", "y", "z"):
        if needed not in bare:
            raise InputError(f"a log needs a column `{needed}` (its columns: {', '.join(columns)})")

    def scaled(name: str) -> Array:
        header = bare[name]
        unit = header.split("[")[1].rstrip("] ") if "[" in header else ""
        if unit not in _FACTORS:
            raise InputError(f"column `{header}`: name its unit, as in `{name}[mm]`")
        return columns[header] * _FACTORS[unit]

    def is_joint(name: str, header: str) -> bool:
        unit = header.split("[")[1].rstrip("] ") if "[" in header else ""
        return name not in _NO_JOINT and unit in ("rad", "deg", "mrad", "m", "mm", "um", "in")

    names = [name for name, header in bare.items() if is_joint(name, header)] if joints is None else list(joints)
    unknown = [name for name in names if name not in bare]
    if unknown or not names:
        raise InputError(f"the log has no joint column {', '.join(unknown) or 'with a unit'} (its columns: {', '.join(columns)})")
    order = np.argsort(scaled("time"), kind="stable")
    time = scaled("time")[order]
    first = np.concatenate([[True], np.diff(time) > 0.0])
    q = np.stack([scaled(name)[order] for name in names], axis=1)[first]
    positions = np.stack([scaled(axis)[order] for axis in "xyz"], axis=1)
    seen = np.isfinite(positions).all(axis=1)
    turned = all(name in bare for name in ("qw", "qx", "qy", "qz"))
    rotations = np.stack([columns[bare[name]][order] for name in ("qw", "qx", "qy", "qz")], axis=1)[seen] if turned else None
    located = [(p, None if rotations is None else rotations[k]) for k, p in enumerate(positions[seen])]
    slides = ("m", "mm", "um", "in")
    units = ["m" if bare[name].split("[")[1].rstrip("] ") in slides else "rad" for name in names]
    headers = [f"{name}[{unit}]" for name, unit in zip(names, units, strict=True)]
    return align(headers, time[first], q, time[seen], located, still=still, dwell=dwell, settle=settle, lag=lag)


def _numbers(log: Frame) -> dict[str, Array]:
    """Columns of numbers of a frame."""
    if isinstance(log, Mapping):
        pairs = list(log.items())
    else:
        frame: Any = log
        names = [str(name) for name in (frame.column_names if hasattr(frame, "column_names") else frame.columns)]
        pairs = [(name, frame[name]) for name in names]
    columns: dict[str, Array] = {}
    for name, values in pairs:
        try:
            columns[str(name)] = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError):
            continue
    return columns


def align(
    headers: Sequence[str],
    tq: Array,
    q: Array,
    tp: Array,
    located: Sequence[tuple[Array, Array | None]],
    *,
    still: float,
    dwell: float,
    settle: float,
    lag: float | None,
) -> Recording:
    """Standstills of joints ``q`` (times × joints, at ``tq``, s) with the poses (position, quaternion w x y z or none) at ``tp``, s."""
    position = np.array([p for p, _ in located])
    turned = [r for _, r in located if r is not None]
    rotation = np.array(turned) if len(turned) == len(located) else None
    joints, points = np.ascontiguousarray(q, dtype=np.float64), np.ascontiguousarray(position, dtype=np.float64)
    pairs, found, correlation = _core.standstills(tq, joints, tp, points, still, dwell)
    if lag is not None:
        used = lag
    else:
        used = found if correlation >= 0.5 else 0.0
    starts, ends = [float(tq[first]) for first, _ in pairs], [float(tq[last]) for _, last in pairs]
    rows: list[tuple[float, float, Array, Array, Array | None, int, float]] = []
    for start, end in zip(starts, ends, strict=True):
        at = (tp - used >= start + settle) & (tp - used <= end)
        inside = (tq >= start) & (tq <= end)
        if not at.any():
            continue
        p = position[at]
        scatter = float(np.sqrt(np.mean(np.var(p, axis=0, ddof=1)))) if len(p) > 1 else float("nan")
        turn = None if rotation is None else _mean_rotation(rotation[at])
        rows.append((start, end, q[inside].mean(axis=0), p.mean(axis=0), turn, int(at.sum()), scatter))
    if not rows:
        raise InputError(
            f"no standstill of {dwell} s within {still} rad or m with a tracked pose in it: lower `dwell`, raise `still`, or check the clocks"
        )
    columns = {header: np.array([row[2][k] for row in rows]) for k, header in enumerate(headers)}
    for k, axis in enumerate("xyz"):
        columns[f"{axis}[m]"] = np.array([row[3][k] for row in rows])
    turns = [row[4] for row in rows if row[4] is not None]
    if len(turns) == len(rows):
        for k, name in enumerate(("qw", "qx", "qy", "qz")):
            columns[name] = np.array([turn[k] for turn in turns])
    columns["time[s]"] = np.array([0.5 * (row[0] + row[1]) for row in rows])
    return Recording(
        columns=columns,
        start=np.array([row[0] for row in rows]),
        end=np.array([row[1] for row in rows]),
        samples=np.array([row[5] for row in rows], dtype=np.int64),
        scatter=np.array([row[6] for row in rows]),
        lag=used,
        correlation=correlation,
    )


def _mean_rotation(quaternions: Array) -> Array:
    """Mean of rotations: the eigenvector of the largest eigenvalue of the sum of their outer products (Markley and others, 2007)."""
    mean: Array = np.linalg.eigh(quaternions.T @ quaternions)[1][:, -1]
    return mean if mean[0] >= 0.0 else -mean


def _messages(file: Path) -> Iterator[tuple[str, float, Any]]:
    """Topic, time of recording (s) and message of everything in a file."""
    if file.is_dir():
        reader = _decoder("rosbags.highlevel", "rosbags").AnyReader([file])
        try:
            reader.open()
        except Exception as error:
            raise InputError(f"{file}: is no rosbag2: {error}") from error
        try:
            for connection, nanoseconds, raw in reader.messages():
                yield connection.topic, 1e-9 * nanoseconds, reader.deserialize(raw, connection.msgtype)
        finally:
            reader.close()
        return
    factory = _decoder("mcap_ros2.decoder", "mcap-ros2-support").DecoderFactory()
    make_reader = _decoder("mcap.reader", "mcap-ros2-support").make_reader
    try:
        with file.open("rb") as stream:
            for _, channel, raw, message in make_reader(stream, decoder_factories=[factory]).iter_decoded_messages():
                yield channel.topic, 1e-9 * raw.log_time, message
    except Exception as error:
        raise InputError(f"{file}: cannot be read as MCAP: {error}") from error


def _decoder(module: str, package: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(f"recordings are decoded by the package {package}: pip install {package}") from error


def _stamp(message: Any, recorded: float) -> float:
    header = getattr(message, "header", None)
    stamp = getattr(header, "stamp", None)
    seconds = float(getattr(stamp, "sec", 0)) + 1e-9 * float(getattr(stamp, "nanosec", 0))
    return seconds if seconds > 0.0 else recorded


def _field(file: Path, topic: str, message: Any, name: str) -> Any:
    value = getattr(message, name, None)
    if value is None:
        raise InputError(f"{file}: messages of {topic} have no `{name}`; it is not of the expected type")
    return value


def _joints(file: Path, topic: str, message: Any, wanted: Sequence[str]) -> list[float]:
    names = [str(name) for name in _field(file, topic, message, "name")]
    values = _field(file, topic, message, "position")
    try:
        return [float(values[names.index(name)]) for name in wanted]
    except (ValueError, IndexError) as error:
        missing = next((name for name in wanted if name not in names), wanted[-1])
        raise InputError(f"{file}: a message of {topic} has no joint {missing} (its joints: {', '.join(names)})") from error


def _pose(file: Path, topic: str, message: Any) -> tuple[Array, Array | None]:
    """Position, and quaternion w x y z where there is one."""
    for outer in ("pose", "transform", "point"):
        part = getattr(message, outer, None)
        if part is None:
            continue
        inner = getattr(part, "pose", part)  # of an odometry
        at = getattr(inner, "position", None) or getattr(inner, "translation", None) or inner
        turn = getattr(inner, "orientation", None) or getattr(inner, "rotation", None)
        if all(hasattr(at, axis) for axis in "xyz"):
            position = np.array([float(at.x), float(at.y), float(at.z)])
            rotation = None if turn is None else np.array([float(turn.w), float(turn.x), float(turn.y), float(turn.z)])
            return position, rotation
    raise InputError(f"{file}: messages of {topic} have no position; a PoseStamped, PointStamped, TransformStamped or Odometry is expected")
