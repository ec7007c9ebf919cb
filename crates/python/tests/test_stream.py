"""Blocks anywhere: the same bytes for any partitioning, order and number of workers; and a worker that is killed."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import truepose as tp
import truepose.stream as stream

ROWS = 6000
BLOCK = 500


@pytest.fixture(scope="module")
def arm() -> tp.Robot:
    half = np.pi / 2
    joints = [{"d": 0.16, "alpha": half}, {"a": -0.42}, {"a": -0.39}, {"d": 0.13, "alpha": half}, {"d": 0.1, "alpha": -half}, {"d": 0.1}]
    return tp.Robot.from_dh([{**joint, "limits": (-3, 3)} for joint in joints], name="arm", targets={"P1": [0.1, 0, 0], "P2": [0, 0.1, 0.1]})


@pytest.fixture(scope="module")
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


@pytest.fixture(scope="module")
def whole(arm: tp.Robot, rows: pd.DataFrame) -> tp.Fit:
    return stream.identify(arm, [rows], block=BLOCK)


def parts(rows: pd.DataFrame, count: int, shift: int = 0) -> list[pd.DataFrame]:
    ends = [0, *(len(rows) * k // count + shift for k in range(1, count)), len(rows)]
    return [rows.iloc[a:b] for a, b in zip(ends[:-1], ends[1:])]


def test_it_is_the_fit_of_all_rows(arm: tp.Robot, rows: pd.DataFrame, whole: tp.Fit) -> None:
    in_memory = tp.identify(arm, rows)
    q = arm.spread(50)
    away = np.abs(whole.predict(q).position - in_memory.predict(q).position).max()
    assert away < 2e-6, away
    assert whole.summary["held_out"]["rms_mm"] == pytest.approx(1e3 * in_memory.held_out.rms, rel=1e-3)
    assert whole.summary["rows"] == ROWS and whole.summary["visits"] == ROWS // 2


@pytest.mark.parametrize(("count", "shift"), [(2, 0), (7, 1), (40, 3)])
def test_partitions_change_nothing(arm: tp.Robot, rows: pd.DataFrame, whole: tp.Fit, count: int, shift: int) -> None:
    again = stream.identify(arm, parts(rows, count, shift), block=BLOCK)
    assert again.to_json() == whole.to_json()
    assert again.summary == whole.summary


def test_every_kind_of_part(arm: tp.Robot, rows: pd.DataFrame, whole: tp.Fit, tmp_path: Path) -> None:
    arrow = pa.Table.from_pandas(rows, preserve_index=False)
    pq.write_table(arrow.slice(0, 2501), tmp_path / "a.parquet", row_group_size=700)
    mixed: list[Any] = [tmp_path / "a.parquet", arrow.slice(2501, 99), rows.iloc[2600:3000]]
    mixed += [{name: rows[name].to_numpy()[3000:5000] for name in rows}]
    import polars

    mixed += [polars.from_arrow(arrow.slice(5000))]
    assert stream.identify(arm, mixed, block=BLOCK).to_json() == whole.to_json()


def test_the_stream_of_the_program_is_the_same_where_blocks_are(arm: tp.Robot, rows: pd.DataFrame, tmp_path: Path) -> None:
    # One row a pose, and fewer rows than a sample wants: the program's sample and blocks are these.
    few = rows.iloc[::2].iloc[:2000].reset_index(drop=True)
    robot, data, out = tmp_path / "robot.toml", tmp_path / "data.csv", tmp_path / "fit.json"
    robot.write_text(arm.to_toml())
    few.to_csv(data, index=False)
    program = str(Path(sys.executable).parent / "truepose")
    ran = subprocess.run([program, "identify", "--robot", robot, "--data", data, "--stream", "--out", out], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert stream.identify(tp.Robot.from_toml(robot), [few]).to_json() == out.read_text()


def test_accumulators_merge_in_any_order_and_through_bytes(arm: tp.Robot, rows: pd.DataFrame, whole: tp.Fit) -> None:
    cut = stream.Rows(arm, [rows], block=BLOCK)
    plan = stream.Plan(arm, stream.sample(arm, cut, None, lambda part, low, high: stream.cut(rows, low, high)))
    random = np.random.default_rng(0)
    while not plan.done:
        made = []
        for k in random.permutation(cut.blocks).tolist():
            first, overlapping = cut.around(k * BLOCK, (k + 1) * BLOCK)
            parts = [stream.cut(rows, low, high) for _, low, high in overlapping]
            made.append(stream.work(plan.pass_bytes, (), arm, [(k, first, k * BLOCK, (k + 1) * BLOCK)], [parts], False))
        assert pickle.loads(pickle.dumps(made[0])).to_bytes() == made[0].to_bytes()
        left, right = made[0], stream.Accumulator.from_bytes(made[1].to_bytes())
        for one in made[2:]:
            (left if random.random() < 0.5 else right).merge(one)
        total = stream.Accumulator.from_bytes(left.to_bytes()).merge(right)
        assert total.rows == ROWS and list(total.blocks) == list(range(cut.blocks))
        with pytest.raises(tp.InputError, match="both"):
            total.merge(made[3])
        with pytest.raises(tp.InputError, match="has not been taken in"):
            plan.advance(left)
        plan.advance(total)
    assert plan.fit.to_json() == whole.to_json()


def test_altered_bytes_are_refused(arm: tp.Robot, rows: pd.DataFrame) -> None:
    plan = stream.Plan(arm, rows.iloc[:1000])
    stored = plan.accumulator().update(0, arm, rows.iloc[:100]).to_bytes()
    random = np.random.default_rng(0)
    for _ in range(200):
        at = int(random.integers(len(stored)))
        altered = stored[:at] + bytes([stored[at] ^ (1 << int(random.integers(8)))]) + stored[at + 1 :]
        for wrong in (altered, stored[:at], b"", b"x" * at):
            with pytest.raises(tp.InputError):
                stream.Accumulator.from_bytes(wrong)
    with pytest.raises(tp.InputError, match="different passes"):
        plan.accumulator().merge(stream.Plan(arm, rows.iloc[:1002]).accumulator())


def test_what_cannot_be_streamed_is_refused(arm: tp.Robot, rows: pd.DataFrame) -> None:
    for options, words in (
        ({"solver": "huber(qr)"}, "all rows at once"),
        ({"model": [tp.Backlash("j1")]}, "approach"),
        ({"folds": 1}, "fold"),
    ):
        with pytest.raises(tp.InputError, match=words):
            stream.identify(arm, [rows], **options)  # type: ignore[arg-type]
    with pytest.raises(tp.InputError, match="differ in their columns"):
        stream.identify(arm, [rows.iloc[:3000], rows.iloc[3000:].drop(columns="target")], block=BLOCK)
    spoiled = rows.assign(**{"j1[deg]": rows["j1[deg]"].where(np.arange(ROWS) != 5123)})
    with pytest.raises(tp.InputError, match="is empty") as raised:
        stream.identify(arm, [spoiled], block=BLOCK, folds=0)
    assert (raised.value.row, raised.value.column) == (5124, "j1[deg]")


distributed = pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def parquet(rows: pd.DataFrame, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("parquet")
    paths = []
    for k, part in enumerate(parts(rows, 10, 1)):
        paths.append(folder / f"{k}.parquet")
        part.to_parquet(paths[-1], index=False, row_group_size=250)
    return paths


@pytest.fixture(scope="module", params=[1, 2, 3])
def client(request: pytest.FixtureRequest) -> Iterator[Any]:
    with distributed.LocalCluster(n_workers=request.param, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            yield client


def test_dask(arm: tp.Robot, rows: pd.DataFrame, whole: tp.Fit, parquet: list[Path], client: Any) -> None:
    import truepose.dask

    assert truepose.dask.identify(arm, parquet, block=BLOCK, client=client).to_json() == whole.to_json()
    assert truepose.dask.identify(arm, parts(rows, 4), block=BLOCK, client=client).to_json() == whole.to_json()


def test_a_killed_worker_costs_time_alone(arm: tp.Robot, whole: tp.Fit, parquet: list[Path]) -> None:
    import truepose.dask

    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            killed: list[str] = []

            def kill(words: str) -> None:
                if words == "pass 2":
                    pids = client.run(os.getpid)
                    killed.append(words)
                    os.kill(next(iter(pids.values())), 9)

            fit = truepose.dask.identify(arm, parquet, block=BLOCK, client=client, progress=kill)
    assert killed == ["pass 2"]
    assert fit.to_json() == whole.to_json()
