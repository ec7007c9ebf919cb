"""Recordings: joints and poses that were recorded apart, the poses late, as measurements."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import truepose as tp

writer = pytest.importorskip("mcap_ros2.writer")

JOINTS = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
POINT = """std_msgs/Header header
geometry_msgs/Point point
================================================================================
MSG: geometry_msgs/Point
float64 x
float64 y
float64 z
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
LAG = 0.137


def header(t: float) -> dict[str, Any]:
    nanoseconds = round(t * 1e9) + 1_700_000_000_000_000_000
    return {"stamp": {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}, "frame_id": "base"}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory, robot: tp.Robot) -> tuple[Path, np.ndarray]:
    """Twelve stops of two seconds, moves of one and a half between them, joints at 100 Hz, a tracker at 73 Hz."""
    rng = np.random.default_rng(5)
    stops = robot.spread(12)
    times, path = [], []
    t = 0.0
    for k, stop in enumerate(stops):
        for _ in range(200):
            times.append(t)
            path.append(stop + rng.normal(0, 1e-5, stop.shape))
            t += 0.01
        if k + 1 < len(stops):
            for s in np.linspace(0, 1, 150, endpoint=False):
                w = s * s * (3 - 2 * s)
                times.append(t)
                path.append((1 - w) * stop + w * stops[k + 1])
                t += 0.01
    tq, q = np.array(times), np.array(path)
    tp_ = np.arange(0.0, tq[-1], 1 / 73)
    at = np.stack([np.interp(tp_, tq, q[:, k]) for k in range(q.shape[1])], axis=1)
    points = robot.fk(at)[:, :3, 3] + rng.normal(0, 1e-5, (len(tp_), 3))
    file = tmp_path_factory.mktemp("bag") / "run.mcap"
    with file.open("wb") as out:
        mcap = writer.Writer(out)
        states = mcap.register_msgdef("sensor_msgs/msg/JointState", JOINTS)
        tracked = mcap.register_msgdef("geometry_msgs/msg/PointStamped", POINT)
        names = list(reversed([joint.name for joint in robot.joints]))
        for k, (t, values) in enumerate(zip(tq, q, strict=True)):
            message = {"header": header(t), "name": names, "position": list(reversed(values.tolist())), "velocity": [], "effort": []}
            mcap.write_message("/joint_states", states, message, log_time=round(t * 1e9), publish_time=round(t * 1e9), sequence=k)
        for k, (t, p) in enumerate(zip(tp_ + LAG, points, strict=True)):
            message = {"header": header(t), "point": {"x": p[0], "y": p[1], "z": p[2]}}
            mcap.write_message("/tracker/point", tracked, message, log_time=round(t * 1e9), publish_time=round(t * 1e9), sequence=k)
        mcap.finish()
    return file, stops


def test_a_recording_is_a_table_of_standstills(robot: tp.Robot, recorded: tuple[Path, np.ndarray]) -> None:
    file, stops = recorded
    names = [joint.name for joint in robot.joints]
    found = tp.read_mcap(file, poses="/tracker/point", names=names)
    assert len(found) == len(stops) and abs(found.lag - LAG) < 5e-3 and found.correlation > 0.7, found
    q = np.stack([found.columns[f"{name}[rad]"] for name in names], axis=1)
    np.testing.assert_allclose(q, stops, atol=5e-6)
    p = np.stack([found.columns[f"{axis}[m]"] for axis in "xyz"], axis=1)
    np.testing.assert_allclose(p, robot.fk(stops)[:, :3, 3], atol=1e-5)
    assert (found.samples > 100).all() and np.nanmax(found.scatter) < 3e-5
    # It is a table of measurements.
    assert len(tp.measurements(robot, found.columns)) == len(stops)


def test_what_a_recording_lacks_is_told(tmp_path: Path, robot: tp.Robot, recorded: tuple[Path, np.ndarray]) -> None:
    file, _ = recorded
    with pytest.raises(tp.InputError, match="no message of the topic /tracker/pose .*/tracker/point"):
        tp.read_mcap(file)
    with pytest.raises(tp.InputError, match="has no joint elbow"):
        tp.read_mcap(file, poses="/tracker/point", names=["elbow"])
    with pytest.raises(tp.InputError, match="have no position"):
        tp.read_mcap(file, poses="/joint_states", joints="/joint_states")
    with pytest.raises(tp.InputError, match="no standstill"):
        tp.read_mcap(file, poses="/tracker/point", dwell=60)
    with pytest.raises(tp.InputError, match="no such file"):
        tp.read_mcap(tmp_path / "none.mcap")
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"no recording")
    with pytest.raises(tp.InputError, match="cannot be read as MCAP"):
        tp.read_mcap(broken)
