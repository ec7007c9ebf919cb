"""Several installations, touched points, fleets, ISO 9283 and robot programs: the same bytes as the program."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from test_same_bytes import files, program

import truepose as tp


def ran(*arguments: object) -> str:
    made = program(*arguments)
    assert made.returncode == 0, made.stderr
    return made.stdout


@pytest.fixture(scope="module")
def halls(frame: pd.DataFrame) -> pd.DataFrame:
    """The second half of the rows, seen from elsewhere."""
    half = frame.index >= len(frame) // 2
    moved = frame.assign(session=np.where(half, "hall B", "north"))
    x, y = frame["x[mm]"].to_numpy(), frame["y[mm]"].to_numpy()
    moved["x[mm]"] = np.where(half, np.cos(1.1) * x - np.sin(1.1) * y + 1500.0, x)
    moved["y[mm]"] = np.where(half, np.sin(1.1) * x + np.cos(1.1) * y - 700.0, y)
    return moved


def test_sessions(robot: tp.Robot, halls: pd.DataFrame, example: Path, tmp_path: Path) -> None:
    data, out, predicted = tmp_path / "data.csv", tmp_path / "fit.json", tmp_path / "p.csv"
    halls.to_csv(data, index=False)
    ran("identify", "--robot", example / "robot.toml", "--data", data, "--model", example / "model.toml", "--out", out)
    fit = tp.identify(robot, data, model=example / "model.toml")
    assert fit.to_json() == out.read_text()
    assert fit.sessions == ["north", "hall B"] and fit.residuals.rms < 2e-4
    assert [session["name"] for session in fit.summary["sessions"]] == fit.sessions
    assert set(tp.read(robot, data).session) == {"north", "hall B"}
    # Each row in its own session, and all rows in one.
    ran("predict", "--fit", out, "--data", data, "--out", predicted)
    np.testing.assert_array_equal(fit.predict(data).position[:, 0], pd.read_csv(predicted)["x[m]"])
    with pytest.raises(tp.InputError, match="several sessions"):
        fit.predict(robot.spread(3))
    q = robot.spread(5)
    places = {name: fit.in_session(name).predict(q).position for name in fit.sessions}
    assert np.linalg.norm(places["north"] - places["hall B"], axis=1).min() > 0.1
    # Exports are of the arm, which all sessions share.
    ran("export", "--fit", out, "--format", "mdh", "--out", tmp_path / "mdh.csv")
    assert fit.to_dh(modified=True) == (tmp_path / "mdh.csv").read_text()
    with pytest.raises(tp.InputError, match="choose one with in_session"):
        fit.compensate(places["north"])
    assert fit.in_session("hall B").compensate(places["hall B"], seed=q).ok.all()


def test_sessions_are_discovered_in(robot: tp.Robot, halls: pd.DataFrame, example: Path, tmp_path: Path) -> None:
    data, out = tmp_path / "data.csv", tmp_path / "fit.json"
    halls.to_csv(data, index=False)
    ran("discover", "--robot", example / "robot.toml", "--data", data, "--model", example / "model.toml", "--most", "1", "--rotations", "99", "--out", out)
    found = tp.discover(robot, data, model=example / "model.toml", most=1, rotations=99)
    assert found.fit.to_json() == out.read_text() and found.fit.sessions == ["north", "hall B"]


TWO = """name = "two"
[units]
length = "mm"
angle = "rad"
[[joints]]
name = "j1"
limits = [-3, 3]
dh = { theta = 0, d = 0, a = 400, alpha = 1.5 }
[[joints]]
name = "j2"
limits = [-3, 3]
dh = { theta = 0, d = 50, a = 300, alpha = -1.2 }
[[joints]]
name = "j3"
limits = [-3, 3]
dh = { theta = 0, d = 0, a = 200, alpha = 0.4 }
[[joints]]
name = "j4"
limits = [-3, 3]
dh = { theta = 0, d = 30, a = 150, alpha = 0 }
[[landmarks]]
name = "A"
kind = "socket"
[[landmarks]]
name = "B"
kind = "socket"
[[landmarks]]
name = "wire"
kind = "distance"
free = ["offset"]
[[distances]]
between = ["A", "B"]
value = 300
"""


def touches(robot: tp.Robot, at: np.ndarray, count: int) -> np.ndarray:
    """Joint values that bring the tool to a point, from many postures: damped steps."""
    q = robot.spread(8 * count)
    for _ in range(60):
        error = at - robot.fk(q)[:, :3, 3]
        step = np.linalg.pinv(robot.jacobian(q)[:, :3], rcond=1e-3) @ error[:, :, None]
        q = np.clip(q + np.clip(step[:, :, 0], -0.3, 0.3), -2.9, 2.9)
    there = np.linalg.norm(at - robot.fk(q)[:, :3, 3], axis=1) < 1e-9
    return q[there][:count]


@pytest.fixture(scope="module")
def observed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A robot and a table of touched points and of lengths of a wire."""
    folder = tmp_path_factory.mktemp("observed")
    (folder / "robot.toml").write_text(TWO)
    off = np.random.default_rng(5)
    lengths = {"a = 400": "a = 400.7", "a = 300,": "a = 299.2,", "a = 200": "a = 200.5", "d = 50": "d = 50.6"}
    text = TWO
    for old, new in lengths.items():
        text = text.replace(old, new)
    moved = tp.Robot.from_text(text)
    tables = []
    for name, at in {"A": np.array([0.3, 0.35, 0.1]), "B": np.array([0.3, 0.35, 0.4])}.items():
        q = touches(moved, at, 30)
        assert len(q) >= 20
        tables.append(pd.DataFrame(q, columns=[f"j{k}[rad]" for k in range(1, 5)]).assign(kind="same_point", landmark=name))
    q = moved.spread(40)
    wire = np.linalg.norm(moved.fk(q)[:, :3, 3] - [0.9, -0.8, -0.3], axis=1) * 1e3 + 3.0
    tables.append(pd.DataFrame(q, columns=[f"j{k}[rad]" for k in range(1, 5)]).assign(kind="distance", landmark="wire").assign(**{"distance[mm]": wire}))
    table = pd.concat(tables, ignore_index=True)
    for k in range(1, 5):
        table[f"j{k}[rad]"] += off.normal(scale=2e-5, size=len(table))
    table.to_csv(folder / "data.csv", index=False)
    return folder / "robot.toml", folder / "data.csv"


