"""Frames at random, from good to rubbish: each is taken or refused with InputError. `python fuzz.py 100000 [seed]` runs many."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa

import truepose as tp

HEADERS = ["j1[rad]", "j2[deg]", "x[mm]", "y[mm]", "z[mm]"]
MORE = ["target", "visit", "time[s]", "payload[kg]", "cx[m]", "cy[m]", "cz[m]", "qw", "qx", "qy", "qz", "rx[deg]", "sx[mm]", "approach_j1", "temperature[degC]",
        "id", "use", "x", "j3", "", "x[mm]", "y[kg]", "\0", "é[m]", "time", "fx[N]"]  # fmt: skip
CELLS: list[Any] = [None, 0, 1, -1, 2.5, 1e3, 1e300, float("nan"), float("inf"), -0.0, 5e-324, "", "P1", "P9", "abc", "1,5", "\0", "x" * 3000, True, 2**62,
                    np.float32(1), np.int8(3), pd.NA, pd.NaT, b"b", 3j, [1], {}, object()]  # fmt: skip


def robot() -> tp.Robot:
    return tp.Robot.from_dh([{"a": 0.4}, {"a": 0.3}], name="two", targets={"P1": [0.0, 0.0, 0.1]})


def table(random: np.random.Generator) -> dict[str, Any]:
    rows = int(random.choice([0, 1, 2, 3, 8, 30]))
    q = random.uniform(-2, 2, size=(rows, 2))
    good: dict[str, Any] = {
        "j1[rad]": q[:, 0],
        "j2[deg]": np.degrees(q[:, 1]),
        "x[mm]": 400 * np.cos(q[:, 0]) + 300 * np.cos(q.sum(axis=1)),
        "y[mm]": 400 * np.sin(q[:, 0]) + 300 * np.sin(q.sum(axis=1)),
        "z[mm]": random.normal(size=rows),
    }
    for _ in range(int(random.integers(4))):
        header = MORE[int(random.integers(len(MORE)))]
        good[header] = [CELLS[int(random.integers(len(CELLS)))] for _ in range(rows)] if random.random() < 0.3 else random.normal(size=rows)
    for _ in range(int(random.integers(3))):
        header = list(good)[int(random.integers(len(good)))]
        change = random.random()
        if change < 0.2:
            del good[header]
        elif change < 0.7 and len(good[header]):
            cells = list(good[header])
            cells[int(random.integers(len(cells) or 1))] = CELLS[int(random.integers(len(CELLS)))]
            good[header] = cells
        elif change < 0.8:
            good[header] = list(good[header])[:-1]
        else:
            kind = ["float32", "int8", "str", "object", "complex", "bool", "datetime64[s]"][int(random.integers(7))]
            try:
                good[header] = np.asarray(good[header]).astype(kind)
            except (TypeError, ValueError, OverflowError):
                pass
        if not good:
            break
    return good


def once(two: tp.Robot, random: np.random.Generator) -> bool:
    """Whether a frame was taken."""
    frame: Any = table(random)
    form = random.random()
    try:
        if form < 0.3:
            frame = pd.DataFrame(frame)
        elif form < 0.5:
            frame = pl.DataFrame(frame, strict=False)
        elif form < 0.6:
            frame = pa.table(frame)
    except Exception:  # the library of frames refuses it
        pass
    try:
        taken = tp.measurements(two, frame)
        if random.random() < 0.05:
            tp.identify(two, taken, folds=int(random.choice([0, 2, 5])))
        return True
    except tp.InputError as error:
        assert str(error)
        return False


def run(count: int, seed: int) -> int:
    warnings.simplefilter("ignore")
    random = np.random.default_rng(seed)
    two = robot()
    return sum(once(two, random) for _ in range(count))


if __name__ == "__main__":
    count = int(sys.argv[1])
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    print(f"{run(count, seed)} of {count} frames were taken, the others refused with InputError")
