#!/usr/bin/env python3
"""Recorded digits: tool poses and joint loads of three robots, by a third way.

Plain Python: 4×4 matrices as nested lists, every transform written out as its elementary factors; loads by
the torque of each weight about each axis, in the measurement frame. The numbers of the robots are typed in from
their descriptions, not read from the workspace. `digits.rs` holds the model and the plant against the output:

    python3 digits.py > digits.json
"""

import json
from math import cos, pi, sin, sqrt


def mul(*matrices):
    product = [[float(i == j) for j in range(4)] for i in range(4)]
    for m in matrices:
        product = [[sum(product[i][k] * m[k][j] for k in range(4)) for j in range(4)] for i in range(4)]
    return product


def about(axis, angle):
    """Rotation about any axis, by Rodrigues' formula."""
    n = sqrt(sum(v * v for v in axis))
    x, y, z = (v / n for v in axis)
    c, s = cos(angle), sin(angle)
    d = 1 - c
    return [
        [c + x * x * d, x * y * d - z * s, x * z * d + y * s, 0.0],
        [y * x * d + z * s, c + y * y * d, y * z * d - x * s, 0.0],
        [z * x * d - y * s, z * y * d + x * s, c + z * z * d, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]


def shift(x, y, z):
    return [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]


X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)


def xyz_rpy(xyz, rpy):
    return mul(shift(*xyz), about(Z, rpy[2]), about(Y, rpy[1]), about(X, rpy[0]))


def point(m, p):
    return [sum(m[i][k] * p[k] for k in range(3)) + m[i][3] for i in range(3)]


