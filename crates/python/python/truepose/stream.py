"""Identification of rows that are nowhere whole: blocks are taken in one after the other, or anywhere, and sums of them merge.

    plan = Plan(robot, sample, model=…)          # structure, from some thousand rows all over the data
    while not plan.done:
        total = plan.accumulator()               # to_bytes / from_bytes: for workers
        for number, block in enumerate(blocks):  # whole pose measurements, always the same blocks
            total.update(number, block)          # accumulators of other blocks merge
        plan.advance(total)
    plan.fit                                     # three to seven passes: Gauss and Newton's steps, and the residuals

Sums are added in the order of the blocks' numbers, whoever has taken them in: equal blocks give equal bytes for any number of workers and in
any order. `identify` is this loop over `Rows`, which cuts any sequence of parts (frames, Parquet files) into blocks that do not depend on where
the parts begin; `truepose.dask` is the same on a cluster. What has to see all rows at once cannot be done this way: robust and validating
solvers, channels that lag, and directions of approach that no column states.
"""

from __future__ import annotations

import functools
import importlib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from truepose import _core
from truepose._arrays import ArrowStream, column, table
from truepose._core import InputError
from truepose._effect import Effect, Model, items
from truepose._fit import Fit
from truepose._robot import Robot

__all__ = ["BLOCK", "Accumulator", "Plan", "Rows", "identify"]

BLOCK = 16384
"""Rows of a block: some megabytes, and work enough for every fold."""

REACH = 256
"""Rows before and behind a block in which its first and last pose measurement have to begin and end."""

PLACES = 32
"""Places of the data that are sampled."""

Part: TypeAlias = Any
"""A frame, a mapping from headers to columns, or the path of a Parquet file."""


class Accumulator:
    """Sums of some of the blocks of one pass. Made by `Plan.accumulator`; pickles."""

    __slots__ = ("_classes", "_core")

    def __init__(self, core: _core.Accumulator, classes: tuple[type[Effect], ...] = ()) -> None:
        self._core = core
        self._classes = classes

    @classmethod
    def of_pass(cls, bytes_: bytes, classes: tuple[type[Effect], ...] = ()) -> Accumulator:
        """An empty one of a pass (`Plan.pass_bytes`)."""
        return cls(_core.Accumulator(bytes_, list(classes)), classes)

    def update(self, number: int, robot: Robot, block: object, *, positions_only: bool = False) -> Accumulator:
        """Takes in a block (a frame or mapping with the headers of files): its number, from 0, and its rows, whole pose measurements."""
        self._core.update(number, _core.take_block(robot._core, table(block), positions_only))
        return self

    def merge(self, other: Accumulator) -> Accumulator:
        """Takes in what another accumulator of the same pass has taken in; no block twice."""
        self._core.merge(other._core)
        return self

    @property
    def rows(self) -> int:
        """Rows that have been taken in."""
        return self._core.rows

    @property
    def blocks(self) -> Sequence[int]:
        """Numbers of the blocks that have been taken in."""
        return self._core.blocks

    def to_bytes(self) -> bytes:
        """The stored form, which `from_bytes` reads on another machine."""
        return self._core.to_bytes()

    @classmethod
    def from_bytes(cls, bytes_: bytes, classes: tuple[type[Effect], ...] = ()) -> Accumulator:
        """Reads the stored form. Refuses what was cut off or altered."""
        return cls(_core.Accumulator.from_bytes(bytes_, list(classes)), classes)

    def __reduce__(self) -> tuple[Any, ...]:
        return Accumulator.from_bytes, (self.to_bytes(), self._classes)


