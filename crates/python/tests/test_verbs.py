"""Every verb, progress, interruption, threads, scikit-learn."""

from __future__ import annotations

import pickle
import signal
import subprocess
import sys
import textwrap
import threading
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, GroupKFold, cross_val_score

import truepose as tp


def test_a_fit_shows_what_it_is(fit: tp.Fit) -> None:
    assert "held-out" in fit.verdict and str(fit).startswith("palletiser")
    assert 1e-5 < fit.residuals.rms < fit.held_out.rms < 2e-4
    assert fit.residuals.position.shape == (360, 3) and len(fit.held_out.fold_rms) == 5
    n = fit.coefficients.rows
    assert fit.covariance.shape == (n, n) and np.allclose(np.sqrt(np.diag(fit.covariance)), fit.coefficients["sd"])
    assert 0 < fit.groups.rows < n and fit.parameters.rows > 10 and fit.parameters_absent is None
    html = fit._repr_html_()
    assert "<table>" in html and "data:image/svg+xml" in html
    assert "<" not in repr(fit)


def test_reports_are_written(fit: tp.Fit, tmp_path: Path) -> None:
    fit.report(tmp_path / "report")
    assert "palletiser" in (tmp_path / "report" / "index.html").read_text()
    assert set(fit.figures) <= {path.name for path in (tmp_path / "report").iterdir()}
    with pytest.raises(tp.InputError, match="report is made of"):
        pickle.loads(pickle.dumps(fit)).report(tmp_path / "none")


def test_results_go_to_every_library_of_frames(fit: tp.Fit) -> None:
    table = fit.coefficients
    for frame in (table.to_pandas(), table.to_polars().to_pandas(), table.to_arrow().to_pandas()):
        assert list(frame["name"]) == list(table["name"])
        np.testing.assert_array_equal(frame["value"], table["value"])
    predicted = fit.predict(fit.robot.spread(3))
    assert predicted.pose.shape == (3, 4, 4) and len(predicted.table["x[m]"]) == 3


def test_an_orientation_is_every_way_of_writing_it(robot: tp.Robot) -> None:
    q = robot.spread(20)
    pose = robot.fk(q)
    whole = tp.measurements(robot, q=q, pose=pose)
    again = tp.measurements(robot, q=q, position=pose[:, :3, 3], orientation=pose[:, :3, :3])
    np.testing.assert_array_equal(whole.orientation, again.orientation)
    third = tp.measurements(robot, q=q, position=pose[:, :3, 3], orientation=whole.orientation)
    np.testing.assert_allclose(third.orientation, whole.orientation, atol=1e-15)
    fit = tp.identify(robot, whole, folds=0)
    turned = np.abs(np.sum(fit.predict(q).orientation * whole.orientation, axis=1))
    np.testing.assert_allclose(turned, 1.0, atol=1e-12)
    commands = fit.compensate(pose, seed=q)
    np.testing.assert_allclose(commands.q[commands.ok], q[commands.ok], atol=1e-6)
    assert commands.ok.sum() > 10


def test_selected_rows_and_groups(robot: tp.Robot, frame: pd.DataFrame) -> None:
    rows = tp.measurements(robot, frame)
    groups = rows.configuration % 4
    fit = tp.identify(robot, rows, groups=groups)
    assert len(fit.held_out.fold_rms) == 4
    part = rows.select(groups != 0)
    assert len(part) == int((groups != 0).sum())
    trained = tp.identify(robot, part, folds=0)
    left_out = trained.residuals_of(rows.select(groups == 0)).rms
    assert left_out == pytest.approx(fit.held_out.fold_rms[int(np.unique(groups).tolist().index(0))], rel=0.2)
    with pytest.raises(tp.InputError, match="visit"):
        tp.identify(robot, rows, groups=np.arange(len(rows)))
    with pytest.raises(tp.InputError, match="no row"):
        rows.select([10**6])


def test_scikit_learn(scara: tp.Robot, bent: tuple[np.ndarray, np.ndarray]) -> None:
    q, position = bent
    calibrator = tp.Calibrator(scara, model=[tp.Geometric(["base"]), tp.Transmission("j2", mode="gain")])
    groups = np.arange(len(q)) // 10
    scores = cross_val_score(calibrator, q, position, groups=groups, cv=GroupKFold(5))
    assert scores.shape == (5,) and (scores > -6e-5).all() and (scores < -2e-5).all()
    assert clone(calibrator).get_params() == calibrator.get_params()
    models: list[Any] = [[tp.Geometric(["base"])], calibrator.model]
    search = GridSearchCV(tp.Calibrator(scara), {"model": models}, cv=4).fit(q, position)
    assert search.best_params_["model"] is models[1]
    assert calibrator.fit(q, position, groups=groups).fit_.held_out.rms < 6e-5
    with pytest.raises(tp.InputError, match="not been fitted"):
        tp.Calibrator(scara).predict(q)
    with pytest.raises(ValueError, match="unknown parameter"):
        calibrator.set_params(colour="red")


def test_compare_plan_check(robot: tp.Robot, frame: pd.DataFrame, fit: tp.Fit, example: Path) -> None:
    compared = tp.compare(robot, frame, model=example / "model.toml", solvers=["qr", "ridge(gcv)"])
    assert sorted(strategy["solver"] for strategy in compared.summary["strategies"]) == ["qr", "ridge"]
    planned = tp.plan(fit, count=8, loads=[0.0, 10.0], com=[0, 0, 0.1])
    assert len(planned) == 8 and planned.q.shape == (8, 6) and set(planned.why) == {"new", "repeat"}
    checked = tp.check(robot, frame, model=example / "model.toml")
    assert checked.measurements is not None and len(checked.measurements) == 360
    assert checked.unknowns.rows == fit.coefficients.rows


