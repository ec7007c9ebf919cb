"""Data of the tests: the example of the repository, and robots of a table."""

from __future__ import annotations

from pathlib import Path

import many_rows
import numpy as np
import pandas as pd
import pytest

import truepose as tp
import truepose.stream

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "01_identify"


@pytest.fixture(scope="session")
def example() -> Path:
    return EXAMPLE


@pytest.fixture(scope="session")
def robot() -> tp.Robot:
    return tp.Robot.from_toml(EXAMPLE / "robot.toml")


@pytest.fixture(scope="session")
def frame() -> pd.DataFrame:
    return pd.read_csv(EXAMPLE / "measurements.csv", comment="#")


@pytest.fixture(scope="session")
def fit(robot: tp.Robot, frame: pd.DataFrame) -> tp.Fit:
    return tp.identify(robot, frame, model=EXAMPLE / "model.toml")


@pytest.fixture(scope="session")
def scara() -> tp.Robot:
    joints = [{"a": 0.4, "limits": (-2.5, 2.5)}, {"a": 0.3, "limits": (-2.2, 2.2)}, {"type": "prismatic", "limits": (0, 0.3)}, {"limits": (-3, 3)}]
    return tp.Robot.from_dh(joints, name="scara")


@pytest.fixture(scope="session")
def bent(scara: tp.Robot) -> tuple[np.ndarray, np.ndarray]:
    """Joint values and positions of a SCARA whose second encoder reads 1e-3 too little, by plain arithmetic, with 20 µm of noise."""
    noise = np.random.default_rng(7)
    q = scara.spread(200)
    real = q + np.outer(q[:, 1] * 1e-3, [0, 1, 0, 0])
    position = np.stack(
        [
            0.4 * np.cos(real[:, 0]) + 0.3 * np.cos(real[:, 0] + real[:, 1]),
            0.4 * np.sin(real[:, 0]) + 0.3 * np.sin(real[:, 0] + real[:, 1]),
            real[:, 2],
        ],
        axis=1,
    )
    return q, position + noise.normal(scale=2e-5, size=position.shape)


@pytest.fixture(scope="session")
def arm() -> tp.Robot:
    return many_rows.arm()


@pytest.fixture(scope="session")
def rows(arm: tp.Robot) -> pd.DataFrame:
    return many_rows.rows(arm)


@pytest.fixture(scope="session")
def whole(arm: tp.Robot, rows: pd.DataFrame) -> tp.Fit:
    return truepose.stream.identify(arm, [rows], block=many_rows.BLOCK)
