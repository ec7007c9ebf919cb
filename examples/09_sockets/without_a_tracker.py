"""Measures the simulated robots of examples 09, 10 and 11. Its kinematics and its solver share nothing with truepose.

python3 examples/09_sockets/without_a_tracker.py     # writes robot.toml and measurements.csv of the three, the same each time
"""

import math
import random
from pathlib import Path

HERE = Path(__file__).parent.parent


def product(a, b):
    return [[sum(x * y for x, y in zip(row, column)) for column in zip(*b)] for row in a]


def times(a, v):
    return [sum(x * y for x, y in zip(row, v)) for row in a]


def transposed(a):
    return [list(row) for row in zip(*a)]


def rpy(roll, pitch, yaw):
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(t), math.sin(t)) for t in (roll, pitch, yaw))
    return [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]


def solved(a, b):
    """a x = b by elimination with pivots."""
    n = len(b)
    m = [row[:] + [value] for row, value in zip(a, b)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(m[k][i]))
        m[i], m[pivot] = m[pivot], m[i]
        for k in range(n):
            if k != i:
                factor = m[k][i] / m[i][i]
                m[k] = [x - factor * y for x, y in zip(m[k], m[i])]
    return [m[i][n] / m[i][i] for i in range(n)]


class Arm:
    """Joints that turn about z of their frames: (xyz, rpy) each, with an error of either, and what the gears do."""

    def __init__(self, joints, tool, rng, errors=(0.0, 0.0), base=(0.0, 0.0, 0.0), gear=None):
        one = lambda: [rng.uniform(-errors[0], errors[0]) for _ in range(3)] + [rng.uniform(-errors[1], errors[1]) for _ in range(3)]
        self.joints, self.tool, self.base, self.gear = joints, tool, base, gear
        self.errors = [one() for _ in joints]

    def pose(self, q):
        r, p = rpy(0, 0, 0), list(self.base)
        for k, ((xyz, turn), error, angle) in enumerate(zip(self.joints, self.errors, q)):
            step = times(r, [a + e for a, e in zip(xyz, error)])
            p = [a + b for a, b in zip(p, step)]
            r = product(r, rpy(*(a + e for a, e in zip(turn, error[3:]))))
            if self.gear and self.gear[0] == k:
                angle += self.gear[1] * math.sin(2 * math.pi * angle / self.gear[2] + 0.7)
            r = product(r, rpy(0, 0, angle))
        return r, [a + b for a, b in zip(p, times(r, self.tool))]

    def reached(self, goal, turn, rng, limits):
        """Joints with which the tool is at `goal`, and, unless `turn` is None, turned like that: Newton's method from anywhere."""

        def off(q):
            r, p = self.pose(q)
            error = [g - x for g, x in zip(goal, p)]
            if turn is not None:
                d = product(turn, transposed(r))
                # The tangent of half the angle along its axis, which no other turn has.
                half = 1.0 + d[0][0] + d[1][1] + d[2][2]
                error += [v / max(half, 1e-6) for v in (d[2][1] - d[1][2], d[0][2] - d[2][0], d[1][0] - d[0][1])]
            return error

        while True:
            q = [rng.uniform(*limit) for limit in limits]
            for _ in range(60):
                error = off(q)
                if max(map(abs, error)) < 1e-10:
                    break
                columns = []
                for k in range(len(q)):
                    moved = q[:]
                    moved[k] += 1e-6
                    columns.append([(a - b) / 1e-6 for a, b in zip(error, off(moved))])
                square = [[sum(c[i] * c[j] for c in columns) + (1e-9 if i == j else 0) for j in range(len(error))] for i in range(len(error))]
                x = solved(square, error)
                step = [sum(c[i] * x[i] for i in range(len(x))) for c in columns]
                most = max(map(abs, step))
                q = [a + b * min(1.0, 0.3 / max(most, 1e-12)) for a, b in zip(q, step)]
            if max(map(abs, off(q))) < 1e-9 and all(low <= a <= high for a, (low, high) in zip(q, limits)):
                return q


