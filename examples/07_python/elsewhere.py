"""The corrected URDF in other libraries: pinocchio, mujoco and Robotics Toolbox agree with `Fit.predict` to 1e-9 m, where they are installed.

`pip install pin mujoco roboticstoolbox-python`
"""

from __future__ import annotations

import importlib
import importlib.util
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import truepose as tp

Floats = NDArray[np.float64]


def robot_and_fit() -> tuple[tp.Robot, tp.Fit]:
    """An arm of six joints whose lengths, angles and zeros are all slightly off, as its own maker's table does not have them."""
    half = np.pi / 2
    rows: list[dict[str, Any]] = [
        {"d": 0.1625, "alpha": half},
        {"a": -0.425},
        {"a": -0.3922},
        {"d": 0.1333, "alpha": half},
        {"d": 0.0997, "alpha": -half},
        {"d": 0.0996},
    ]
    robot = tp.Robot.from_dh([{**row, "limits": (-3.0, 3.0)} for row in rows], name="arm")
    off = np.random.default_rng(3)
    real = [{key: value + off.normal(scale=5e-4) for key, value in {"theta": 0.0, "d": 0.0, "a": 0.0, "alpha": 0.0, **row}.items()} for row in rows]
    q = robot.spread(300)
    pose = tp.Robot.from_dh(real, name="real").fk(q)
    return robot, tp.identify(robot, q=q, pose=pose)


def pinocchio(urdf: Path) -> Callable[[Floats], Floats]:
    pin: Any = importlib.import_module("pinocchio")
    model: Any = pin.buildModelFromUrdf(str(urdf))
    data: Any = model.createData()
    tip = model.nframes - 1

    def fk(q: Floats) -> Floats:
        pin.framesForwardKinematics(model, data, q)
        return np.asarray(data.oMf[tip].homogeneous, dtype=np.float64)

    return fk


def mujoco(urdf: Path) -> Callable[[Floats], Floats]:
    mj: Any = importlib.import_module("mujoco")
    # Bodies that move need masses there, and fixed links would be merged.
    spec: Any = mj.MjSpec.from_file(str(urdf))
    spec.compiler.fusestatic = False
    spec.compiler.boundmass = spec.compiler.boundinertia = 1e-3
    model: Any = spec.compile()
    data: Any = mj.MjData(model)

    def fk(q: Floats) -> Floats:
        data.qpos[:] = q
        mj.mj_kinematics(model, data)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = np.asarray(data.xmat[-1]).reshape(3, 3), data.xpos[-1]
        return pose

    return fk


def toolbox(urdf: Path) -> Callable[[Floats], Floats]:
    rtb: Any = importlib.import_module("roboticstoolbox")
    robot: Any = rtb.ERobot.URDF(str(urdf))
    return lambda q: np.asarray(robot.fkine(q).A, dtype=np.float64)


LIBRARIES: dict[str, tuple[str, Callable[[Path], Callable[[Floats], Floats]]]] = {
    "pinocchio": ("pinocchio", pinocchio),
    "mujoco": ("mujoco", mujoco),
    "Robotics Toolbox": ("roboticstoolbox", toolbox),
}


def differences() -> dict[str, float]:
    """Largest difference of positions, m, from the prediction in the base frame of the fit, for each library that is installed."""
    robot, fit = robot_and_fit()
    q = robot.spread(50)
    predicted = fit.predict(q).pose
    found: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        urdf = Path(folder) / "arm.urdf"
        fit.to_urdf(urdf)
        for name, (module, load) in LIBRARIES.items():
            if importlib.util.find_spec(module) is None:
                print(f"{name}: not installed")
                continue
            fk = load(urdf)
            poses = np.stack([fk(row) for row in q])
            # The URDF begins at the base link: the pose of that in the measurement frame is constant.
            base = predicted[0] @ np.linalg.inv(poses[0])
            found[name] = float(np.abs((base @ poses)[:, :3, 3] - predicted[:, :3, 3]).max())
            print(f"{name}: {found[name]:.1e} m")
    return found


if __name__ == "__main__":
    differences()
