"""The verbs as functions."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from truepose import _core
from truepose._arrays import Arrays, Floats, Path
from truepose._core import InputError
from truepose._data import Data, Measurements, taken, warn
from truepose._discovery import Discovery
from truepose._effect import Hypothesis, Model, items
from truepose._fit import Fit
from truepose._progress import Line, Progress
from truepose._robot import Robot
from truepose._table import Table

if TYPE_CHECKING:
    from typing_extensions import Unpack


def identify(
    robot: Robot,
    data: Data = None,
    *,
    model: Model = None,
    solver: str = "qr",
    folds: int = 5,
    split: str = "random",
    groups: ArrayLike | None = None,
    repeat: int = 1,
    seed: int = 0,
    holdout: float | None = None,
    positions_only: bool = False,
    prior: str | float | Fit = "evidence",
    linear: bool = False,
    reduce_once: bool = False,
    rounds: int | None = None,
    progress: Progress = False,
    **arrays: Unpack[Arrays],
) -> Fit:
    """Fits a declared error model to measured poses, and estimates its accuracy on held-out data.

    Parameters
    ----------
    robot
        The nominal robot.
    data
        A frame (pandas, polars, pyarrow, DuckDB …) or a mapping with the headers of files, a file, or `Measurements`; or arrays as keywords, in SI
        units: ``q=…, position=…`` (see `Arrays`).
    model
        Effects (``[tp.Geometric(), tp.JointCompliance(["j2"])]``) or a model file; default: constant errors of every frame and target.
    solver
        A strategy with its options in brackets: ``qr``, ``svd(rcond=1e-10)``, ``ridge(gcv)``, ``huber(qr, k=1.345)`` …
    folds
        Of the cross-validation; 0 for none.
    split
        ``random``, ``time`` (contiguous blocks), ``joint`` (slabs along the joint that moves most) or ``leave-one-out``.
    groups
        One label for each row: folds of your own, in place of `folds` and `split`.
    repeat
        So many random splits.
    seed
        Of every random choice.
    holdout
        Fraction of the configurations in a test set that is drawn before anything is fitted.
    positions_only
        Orientations are not used.
    prior
        Scale of the prior standard deviations: ``evidence`` (from the data), ``none``, or a factor; or what `fleet` made of the fits of other robots
        of this type, whose model is then taken.
    linear
        A single linear step.
    reduce_once
        Identifiable errors are determined once, at the nominal robot.
    rounds
        Largest number of iterations.
    progress
        True for a line, or a function that is called with the words of each step.
    **arrays
        Measurements as arrays, in place of `data`.

    Raises
    ------
    InputError
        What is wrong with the input, with row and column.
    """
    rows = taken(robot, data, arrays, positions_only=positions_only)
    if isinstance(prior, Fit):
        given = {"model": model is not None, "groups": groups is not None, "holdout": holdout is not None, "repeat": repeat != 1}
        for name in (name for name, there in given.items() if there):
            raise InputError(f"{name}: cannot be used with a fleet as prior; the model is that of the fleet")
        return Fit(
            _core.identify_sister(robot._core, rows._core, prior._core, solver, _count("folds", folds), split, _count("seed", seed))
        )
    labels = None
    if groups is not None:
        _, labels = np.unique(np.asarray(groups), return_inverse=True)
        labels = np.ascontiguousarray(labels, dtype=np.int64).reshape(-1)
    with Line(progress) as show:
        core, said = _core.identify(
            robot._core, rows._core, items(model), solver, _count("folds", folds), split, _count("repeat", repeat), _count("seed", seed),
            holdout, prior, linear, reduce_once, None if rounds is None else _count("rounds", rounds), labels, show,
        )  # fmt: skip
    warn(said)
    return Fit(core)


def discover(
    robot: Robot,
    data: Data = None,
    *,
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
    nested: int = 0,
    positions_only: bool = False,
    progress: Progress = False,
    **arrays: Unpack[Arrays],
) -> Discovery:
    """Finds effects that the declared model lacks, adds them, and tests the enlarged model on held-out data.

    `robot`, `data`, `model`, `solver` and arrays as in `identify`. `alpha`: family-wise significance level; `rotations`: random rotations behind each
    p-value; `most`: largest number of effects; `hypotheses`: of your own, tested beside the built-in ones; `without`: families that are left out;
    `rivals`: competing hypotheses that are not distinguishable are fitted as well; `nested`: folds of a nested cross-validation of the whole search.
    Ctrl-C ends the search with `Interrupted`, which has what was found until then.
    """
    rows = taken(robot, data, arrays, positions_only=positions_only)
    search = asked(
        robot, rows, model=model, solver=solver, holdout=holdout, seed=seed, alpha=alpha, rotations=rotations, most=most,
        hypotheses=hypotheses, without=without, rivals=rivals, nested=nested,
    )  # fmt: skip
    with Line(progress) as show:
        core = search.run(True, 0, show)
    warn(core.remarks())
    return Discovery(core)


def asked(
    robot: Robot,
    rows: Measurements,
    *,
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
    nested: int = 0,
) -> _core.Search:
    """A search with the options of `discover`."""
    return _core.Search(
        robot._core, rows._core, items(model), solver, holdout, _count("seed", seed), alpha, _count("rotations", rotations),
        _count("most", most), list(hypotheses), list(without), rivals, _count("nested", nested),
    )  # fmt: skip


@dataclass(frozen=True)
class Comparison:
    """Solver strategies on the same folds. `summary` is comparison.json."""

    summary: dict[str, Any]
    text: str

    def __str__(self) -> str:
        return self.text


STRATEGIES = ("qr", "svd", "normal", "ridge(gcv)", "ridge(map)", "lasso(cv)", "huber(qr)", "tukey(qr)")


def compare(
    robot: Robot,
    data: Data = None,
    *,
    model: Model = None,
    solvers: Sequence[str] = STRATEGIES,
    folds: int = 5,
    split: str = "random",
    seed: int = 0,
    prior: str | float = "none",
    positions_only: bool = False,
    progress: Progress = False,
    **arrays: Unpack[Arrays],
) -> Comparison:
    """Fits one model with several solver strategies, on the same folds, and tests the differences."""
    rows = taken(robot, data, arrays, positions_only=positions_only)
    with Line(progress) as show:
        summary, text = _core.compare(
            robot._core, rows._core, items(model), list(solvers), _count("folds", folds), split, _count("seed", seed), prior, show
        )
    return Comparison(json.loads(summary), text)


@dataclass(frozen=True)
class Plan:
    """Pose measurements to make, in the order of their worth: joint values `q` n × dof, `payload` (kg), direction of `approach` n × dof, `why`
    (``new`` or ``repeat``) and `worth`; of `plan_observed`, what is `observed` in each: kind, landmark and target. `summary` is what the program
    prints with ``--json``."""

    q: Floats
    payload: Floats
    approach: Floats
    why: Sequence[str]
    worth: Floats
    summary: dict[str, Any]
    text: str
    robot: Robot
    observed: Sequence[Sequence[tuple[str, str, str]]] = ()

    def __len__(self) -> int:
        return len(self.q)

    def __str__(self) -> str:
        return self.text

    @property
    def table(self) -> Table:
        """Under the headers of `truepose plan`; where something is observed, a line for each thing."""
        rows = [(k, row) for k in range(len(self)) for row in (self.observed[k] if self.observed else [("", "", "")])]
        of = [k for k, _ in rows]
        columns: dict[str, Any] = {f"{joint.name}[{joint.unit}]": self.q[of, k] for k, joint in enumerate(self.robot.joints)}
        columns.update({f"approach_{joint.name}": self.approach[of, k] for k, joint in enumerate(self.robot.joints)})
        columns.update({"payload[kg]": self.payload[of], "why": [self.why[k] for k in of], "worth": self.worth[of]})
        if self.observed:
            for k, name in enumerate(("kind", "landmark", "target")):
                columns[name] = [row[k] for _, row in rows]
        return Table(columns)


def plan(
    fit: Fit,
    *,
    rival: Fit | None = None,
    at: Data = None,
    count: int = 30,
    loads: Sequence[float] = (),
    com: Sequence[float] = (0.0, 0.0, 0.0),
    pool: int = 400,
    seed: int = 0,
) -> Plan:
    """Plans further measurements: for accuracy, or, with a `rival`, to distinguish two hypotheses.

    `at`: joint values, loads and channels where accuracy matters; `loads`: payloads that can be carried, kg, with their centre of gravity `com` in the
    tool's frame, m; `pool`: number of candidate configurations.
    """
    goals = None if at is None else taken(fit.robot, at, {}, measured=False)
    x, y, z = (float(v) for v in com)
    found, summary, text = _core.plan(
        fit._core, None if rival is None else rival._core, None if goals is None else goals._core, _count("count", count),
        [float(mass) for mass in loads], (x, y, z), _count("pool", pool), _count("seed", seed),
    )  # fmt: skip
    return Plan(
        found["q"], found["payload"], found["approach"], found["why"], found["worth"], json.loads(summary), text, fit.robot
    )


def plan_observed(
    fit: Fit,
    robot: Robot,
    *,
    at: Data = None,
    target: str | None = None,
    count: int = 30,
    loads: Sequence[float] = (),
    com: Sequence[float] = (0.0, 0.0, 0.0),
    pool: int = 400,
    seed: int = 0,
) -> Plan:
    """Plans what to touch and to look at next, and from where: the landmarks and cameras of `robot`, with postures within its joints' ranges in which
    its `target` (the first) observes.

    The places of landmarks and sensors that the robot leaves open are unknowns beside its errors; those that the fit has found are taken from it. The
    plan's `observed` says what is observed in each posture. Other arguments as for `plan`.
    """
    goals = None if at is None else taken(fit.robot, at, {}, measured=False)
    x, y, z = (float(v) for v in com)
    found, summary, text = _core.plan_observed(
        fit._core, robot._core, None if goals is None else goals._core, target, _count("count", count),
        [float(mass) for mass in loads], (x, y, z), _count("pool", pool), _count("seed", seed),
    )  # fmt: skip
    return Plan(
        found["q"], found["payload"], found["approach"], found["why"], found["worth"], json.loads(summary), text, fit.robot,
        found["observed"],
    )  # fmt: skip


def plan_monitoring(fit: Fit, *, count: int = 12, alpha: float = 0.01) -> Plan:
    """Chooses those poses of a fit that show changes of the robot best, for looks with `monitor`. The plan's `summary` lists the smallest changes that
    the first look finds in 9 cases of 10 (``detectable``), and those that none of the poses shows (``invisible``)."""
    found, summary = _core.monitoring(fit._core, _count("count", count), alpha)
    words = f"{len(found['q'])} poses for looks with truepose.monitor"
    return Plan(found["q"], found["payload"], found["approach"], found["why"], found["worth"], json.loads(summary), words, fit.robot)


def fleet(fits: Iterable[Fit]) -> Fit:
    """What robots of one type have in common, from fits that were made with one model: a prior for the next robot, ``identify(…, prior=…)``.

    Its coefficients are the means, its covariance the scatter from robot to robot; `summary` lists both.
    """
    return Fit(_core.fleet([fit._core for fit in fits]))


def simulate(plant: Path, *, seed: int | None = None, campaign_seed: int | None = None) -> tuple[Robot, Measurements]:
    """Measurements of a simulated robot with physical error sources, of a plant file (TOML): the nominal robot, and its measurements."""
    robot, data = _core.simulate(os.fspath(plant), seed, campaign_seed)
    made = Robot(robot)
    return made, Measurements(data, made)


def transfer(
    fit: Fit, data: Data = None, *, tool: bool = False, targets: bool = False, update: bool = False, **arrays: Unpack[Arrays]
) -> Fit:
    """The arm as identified, in a new installation: its base (and `tool`, `targets`) is found from a few poses. `update` lets the errors of the arm move.

    The result's `summary` says how well the installation is determined and whether the arm still fits.
    """
    rows = taken(fit.robot, data, arrays)
    return Fit(_core.transfer(fit._core, rows._core, tool, targets, update))


@dataclass(frozen=True)
class Look:
    """Whether a robot has changed since it was calibrated. `summary` is what the program prints with ``--json``."""

    changed: bool
    summary: dict[str, Any]
    text: str

    def __str__(self) -> str:
        return self.text


def monitor(
    fit: Fit,
    data: Data = None,
    *,
    alpha: float = 0.01,
    looks: int = 0,
    base: bool = False,
    tool: bool = False,
    targets: bool = False,
    **arrays: Unpack[Arrays],
) -> Look:
    """Tests whether the robot has changed. `alpha`: probability that an unchanged robot ever raises an alarm, over all looks; `looks`: those before
    this one; `base`, `tool`, `targets`: what is found anew from these data."""
    rows = taken(fit.robot, data, arrays)
    changed, summary, text = _core.monitor(fit._core, rows._core, alpha, _count("looks", looks), base, tool, targets)
    return Look(changed, json.loads(summary), text)


@dataclass(frozen=True)
class Check:
    """What robot, model and data are understood as: `unknowns` of the model (family, name, SI unit, expected size), `measurements`, `warnings`."""

    robot: Robot
    unknowns: Table
    measurements: Measurements | None
    warnings: list[str]

    def __repr__(self) -> str:
        return f"Check({self.robot!r}, {self.unknowns.rows} unknowns, {self.measurements!r}, {len(self.warnings)} warnings)"


def check(robot: Robot, data: Data = None, *, model: Model = None, **arrays: Unpack[Arrays]) -> Check:
    """Reads everything and fits nothing: raises what `identify` would raise about its input."""
    given = data is not None or bool(arrays)
    rows = None
    if given:
        import warnings

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            rows = taken(robot, data, arrays, measured=False)
    unknowns = _core.check(robot._core, None if rows is None else rows._core, items(model))
    names = ("family", "name", "unit", "size")
    said = robot.warnings + (rows.warnings if rows is not None else [])
    return Check(robot, Table({name: [row[k] for row in unknowns] for k, name in enumerate(names)}), rows, said)


def _count(name: str, value: int) -> int:
    try:
        whole = int(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name}: {value!r} is not a whole number, 0 or more") from None
    if whole != value or whole < 0 or whole >= 2**63:
        raise InputError(f"{name}: {value!r} is not a whole number, 0 or more")
    return whole
