"""Bad input: a typed exception with row and column, and never a dead interpreter."""

from __future__ import annotations

import os
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import truepose as tp

GOOD = {"j1[rad]": [0.1, 0.2, 0.3, 0.4], "j2[rad]": [0.4, 0.1, 0.2, 0.9], "x[m]": [0.5, 0.6, 0.65, 0.61], "y[m]": [0.1, 0.2, 0.25, 0.3], "z[m]": [0.0] * 4}


@pytest.fixture(scope="module")
def two() -> tp.Robot:
    return tp.Robot.from_dh([{"a": 0.4}, {"a": 0.3}], name="two", targets={"P1": [0, 0, 0]})


def spoiled(column: str, row: int, value: Any) -> dict[str, Any]:
    table: dict[str, Any] = {name: list(values) for name, values in GOOD.items()}
    table[column] = list(table.get(column, [None] * 4))
    table[column][row] = value
    return table


@pytest.mark.parametrize(
    ("column", "row", "value", "words"),
    [
        ("j1[rad]", 2, float("nan"), "is empty"),
        ("x[m]", 1, float("inf"), "finite"),
        ("x[m]", 0, "abc", "not a number"),
        ("j2[rad]", 3, 1e300, "cannot be meant"),
        ("target", 1, "P9", "no target `P9`"),
        ("y[m]", 2, object(), "neither a number nor a text"),
        ("y[m]", 2, 10**400, "no number"),
    ],
)
@pytest.mark.parametrize("kind", ["mapping", "pandas", "polars"])
def test_a_bad_cell_has_a_row_and_a_column(two: tp.Robot, column: str, row: int, value: Any, words: str, kind: str) -> None:
    table: Any = spoiled(column, row, value)
    if kind == "pandas":
        table = pd.DataFrame({name: pd.Series(values, dtype=object) for name, values in table.items()})
    elif kind == "polars":
        try:
            table = pl.DataFrame(table, strict=False)
        except Exception:
            pytest.skip("polars has no such column")
        if not isinstance(value, (str, float)) or str(table[column][row]) != str(value):
            pytest.skip("polars has made something else of it")
    with pytest.raises(tp.InputError, match=words) as raised:
        tp.measurements(two, table)
    assert raised.value.row == row + 1 and raised.value.column == column, raised.value
    assert raised.value.errors[0][:2] == (row + 1, column) and raised.value.source == "data"


def test_columns_that_are_missing_or_unknown(two: tp.Robot) -> None:
    without = {name: values for name, values in GOOD.items() if name != "j2[rad]"}
    with pytest.raises(tp.InputError, match="joint `j2` has no column"):
        tp.identify(two, without)
    with pytest.raises(tp.InputError, match="no columns hold anything measured"):
        tp.identify(two, {name: GOOD[name] for name in ("j1[rad]", "j2[rad]")})
    with pytest.raises(tp.InputError, match="unknown unit|furlong"):
        tp.identify(two, {**{n: v for n, v in GOOD.items() if n != "x[m]"}, "x[furlong]": GOOD["x[m]"]})
    with pytest.raises(tp.InputError, match="rows"):
        tp.identify(two, {**GOOD, "x[m]": [1.0]})


@pytest.mark.parametrize("data", [3, 3.5, object(), [[1, 2]], np.zeros((3, 3)), "none.csv", b"bytes", {"x": object()}, {}, {1: [2]}])
def test_what_is_no_table(two: tp.Robot, data: Any) -> None:
    with pytest.raises(tp.InputError):
        tp.identify(two, data)


