"""The same nonlinear calibration by another program: numpy and scipy, with a forward model of its own.

    python make.py        writes poses.csv and digits.csv beside this file

A 6R arm (the link dimensions of a UR10), 1 000 random poses, position and orientation of the tool. The arm that is measured
has errors in all 48 places; fitted are the 30 that the geometry can tell apart, the others stay zero. Both programs minimise

    sum (p_measured - p)^2 / s_p^2 + sum log(R_measured R^T)^2 / s_r^2

over them, s_p = 50 um and s_r = 100 urad. Jacobians here are by complex steps, exact to round-off; MINPACK finds the minimum and
Gauss-Newton steps by SVD polish it until nothing moves.
"""

import pathlib

import numpy as np
from scipy.optimize import least_squares

HERE = pathlib.Path(__file__).parent
D = [0.1273, 0.0, 0.0, 0.163941, 0.1157, 0.0922]
A = [0.0, -0.612, -0.5723, 0.0, 0.0, 0.0]
ALPHA = [np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0]
TOOL = [0.05, 0.03, 0.1]
SD_P, SD_R = 5e-5, 1e-4
PLACES = ["base", "j1", "j2", "j3", "j4", "j5", "j6", "tool"]
WORDS = ["x", "y", "z", "rx", "ry", "rz"]


def turn(axis, angle):
    """Homogeneous rotation about a coordinate axis; angle may be an array of poses."""
    angle = np.asarray(angle)
    c, s = np.cos(angle), np.sin(angle)
    t = np.zeros(angle.shape + (4, 4), dtype=angle.dtype if angle.dtype == complex else float)
    t[..., 3, 3] = 1
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    t[..., axis, axis] = 1
    t[..., i, i], t[..., i, j], t[..., j, i], t[..., j, j] = c, -s, s, c
    return t


def shift(v):
    t = np.eye(4, dtype=np.asarray(v).dtype)
    t[:3, 3] = v
    return t


def error(e):
    """Rotations about Y, Z, X in that order, with the translation in front."""
    return shift(e[:3]) @ turn(1, e[4]) @ turn(2, e[5]) @ turn(0, e[3])


def forward(q, e):
    """Tool poses at q (n x 6) with errors e (8 x 6)."""
    t = error(e[0])
    for k in range(6):
        t = t @ turn(2, q[:, k]) @ shift(np.array([A[k], 0, D[k]])) @ turn(0, ALPHA[k]) @ error(e[k + 1])
    return t @ shift(np.array(TOOL)) @ error(e[7])


def from_vector(v):
    """Rotation matrices of rotation vectors, Rodrigues."""
    angle = np.linalg.norm(v, axis=1)[:, None, None]
    x, y, z = (v / angle[:, :, 0]).T
    o = np.zeros_like(x)
    k = np.stack([np.stack([o, -z, y], 1), np.stack([z, o, -x], 1), np.stack([-y, x, o], 1)], 1)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def to_vector(r):
    """Rotation vectors of rotation matrices, by the quaternion's largest part."""
    out = []
    for m in r:
        q = np.array([1 + m[0, 0] + m[1, 1] + m[2, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2],
                      1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2]])
        w = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]
        xy, xz, yz = m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1]
        rows = [[q[0], *w], [w[0], q[1], xy, xz], [w[1], xy, q[2], yz], [w[2], xz, yz, q[3]]]
        v = np.array(rows[int(np.argmax(q))])
        v = v / np.linalg.norm(v) * (1 if v[0] >= 0 else -1)
        out.append(2 * np.arctan2(np.linalg.norm(v[1:]), v[0]) * v[1:] / np.linalg.norm(v[1:]))
    return np.array(out)


def small_log(r):
    """Rotation vectors of rotations by less than a right angle; complex steps pass through."""
    v = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], 1) / 2
    s = np.sqrt((v * v).sum(1))[:, None]
    return v * np.arcsin(s) / s


def residual(x, kept, q, p, r):
    e = np.zeros((8, 6), dtype=x.dtype)
    for value, (place, word) in zip(x, kept):
        e[place, word] = value
    t = forward(q, e)
    off = (p - t[:, :3, 3]) / SD_P
    turned = small_log(r @ np.swapaxes(t[:, :3, :3], 1, 2)) / SD_R
    return np.concatenate([off, turned], 1).ravel()


def jacobian(x, *rest):
    columns = []
    for k in range(len(x)):
        z = x.astype(complex)
        z[k] += 1e-30j
        columns.append(residual(z, *rest).imag / 1e-30)
    return np.stack(columns, 1)


def main():
    kept = []
    for line in (HERE / "kept.csv").read_text().split():
        word, place = line.split("@")
        kept.append((PLACES.index(place), WORDS.index(word)))
    rng = np.random.default_rng(20240601)
    q = np.round(rng.uniform(-2.4, 2.4, (1000, 6)), 5)
    true = np.concatenate([rng.normal(0, 5e-4, (8, 3)), rng.normal(0, 5e-4, (8, 3))], 1)
    t = forward(q, true)
    p = np.round(t[:, :3, 3] + rng.normal(0, SD_P, (1000, 3)), 7)
    v = np.round(to_vector(from_vector(rng.normal(0, SD_R, (1000, 3))) @ t[:, :3, :3]), 7)
    with open(HERE / "poses.csv", "w") as f:
        f.write("j1,j2,j3,j4,j5,j6,x,y,z,rx,ry,rz\n")
        for row in np.concatenate([q, p, v], 1):
            f.write(",".join(f"{n:.5f}" if k < 6 else f"{n:.7f}" for k, n in enumerate(row)) + "\n")
    rest = (kept, q, p, from_vector(v))
    found = least_squares(residual, np.zeros(len(kept)), jac=jacobian, args=rest, method="lm", x_scale="jac",
                          xtol=1e-15, ftol=1e-15, gtol=1e-15)
    x = found.x
    for _ in range(6):
        j, r = jacobian(x, *rest), residual(x, *rest)
        norms = np.linalg.norm(j, axis=0)
        step = np.linalg.lstsq(j / norms, -r, rcond=None)[0] / norms
        x = x + step
    print("last step, in standard deviations:", np.abs(j @ step).max())
    with open(HERE / "digits.csv", "w") as f:
        f.write(f"chi_square,{(residual(x, *rest) ** 2).sum():.17g}\n")
        for value, (place, word) in zip(x, kept):
            f.write(f"{WORDS[word]}@{PLACES[place]},{value:.17g}\n")


main()
