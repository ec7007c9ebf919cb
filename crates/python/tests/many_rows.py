"""An arm, and rows of it that are cut into parts and blocks."""

from __future__ import annotations

import numpy as np
import pandas as pd

import truepose as tp

ROWS = 6000
BLOCK = 500


def arm() -> tp.Robot:
    half = np.pi / 2
    joints = [{"d": 0.16, "alpha": half}, {"a": -0.42}, {"a": -0.39}, {"d": 0.13, "alpha": half}, {"d": 0.1, "alpha": -half}, {"d": 0.1}]
    return tp.Robot.from_dh([{**joint, "limits": (-3, 3)} for joint in joints], name="arm", targets={"P1": [0.1, 0, 0], "P2": [0, 0.1, 0.1]})


def rows(arm: tp.Robot) -> pd.DataFrame:
    """Two targets at each pose, of an arm with other zeros."""
    random = np.random.default_rng(2)
    q = np.repeat(random.uniform(-3, 3, size=(ROWS // 2, 6)), 2, axis=0)
    pose = arm.fk(q + [1e-3, -2e-3, 5e-4, 1e-3, -1e-3, 0])
    target = np.tile([[0.1, 0, 0], [0, 0.1, 0.1]], (ROWS // 2, 1))
    position = pose[:, :3, 3] + np.einsum("nij,nj->ni", pose[:, :3, :3], target) + random.normal(scale=5e-5, size=(ROWS, 3))
    table = pd.DataFrame(np.hstack([np.degrees(q), 1e3 * position]), columns=[*(f"j{k}[deg]" for k in range(1, 7)), "x[mm]", "y[mm]", "z[mm]"])
    table["target"] = np.tile(["P1", "P2"], ROWS // 2)
    table["oil[degC]"] = random.uniform(20, 30, size=ROWS)
    return table


def parts(rows: pd.DataFrame, count: int, shift: int = 0) -> list[pd.DataFrame]:
    ends = [0, *(len(rows) * k // count + shift for k in range(1, count)), len(rows)]
    return [rows.iloc[a:b] for a, b in zip(ends[:-1], ends[1:])]