def test_dtypes(two: tp.Robot) -> None:
    q32 = {name: np.array(values, dtype=np.float32) for name, values in GOOD.items()}
    assert len(tp.measurements(two, q32)) == 4
    strided = {name: np.repeat(values, 3)[::3] for name, values in GOOD.items()}
    assert len(tp.measurements(two, strided)) == 4
    nullable = pd.DataFrame(GOOD).convert_dtypes()
    nullable.loc[1, "z[m]"] = pd.NA
    assert np.isnan(tp.measurements(two, nullable).position[1, 2])
    categories = pd.DataFrame({**GOOD, "target": pd.Categorical(["P1", None, "P1", "P1"])})
    assert tp.measurements(two, categories).target == ["P1", None, "P1", "P1"]
    assert tp.measurements(two, pl.from_pandas(categories)).target == ["P1", None, "P1", "P1"]
    dictionary = pa.table({**GOOD, "target": pa.array(["P1", None, "P1", "P1"]).dictionary_encode()})
    assert tp.measurements(two, dictionary).target == ["P1", None, "P1", "P1"]
    timed = pd.DataFrame({**GOOD, "time": pd.to_datetime(["2024-01-01T00:00:00Z"] * 4) + pd.to_timedelta([0, 1, 2.5, 3], unit="s")})
    assert len(tp.measurements(two, timed)) == 4
    with pytest.raises(tp.InputError, match="type"):
        tp.measurements(two, pl.DataFrame({**GOOD, "time[s]": [timedelta(seconds=k) for k in range(4)]}))
    for wrong in (np.zeros(4, dtype=complex), np.zeros(4, dtype="V8"), np.zeros((4, 2))):
        with pytest.raises(tp.InputError):
            tp.measurements(two, {**GOOD, "y[m]": wrong})


def test_arrays_of_wrong_shapes(two: tp.Robot) -> None:
    q, position = np.zeros((4, 2)), np.ones((4, 3))
    for arrays in (
        {"q": q},
        {"position": position},
        {"q": np.zeros((4, 3)), "position": position},
        {"q": q, "position": np.zeros((3, 3))},
        {"q": q, "position": position, "orientation": np.zeros((4, 5))},
        {"q": q, "position": position, "orientation": np.full((4, 3, 3), 2.0)},
        {"q": q, "position": position, "orientation": np.zeros((4, 4))},
        {"q": q, "position": "text"},
        {"q": q, "positions": position},
        {"q": q, "position": position, "payload": -1.0},
        {"q": q, "position": position, "visit": [0.5, 1, 2, 3]},
        {"q": q, "position": position, "target": ["P7"] * 4},
        {"q": q, "pose": np.zeros((4, 3, 4))},
    ):
        with pytest.raises(tp.InputError):
            tp.measurements(two, **arrays)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"solver": "magic"}, "solver"),
        ({"folds": 1}, "fold"),
        ({"folds": -1}, "whole number"),
        ({"folds": 2.5}, "whole number"),
        ({"split": "sideways"}, "split"),
        ({"seed": -1}, "whole number"),
        ({"prior": "much"}, "prior"),
        ({"prior": -1.0}, "prior"),
        ({"holdout": 2.0}, "holdout|held|fraction|share"),
        ({"model": "none.toml"}, "no such file"),
        ({"model": []}, "no effects"),
        ({"model": [3]}, "an effect is"),
        ({"model": 3}, "a model is"),
        ({"model": [{"family": "geometri"}]}, "did you mean"),
        ({"model": [tp.Geometric(), tp.Geometric()]}, "twice"),
        ({"model": [tp.JointCompliance(["j9"])]}, "no joint `j9`"),
        ({"model": [tp.Declared("geometric", colour="red")]}, "colour"),
        ({"model": [tp.Thermal("oil", joint="j1")]}, "channel `oil`"),
        ({"groups": [1, 1, 1, 1]}, "single value"),
        ({"groups": [1, 2]}, "labels"),
        ({"repeat": 0}, "repeat"),
    ],
)
def test_bad_options(two: tp.Robot, options: dict[str, Any], words: str) -> None:
    with pytest.raises(tp.InputError, match=words):
        tp.identify(two, GOOD, **options)


