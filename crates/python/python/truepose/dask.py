"""The same on a Dask cluster: `identify` over Parquet files, frames, or a Dask data frame; `discover` with a task for each outer fold.

Tasks take in blocks that do not depend on partitions or workers, and their sums are added in the order of the blocks: the fit has the same bytes for
any number of workers and any partitioning, and those of `truepose.stream.identify`. A search has those of `truepose.discover`. A worker that is lost
costs time: its tasks run again. Needs ``dask[distributed]`` (``pip install truepose[dask]``).
"""

from __future__ import annotations

import functools
import importlib
import os
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

from truepose import _core
from truepose._arrays import Arrays, Frame, Path, columns_of
from truepose._core import InputError
from truepose._data import Measurements, taken, warn
from truepose._discovery import Discovery
from truepose._effect import Effect, Hypothesis, Model
from truepose._errors import Interrupted
from truepose._fit import Fit
from truepose._progress import Line, Progress
from truepose._robot import Robot
from truepose._verbs import asked, simulate
from truepose.stream import BLOCK, Accumulator, Plan, Rows, cut, length, run, sample, work

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["discover", "discover_each", "identify", "study"]

TASK = 16
"""Blocks of a task."""

P = ParamSpec("P")
T = TypeVar("T")


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

    def read(wanted: Sequence[tuple[int, int, int]]) -> Any:
        return client.gather([client.submit(cut, held[part], low, high, pure=False) for part, low, high in wanted])

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


def _failing(task: Callable[P, T]) -> Callable[P, T]:
    """A task whose client hears of every end. A panic is no `Exception`: a client would wait for its task forever."""

    @functools.wraps(task)
    def run(*args: P.args, **options: P.kwargs) -> T:
        try:
            return task(*args, **options)
        except (Exception, KeyboardInterrupt, SystemExit):
            raise
        except BaseException as error:
            raise RuntimeError(f"a task ended with {type(error).__name__}: {error}") from None

    return run


@_failing
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


def discover(
    robot: Robot,
    data: Frame | Path | None = None,
    *,
    client: Any = None,
    nested: int = 5,
    model: Model = None,
    solver: str = "qr",
    holdout: float | None = None,
    seed: int = 0,
    alpha: float = 0.002,
    rotations: int = 499,
    most: int = 24,
    hypotheses: Iterable[Hypothesis] = (),
    without: Iterable[str] = (),
    rivals: bool = False,
    positions_only: bool = False,
    progress: Progress = False,
    **arrays: Unpack[Arrays],
) -> Discovery:
    """Finds effects that the declared model lacks, as `truepose.discover`, with its nested cross-validation on a cluster: the whole search
    without each of the `nested` outer folds is a task on one thread, while the search of all rows runs here.

    `data`: a frame or a mapping, or a file that every worker can read, as must a model file; or arrays as keywords. `client`: of `distributed`;
    default: the present one. Other options as in `truepose.discover`, and the same bytes as with ``nested=…`` there, for any number of workers.
    Ctrl-C ends it with `Interrupted`, which has what was found until then.
    """
    client = _client(client)
    if isinstance(data, Measurements):
        raise InputError("measurements that were read stay on this machine: give the frame, mapping or file that they are from")
    given: Any = columns_of(robot, arrays) if data is None else data
    rows = taken(robot, given, {} if data is None else arrays, positions_only=positions_only)
    options: dict[str, Any] = {
        "model": model, "solver": solver, "holdout": holdout, "seed": seed, "alpha": alpha, "rotations": rotations, "most": most,
        "hypotheses": list(hypotheses), "without": list(without), "rivals": rivals, "nested": nested,
    }  # fmt: skip
    search = asked(robot, rows, **options)
    options["positions_only"] = positions_only
    # Nothing is scattered here, either.
    held = given if isinstance(given, (str, os.PathLike)) else client.submit(_same, given, pure=False)
    folds = [client.submit(_without, robot, held, options, fold, pure=False) for fold in range(search.folds)]
    found: _core.Discovery | None = None
    try:
        with Line(progress) as show:
            found = search.run(False, 0, show)
            for number, fold in enumerate(folds, 1):
                if show is not None:
                    show(f"waiting for fold {number} of {len(folds)}")
                fold.result()
        if folds:
            found = search.judged(found, client.gather(folds))
    except KeyboardInterrupt:
        if found is None:
            raise
        raise Interrupted("the search is complete; its nested cross-validation is not", Discovery(found)) from None
    finally:
        client.cancel(folds)
    warn(found.remarks())
    return Discovery(found)


def discover_each(robots: Iterable[tuple[Robot, Any]], *, client: Any = None, **options: Any) -> list[Any]:
    """Runs `truepose.discover` for each robot of a fleet with its data (a frame, a mapping, or a path), one task each, on one thread: futures of
    (summary, fit), in the order of the robots. `options` are those of `truepose.discover`."""
    client = _client(client)
    return [client.submit(_discovered, robot, data, options, pure=False) for robot, data in robots]


def study(plant: Path, seeds: Iterable[int], *, client: Any = None, **options: Any) -> list[Any]:
    """What `truepose.discover` finds in simulated robots: for each seed a task, on one thread, that measures a robot of the plant file with
    `truepose.simulate` and searches. Futures of (summary, fit), in the order of the seeds; a seed has the same bytes on any machine. Every worker
    can read the plant and the robot that it names. `options` are those of `truepose.discover`."""
    client = _client(client)
    return [client.submit(_studied, os.fspath(plant), int(seed), options, pure=False) for seed in seeds]


@_failing
def _studied(plant: str, seed: int, options: dict[str, Any]) -> tuple[dict[str, Any], Fit]:
    return _discovered(*simulate(plant, seed=seed), options)


@_failing
def _discovered(robot: Robot, data: Any, options: dict[str, Any]) -> tuple[dict[str, Any], Fit]:
    found = Discovery(_asked(robot, data, **options).run(True, 1, None))
    return found.summary, found.fit


@_failing
def _without(robot: Robot, data: Any, options: dict[str, Any], fold: int) -> bytes:
    return _asked(robot, data, **options).fold(fold, 1)


def _asked(robot: Robot, data: Any, *, positions_only: bool = False, **options: Any) -> _core.Search:
    return asked(robot, taken(robot, data, {}, positions_only=positions_only), **options)


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
