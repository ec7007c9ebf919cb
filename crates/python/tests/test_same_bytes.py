"""The same bytes as the program, from every kind of frame."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import truepose as tp

PROGRAM = str(Path(sys.executable).parent / "truepose")


def program(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)


def files(example: Path) -> list[object]:
    return ["--robot", example / "robot.toml", "--data", example / "measurements.csv", "--model", example / "model.toml"]


@pytest.fixture(scope="module")
def by_program(example: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("program") / "fit.json"
    ran = program("identify", *files(example), "--out", out)
    assert ran.returncode == 0, ran.stderr
    return out


def test_identify(fit: tp.Fit, by_program: Path, tmp_path: Path) -> None:
    fit.save(tmp_path / "fit.json")
    assert (tmp_path / "fit.json").read_bytes() == by_program.read_bytes()


def unaligned(values: Any) -> Any:
    """The same numbers, a byte off their natural addresses, as in a buffer that came over a network."""
    array = np.asarray(values)
    if array.dtype.kind != "f":
        return array
    moved = np.frombuffer(b"-" + array.tobytes(), dtype=array.dtype, offset=1)
    assert not moved.flags.aligned
    return moved


def off(values: Any) -> Any:
    """As `unaligned`, for Arrow."""
    array = np.asarray(values)
    if array.dtype.kind != "f":
        return pa.array(array)
    return pa.Array.from_buffers(pa.float64(), len(array), [None, pa.py_buffer(b"-" + array.tobytes()).slice(1)])


@pytest.mark.parametrize("kind", ["polars", "pyarrow", "mapping", "file", "chunks", "unaligned", "packed", "arrow off"])
def test_every_kind_of_frame(robot: tp.Robot, frame: pd.DataFrame, example: Path, by_program: Path, kind: str) -> None:
    arrow = pa.Table.from_pandas(frame, preserve_index=False)
    # Records of an odd number of bytes: most of their numbers are not aligned.
    packed = np.zeros(len(frame), dtype=[("mark", "S1"), *((name, frame[name].to_numpy().dtype) for name in frame)])
    for name in frame:
        packed[name] = frame[name]
    data = {
        "polars": lambda: pl.from_arrow(arrow),
        "pyarrow": lambda: arrow,
        "mapping": lambda: {name: frame[name].to_numpy() for name in frame},
        "file": lambda: example / "measurements.csv",
        "chunks": lambda: pa.concat_tables([arrow.slice(0, 7), arrow.slice(7, 200), arrow.slice(207)]),
        "unaligned": lambda: {name: unaligned(frame[name]) for name in frame},
        "packed": lambda: {name: packed[name] for name in frame},
        "arrow off": lambda: pa.table({name: off(frame[name]) for name in frame}),
    }[kind]()
    fit = tp.identify(robot, data, model=example / "model.toml")
    assert fit.to_json() == by_program.read_text()


def test_arrays_in_si_units_are_the_same_rows(robot: tp.Robot, frame: pd.DataFrame) -> None:
    read = tp.measurements(robot, frame)
    # The file has mm; its numbers in m are those of the reader.
    again = tp.measurements(
        robot, q=read.q, position=read.position, target=read.target, visit=read.visit, payload=read.payload, com=[0.0, 0.0, 0.25],
        channels={"temperature[degC]": read.channels["temperature"]} if "temperature" in read.channels else {},
    )  # fmt: skip
    for name in ("q", "position", "visit", "configuration", "payload"):
        np.testing.assert_array_equal(getattr(again, name), getattr(read, name))
    assert again.target == read.target


def test_options_are_those_of_the_program(robot: tp.Robot, frame: pd.DataFrame, example: Path, tmp_path: Path) -> None:
    out = tmp_path / "fit.json"
    ran = program("identify", *files(example), "--solver", "huber(qr)", "--folds", 4, "--seed", 3, "--holdout", "20%", "--prior", "none", "--out", out)
    assert ran.returncode == 0, ran.stderr
    fit = tp.identify(robot, frame, model=example / "model.toml", solver="huber(qr)", folds=4, seed=3, holdout=0.2, prior="none")
    assert fit.to_json() == out.read_text()


def test_a_loaded_fit_writes_the_same_bytes(by_program: Path) -> None:
    fit = tp.load(by_program)
    assert fit.to_json() == by_program.read_text()
    assert pickle.loads(pickle.dumps(fit)).to_json() == by_program.read_text()


def test_predictions_and_commands(fit: tp.Fit, by_program: Path, example: Path, frame: pd.DataFrame, tmp_path: Path) -> None:
    out = tmp_path / "p.csv"
    assert program("predict", "--fit", by_program, "--data", example / "measurements.csv", "--out", out).returncode == 0
    written = pd.read_csv(out)
    predicted = fit.predict(frame).table
    for header in predicted:
        np.testing.assert_array_equal(predicted[header], written[header].to_numpy(dtype=float), err_msg=header)
    poses = pd.DataFrame({f"{axis}[m]": written[f"{axis}[m]"][:20] for axis in "xyz"} | {"target": written["target"][:20]})
    poses.to_csv(tmp_path / "t.csv", index=False)
    assert program("compensate", "--fit", by_program, "--poses", tmp_path / "t.csv", "--out", out).returncode == 0
    written = pd.read_csv(out)
    commanded = fit.compensate(poses).table
    for joint in ("a1[rad]", "a6[rad]", "within_95[m]"):
        np.testing.assert_array_equal(commanded[joint], written[joint].to_numpy(dtype=float), err_msg=joint)
    assert list(commanded["status"]) == list(written["status"])


@pytest.mark.parametrize("kind", ["urdf", "dh", "mdh", "ros", "iso230"])
def test_exports(fit: tp.Fit, by_program: Path, tmp_path: Path, kind: str) -> None:
    out = tmp_path / "out"
    ran = program("export", "--fit", by_program, "--format", kind, "--out", out)
    export = {
        "urdf": lambda: fit.to_urdf(),
        "dh": lambda: fit.to_dh(),
        "mdh": lambda: fit.to_dh(modified=True),
        "ros": lambda: fit.to_yaml(),
        "iso230": lambda: fit.to_iso230(),
    }[kind]
    if ran.returncode == 0:
        assert export() == out.read_text()
    else:
        with pytest.raises(tp.InputError) as raised:
            export()
        assert str(raised.value) in ran.stderr


def test_discover(robot: tp.Robot, example: Path, tmp_path: Path) -> None:
    robot_file, data = tmp_path / "robot.toml", tmp_path / "data.csv"
    small = tp.Robot.from_dh([{"a": 0.4}, {"a": 0.3}], name="two")
    robot_file.write_text(small.to_toml())
    q = small.spread(60)
    real = q + np.outer(np.sin(q[:, 0]) * 1e-3, [1, 0])
    noise = np.random.default_rng(1).normal(scale=1e-5, size=(60, 3))
    position = small.fk(real)[:, :3, 3] + noise
    table = pd.DataFrame(np.hstack([q, position]), columns=["j1[rad]", "j2[rad]", "x[m]", "y[m]", "z[m]"])
    table.to_csv(data, index=False)
    out = tmp_path / "fit.json"
    ran = program("discover", "--robot", robot_file, "--data", data, "--out", out)
    assert ran.returncode == 0, ran.stderr
    found = tp.discover(tp.Robot.from_toml(robot_file), table)
    assert found.fit.to_json() == out.read_text()
    assert [(effect.family, effect.joint) for effect in found.effects] == [("transmission", "j1")]
    assert found.effects[0].figure is not None and found.effects[0].figure.startswith("<svg")
    assert "transmission" in found._repr_html_() and str(found) in ran.stdout


def test_the_program_in_the_wheel(example: Path, tmp_path: Path) -> None:
    assert program("--version").stdout.strip() == f"truepose {tp.__version__}"
    assert program("identify", "--help").returncode == 0
    assert program("frobnicate").returncode == 2
    ran = program("identify", "--robot", tmp_path / "none.toml", "--data", example / "measurements.csv")
    assert ran.returncode == 2 and "no such file" in ran.stderr
    ran = program("identify", *files(example), "--require", "0.01mm")
    assert ran.returncode == 1 and "not met" in ran.stderr
    out = tmp_path / "report"
    assert program("identify", *files(example), "--report", out).returncode == 0
    assert '"identify"' in (out / "run.json").read_text()
    assert program("verify", out / "run.json").returncode == 0
