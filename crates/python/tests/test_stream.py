"""Blocks anywhere: the same bytes for any partitioning and order."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from many_rows import BLOCK, ROWS, parts

import truepose as tp
import truepose.stream as stream

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
    plan = stream.Plan(arm, stream.sample(arm, cut, None, lambda wanted: [stream.cut(rows, low, high) for _, low, high in wanted]))
    random = np.random.default_rng(0)
    while not plan.done:
        made = []
        for k in random.permutation(cut.blocks).tolist():
            first, overlapping = cut.around(k * BLOCK, (k + 1) * BLOCK)
            read = [stream.cut(rows, low, high) for _, low, high in overlapping]
            made.append(stream.work(plan.pass_bytes, (), arm, [(k, first, k * BLOCK, (k + 1) * BLOCK)], [read], False))
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
