"""Least squares, covariance and relations of ten ill-conditioned problems, in 60 digits by mpmath.

    python make.py > digits.txt

The data follow from sums, products and quotients of whole numbers that `precision.rs` repeats: every step is rounded as IEEE 754 says, so
that both programs have the same bits; what is solved here is the problem with those bits. Each problem has a further column that depends
on the others; relations say how, with 1 at that column.
"""

import mpmath as mp

mp.mp.dps = 60


def hilbert(m, n):
    return [[1.0 / (i + j + 1) for j in range(n)] for i in range(m)]


def powers(m, n):
    rows = []
    for i in range(m):
        t, row = i / 64.0, [1.0]
        for _ in range(n - 1):
            row.append(row[-1] * t)
        rows.append(row)
    return rows


def laeuchli(n, step):
    return [[1.0] * n] + [[step if i == j else 0.0 for j in range(n)] for i in range(n)]


def alike(m, n, apart):
    """The last column is the first but for a trifle."""
    rows = [[float((7 * i * i + 3 * (j + 1) * i + 5 * j * j) % 23 - 11) for j in range(n)] for i in range(m)]
    for i, row in enumerate(rows):
        row[n - 1] = row[0] + apart * float((5 * i + 3) % 13 - 6)
    return rows


def graded(m, n):
    """Columns of very different sizes that are nearly of one direction."""
    rows = alike(m, n, 2.0**-12)
    size = 1.0
    for j in range(n):
        for row in rows:
            row[j] *= size
        size /= 4096.0
    return rows


PROBLEMS = [
    ("hilbert_4", hilbert(10, 4)),
    ("hilbert_6", hilbert(12, 6)),
    ("hilbert_8", hilbert(14, 8)),
    ("powers_6", powers(41, 6)),
    ("powers_9", powers(65, 9)),
    ("laeuchli_2e-13", laeuchli(5, 2.0**-13)),
    ("laeuchli_2e-24", laeuchli(5, 2.0**-24)),
    ("alike_2e-20", alike(30, 6, 2.0**-20)),
    ("alike_2e-32", alike(30, 6, 2.0**-32)),
    ("graded", graded(30, 6)),
]


def solved(a, y):
    """A⁺ y by the normal equations, which have digits enough."""
    return mp.lu_solve(a.T * a, a.T * y)


def show(name, what, values):
    print(name, what, *(mp.nstr(mp.mpf(v), 20) for v in values))


for name, rows in PROBLEMS:
    m, n = len(rows), len(rows[0])
    a = mp.matrix(rows)
    y = []
    for row in rows:
        total = 0.0
        for j in range(n):
            total = total + row[j] * float(j % 3 + 1)
        y.append(total)
    unit = a.copy()
    for j in range(n):
        size = mp.norm(a[:, j])
        for i in range(m):
            unit[i, j] /= size
    values = mp.svd_r(unit, compute_uv=False)
    show(name, "condition", [values[0] / values[n - 1]])
    show(name, "solution", solved(a, mp.matrix(y)))
    inverse = (a.T * a) ** -1
    show(name, "covariance", [inverse[i, j] for i in range(n) for j in range(n)])
    # A further column, first + 2 second − third (of one size each), as it is rounded.
    grade = 4096.0 if name == "graded" else 1.0
    more = mp.matrix([row[0] + 2.0 * grade * row[1] - grade * grade * row[2] for row in rows])
    show(name, "relation", [-v for v in solved(a, more)])
