"""What a frame costs beside rows that Rust has already: processor time and peak of memory of `identify`. `python frames.py [rows] [runs]`.

`identify` of a frame is `measurements` of the frame and `identify` of those: both are timed, the least of all runs, for the default fit and for the
shortest that there is (a single linear step without folds and prior), in which the frame weighs most. Each peak is that of a process of its own with the
shortest fit, above what it had with the frame in memory: of rows that were read, with them.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from many_rows import arm

import truepose as tp

SHORTEST: dict[str, Any] = {"linear": True, "folds": 0, "prior": "none"}


def frame(robot: tp.Robot, rows: int) -> pd.DataFrame:
    random = np.random.default_rng(2)
    q = random.uniform(-3, 3, size=(rows, 6))
    position = robot.fk(q + [1e-3, -2e-3, 5e-4, 1e-3, -1e-3, 0])[:, :3, 3] + random.normal(scale=5e-5, size=(rows, 3))
    return pd.DataFrame(np.hstack([np.degrees(q), 1e3 * position]), columns=[*(f"j{k}[deg]" for k in range(1, 7)), "x[mm]", "y[mm]", "z[mm]"])


def memory(what: str) -> float:
    """MB."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(what)) / 1024


def peak(kind: str, rows: int) -> None:
    """Prints the peak of one kind, MB."""
    robot = arm()
    data = frame(robot, rows)
    tp.identify(robot, data.iloc[:2000], **SHORTEST)
    before = memory("VmRSS")
    given = tp.measurements(robot, data) if kind == "read" else data
    Path("/proc/self/clear_refs").write_text("5")
    tp.identify(robot, given, **SHORTEST)
    print(memory("VmHWM") - before)


def least(runs: int, work: Callable[[], object]) -> float:
    """Processor time, s."""
    taken = []
    for _ in range(runs):
        begun = time.process_time()
        work()
        taken.append(time.process_time() - begun)
    return min(taken)


def main(rows: int = 200_000, runs: int = 3) -> None:
    robot = arm()
    data = frame(robot, rows)
    read = tp.measurements(robot, data)
    reading = least(runs, lambda: tp.measurements(robot, data))
    options: dict[str, Any]
    for words, options in (("default fit", {}), ("shortest fit", SHORTEST)):
        fitting = least(runs, lambda: tp.identify(robot, read, **options))
        print(f"{words}: {fitting:.2f} s of rows that were read, {reading:.2f} s to read the frame: {1 + reading / fitting:.3f}", flush=True)
    peaks = [float(subprocess.check_output([sys.executable, __file__, kind, str(rows)])) for kind in ("frame", "read")]
    print(f"peak: {peaks[0]:.0f} MB of a frame, {peaks[1]:.0f} MB of rows that were read: {peaks[0] / peaks[1]:.3f}")


if __name__ == "__main__":
    if sys.argv[1:2] in (["frame"], ["read"]):
        peak(sys.argv[1], int(sys.argv[2]))
    else:
        main(*map(int, sys.argv[1:]))