class Plan:
    """A streamed identification between two passes."""

    def __init__(
        self,
        robot: Robot,
        sample: object,
        *,
        model: Model = None,
        solver: str = "qr",
        folds: int = 5,
        prior: str | float = "evidence",
        linear: bool = False,
        positions_only: bool = False,
    ) -> None:
        """Decides on a sample (a table of at least `wanted` rows from all over the data) which errors are identifiable. Options as in `truepose.identify`."""
        listed = items(model)
        self.classes: tuple[type[Effect], ...] = tuple({type(item) for kind, item in listed or [] if kind == "object"})
        rows = _core.take_block(robot._core, table(sample), positions_only)
        self._core = _core.Streaming(robot._core, rows, listed, solver, folds, prior, linear)
        self._fit: Fit | None = None
        self.pass_bytes, self._last = self._core.pass_()

    @staticmethod
    def wanted(robot: Robot, model: Model = None) -> int:
        """Rows that a sample should have."""
        return _core.Streaming.wanted(robot._core, items(model))

    def accumulator(self) -> Accumulator:
        """An empty accumulator of the present pass."""
        return Accumulator.of_pass(self.pass_bytes, self.classes)

    def advance(self, total: Accumulator) -> None:
        """Goes on to the next pass, with the sums of all blocks."""
        if self._last:
            self._fit = Fit(self._core.finish(total._core))
            return
        self._core.solve(total._core)
        self.pass_bytes, self._last = self._core.pass_()

    @property
    def done(self) -> bool:
        """Whether the fit is there."""
        return self._fit is not None

    @property
    def fit(self) -> Fit:
        """The fit."""
        if self._fit is None:
            raise InputError("there are passes left: advance the plan until it is done")
        return self._fit


