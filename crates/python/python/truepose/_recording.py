"""Recordings of ROS 2 as measurements: joint states and tracked poses, aligned in time, averaged where the robot stood still.

The decoders are existing packages: ``mcap-ros2-support`` for a bare MCAP file, ``rosbags`` for the folder of a rosbag2.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
    found, correlation = _lag(tq, q, tp, position)
    if lag is not None:
        used = lag
    else:
        used = found if correlation >= 0.5 else 0.0
    starts, ends = _standstills(tq, q, still, dwell)
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


def _standstills(t: Array, q: Array, still: float, dwell: float) -> tuple[list[float], list[float]]:
    """Stretches in which no joint moves by more than ``still`` within a fifth of ``dwell``, and none by more than five times that in all."""
    if len(t) < 3:
        return [], []
    step = float(np.median(np.diff(t)))
    half = max(1, round(0.1 * dwell / max(step, 1e-9)))
    padded = np.pad(q, ((half, half), (0, 0)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0)
    calm = (windows.max(axis=-1) - windows.min(axis=-1) <= still).all(axis=1)
    starts, ends, first = [], [], -1
    for k in range(len(t) + 1):
        goes_on = k < len(t) and bool(calm[k])
        if goes_on and first >= 0:
            # Samples of joint states may be missing: a gap is no standstill.
            goes_on = bool(t[k] - t[k - 1] <= 10.0 * step and np.all(np.abs(q[k] - q[first]) <= 5.0 * still))
        if not goes_on:
            if first >= 0 and t[k - 1] - t[first] >= dwell:
                starts.append(float(t[first]))
                ends.append(float(t[k - 1]))
            first = -1
        if k < len(t) and calm[k] and first < 0:
            first = k
    return starts, ends


def _lag(tq: Array, q: Array, tp: Array, p: Array) -> tuple[float, float]:
    """The lag of the poses, s, at which the speeds of joints and of the tracked point correlate most, and that correlation."""
    if len(tq) < 4 or len(tp) < 4:
        return 0.0, 0.0
    step = float(max(min(np.median(np.diff(tq)), np.median(np.diff(tp))), 1e-4))
    begin, end = max(tq[0], tp[0]), min(tq[-1], tp[-1])
    count = int((end - begin) / step)
    if count < 16:
        return 0.0, 0.0
    grid = begin + step * np.arange(count)
    # Mean speeds over a few samples: derivatives of what scatters would correlate with nothing.
    width = max(1, round(0.05 / step))

    def speed(t: Array, values: Array) -> Array:
        even = np.stack([np.interp(grid, t, values[:, k]) for k in range(values.shape[1])], axis=1)
        moved = np.linalg.norm(even[width:] - even[:-width], axis=1)
        # Moving or not, rather than how fast: how much faster a point is than the joints changes from posture to posture.
        slow = 0.1 * float(np.quantile(moved, 0.9))
        moved = moved / (moved + slow) if slow > 0.0 else moved
        return np.asarray(moved - moved.mean(), dtype=np.float64)

    a, b = speed(tq, q), speed(tp, p)
    scale = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    if scale == 0.0:
        return 0.0, 0.0
    size = 1 << (2 * len(a) - 1).bit_length()
    cross = np.fft.irfft(np.conj(np.fft.rfft(a, size)) * np.fft.rfft(b, size), size) / scale
    most = min(len(a) // 2, round(2.0 / step))
    shifts = np.arange(-most, most + 1)
    values = cross[shifts]
    best = int(np.argmax(values))
    shift = float(shifts[best])
    if 0 < best < len(shifts) - 1:
        left, middle, right = values[best - 1 : best + 2]
        bend = left - 2.0 * middle + right
        if bend < 0.0:
            shift += 0.5 * float((left - right) / bend)
    return shift * step, float(values[best])


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