def direction(m, v):
    return [sum(m[i][k] * v[k] for k in range(3)) for i in range(3)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def dh(theta, d, a, alpha, q, kind):
    turn, slide = (q, 0.0) if kind == "r" else (0.0, q)
    return mul(about(Z, theta + turn), shift(0, 0, d + slide), shift(a, 0, 0), about(X, alpha))


def mdh(alpha, a, theta, d, q, kind):
    turn, slide = (q, 0.0) if kind == "r" else (0.0, q)
    return mul(about(X, alpha), shift(a, 0, 0), about(Z, theta + turn), shift(0, 0, d + slide))


def origin(xyz, rpy, axis, q, kind):
    n = sqrt(dot(axis, axis))
    motion = {"r": about(axis, q), "p": shift(*(v / n * q for v in axis)), "f": shift(0, 0, 0)}[kind]
    return mul(xyz_rpy(xyz, rpy), motion)


def solve(base, joints, tool, gravity, payload):
    """joints: (before_axis, axis, kind, whole, link) at their values; the axis is seen behind `before_axis`."""
    at, axes, weights = base, [], []
    for before, axis, kind, whole, link in joints:
        here = mul(at, before)
        axes.append((direction(here, axis), point(here, (0, 0, 0)), kind))
        at = mul(at, whole)
        if link:
            weights.append((len(axes), point(at, link[1]), [link[0] * g for g in gravity]))
    at = mul(at, tool)
    weights.append((len(axes), point(at, payload[1]), [payload[0] * g for g in gravity]))
    loads = []
    for index, (axis, through, kind) in enumerate(axes, 1):
        total = 0.0
        for carrier, where, force in weights:
            if carrier >= index:
                arm = [w - t for w, t in zip(where, through)]
                total += dot(axis, force) if kind == "p" else dot(axis, cross(arm, force))
        if kind != "f":
            loads.append(total)
    return {"rotation": [row[:3] for row in at[:3]], "position": [row[3] for row in at[:3]], "loads": loads}


def ur10(q):
    rows = [(0.1273, 0.0, pi / 2), (0.0, -0.612, 0.0), (0.0, -0.5723, 0.0),
            (0.163941, 0.0, pi / 2), (0.1157, 0.0, -pi / 2), (0.0922, 0.0, 0.0)]
    joints = [(shift(0, 0, 0), Z, "r", dh(0.0, d, a, alpha, v, "r"), None) for (d, a, alpha), v in zip(rows, q)]
    return solve(shift(0, 0, 0), joints, shift(0, 0, 0), (0, 0, -9.81), (7.5, (0.02, -0.03, 0.12)))


def heavy(q):
    rows = [(0.0, 0.0, 0.0, 0.65, 380.0, [0.1, 0.02, -0.14]),
            (-pi / 2, 0.32, 0.0, 0.0, 260.0, [0.5, -0.03, 0.05]),
            (0.0, 1.1, -pi / 2, 0.0, 190.0, [0.02, 0.16, -0.04]),
            (-pi / 2, -0.05, 0.0, 1.15, 70.0, [0.0, 0.01, -0.33]),
            (pi / 2, 0.0, 0.0, 0.0, 40.0, [0.0, -0.05, 0.01]),
            (-pi / 2, 0.0, 0.0, 0.21, 15.0, [0.0, 0.0, -0.03])]
    joints = [(mul(about(X, al), shift(a, 0, 0)), Z, "r", mdh(al, a, th, d, v, "r"), (m, c))
              for (al, a, th, d, m, c), v in zip(rows, q)]
    base = xyz_rpy((1.4, 0.3, 0.5), (0.0, 0.1, 0.5))
    return solve(base, joints, shift(0.05, 0.0, 0.25), (0, 0, -9.81), (90.0, (0.1, -0.05, 0.3)))


def skewed(q):
    def place(xyz, rpy, axis, kind, v, link):
        return (xyz_rpy(xyz, rpy), [c / sqrt(dot(axis, axis)) for c in axis], kind,
                origin(xyz, rpy, axis, v, kind), link)

    joints = [
        place([0.1, 0.2, 0.3], [0.1, -0.2, 0.3], [0.0, 0.0, -1.0], "r", q[0], (5.0, [0.1, 0.2, 0.0])),
        place([0.0, 0.1, 0.2], [0.4, 0.0, 0.0], [0.0, 0.0, 1.0], "f", 0.0, (1.0, [0.0, 0.0, 0.1])),
        place([0.2, 0.0, 0.1], [0.0, 0.5, 0.2], [1.0, -2.0, 0.5], "p", q[1], (3.0, [0.0, 0.1, 0.0])),
        place([0.0, -0.2, 0.4], [0.3, 0.2, 0.1], [1.0, 1.0, 1.0], "r", q[2], (2.0, [0.05, 0.0, 0.2])),
        (shift(0, 0, 0), Z, "p", dh(0.3, 0.1, 0.2, -1.1, q[3], "p"), None),
        (shift(0, 0, 0), Z, "r", dh(-0.4, 0.2, 0.1, 0.7, q[4], "r"), (1.5, [0.0, 0.0, 0.1])),
    ]
    tool = xyz_rpy([0.1, 0.05, 0.2], [0.2, -0.3, 0.4])
    return solve(shift(0, 0, 0), joints, tool, (0.5, -1.0, -9.7), (4.0, (0.1, 0.0, -0.05)))


if __name__ == "__main__":
    postures = {
        "ur10": [[0.3, -1.2, 0.9, -0.4, 1.3, 0.2], [-2.5, 0.7, -1.9, 2.2, -0.8, 3.0]],
        "heavy": [[0.4, -0.7, 0.5, 1.1, -0.6, 0.3], [-1.5, 0.2, -1.1, -0.9, 1.4, -1.7]],
        "skewed": [[0.6, 0.25, -0.8, 0.15, 1.2], [-1.4, -0.1, 2.3, 0.3, -0.5]],
    }
    robots = {"ur10": ur10, "heavy": heavy, "skewed": skewed}
    records = [{"robot": name, "joints": q, **robots[name](q)} for name, all_q in postures.items() for q in all_q]
    print(json.dumps(records, indent=1))
