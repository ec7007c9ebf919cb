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


RIDER = """name = "rider"
[units]
length = "mm"
angle = "deg"
[[joints]]
name = "rail"
type = "prismatic"
limits = [-500, 4000]
origin = { xyz = [0, 0, 0], axis = [0, 1, 0] }
[[joints]]
name = "j1"
limits = [-170, 170]
origin = { xyz = [0, 0, 520], rpy = [0, 0, 0], axis = [0, 0, 1] }
[[joints]]
name = "j2"
limits = [-80, 130]
origin = { xyz = [160, 0, 0], rpy = [0, 0, 0], axis = [0, 1, 0] }
[[joints]]
name = "j3"
limits = [-170, 75]
origin = { xyz = [0, 0, 870], rpy = [0, 0, 0], axis = [0, 1, 0] }
[[joints]]
name = "j4"
limits = [-300, 300]
origin = { xyz = [0, 0, 180], rpy = [0, 0, 0], axis = [1, 0, 0] }
[[joints]]
name = "j5"
limits = [-120, 120]
origin = { xyz = [940, 0, 0], rpy = [0, 0, 0], axis = [0, 1, 0] }
[[joints]]
name = "j6"
limits = [-350, 350]
origin = { xyz = [130, 0, 0], rpy = [0, 90, 0], axis = [0, 0, 1] }
[base]
known = false
[tool]
known = false
"""


@pytest.fixture(scope="module")
def rider(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the fit of an arm on a track."""
    folder = tmp_path_factory.mktemp("rider")
    (folder / "robot.toml").write_text(RIDER)
    (folder / "plant.toml").write_text(
        'robot = "robot.toml"\nseed = 9\n[errors.geometric]\nposition_mm = 0.4\nangle_mrad = 0.4\n[instrument]\nsd_um = 15\n'
        '[repeatability]\nsd_um = 20\n[campaign]\npostures = "random"\nvisits = 60\n'
    )
    assert program("simulate", "--plant", folder / "plant.toml", "--out", folder / "data.csv").returncode == 0
    ran = program("identify", "--robot", folder / "robot.toml", "--data", folder / "data.csv", "--out", folder / "fit.json")
    assert ran.returncode == 0, ran.stderr
    return folder


def test_held_joints(rider: Path, tmp_path: Path) -> None:
    poses = pd.DataFrame(
        {"x[mm]": [1000.0], "y[mm]": [1350.0], "z[mm]": [900.0], "qw": [0.0], "qx": [0.0], "qy": [1.0], "qz": [0.0], "rail[mm]": [1300.0]}
        | {f"j{k}[deg]": [float(value)] for k, value in zip(range(1, 7), (0, 20, 10, 0, 60, 0))}
    )
    poses.to_csv(tmp_path / "poses.csv", index=False)
    out = tmp_path / "q.csv"
    ran = program("compensate", "--fit", rider / "fit.json", "--poses", tmp_path / "poses.csv", "--hold", "rail", "--out", out)
    assert ran.returncode == 0, ran.stderr
    fit = tp.load(rider / "fit.json")
    held = fit.compensate(poses, hold=["rail"]).table
    written = pd.read_csv(out)
    # The poses have mm and degrees, and so has the program's file; the package has SI units.
    rail, turn = written["rail[mm]"].to_numpy(dtype=float), written["j2[deg]"].to_numpy(dtype=float)
    np.testing.assert_allclose(held["rail[m]"], 1e-3 * rail, rtol=1e-15)
    np.testing.assert_allclose(held["j2[rad]"], np.radians(turn), rtol=1e-14)
    np.testing.assert_allclose(held["rail[m]"], [1.3], rtol=1e-15)
    assert abs(fit.compensate(poses).table["rail[m]"][0] - 1.3) > 1e-6
    with pytest.raises(tp.InputError, match="no joint `cart`"):
        fit.compensate(poses, hold=["cart"])


def test_programs_with_external_axes_and_offsets(rider: Path, tmp_path: Path) -> None:
    place = "[[{:.3f},{:.3f},850.000],[0,0,1,0],[0,0,0,0],[1300,9E9,9E9,9E9,9E9,9E9]]"
    job, new = tmp_path / "job.mod", tmp_path / "new.mod"
    moves = "".join(f"MoveL {place.format(x, y)},v100,fine,grip\\WObj:=table;\n" for x, y in ((850, 1350), (850, 1200), (900, 1250)))
    job.write_text(
        'MODULE M\nPERS tooldata grip:=[TRUE,[[0,0,140],[1,0,0,0]],[1,[0,0,80],[1,0,0,0],0,0,0]];\n'
        'PERS wobjdata table:=[FALSE,TRUE,"",[[200,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\nPROC main()\nConfL\\Off;\n'
        f"MoveAbsJ [[0,5,5,0,40,0],[1300,9E9,9E9,9E9,9E9,9E9]],v100,fine,grip;\n{moves}ENDPROC\nENDMODULE\n"
    )
    fit = tp.load(rider / "fit.json")
    ran = program("compensate", "--fit", rider / "fit.json", "--program", job, "--external", "eax_a=rail", "--out", new)
    assert ran.returncode == 0, ran.stderr
    made = tp.rewrite(fit, job, external={"eax_a": "rail"})
    assert made.program == new.read_bytes() and made.program.count(b",[1300,9E9,") == 4
    assert len(made.summary["changed"]) == 4 and made.summary["changed"][0]["line"] == 6
    table = tmp_path / "offsets.csv"
    ran = program("compensate", "--fit", rider / "fit.json", "--program", job, "--external", "eax_a=rail", "--offsets", "--out", table)
    assert ran.returncode == 0, ran.stderr
    [offset] = tp.rewrite(fit, job, external={"eax_a": "rail"}, offsets=True).offsets
    [written] = pd.read_csv(table).to_dict("records")
    assert (offset["name"].lower(), offset["points"]) == (written["name"].lower(), written["points"])
    np.testing.assert_allclose(offset["rms_after_mm"], 1e3 * written["rms_after[m]"], rtol=1e-9)
    # Work on a positioner that the fit has not is refused in the same words.
    ran = program("compensate", "--fit", rider / "fit.json", "--program", job, "--external", "eax_a=rail", "--work", "table=turntable", "--out", new)
    assert ran.returncode == 2
    with pytest.raises(tp.InputError) as raised:
        tp.rewrite(fit, job, external={"eax_a": "rail"}, work={"table": "turntable"})
    assert "turntable" in str(raised.value) and str(raised.value).splitlines()[0].split(": ")[-1] in ran.stderr