def test_bad_requests_of_a_fit(fit: tp.Fit) -> None:
    for poses in (np.zeros((3, 2)), np.zeros((2, 4, 3)), {"x[m]": [1.0]}, {"x[m]": ["a"], "y[m]": [0.0], "z[m]": [0.0]}, [[np.nan, 0, 0]]):
        with pytest.raises(tp.InputError):
            fit.compensate(poses)
    for call in (
        lambda: fit.compensate([[1, 0, 1]], seed=[1, 2]),
        lambda: fit.compensate([[1, 0, 1]], target="P99"),
        lambda: fit.predict(np.zeros((3, 2))),
        lambda: fit.predict(),
        lambda: fit.to_yaml("abb"),
        lambda: fit.to_urdf(target="P99"),
        lambda: fit.to_urdf(urdf="none.urdf"),
        lambda: fit.save("/nowhere/fit.json"),
        lambda: fit.report(os.devnull),
        lambda: tp.load("none.json"),
        lambda: tp.Fit.from_json("{}"),
        lambda: tp.Fit.from_json(fit.to_json()[:-100]),
        lambda: tp.plan(fit, count=-3),
        lambda: tp.plan(fit, loads=[-1.0]),
        lambda: tp.monitor(fit, {"x": [1.0]}),
        lambda: tp.transfer(fit),
    ):
        with pytest.raises(tp.InputError):
            call()


def test_sessions_of_too_few_rows_are_refused(two: tp.Robot) -> None:
    with pytest.raises(tp.InputError, match="session"):
        tp.identify(two, {**GOOD, "session": ["a", "a", "b", "b"]})


def test_a_reader_of_a_stream_that_breaks_is_an_error(two: tp.Robot) -> None:
    class Broken:
        def __arrow_c_stream__(self, requested_schema: object = None) -> object:
            raise RuntimeError("no more")

    class Empty:
        def __arrow_c_stream__(self, requested_schema: object = None) -> object:
            return 3

    with pytest.raises(RuntimeError, match="no more"):
        tp.identify(two, Broken())
    with pytest.raises(TypeError, match="capsule"):
        tp.identify(two, Empty())
    nested = pa.table({**GOOD, "y[m]": [[1.0], [2.0], [3.0], [4.0]]})
    with pytest.raises(tp.InputError, match=r"y\[m\]"):
        tp.identify(two, nested)


def test_one_session_is_none(robot: tp.Robot, frame: pd.DataFrame) -> None:
    one = tp.identify(robot, frame.assign(session="north"), folds=0)
    np.testing.assert_array_equal(one.covariance, tp.identify(robot, frame, folds=0).covariance)
    assert one.sessions == [] and one.landmarks == {}


def test_what_is_wrong_with_the_further_verbs_is_told(fit: tp.Fit, robot: tp.Robot, frame: pd.DataFrame, tmp_path: Path) -> None:
    with pytest.raises(tp.InputError, match="did you mean ur10"):
        tp.Robot.named("ur10x")
    with pytest.raises(tp.InputError, match="no fleet"):
        tp.fleet([fit])
    with pytest.raises(tp.InputError, match="model: cannot be used with a fleet"):
        tp.identify(robot, frame, prior=fit, model=[tp.Geometric()])
    with pytest.raises(tp.InputError, match="session"):
        fit.in_session("north")
    with pytest.raises(tp.InputError, match="align"):
        tp.iso9283(fit, frame, align="roughly")
    with pytest.raises(tp.InputError, match="no figure with a limit"):
        tp.iso9283(fit, frame, spec={"XX": 1e-3})
    with pytest.raises(tp.InputError, match="instrument"):
        tp.iso9283(fit, frame, instrument=float("nan"))
    program = tmp_path / "job.src"
    program.write_text("DEF job()\nPTP {A1 0\nEND\n")
    with pytest.raises(tp.InputError, match=r"job\.src:2"):
        tp.rewrite(fit, program)
    with pytest.raises(tp.InputError, match="no such file"):
        tp.rewrite(fit, tmp_path / "none.src")
    with pytest.raises(tp.InputError, match="unknown language"):
        tp.rewrite(fit, program, language="cobol")
    with pytest.raises(tp.InputError, match="frames has the shape"):
        tp.rewrite(fit, program, frames=[1.0, 2.0])
    with pytest.raises(tp.InputError, match="start"):
        tp.rewrite(fit, program, start=[0.0])
    with pytest.raises(tp.InputError, match="limit"):
        tp.rewrite(fit, program, limit=0.0)