def test_landmarks_and_kinds_of_observation(observed: tuple[Path, Path], tmp_path: Path) -> None:
    robot_file, data = observed
    out = tmp_path / "fit.json"
    told = json.loads(ran("identify", "--robot", robot_file, "--data", data, "--out", out, "--json"))
    robot = tp.Robot.from_toml(robot_file)
    with pytest.warns(tp.TrueposeWarning, match="base is not determined"):
        fit = tp.identify(robot, data)
    assert fit.to_json() == out.read_text()
    said: dict[str, Any] = fit.summary
    for key in ("landmarks", "kinds", "verdict", "warnings"):
        assert said[key] == told[key], key
    assert np.linalg.norm(fit.landmarks["A"] - fit.landmarks["B"]) == pytest.approx(0.3, abs=1e-9)
    assert fit.coefficients.rows == len(fit.covariance) and fit.groups.rows > 0
    # A robot that went through bytes knows its landmarks; from memory, and compared.
    again = pickle.loads(pickle.dumps(robot))
    frame = pd.read_csv(data)
    with pytest.warns(tp.TrueposeWarning):
        assert tp.identify(again, frame).to_json() == fit.to_json()
    rows = tp.measurements(again, frame)
    assert set(rows.landmark) == {"A", "B", "wire"}
    with pytest.warns(tp.TrueposeWarning):
        found = tp.discover(again, rows, most=1, rotations=99)
    ran("discover", "--robot", robot_file, "--data", data, "--most", "1", "--rotations", "99", "--out", out)
    assert found.fit.to_json() == out.read_text()
    with pytest.raises(tp.InputError, match="no test set|holdout"):
        tp.identify(tp.Robot.from_text(TWO), frame[frame["kind"] == "same_point"].drop(columns="distance[mm]"), holdout=0.2)