def described(name, arms, limits, more):
    """A robot file of arms: (prefix of the joints, arm)."""
    text = f'name = "{name}"\ngravity = [0, 0, -9.81]\n\n[units]\nlength = "mm"\nangle = "deg"\n'
    for prefix, arm in arms:
        if len(arms) > 1:
            # A joint that does not turn: where the arm stands has errors of its own.
            at = [round(1e3 * a, 6) for a in arm.base]
            text += f'\n[[joints]]\nname = "{prefix}_mount"\ntype = "fixed"\nparent = "base"\norigin = {{ xyz = {at}, rpy = [0, 0, 0], axis = [0, 0, 1] }}\n'
        for k, ((xyz, turn), limit) in enumerate(zip(arm.joints, limits), 1):
            xyz = [round(1e3 * a, 6) for a in xyz]
            turn = [round(math.degrees(t), 6) for t in turn]
            ends = [round(math.degrees(t), 3) for t in limit]
            text += f'\n[[joints]]\nname = "{prefix}{k}"\ntype = "revolute"\nlimits = {ends}\n'
            text += f"origin = {{ xyz = {xyz}, rpy = {turn}, axis = [0, 0, 1] }}\n"
    return text + more


def written(folder, robot, header, rows):
    (HERE / folder / "robot.toml").write_text(robot)
    (HERE / folder / "measurements.csv").write_text("\n".join([header, *rows]) + "\n")


def degrees(q):
    return ",".join(f"{math.degrees(a):.6f}" for a in q)


QUARTER = math.pi / 2
SEVEN = [
    ((0, 0, 0.333), (0, 0, 0)),
    ((0, 0, 0), (-QUARTER, 0, 0)),
    ((0, -0.316, 0), (QUARTER, 0, 0)),
    ((0.0825, 0, 0), (QUARTER, 0, 0)),
    ((-0.0825, 0.384, 0), (-QUARTER, 0, 0)),
    ((0, 0, 0), (QUARTER, 0, 0)),
    ((0.088, 0, 0), (QUARTER, 0, 0)),
]
SIX = [
    ((0, 0, 0.18), (0, 0, 0)),
    ((0, 0.14, 0), (-QUARTER, -QUARTER, 0)),
    ((0.61, 0, -0.12), (0, 0, 0)),
    ((0.57, 0, 0), (0, 0, -QUARTER)),
    ((0, 0, 0.115), (-QUARTER, 0, 0)),
    ((0, 0, 0.115), (QUARTER, 0, 0)),
]


def sockets(rng):
    """A light arm; a ball at its flange is put by hand into two sockets 50 mm apart, on a base that stands in six places."""
    limits = [(-2.6, 2.6), (-1.6, 1.6), (-2.6, 2.6), (-2.9, -0.2), (-2.6, 2.6), (0.2, 3.5), (-2.6, 2.6)]
    arm = Arm(SEVEN, (0.02, 0.0, 0.15), rng, (5e-4, 1.5e-3), gear=(1, 4e-4, math.radians(24)))
    rows, visit = [], 0
    for place, (x, y, z) in zip("ABCDEF", [(0.45, -0.3, 0.02), (0.6, 0.05, 0.02), (0.42, 0.33, 0.02), (0.5, -0.1, 0.35), (0.35, 0.25, 0.4), (0.62, 0.2, 0.15)]):
        turn = rng.uniform(-math.pi, math.pi)
        for _ in range(14):
            for side in (1, 2):
                at = [x, y, z] if side == 1 else [x + 0.05 * math.cos(turn), y + 0.05 * math.sin(turn), z]
                q = arm.reached([a + rng.gauss(0, 2e-5) for a in at], None, rng, limits)
                rows.append(f"same_point,{place}{side},{visit},{degrees(q)}")
                visit += 1
    pairs = "".join(f'\n[[distances]]\nbetween = ["{place}1", "{place}2"]\nvalue = 50\n' for place in "ABCDEF")
    robot = described("arm-7", [("j", arm)], limits, f"\n[tool]\nxyz = [20, 0, 150]\n{pairs}")
    written("09_sockets", robot, "kind,landmark,visit," + ",".join(f"j{k}[deg]" for k in range(1, 8)), rows)


