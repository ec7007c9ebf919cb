"""The scripts of examples/07_python run, and say what they should; the README's class names exist."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import truepose as tp

FOLDER = Path(__file__).resolve().parents[3] / "examples" / "07_python"


def run(name: str, tmp_path: Path) -> str:
    ran = subprocess.run([sys.executable, FOLDER / name], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def test_first_calibration(tmp_path: Path) -> None:
    out = run("first_calibration.py", tmp_path)
    assert "held-out RMS: 0.134 mm" in out and "['ok', 'ok', 'ok'] left, mm: 0.0" in out
    assert (tmp_path / "fit.json").exists() and (tmp_path / "report" / "index.html").exists()


def test_hidden_effect(tmp_path: Path) -> None:
    assert "transmission a1: p = " in run("hidden_effect.py", tmp_path)


def test_own_effect(tmp_path: Path) -> None:
    assert "acme/encoder_gain j2: The encoder of j2" in run("own_effect.py", tmp_path)


def test_cluster(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    assert "the bytes of one machine: True" in run("cluster.py", tmp_path)


def test_notebooks_are_stored_without_outputs_and_are_listed() -> None:
    folder = FOLDER.parent / "08_notebooks"
    readme = (folder / "README.md").read_text()
    notebooks = sorted(folder.glob("*.ipynb"))
    assert len(notebooks) >= 5
    for notebook in notebooks:
        assert f"({notebook.name})" in readme
        for cell in json.loads(notebook.read_text())["cells"]:
            assert not cell.get("outputs") and cell.get("execution_count") is None, notebook.name


def test_the_corrected_urdf_is_the_same_robot_elsewhere() -> None:
    spec = importlib.util.spec_from_file_location("elsewhere", FOLDER / "elsewhere.py")
    assert spec is not None and spec.loader is not None
    elsewhere: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(elsewhere)
    found = elsewhere.differences()
    if not found:
        pytest.skip("none of pinocchio, mujoco and Robotics Toolbox is installed")
    assert max(found.values()) < 1e-9, found


def test_everything_public_is_documented() -> None:
    for name in tp.__all__:
        thing = getattr(tp, name)
        if name == "__version__":
            continue
        assert thing.__doc__, name
        if isinstance(thing, type) and thing.__module__.startswith("truepose"):
            for key, value in vars(thing).items():
                if not key.startswith("_") and (callable(value) or isinstance(value, property)):
                    assert value.__doc__, f"{name}.{key}"


def test_the_readme_of_the_project_runs(tmp_path: Path) -> None:
    root = Path(__file__).resolve().parents[3]
    (script,) = [text for text in re.findall(r"```python\n(.*?)```", (root / "README.md").read_text(), re.S) if "import truepose" in text]
    (tmp_path / "examples").symlink_to(root / "examples")
    ran = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr


def test_the_readme_names_what_there_is() -> None:
    readme = (Path(__file__).resolve().parents[1] / "README.md").read_text()
    for name in re.findall(r"tp\.([A-Za-z]\w*)", readme):
        assert hasattr(tp, name), name