def test_fleets(robot: tp.Robot, example: Path, tmp_path: Path) -> None:
    fits = []
    for seed in range(11, 15):
        made, rows = tp.simulate(example / "plant.toml", seed=seed)
        fits.append(tp.identify(made, rows, folds=0))
        fits[-1].save(tmp_path / f"{seed}.json")
    prior, out, few = tmp_path / "prior.json", tmp_path / "fit.json", tmp_path / "few.csv"
    ran("fleet", *(tmp_path / f"{seed}.json" for seed in range(11, 15)), "--out", prior)
    fleet = tp.fleet(fits)
    assert fleet.to_json() == prior.read_text() and fleet.summary["robots"] == 4
    pd.read_csv(example / "measurements.csv").head(45).to_csv(few, index=False)
    ran("identify", "--robot", example / "robot.toml", "--data", few, "--prior", prior, "--out", out)
    fit = tp.identify(robot, few, prior=fleet)
    assert fit.to_json() == out.read_text() and "fleet_used" in fit.summary and "sisters" in str(fit)
    assert tp.identify(robot, few, prior=tp.load(prior)).to_json() == out.read_text()


def test_iso9283(tmp_path: Path) -> None:
    description = tmp_path / "robot.toml"
    description.write_text(tp.Robot.named("ur10e").to_toml().replace("known = false", "known = true"))
    plan, data = tmp_path / "plan.csv", tmp_path / "data.csv"
    ran("plan", "--for", "iso9283", "--robot", description, "--out", plan, "--loads", "10")
    table = pd.read_csv(plan)
    draw = np.random.default_rng(2)
    for axis, offset in zip("xyz", (1e-4, -2e-4, 3e-4)):
        table[f"{axis}[m]"] = table[f"command_{axis}[m]"] + offset * table["pose[1]"] + draw.normal(scale=2e-5, size=len(table))
    table.assign(**{"speed[%]": 100, "time[s]": 10.0 * np.arange(len(table))}).to_csv(data, index=False)
    told = json.loads(program("iso9283", "--robot", description, "--data", data, "--spec", "AP=1mm", "--json").stdout)
    found = tp.iso9283(tp.Robot.from_toml(description), data, spec={"AP": 1e-3})
    assert found.summary == told and found.fails
    assert str(found) in program("iso9283", "--robot", description, "--data", data, "--spec", "AP=1mm").stdout
    found.report(tmp_path / "report")
    assert "ISO 9283" in (tmp_path / "report" / "index.html").read_text() and "Acceptance(" in repr(found)


def test_programs(fit: tp.Fit, tmp_path: Path) -> None:
    fit.save(tmp_path / "fit.json")
    old, new = tmp_path / "job.dat", tmp_path / "new.dat"
    (tmp_path / "job.src").write_bytes(b"&ACCESS RVP\r\nDEF job( )\r\n;Greifer \xf6ffnen\r\nPTP XP1\r\nPTP  XP2\r\nEND\r\n")
    old.write_text(
        "DEFDAT job\nDECL E6AXIS XP1={A1 50.668,A2 -106.651,A3 81.014,A4 -25.176,A5 -53.698,A6 72.074,E1 0.0}\n"
        "DECL E6AXIS XP2={A1 48.0,A2 -100.0,A3 85.0,A4 -20.0,A5 -60.0,A6 70.0}\n"
        "DECL E6AXIS XHOME={A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\nENDDAT\n"
    )
    arguments = ["compensate", "--fit", tmp_path / "fit.json", "--program", old, "--with", tmp_path / "job.src", "--mark", "--payload", "30", "--out", new]
    told = json.loads(ran(*arguments, "--json"))
    # A home position with the wrist stretched keeps its joints.
    left = ["corrected", "corrected", "unchanged at a wrist singularity"]
    assert list(tp.rewrite(fit, old, others=[tmp_path / "job.src"]).outcomes) == left
    made = tp.rewrite(fit, old, others=[tmp_path / "job.src"], mark=True, payload=30.0)
    assert made.program == new.read_bytes() and made.program != old.read_bytes()
    assert made.summary == told and list(made.outcomes) == left
    corrections = pd.read_csv(f"{new}.corrections.csv")
    np.testing.assert_array_equal(made.corrections["dx[m]"], corrections["dx[m]"])
    assert list(made.corrections["point"]) == list(corrections["point"])
    assert tp.rewrite(fit, old, others=[tmp_path / "job.src"], dry_run=True).program == old.read_bytes()
    # The other way about: the points of the further file are compensated, too; XHOME, to which no motion goes, is not of this program.
    turned = tp.rewrite(fit, tmp_path / "job.src", others=[old], payload=30.0)
    assert turned.program == (tmp_path / "job.src").read_bytes()
    assert turned.others == {str(old): made.program} and list(turned.outcomes) == ["corrected", "corrected"]
    with pytest.raises(tp.InputError, match="XP1 has no value in the files given"):
        tp.rewrite(fit, tmp_path / "job.src")


