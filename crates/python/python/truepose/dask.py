"""The same identification on a Dask cluster: `identify` over Parquet files, frames, or a Dask data frame.

Tasks take in blocks that do not depend on partitions or workers, and their sums are added in the order of the blocks: the fit has the same bytes for
any number of workers and any partitioning, and those of `truepose.stream.identify`. A worker that is lost costs time: its tasks run again.
Needs ``dask[distributed]`` (``pip install truepose[dask]``).
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from truepose._core import InputError
from truepose._effect import Effect, Model
from truepose._fit import Fit
from truepose._robot import Robot
from truepose.stream import BLOCK, Accumulator, Plan, Rows, cut, length, run, sample, work

__all__ = ["discover_each", "identify"]

TASK = 16
"""Blocks of a task."""


def identify(
    robot: Robot,
    parts: Any,
    *,
    client: Any = None,
    model: Model = None,
    solver: str = "qr",
    folds: int = 5,
    prior: str | float = "evidence",
    linear: bool = False,
    positions_only: bool = False,
    block: int = BLOCK,
    progress: Callable[[str], object] | None = None,
) -> Fit:
    """Fits the declared model on a cluster.

    `parts`: paths of Parquet files that every worker can read, frames, or a Dask data frame, in the order of the rows. `client`: of
    `distributed`; default: the present one. Other options as in `truepose.identify`.
    """
    client = _client(client)
    if hasattr(parts, "to_delayed"):
        parts = client.compute(parts.to_delayed())
    # Nothing is scattered: what a lost worker held could not be made again.
    held = [part if isinstance(part, (str, os.PathLike)) or _is_future(part) else client.submit(_same, part, pure=False) for part in parts]
    lengths = client.gather(client.map(length, held, pure=False))
    rows = Rows(robot, held, lengths=lengths, block=block)

    def read(part: int, low: int, high: int) -> Any:
        return client.submit(cut, held[part], low, high, pure=False).result()

    def total(plan: Plan) -> Accumulator:
        tasks = []
        for begin in range(0, rows.blocks, TASK):
            numbers = range(begin, min(begin + TASK, rows.blocks))
            ranges, wanted = [], []
            for k in numbers:
                first, overlapping = rows.around(k * block, (k + 1) * block)
                ranges.append((k, first, k * block, (k + 1) * block))
                wanted.append(overlapping)
            used = sorted({part for overlapping in wanted for part, _, _ in overlapping})
            tasks.append((ranges, wanted, used, [held[part] for part in used]))
        futures = [
            client.submit(_task, plan.pass_bytes, plan.classes, robot, ranges, wanted, used, *parts_, positions_only=positions_only, pure=False)
            for ranges, wanted, used, parts_ in tasks
        ]
        result = plan.accumulator()
        for future in importlib.import_module("distributed").as_completed(futures):
            result.merge(future.result())
            future.release()
        return result

    plan = Plan(
        robot,
        sample(robot, rows, model, read),
        model=model,
        solver=solver,
        folds=folds,
        prior=prior,
        linear=linear,
        positions_only=positions_only,
    )
    return run(plan, total, progress)


def _task(
    pass_bytes: bytes,
    classes: tuple[type[Effect], ...],
    robot: Robot,
    ranges: Sequence[tuple[int, int, int, int]],
    wanted: Sequence[Sequence[tuple[int, int, int]]],
    used: Sequence[int],
    *parts: Any,
    positions_only: bool,
) -> Accumulator:
    at = dict(zip(used, parts))
    # One block after the other is read: that is all that a task has in memory. A task has one thread, as Dask counts them.
    cuts = ([cut(at[part], low, high) for part, low, high in overlapping] for overlapping in wanted)
    return work(pass_bytes, classes, robot, ranges, cuts, positions_only, threads=1)


def discover_each(
    robots: Iterable[tuple[Robot, Any]], *, client: Any = None, **options: Any
) -> list[Any]:
    """Runs `truepose.discover` for each robot of a fleet with its data (a frame, a mapping, or a path), one task each: futures of
    (summary, fit), in the order of the robots. `options` are those of `truepose.discover`."""
    client = _client(client)
    return [client.submit(_discovered, robot, data, options, pure=False) for robot, data in robots]


def _discovered(robot: Robot, data: Any, options: dict[str, Any]) -> tuple[dict[str, Any], Fit]:
    from truepose._verbs import discover

    found = discover(robot, data, **options)
    return found.summary, found.fit


def _same(part: Any) -> Any:
    return part


def _client(client: Any) -> Any:
    if client is not None:
        return client
    try:
        return importlib.import_module("distributed").get_client()
    except ImportError:
        raise InputError("truepose.dask needs dask[distributed]: pip install 'dask[distributed]'") from None
    except ValueError:
        raise InputError("there is no Dask client: make one (distributed.Client()), or pass client=…") from None


def _is_future(part: Any) -> bool:
    return type(part).__name__ == "Future" and hasattr(part, "result")
