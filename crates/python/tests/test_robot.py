"""The nominal robot."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import truepose as tp


def test_forward_kinematics_are_those_of_the_table(scara: tp.Robot) -> None:
    q = np.array([[0.3, -0.5, 0.1, 0.2], [0.0, 0.0, 0.0, 0.0]])
    poses = scara.fk(q)
    assert poses.shape == (2, 4, 4)
    x = 0.4 * np.cos(0.3) + 0.3 * np.cos(-0.2)
    np.testing.assert_allclose(poses[0, :3, 3], [x, 0.4 * np.sin(0.3) + 0.3 * np.sin(-0.2), 0.1], atol=1e-15)
    turn = 0.3 - 0.5 + 0.2
    np.testing.assert_allclose(poses[0, :2, :2], [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]], atol=1e-15)
    np.testing.assert_array_equal(scara.fk(q[0])[0], poses[0])


def test_jacobians_are_differences(robot: tp.Robot) -> None:
    q = robot.spread(5)
    jacobian = robot.jacobian(q)
    assert jacobian.shape == (5, 6, 6)
    step = 1e-6
    for k in range(6):
        ahead, behind = (robot.fk(q + sign * step * np.eye(6)[k]) for sign in (1, -1))
        np.testing.assert_allclose(jacobian[:, :3, k], (ahead - behind)[:, :3, 3] / (2 * step), atol=1e-8)
        spin = (ahead - behind)[:, :3, :3] @ np.swapaxes(robot.fk(q)[:, :3, :3], 1, 2) / (2 * step)
        np.testing.assert_allclose(jacobian[:, 3:, k], np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1), atol=1e-8)


def error_jacobians(scara: tp.Robot, q: np.ndarray) -> np.ndarray:
    """Of the arm that the fixture has, by its table: n × 6 × 24, Eq. (7) frame by frame."""
    result = np.zeros((len(q), 6, 24))
    for row, (first, second, lift, turn) in enumerate(q):
        angles = [first, first + second, first + second, first + second + turn]
        elbow = 0.4 * np.array([np.cos(first), np.sin(first), 0.0])
        wrist = elbow + 0.3 * np.array([np.cos(first + second), np.sin(first + second), 0.0])
        hand = wrist + [0.0, 0.0, lift]
        for frame, (angle, origin) in enumerate(zip(angles, (elbow, wrist, hand, hand))):
            axes = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
            result[row, :3, 6 * frame : 6 * frame + 3] = axes
            result[row, :3, 6 * frame + 3 : 6 * frame + 6] = np.cross(axes.T, hand - origin).T
            result[row, 3:, 6 * frame + 3 : 6 * frame + 6] = axes
    return result


def test_error_jacobians_are_used_without_being_kept(scara: tp.Robot) -> None:
    q = np.random.default_rng(5).uniform(-1.0, 1.0, (300, 4))
    jacobian = error_jacobians(scara, q)
    position, rotation = scara.error_gram(q)
    np.testing.assert_allclose(position, np.einsum("nci,ncj->ij", jacobian[:, :3], jacobian[:, :3]), atol=1e-10)
    np.testing.assert_allclose(rotation, np.einsum("nci,ncj->ij", jacobian[:, 3:], jacobian[:, 3:]), atol=1e-10)
    assert scara.error_columns[:7] == ["j1 x", "j1 y", "j1 z", "j1 rx", "j1 ry", "j1 rz", "j2 x"] and len(scara.error_columns) == 24

    root = np.random.default_rng(6).normal(0.0, 1e-4, (24, 30))
    covariance = root @ root.T
    variances = scara.error_variances(q, covariance)
    np.testing.assert_allclose(variances, np.einsum("nci,ij,ncj->nc", jacobian, covariance, jacobian), rtol=1e-9)

    found = scara.observability(q, position_sd=2e-4, orientation_sd=1e-3, length=2e-3, angle=1e-3)
    scaled = jacobian * np.tile([2e-3] * 3 + [1e-3] * 3, 4) / np.repeat([2e-4, 1e-3], 3)[:, None]
    singular = np.linalg.svd(scaled.reshape(-1, 24), compute_uv=False)
    assert found.rank == np.sum(singular > 1e-10 * singular[0]) < 24
    np.testing.assert_allclose(found.singular_values, singular[: found.rank], rtol=1e-6)
    np.testing.assert_allclose([found.o2, found.o3], [singular[found.rank - 1] / singular[0], singular[found.rank - 1]], rtol=1e-6)
    assert scara.observability(q).rank < found.rank


def test_scales_and_covariances_that_are_none_are_refused(scara: tp.Robot) -> None:
    q = scara.spread(3)
    with pytest.raises(tp.InputError, match="24 × 24"):
        scara.error_variances(q, np.eye(6))
    with pytest.raises(tp.InputError, match="negative variance"):
        scara.error_variances(q, -np.eye(24))
    with pytest.raises(tp.InputError, match="position_sd"):
        scara.observability(q, position_sd=0.0)
    with pytest.raises(tp.InputError, match="not a finite number"):
        scara.error_gram([[0.0, np.nan, 0.0, 0.0]])


def test_a_robot_pickles_to_the_last_bit(robot: tp.Robot, scara: tp.Robot) -> None:
    for one in (robot, scara):
        again = pickle.loads(pickle.dumps(one))
        assert again == one and hash(again) == hash(one)
        np.testing.assert_array_equal(again.fk(one.spread(9)), one.fk(one.spread(9)))


def test_a_urdf_is_read_between_two_links(tmp_path: Path) -> None:
    urdf = tmp_path / "arm.urdf"
    link = "".join(f'<link name="l{k}"/>' for k in range(3))
    joint = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>'
        f'<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        for k in (1, 2)
    )
    urdf.write_text(f'<robot name="arm">{link}{joint}</robot>')
    assert tp.Robot.from_urdf(urdf).dof == 2
    assert tp.Robot.from_urdf(urdf, tip="l1").dof == 1
    with pytest.raises(tp.InputError, match="l7"):
        tp.Robot.from_urdf(urdf, tip="l7")


def test_units_and_conventions_of_a_table() -> None:
    si = tp.Robot.from_dh([{"a": 0.4, "alpha": np.pi / 2}, {"a": 0.3}])
    mm = tp.Robot.from_dh([{"a": 400, "alpha": 90}, {"a": 300}], length="mm", angle="deg")
    q = [[0.1, 0.2]]
    np.testing.assert_allclose(si.fk(q), mm.fk(q), atol=1e-12)
    craig = tp.Robot.from_dh([{}, {"a": 0.4, "alpha": np.pi / 2}], modified=True, tool={"xyz": [0.3, 0, 0]})
    np.testing.assert_allclose(craig.fk(q), si.fk(q), atol=1e-12)
    found = tp.Robot.from_dh([{}, {}], base={"known": False}, targets={"P1": [1, 2, 3], "P2": None})
    assert [(t.name, t.known) for t in found.targets] == [("P1", True), ("P2", False)]


@pytest.mark.parametrize(
    ("joints", "words"),
    [([{"b": 1}], "unknown key `b`"), ([{"a": float("nan")}], "finite|nan"), ([{"type": "ball"}], "ball"), ([], "joint"), ([{"a": object()}], "value")],
)
def test_what_is_no_robot_is_refused(joints: list[dict[str, object]], words: str) -> None:
    with pytest.raises(tp.InputError, match=words):
        tp.Robot.from_dh(joints)


def test_files_that_are_no_robot(tmp_path: Path) -> None:
    with pytest.raises(tp.InputError, match="no such file"):
        tp.Robot.from_toml(tmp_path / "none.toml")
    bad = tmp_path / "bad.toml"
    bad.write_text('name = "x"\n[[joints]]\nname = 3\n')
    with pytest.raises(tp.InputError) as raised:
        tp.Robot.from_toml(bad)
    assert raised.value.row == 3


@pytest.mark.parametrize("q", [[[1.0, 2.0]], [[0, 0, 0, "a"]], np.zeros((2, 2, 2)), np.zeros((3, 5)), [[np.nan, 0, 0, 0]], "text", None, object()])
def test_joint_values_of_another_shape(scara: tp.Robot, q: object) -> None:
    with pytest.raises((tp.InputError, ValueError, TypeError)):
        scara.fk(q)  # type: ignore[arg-type]