def test_frames_of_programs_in_numbers_and_in_words(fit: tp.Fit, tmp_path: Path) -> None:
    job = tmp_path / "job.src"
    job.write_text(
        "DEF job()\n$BASE=BASE_DATA[1]\n$TOOL=TOOL_DATA[1]\nPTP {A1 50,A2 -100,A3 80,A4 -25,A5 -50,A6 70}\n"
        "LIN {X 600.0,Y 100.0,Z 300.0,A 10.0,B 80.0,C 5.0}\nEND\n"
    )
    words = {"BASE_DATA[1]": "900mm,200mm,800mm,0,0,90", "TOOL_DATA[1]": "0mm,0mm,120mm,0,0,0"}
    spoken = tp.rewrite(fit, job, frames={"BASE_DATA[1]": words["BASE_DATA[1]"]}, tools={"TOOL_DATA[1]": words["TOOL_DATA[1]"]}, mark=True)
    turned = np.array([[0.0, -1, 0, 0.9], [1, 0, 0, 0.2], [0, 0, 1, 0.8], [0, 0, 0, 1]])
    numbers = tp.rewrite(fit, job, frames={"BASE_DATA[1]": turned}, tools={"TOOL_DATA[1]": [0, 0, 0.12, 0, 0, 0]}, mark=True)
    assert numbers.program == spoken.program
    assert len(numbers.outcomes) == 2


def test_programs_of_a_folder(fit: tp.Fit, tmp_path: Path) -> None:
    fit.save(tmp_path / "fit.json")
    backup, new = tmp_path / "BACKUP", tmp_path / "NEW"
    (backup / "R1").mkdir(parents=True)
    go = "DEF {}()\nPTP {{A1 50,A2 -100,A3 80,A4 -25,A5 -50,A6 70,E1 {}}}\n{}END\n"
    (backup / "R1" / "a.src").write_text(go.format("a", 0, ""))
    (backup / "b.src").write_text(go.format("b", 0, ""))
    (backup / "c.src").write_text(go.format("c", 0, "LIN_REL {Z 5}\n"))
    told = program("compensate", "--fit", tmp_path / "fit.json", "--program", backup, "--out", new, "--json")
    made = tp.rewrite(fit, backup)
    assert made.summary == json.loads(told.stdout)
    assert list(made.refused) == [str(backup / "c.src")] and "line" not in made.program.decode()
    made.save(tmp_path / "SAVED")
    for name in ("R1/a.src", "b.src"):
        assert (tmp_path / "SAVED" / name).read_bytes() == (new / name).read_bytes() == made.others[str(backup / name)]