def hand_eye(rng):
    """An arm with a camera on its flange looks at a board that lies somewhere."""
    limits = [(-3.1, 3.1)] * 6
    arm = Arm(SIX, (0.0, 0.0, 0.0), rng, (6e-4, 1e-3))
    mount = (rpy(0.03, -0.02, 0.6), [0.04, -0.05, 0.06])
    board = (rpy(0.02, -0.03, 0.4), [0.55, 0.1, 0.05])
    corners = [(f"c{k + 1}", [0.03 * (k % 4), 0.03 * (k // 4), 0.0]) for k in range(12)]
    middle = [a + b for a, b in zip(board[1], times(board[0], [0.045, 0.03, 0.0]))]
    rows, image = [], 0
    while image < 36:
        away, around, up = rng.uniform(0.3, 0.5), rng.uniform(-math.pi, math.pi), rng.uniform(0.6, 1.3)
        eye = [m + away * d for m, d in zip(middle, [math.cos(around) * math.cos(up), math.sin(around) * math.cos(up), math.sin(up)])]
        ahead = [(m - e) / away for m, e in zip(middle, eye)]
        turn = rng.uniform(-math.pi, math.pi)
        aside = [math.cos(turn), math.sin(turn), 0.0]
        down = [ahead[1] * aside[2] - ahead[2] * aside[1], ahead[2] * aside[0] - ahead[0] * aside[2], ahead[0] * aside[1] - ahead[1] * aside[0]]
        length = math.sqrt(sum(a * a for a in down))
        down = [a / length for a in down]
        right = [down[1] * ahead[2] - down[2] * ahead[1], down[2] * ahead[0] - down[0] * ahead[2], down[0] * ahead[1] - down[1] * ahead[0]]
        camera = transposed([right, down, ahead])
        flange = product(camera, transposed(mount[0]))
        q = arm.reached([e - a for e, a in zip(eye, times(flange, mount[1]))], flange, rng, limits)
        r, p = arm.pose(q)
        seen = product(r, mount[0])
        centre = [a + b for a, b in zip(p, times(r, mount[1]))]
        image += 1
        for name, corner in corners:
            at = [a + b for a, b in zip(board[1], times(board[0], corner))]
            x, y, z = times(transposed(seen), [a - b for a, b in zip(at, centre)])
            u, v = (900 * x / z + 640 + rng.gauss(0, 0.15), 900 * y / z + 480 + rng.gauss(0, 0.15))
            rows.append(f"pixel,eye,{name},{u:.3f},{v:.3f},{image},{degrees(q)}")
    camera = '\n[base]\nknown = false\n\n[[cameras]]\nname = "eye"\nmount = "tool"\nfx = 900\nfy = 900\ncx = 640\ncy = 480\n'
    points = "".join(f'\n[[landmarks]]\nname = "{name}"\nxyz = {[round(1e3 * c, 6) for c in corner]}\n' for name, corner in corners)
    robot = described("arm-6", [("j", arm)], limits, camera + points)
    written("10_hand_eye", robot, "kind,landmark,point,u[px],v[px],visit," + ",".join(f"j{k}[deg]" for k in range(1, 7)), rows)


def two_arms(rng):
    """Two arms on one table: a pin of one in a hole of the other, or a bar of 250 mm between them."""
    limits = [(-2.6, 2.6)] * 6
    tool = (0.0, 0.02, 0.12)
    left = Arm(SIX, tool, rng, (5e-4, 1e-3), base=(-0.45, 0, 0))
    right = Arm(SIX, tool, rng, (5e-4, 1e-3), base=(0.45, 0, 0))
    rows = []
    while len(rows) < 48:
        q = [rng.uniform(*limit) for limit in limits]
        _, p = left.pose(q)
        apart = 0.25 if len(rows) % 4 == 3 else 0.0
        way = [rng.gauss(0, 1) for _ in range(3)]
        length = math.sqrt(sum(a * a for a in way))
        goal = [a + apart * b / length + rng.gauss(0, 2e-5) for a, b in zip(p, way)]
        if goal[2] < 0.1 or math.dist(goal, (0.45, 0, 0.18)) > 1.1:
            continue
        other = right.reached(goal, None, rng, limits)
        rows.append(f"frames,right,left,{'' if apart == 0 else 1e3 * apart:},{len(rows)},{degrees(q)},{degrees(other)}")
    tools = "".join(f'\n[[tools]]\nname = "{side}"\njoint = "{side[0]}6"\nxyz = [0, 20, 120]\n' for side in ("left", "right"))
    robot = described("pair", [("l", left), ("r", right)], limits, tools)
    joints = [f"{side}{k}[deg]" for side in "lr" for k in range(1, 7)]
    written("11_two_arms", robot, "kind,landmark,tool,distance[mm],visit," + ",".join(joints), rows)


if __name__ == "__main__":
    sockets(random.Random(9))
    hand_eye(random.Random(10))
    two_arms(random.Random(11))