def test_simulate_transfer_monitor(example: Path) -> None:
    robot, rows = tp.simulate(example / "plant.toml", campaign_seed=5)
    fit = tp.identify(robot, rows, model=example / "model.toml")
    # The same robot on another base.
    few = rows.select(rows.visit < 15)
    shift = np.array([0.3, -0.1, 0.05])
    table: dict[str, Any] = {f"{joint.name}[rad]": few.q[:, k] for k, joint in enumerate(robot.joints)}
    table |= {f"{axis}[m]": few.position[:, k] + shift[k] for k, axis in enumerate("xyz")}
    table |= {"target": few.target, "visit": few.visit, "payload[kg]": few.payload, "cx[m]": 0 * few.payload, "cy[m]": 0 * few.payload, "cz[m]": 0.25 + 0 * few.payload}
    table |= {f"{name}[degC]" if name == "temperature" else name: values for name, values in few.channels.items()}
    there = tp.transfer(fit, table)
    assert there.residuals_of(table).rms < 3e-4 and there.summary["residual"]["rms_mm"] < 0.3
    look = tp.monitor(fit, few)
    assert look.changed is False and "p" in str(look)
    assert tp.monitor(fit, table).changed is True
    # An arm that does not fit there is refused until it is accepted, in a file as in memory.
    wrong = tp.transfer(fit, table | {"y[m]": -table["y[m]"]})
    assert wrong.summary["arm"]["fits"] is False
    again = tp.Fit.from_json(wrong.to_json())
    for refused in (wrong, again):
        with pytest.raises(tp.InputError, match="not to be relied on: it does not fit"):
            refused.predict(few)
        with pytest.warns(tp.TrueposeWarning, match="not to be relied on"):
            refused.accept().predict(few)


def test_progress_is_called(robot: tp.Robot, frame: pd.DataFrame, capsys: pytest.CaptureFixture[str]) -> None:
    steps: list[str] = []
    tp.identify(robot, frame, progress=steps.append)
    assert steps[0] == "estimating base, tool and target frames" and len(steps) == 5
    tp.identify(robot, frame, progress=True)
    assert "cross-validating" in capsys.readouterr().err

    def stops(words: str) -> None:
        raise ZeroDivisionError(words)

    with pytest.raises(ZeroDivisionError, match="estimating"):
        tp.identify(robot, frame, progress=stops)


def test_warnings_are_issued_once(scara: tp.Robot) -> None:
    q = scara.spread(30)
    table: dict[str, Any] = {f"{joint.name}[{joint.unit}]": q[:, k] for k, joint in enumerate(scara.joints)}
    position = scara.fk(q)[:, :3, 3]
    table |= {"x": position[:, 0], "y[m]": position[:, 1], "z[m]": position[:, 2]}
    with pytest.warns(tp.TrueposeWarning, match="has no unit"):
        tp.identify(scara, table, folds=0)
    rows = tp.measurements(scara, table)
    assert any("has no unit" in words for words in rows.warnings)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tp.identify(scara, rows, folds=0)


def test_the_interpreter_goes_on_meanwhile(robot: tp.Robot, frame: pd.DataFrame, example: Path) -> None:
    rows = tp.measurements(robot, frame)
    done = threading.Event()
    result: list[Any] = []

    def work() -> None:
        result.append(tp.identify(robot, rows, model=example / "model.toml", repeat=60).to_json())
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    turns = 0
    while not done.wait(0.002):
        turns += 1
    thread.join()
    assert turns > 10 and result


def run(script: str) -> subprocess.Popen[str]:
    text = textwrap.dedent(script)
    return subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_ctrl_c_ends_a_search_and_keeps_what_was_found(example: Path) -> None:
    process = run(f"""
        import truepose as tp
        robot = tp.Robot.from_toml({str(example / "robot.toml")!r})
        found = lambda words: print(words, flush=True)
        try:
            tp.discover(robot, {str(example / "measurements.csv")!r}, model={str(example / "model.toml")!r}, progress=found)
        except KeyboardInterrupt as stopped:
            kept = stopped.found
            print("kept", type(stopped).__name__, kept.incomplete, [effect.title for effect in kept.effects], kept.fit.provenance["incomplete"], flush=True)
            kept.fit.to_json()
    """)
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("screening again"):
            process.send_signal(signal.SIGINT)
            begun = time.monotonic()
            break
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    kept = [line for line in out.splitlines() if line.startswith("kept")]
    assert kept == ["kept Interrupted True ['transmission a1'] interrupted"], out + err
    assert time.monotonic() - begun < 30


def test_ctrl_c_ends_an_identification(example: Path) -> None:
    process = run(f"""
        import truepose as tp
        robot = tp.Robot.from_toml({str(example / "robot.toml")!r})
        tp.identify(robot, {str(example / "measurements.csv")!r}, repeat=1000, progress=lambda words: print(words, flush=True))
    """)
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("cross-validating"):
            process.send_signal(signal.SIGINT)
            break
    _, err = process.communicate(timeout=60)
    assert "KeyboardInterrupt" in err and process.returncode in (1, -signal.SIGINT, 130), err


def test_ctrl_c_in_the_program(example: Path, tmp_path: Path) -> None:
    program = str(Path(sys.executable).parent / "truepose")
    out = tmp_path / "fit.json"
    command = [program, "discover", "--robot", example / "robot.toml", "--data", example / "measurements.csv", "--nested", "5", "--out", out]
    process = subprocess.Popen([*map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(2.0)
    process.send_signal(signal.SIGINT)
    text, err = process.communicate(timeout=60)
    assert process.returncode == 130 and text.startswith("INCOMPLETE: interrupted"), text + err
