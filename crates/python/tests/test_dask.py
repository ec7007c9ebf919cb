"""A cluster of processes: the same bytes for any number of workers, and with one of them killed in the middle."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from many_rows import BLOCK, parts
from test_same_bytes import program

import truepose as tp

distributed = pytest.importorskip("distributed")
import truepose.dask  # noqa: E402

# With 160 poses each fold searches more than a hundred: below, it would validate itself in folds of its own.
POSES = 160
OPTIONS: dict[str, Any] = {"nested": 3, "rotations": 99}


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """Workers take seconds to start: one cluster for all tests."""
    with distributed.LocalCluster(n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            yield client


def scaled(client: Any, workers: int) -> None:
    client.cluster.scale(workers)
    until = time.monotonic() + 60
    while len(client.scheduler_info(n_workers=-1)["workers"]) != workers:
        assert time.monotonic() < until, "the cluster does not scale"
        time.sleep(0.05)


def killer(client: Any, at: Callable[[str], bool]) -> tuple[list[str], Callable[[str], None]]:
    """Kills a worker at the first step of a kind."""
    killed: list[str] = []

    def kill(words: str) -> None:
        if at(words) and not killed:
            killed.append(words)
            os.kill(next(iter(client.run(os.getpid).values())), 9)

    return killed, kill


@pytest.fixture(scope="module")
def parquet(rows: pd.DataFrame, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("parquet")
    paths = []
    for k, part in enumerate(parts(rows, 10, 1)):
        paths.append(folder / f"{k}.parquet")
        part.to_parquet(paths[-1], index=False, row_group_size=250)
    return paths


@pytest.mark.parametrize("workers", [3, 1, 2])
def test_identify(arm: tp.Robot, rows: pd.DataFrame, whole: tp.Fit, parquet: list[Path], client: Any, workers: int) -> None:
    scaled(client, workers)
    assert truepose.dask.identify(arm, parquet, block=BLOCK, client=client).to_json() == whole.to_json()
    assert truepose.dask.identify(arm, parts(rows, 4), block=BLOCK, client=client).to_json() == whole.to_json()


def test_a_killed_worker_costs_time_alone(arm: tp.Robot, whole: tp.Fit, parquet: list[Path], client: Any) -> None:
    scaled(client, 2)
    killed, kill = killer(client, lambda words: words == "pass 2")
    fit = truepose.dask.identify(arm, parquet, block=BLOCK, client=client, progress=kill)
    assert killed == ["pass 2"]
    assert fit.to_json() == whole.to_json()


@pytest.fixture(scope="module")
def two() -> tp.Robot:
    return tp.Robot.from_dh([{"a": 0.4, "limits": (-3, 3)}, {"a": 0.3, "limits": (-3, 3)}], name="two")


@pytest.fixture(scope="module")
def geared(two: tp.Robot) -> pd.DataFrame:
    """Poses of an arm with a transmission error that nobody declared; a position is missing."""
    q = two.spread(POSES)
    real = q + np.outer(np.sin(q[:, 0]) * 1e-3, [1, 0])
    position = two.fk(real)[:, :3, 3] + np.random.default_rng(1).normal(scale=1e-5, size=(POSES, 3))
    table = pd.DataFrame(np.hstack([q, position]), columns=["j1[rad]", "j2[rad]", "x[m]", "y[m]", "z[m]"])
    table.loc[17, "z[m]"] = np.nan
    return table


@pytest.fixture(scope="module")
def by_program(two: tp.Robot, geared: pd.DataFrame, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("nested")
    (folder / "robot.toml").write_text(two.to_toml())
    geared.to_csv(folder / "data.csv", index=False)
    files = ("--robot", folder / "robot.toml", "--data", folder / "data.csv", "--out", folder / "fit.json", "--report", folder / "report")
    ran = program("discover", *files, *(word for name, value in OPTIONS.items() for word in (f"--{name}", value)))
    assert ran.returncode == 0, ran.stderr
    return folder


def test_outer_folds_are_tasks(by_program: Path, geared: pd.DataFrame, client: Any, tmp_path: Path) -> None:
    scaled(client, 2)
    robot = tp.Robot.from_toml(by_program / "robot.toml")
    killed, kill = killer(client, lambda words: words.startswith("waiting"))
    for data, progress in ((geared, kill), (by_program / "data.csv", False)):
        found = truepose.dask.discover(robot, data, **OPTIONS, client=client, progress=progress)
        assert found.fit.to_json() == (by_program / "fit.json").read_text()
        found.report(tmp_path)
        assert (tmp_path / "discovery.json").read_bytes() == (by_program / "report" / "discovery.json").read_bytes()
    assert killed == ["waiting for fold 1 of 3"]
    assert len(found.summary["nested"]["found"]) == OPTIONS["nested"] and [effect.title for effect in found.effects] == ["transmission j1"]


def test_hypotheses_go_to_workers(two: tp.Robot, geared: pd.DataFrame, client: Any) -> None:
    class Sine(tp.Effect):
        family = "acme/sine"

        def __init__(self, joint: str) -> None:
            self.joint = joint

        def columns(self, robot: tp.Robot) -> list[tp.Column]:
            return [tp.Column(f"sine {self.joint}", size=1e-3, along=self.joint)]

        def evaluate(self, at: tp.Postures) -> np.ndarray:
            return np.sin(at.joint(self.joint))[:, None]

    class Sines(tp.Hypothesis):
        family = "acme/sine"

        def variants(self, setting: tp.Setting) -> Iterable[tp.Variant]:
            return [tp.Variant(Sine(joint), joint=joint) for joint in setting.moved]

        def meaning(self, joint: str) -> str:
            return f"The gear of {joint} is out of round."

    options = {**OPTIONS, "hypotheses": [Sines()], "without": ["transmission"]}
    found = truepose.dask.discover(two, geared, client=client, **options)
    assert found.summary == tp.discover(two, geared, **options).summary
    assert found.summary["nested"]["found"] == [["acme/sine j1"]] * 3


class Fatal(BaseException):
    """What an `except Exception` lets through, as a panic is."""


class Broken(tp.Hypothesis):
    family = "acme/broken"

    def variants(self, setting: tp.Setting) -> Iterable[tp.Variant]:
        raise Fatal("no such machine")

    def meaning(self, joint: str) -> str:
        return ""


def test_a_task_that_fails_in_any_way_ends_the_wait(two: tp.Robot, geared: pd.DataFrame, client: Any) -> None:
    (future,) = truepose.dask.discover_each([(two, geared)], client=client, hypotheses=[Broken()], rotations=99)
    with pytest.raises(RuntimeError, match=r"Fatal: no such machine"):
        future.result(timeout=100)


def test_what_cannot_be_sent_is_refused(two: tp.Robot, geared: pd.DataFrame, client: Any) -> None:
    read = tp.measurements(two, geared)
    with pytest.raises(tp.InputError, match="stay on this machine"):
        truepose.dask.discover(two, read, client=client)  # type: ignore[arg-type]
    with pytest.raises(tp.InputError, match="one fold leaves no data"):
        truepose.dask.discover(two, geared, nested=1, client=client)
    q, position = read.q, read.position
    arrays = truepose.dask.discover(two, q=q, position=position, **OPTIONS, client=client)
    assert arrays.summary == tp.discover(two, geared, **OPTIONS).summary


PLANT = """robot = "robot.toml"
[[errors.transmission]]
joint = "j1"
amplitude_mrad = 1
[instrument]
sd_um = 10
[campaign]
postures = "random"
visits = 150
"""


def test_a_fleet_and_a_study(two: tp.Robot, geared: pd.DataFrame, client: Any, tmp_path: Path) -> None:
    plant = tmp_path / "plant.toml"
    plant.write_text(PLANT)
    (tmp_path / "robot.toml").write_text(two.to_toml())
    options: dict[str, Any] = {"rotations": 99, "most": 1, "client": client}
    fleet = truepose.dask.discover_each([(two, geared), (two, geared.iloc[:150])], **options)
    study = truepose.dask.study(plant, range(2), **options)
    del options["client"]
    (_, first), (summary, second) = client.gather(fleet)
    alone = tp.discover(two, geared.iloc[:150], **options)
    assert summary == alone.summary and second.to_json() == alone.fit.to_json() != first.to_json()
    (_, first), (summary, second) = client.gather(study)
    alone = tp.discover(*tp.simulate(plant, seed=1), **options)
    assert summary == alone.summary and second.to_json() == alone.fit.to_json() != first.to_json()
