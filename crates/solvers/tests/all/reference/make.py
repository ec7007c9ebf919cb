"""Digits that the tests compare with, from numpy, scipy and mpmath.

    python make.py > digits.txt

The data follow from formulas that the Rust test repeats; nothing is shared but the formulas. The nonlinear fit is solved
by MINPACK (scipy) and then polished by Newton's method in 40 digits (mpmath), the Huber fit by Newton's method in mpmath.
"""

import mpmath as mp
import numpy as np
from scipy.optimize import least_squares, lsq_linear

mp.mp.dps = 40


def design(m, p):
    i, j = np.meshgrid(np.arange(m), np.arange(p), indexing="ij")
    return np.sin(0.7 * (i + 1) * (j + 1) + 0.3 * j) + 0.2 * np.cos(0.11 * i)


def observed(m):
    i = np.arange(m)
    return 2.0 * np.sin(0.37 * i) + 0.5 * np.cos(1.9 * i) + 0.3


def show(name, values):
    print(name, *(mp.nstr(mp.mpf(v), 17) for v in values))


# Weighted plain least squares.
a, y = design(80, 6), observed(80)
w = 1.0 + np.arange(80) % 7
root = np.sqrt(w)[:, None]
show("weighted", np.linalg.lstsq(root * a, root[:, 0] * y, rcond=None)[0])

# Shortest solution of a deficient problem with columns scaled by s.
b = a.copy()
b[:, 4] = 2.0 * b[:, 0] - b[:, 3]
s = np.array([1.0, 2.0, 0.5, 1.5, 3.0, 1.0])
show("shortest", s * np.linalg.lstsq(b * s, y, rcond=1e-10)[0])

# Ridge with prior sizes.
lam = 0.7
show("ridge", np.linalg.solve(a.T @ a + lam * np.diag(1 / s**2), a.T @ y))

# Bounds that bind.
low, high = np.full(6, -0.02), np.full(6, 0.03)
low[5] = -np.inf
show("bounded", lsq_linear(a, y, (low, high), method="bvls", tol=1e-15).x)

# Lasso by exhaustive signs: 3^6 candidates, in 40 digits.
def lasso(a, y, lam):
    import itertools

    A, Y = mp.matrix(a.tolist()), mp.matrix(y.tolist())
    n = a.shape[1]
    best = None
    for signs in itertools.product((-1, 0, 1), repeat=n):
        kept = [j for j in range(n) if signs[j]]
        x = mp.matrix(n, 1)
        if kept:
            sub = mp.matrix([[A[i, j] for j in kept] for i in range(A.rows)])
            rhs = sub.T * Y - lam * mp.matrix([signs[j] for j in kept])
            sol = mp.lu_solve(sub.T * sub, rhs)
            if any(sol[k] * signs[j] <= 0 for k, j in enumerate(kept)):
                continue
            for k, j in enumerate(kept):
                x[j] = sol[k]
        r = A * x - Y
        cost = mp.fdot(r, r) / 2 + lam * sum(abs(v) for v in x)
        if best is None or cost < best[0]:
            best = (cost, x)
    return list(best[1])


show("lasso", lasso(design(30, 6), observed(30), 1.0))

# Huber with threshold 0.8, Newton's method on the pieces.
def huber(a, y, delta):
    A, Y = mp.matrix(a.tolist()), mp.matrix(y.tolist())
    x = mp.matrix(np.linalg.lstsq(a, y, rcond=None)[0].tolist())
    for _ in range(200):
        r = A * x - Y
        inside = [i for i in range(A.rows) if abs(r[i]) <= delta]
        sub = mp.matrix([[A[i, j] for j in range(A.cols)] for i in inside])
        g = A.T * mp.matrix([max(-delta, min(delta, v)) for v in r])
        step = mp.lu_solve(sub.T * sub, g)
        x = x - step
        if mp.norm(step) < mp.mpf(10) ** -30:
            break
    else:
        raise SystemExit("Huber did not converge")
    return list(x)


show("huber", huber(a, y, mp.mpf("0.8")))


# A nonlinear fit of nine unknowns.
T = [mp.mpf(i) / 40 for i in range(400)]
TRUE = [0.3, 2.0, 0.4, 1.1, 2.7, 0.5, 1.6, 6.0, 0.8]


def model(x, t, lib):
    return (
        x[0]
        + x[1] * lib.exp(-x[2] * t)
        + x[3] * lib.sin(x[4] * t + x[5])
        + x[6] / (1 + ((t - x[7]) / x[8]) ** 2)
    )


tf = np.arange(400) / 40.0
yf = model(TRUE, tf, np) + 0.05 * np.sin(12.9898 * np.arange(400) ** 2) + 0.02 * np.cos(0.3 * np.arange(400))
start = [0.0, 1.0, 0.2, 1.0, 2.5, 0.0, 1.0, 5.5, 1.0]
fit = least_squares(lambda x: model(x, tf, np) - yf, start, method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
x = mp.matrix(fit.x.tolist())
for _ in range(30):
    rows, r = [], []
    for t, obs in zip(T, yf):
        u, v = t - x[7], x[8]
        d = 1 + (u / v) ** 2
        e, ph = mp.exp(-x[2] * t), x[4] * t + x[5]
        rows.append(
            [1, e, -x[1] * t * e, mp.sin(ph), x[3] * t * mp.cos(ph), x[3] * mp.cos(ph), 1 / d]
            + [2 * x[6] * u / v**2 / d**2, 2 * x[6] * u**2 / v**3 / d**2]
        )
        r.append(model(list(x), t, mp) - mp.mpf(float(obs)))
    J, R = mp.matrix(rows), mp.matrix(r)
    step = mp.lu_solve(J.T * J, J.T * R)
    x = x - step
    if mp.norm(step) < mp.mpf(10) ** -30:
        break
show("nonlinear", list(x))
show("nonlinear_norm", [mp.norm(R)])