class Rows:
    """Parts of a table (frames, mappings, paths of Parquet files) as one sequence of rows, cut into blocks.

    Block k has the pose measurements that begin in rows k·`block` to (k + 1)·`block` of the whole: where parts begin and end does not matter.
    """

    def __init__(self, robot: Robot, parts: Iterable[Part], *, lengths: Sequence[int] | None = None, block: int = BLOCK) -> None:
        self.robot = robot
        self.parts = list(parts)
        self.lengths = [length(part) for part in self.parts] if lengths is None else list(lengths)
        self.block = block
        self.ends = np.cumsum([0, *self.lengths])

    def __len__(self) -> int:
        return int(self.ends[-1])

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return max(1, -(-len(self) // self.block))

    def overlapping(self, start: int, stop: int) -> list[tuple[int, int, int]]:
        """Parts that have rows of this range: number of the part, and its first and last row (exclusive) in it."""
        found = []
        for k, (begin, end) in enumerate(zip(self.ends[:-1].tolist(), self.ends[1:].tolist())):
            low, high = max(start, begin), min(stop, end)
            if low < high:
                found.append((k, low - begin, high - begin))
        return found

    def around(self, start: int, stop: int) -> tuple[int, list[tuple[int, int, int]]]:
        """The first row that is read for the visits that begin in a range, and the parts with all rows that are."""
        first = max(0, start - REACH)
        return first, self.overlapping(first, min(len(self), stop + REACH))

    def sample_ranges(self, rows: int) -> list[tuple[int, int]]:
        """Ranges all over the data with about so many rows; the whole where it is not much longer."""
        each = max(2, -(-rows // PLACES))
        if 3 * PLACES * each >= len(self):
            return [(0, len(self))]
        step = len(self) // PLACES
        return [(place * step, place * step + each) for place in range(PLACES)]


def length(part: Part) -> int:
    """Number of rows of a part."""
    if isinstance(part, (str, os.PathLike)):
        return int(_parquet().ParquetFile(os.fspath(part)).metadata.num_rows)
    if isinstance(part, ArrowStream) or hasattr(part, "iloc"):
        sized: Any = part
        return len(sized)
    return len(next(iter(part.values()), ()))


def cut(part: Part, start: int, stop: int) -> dict[str, Any]:
    """Some rows of a part as columns."""
    if isinstance(part, (str, os.PathLike)):
        return _parquet_rows(os.fspath(part), start, stop)
    if hasattr(part, "iloc"):
        rows = part.iloc[start:stop]
        return {str(header): column(str(header), rows.iloc[:, k]) for k, header in enumerate(rows.columns)}
    if hasattr(part, "items"):
        return {str(header): column(str(header), values[start:stop]) for header, values in part.items()}
    # polars and pyarrow.
    rows = part.slice(start, stop - start)
    names = rows.column_names if hasattr(rows, "column_names") else rows.columns
    return {str(name): _plain(str(name), rows[name]) for name in names}


def _plain(name: str, values: Any) -> Any:
    if hasattr(values, "to_pylist"):
        kind = str(values.type)
        if values.null_count or "string" in kind or "dictionary" in kind:
            return column(name, np.array(values.to_pylist(), dtype=object))
        return column(name, values.to_numpy())
    return column(name, values.to_numpy())


def _parquet() -> Any:
    return importlib.import_module("pyarrow.parquet")


def _parquet_rows(path: str, start: int, stop: int) -> dict[str, Any]:
    about = os.stat(path)
    version = (about.st_mtime_ns, about.st_size)
    ends = _row_groups(path, *version)
    pieces: list[dict[str, Any]] = []
    for group, (begin, end) in enumerate(zip(ends[:-1], ends[1:])):
        low, high = max(start, begin), min(stop, end)
        if low < high:
            rows = _row_group(path, *version, group).slice(low - begin, high - low)
            pieces.append({str(name): _plain(str(name), rows[name]) for name in rows.column_names})
    if pieces:
        return joined(pieces)
    names: Sequence[Any] = _parquet().ParquetFile(path).schema_arrow.names
    return {str(name): np.empty(0) for name in names}


@functools.lru_cache(maxsize=64)
def _row_groups(path: str, changed: int, size: int) -> list[int]:
    """First row of each group of a file, and its number of rows."""
    metadata = _parquet().ParquetFile(path).metadata
    counts = [metadata.row_group(group).num_rows for group in range(metadata.num_row_groups)]
    return [int(end) for end in np.cumsum([0, *counts])]


@functools.lru_cache(maxsize=2)
def _row_group(path: str, changed: int, size: int, group: int) -> Any:
    """A group, decoded once for the blocks in it, which come one after the other; two, since a block may begin in one and end in the next."""
    return _parquet().ParquetFile(path).read_row_group(group, use_threads=False)


def joined(cuts: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Rows of several parts as columns; parts have the same headers."""
    if not cuts:
        return {}
    headers = list(cuts[0])
    for other in cuts[1:]:
        if list(other) != headers:
            raise InputError(f"parts of the data differ in their columns: {', '.join(headers)}; {', '.join(other)}")
    together: dict[str, Any] = {}
    for header in headers:
        columns = [one[header] for one in cuts]
        if all(isinstance(values, np.ndarray) for values in columns):
            together[header] = np.concatenate(columns)
        else:
            together[header] = [
                None if value is None or value != value else str(value) for values in columns for value in values
            ]
    return together


def beginning(robot: Robot, columns: dict[str, Any], first: int, start: int, stop: int) -> dict[str, Any]:
    """Of rows that begin at row `first` of the whole: those of the pose measurements that begin in start … stop."""
    _, taken = _begun(robot, columns, first, start, stop, False)
    return {header: values[taken] if isinstance(values, np.ndarray) else [v for v, t in zip(values, taken) if t] for header, values in columns.items()}


def _begun(
    robot: Robot, columns: dict[str, Any], first: int, start: int, stop: int, positions_only: bool
) -> tuple[_core.Data, NDArray[np.bool_]]:
    """The rows as they are read, and which of them belong to pose measurements that begin in start … stop."""
    try:
        rows = _core.take_block(robot._core, table(columns), positions_only)
    except InputError as error:
        raise _moved(error, first) from None
    visit = rows.visit
    begins = first + np.flatnonzero(np.diff(visit, prepend=-1))
    begun = begins[visit]
    taken: NDArray[np.bool_] = (begun >= start) & (begun < stop)
    if taken.any() and taken[-1] and begun[-1] + REACH <= first + len(visit) - 1:
        raise InputError(f"a pose measurement at row {begun[-1] + 1} has more than {REACH} rows: blocks cannot be cut there")
    return rows, taken


def _moved(error: InputError, first: int) -> InputError:
    """An error of some rows, with its rows counted in the whole."""
    if error.row is None or first == 0:
        return error
    moved = InputError(f"rows from {first + 1} on: {error}")
    moved.row, moved.column, moved.source = error.row + first, error.column, error.source
    moved.errors = [(None if row is None else row + first, header, words) for row, header, words in error.errors]
    return moved


def work(pass_bytes: bytes, classes: tuple[type[Effect], ...], robot: Robot, ranges: Sequence[tuple[int, int, int, int]],
         cuts: Iterable[Sequence[dict[str, Any]]], positions_only: bool, threads: int = 0) -> Accumulator:  # fmt: skip
    """The accumulator of some blocks: (number, first row that is there, start, stop) and the rows of each, one after the other. `threads`: 0 for all."""
    total = Accumulator.of_pass(pass_bytes, classes)
    for (number, first, start, stop), parts in zip(ranges, cuts):
        rows, taken = _begun(robot, joined(parts), first, start, stop, positions_only)
        if taken.any():
            total._core.update(number, rows.block(np.flatnonzero(taken).tolist()), threads)
    return total


def identify(
    robot: Robot,
    parts: Iterable[Part],
    *,
    model: Model = None,
    solver: str = "qr",
    folds: int = 5,
    prior: str | float = "evidence",
    linear: bool = False,
    positions_only: bool = False,
    block: int = BLOCK,
    progress: Callable[[str], object] | None = None,
) -> Fit:
    """Fits the declared model to parts that need not fit into memory together: frames, mappings, or paths of Parquet files. Options as in
    `truepose.identify`; the result does not depend on how the rows are divided into parts."""
    rows = Rows(robot, parts, block=block)

    def cuts(k: int) -> Iterator[dict[str, Any]]:
        _, overlapping = rows.around(k * block, (k + 1) * block)
        return (cut(rows.parts[part], low, high) for part, low, high in overlapping)

    def total(plan: Plan) -> Accumulator:
        result = plan.accumulator()
        ranges = [(k, rows.around(k * block, (k + 1) * block)[0], k * block, (k + 1) * block) for k in range(rows.blocks)]
        return result.merge(work(plan.pass_bytes, plan.classes, robot, ranges, (list(cuts(k)) for k in range(rows.blocks)), positions_only))

    plan = Plan(
        robot,
        sample(robot, rows, model, lambda wanted: [cut(rows.parts[part], low, high) for part, low, high in wanted]),
        model=model,
        solver=solver,
        folds=folds,
        prior=prior,
        linear=linear,
        positions_only=positions_only,
    )
    return run(plan, total, progress)


def sample(
    robot: Robot, rows: Rows, model: Model, read: Callable[[Sequence[tuple[int, int, int]]], Sequence[dict[str, Any]]]
) -> dict[str, Any]:
    """Rows all over the data, in whole pose measurements. `read` gets all that is wanted at once: part, first and last row (exclusive)."""
    ranges = rows.sample_ranges(Plan.wanted(robot, model))
    places = [rows.around(start, stop) for start, stop in ranges]
    cuts = iter(read([one for _, overlapping in places for one in overlapping]))
    found = []
    for (start, stop), (first, overlapping) in zip(ranges, places):
        found.append(beginning(robot, joined([next(cuts) for _ in overlapping]), first, start, stop))
    return joined(found)


def run(plan: Plan, total: Callable[[Plan], Accumulator], progress: Callable[[str], object] | None) -> Fit:
    """Passes until the fit is there."""
    number = 0
    while not plan.done:
        number += 1
        if progress is not None:
            progress(f"pass {number}")
        plan.advance(total(plan))
    return plan.fit