def test_frames_that_were_taught_and_external_axes(fit: tp.Fit, tmp_path: Path) -> None:
    fit.save(tmp_path / "fit.json")
    job, new = tmp_path / "job.src", tmp_path / "new.src"
    job.write_text("DEF job()\n$BASE={X 5,Y 0,Z 0,A 0,B 0,C 0}\n$TOOL=$NULLFRAME\nPTP {A1 50,A2 -100,A3 80,A4 -25,A5 -50,A6 70,E1 7}\nLIN {X 600.0,Y 100.0,Z 300.0,A 10.0,B 80.0,C 5.0,E1 7}\nEND\n")
    touched = tmp_path / "points.csv"
    joints = [f"{joint.name}[deg]" for joint in fit.robot.joints]
    touched.write_text(",".join(["point", *joints]) + "\n" + "\n".join(f"{word},50,-100,80,-25,-50,{k}" for k, word in enumerate(("origin", "x", "xy"))) + "\n")
    name = "$BASE in line 2"
    common = ("compensate", "--fit", tmp_path / "fit.json", "--program", job, "--out", new, "--ignore-external", "--mark")
    for options, words in (({"taught": {name: touched}}, ("--taught", f"{name}={touched}")), ({"taught": {name: (touched, "flange")}}, ("--taught", f"{name}={touched},flange"))):
        told = program(*common, *words).stderr
        with pytest.raises(tp.InputError) as found:
            tp.rewrite(fit, job, ignore_external=True, mark=True, **options)
        assert str(found.value) in told
    for options, words in (({"measured": [name]}, ("--measured", name)), ({"cad": [name]}, ("--cad", name))):
        told = json.loads(program(*common, *words, "--json").stdout)
        assert tp.rewrite(fit, job, ignore_external=True, mark=True, **options).summary == told
    with pytest.raises(tp.InputError, match="which the fit has not"):
        tp.rewrite(fit, job, external={"E1": "track"})


def test_looks_are_planned(fit: tp.Fit, tmp_path: Path) -> None:
    fit.save(tmp_path / "fit.json")
    told = json.loads(ran("plan", "--for", "monitor", "--fit", tmp_path / "fit.json", "--out", tmp_path / "plan.csv", "--json"))
    planned = tp.plan_monitoring(fit)
    assert planned.summary == told and len(planned) == 12
    np.testing.assert_array_equal(planned.table["a1[rad]"], pd.read_csv(tmp_path / "plan.csv")["a1[rad]"])


def test_touches_are_planned(example: Path, tmp_path: Path) -> None:
    sockets, plan = example.parent / "09_sockets", tmp_path / "plan.csv"
    robot = tp.Robot.from_toml(sockets / "robot.toml")
    fit = tp.identify(robot, sockets / "measurements.csv")
    fit.save(tmp_path / "fit.json")
    asked = ("plan", "--fit", tmp_path / "fit.json", "--observe", sockets / "robot.toml", "--count", "12", "--pool", "200")
    told = json.loads(ran(*asked, "--out", plan, "--json"))
    planned, table = tp.plan_observed(fit, robot, count=12, pool=200), pd.read_csv(plan)
    assert planned.summary == told and len(planned) == 12
    np.testing.assert_array_equal(planned.table["j1[rad]"], table["j1[rad]"])
    assert list(planned.table["landmark"]) == list(table["landmark"])
    assert all(kind == "same_point" for things in planned.observed for kind, _, _ in things)
    with pytest.raises(tp.InputError, match="the robot has no target `X`"):
        tp.plan_observed(fit, robot, target="X")


def test_the_library_of_robots(tmp_path: Path) -> None:
    robots = tp.Robot.library()
    assert len(robots) > 25 and "Panda" in robots["panda"]
    ran("init", "panda", "--out", tmp_path / "panda.toml")
    assert tp.Robot.named("Panda") == tp.Robot.from_toml(tmp_path / "panda.toml")


def test_several_installations_are_compared(robot: tp.Robot, halls: pd.DataFrame, example: Path, tmp_path: Path) -> None:
    data = tmp_path / "data.csv"
    halls.to_csv(data, index=False)
    told = json.loads(ran("compare", *files(example)[:2], "--data", data, "--solver", "qr", "--solver", "normal", "--json"))
    found = tp.compare(robot, data, solvers=["qr", "normal"]).summary
    for here, there in zip(found["strategies"], told["strategies"]):
        # Apart from the seconds that it took.
        assert [here[key] for key in ("solver", "train", "held_out")] == [there[key] for key in ("solver", "train", "held_out")]
