"""Peers of the uses of error Jacobians, for which the peers' script has none: the strongest that numpy and numba were found to give.

`register(B)` adds them to the script's table. Each reads w5.csv; none keeps more than a chunk of Jacobians, where Jacobians are not the answer.
"""


def register(B):
    import numpy as np

    CHUNK = 2048
    known = {}

    def chunks(count):
        return [slice(i, min(i + CHUNK, count)) for i in range(0, count, CHUNK)]

    def rows(d):
        if "Qr" not in d:
            d["Qr"] = np.ascontiguousarray(d["Q"].T)
        return d["Qr"]

    def covariance():
        i, k = np.mgrid[0:36, 0:36]
        same, moves, moves_too = (i // 6 == k // 6) & (i % 3 == k % 3), i % 6 < 3, k % 6 < 3
        size = np.where(moves & moves_too, 1e-8 * (1 + i // 6), np.where(~moves & ~moves_too, 1e-6, 3e-8))
        # Their rotations of a frame are about its y, z and x.
        order = np.arange(36).reshape(6, 6)[:, [0, 1, 2, 4, 5, 3]].ravel()
        return np.where(same, size, 0.0)[np.ix_(order, order)]

    def compiled(d):
        """Kernels of the arm: axes and levers packed, sums of products by loops."""
        if known:
            return known
        import numba as nb

        rb = d["rb"]
        RO = np.array([o[0] for o in rb.O]).astype(float)
        PO = np.array([o[1] for o in rb.O])
        tp = np.array(rb.toolp)

        @nb.njit(fastmath=True, error_model="numpy", inline="always")
        def frames(q, Rs, Ps, p):
            R = np.eye(3)
            p[:] = 0.0
            for i in range(6):
                for a in range(3):
                    p[a] += R[a, 0] * PO[i, 0] + R[a, 1] * PO[i, 1] + R[a, 2] * PO[i, 2]
                c, s = np.cos(q[i]), np.sin(q[i])
                for a in range(3):
                    x = R[a, 0] * RO[i, 0, 0] + R[a, 1] * RO[i, 1, 0] + R[a, 2] * RO[i, 2, 0]
                    y = R[a, 0] * RO[i, 0, 1] + R[a, 1] * RO[i, 1, 1] + R[a, 2] * RO[i, 2, 1]
                    z = R[a, 0] * RO[i, 0, 2] + R[a, 1] * RO[i, 1, 2] + R[a, 2] * RO[i, 2, 2]
                    R[a, 0] = x * c + y * s
                    R[a, 1] = y * c - x * s
                    R[a, 2] = z
                for a in range(3):
                    Ps[i, a] = p[a]
                    for b in range(3):
                        Rs[i, a, b] = R[a, b]
            for a in range(3):
                p[a] += R[a, 0] * tp[0] + R[a, 1] * tp[1] + R[a, 2] * tp[2]

        @nb.njit(fastmath=True, error_model="numpy")
        def packed(Q, out):
            Rs, Ps, p = np.empty((6, 3, 3)), np.empty((6, 3)), np.empty(3)
            for s in range(Q.shape[0]):
                frames(Q[s], Rs, Ps, p)
                for i in range(6):
                    d0, d1, d2 = p[0] - Ps[i, 0], p[1] - Ps[i, 1], p[2] - Ps[i, 2]
                    for k in range(3):
                        a0, a1, a2 = Rs[i, 0, k], Rs[i, 1, k], Rs[i, 2, k]
                        out[s, i, k, 0] = a0
                        out[s, i, k, 1] = a1
                        out[s, i, k, 2] = a2
                        out[s, i, 3 + k, 0] = a1 * d2 - a2 * d1
                        out[s, i, 3 + k, 1] = a2 * d0 - a0 * d2
                        out[s, i, 3 + k, 2] = a0 * d1 - a1 * d0

        @nb.njit(fastmath=True, error_model="numpy")
        def sums(Q):
            Rs, Ps, p = np.empty((6, 3, 3)), np.empty((6, 3)), np.empty(3)
            G, J = np.zeros((36, 36)), np.zeros((3, 36))
            for s in range(Q.shape[0]):
                frames(Q[s], Rs, Ps, p)
                for i in range(6):
                    d0, d1, d2 = p[0] - Ps[i, 0], p[1] - Ps[i, 1], p[2] - Ps[i, 2]
                    for k in range(3):
                        a0, a1, a2 = Rs[i, 0, k], Rs[i, 1, k], Rs[i, 2, k]
                        for a in range(3):
                            J[a, 6 * i + k] = Rs[i, a, k]
                        J[0, 6 * i + 3 + k] = a1 * d2 - a2 * d1
                        J[1, 6 * i + 3 + k] = a2 * d0 - a0 * d2
                        J[2, 6 * i + 3 + k] = a0 * d1 - a1 * d0
                for a in range(36):
                    x, y, z = J[0, a], J[1, a], J[2, a]
                    for b in range(36):
                        G[a, b] += x * J[0, b] + y * J[1, b] + z * J[2, b]
            # The products of the rotations are those of the axes.
            for i in range(6):
                for j in range(6):
                    for k in range(3):
                        for l in range(3):
                            G[6 * i + 3 + k, 6 * j + 3 + l] += G[6 * i + k, 6 * j + l]
            return G

        known.update(packed=packed, sums=sums)
        return known

    def answered(value):
        return dict(x=np.zeros(1), rms=float("nan"), checksum=float(value)), None

    def jacobians(d):
        """Whole Jacobians of a chunk, by numba, into a buffer that stays in the cache."""
        whole, Q = B.nb_arm(d), rows(d)
        buffer = np.empty((CHUNK, 6, 36))
        for s in chunks(len(Q)):
            part = buffer[: s.stop - s.start]
            whole(Q[s], part)
            yield s, part.reshape(-1, 36)

    def gram_blas(d, phases):
        G = np.zeros((36, 36))
        for _, J in jacobians(d):
            G += J.T @ J
        return answered(np.abs(G).sum())

    def gram_loops(d, phases):
        return answered(np.abs(compiled(d)["sums"](rows(d))).sum())

    def gram_numpy(d, phases):
        G, buffer = np.zeros((36, 36)), np.zeros((36, 6, CHUNK))
        for s in chunks(d["Q"].shape[1]):
            part = buffer if s.stop - s.start == CHUNK else np.zeros((36, 6, s.stop - s.start))
            B.M.error_jacobian(d["rb"], d["Q"][:, s], out=part)
            J = part.reshape(36, -1)
            G += J @ J.T
        return answered(np.abs(G).sum())

    def variances_blas(d, phases):
        L = np.linalg.cholesky(covariance())
        out = np.empty((d["Q"].shape[1], 6))
        for s, J in jacobians(d):
            half = J @ L
            out[s] = np.einsum("ik,ik->i", half, half).reshape(-1, 6)
        return answered(out.sum())

    def packed(d, phases):
        if "packed" not in d:
            d["packed"] = np.zeros((d["Q"].shape[1], 6, 6, 3))
        compiled(d)["packed"](rows(d), d["packed"])
        return dict(x=np.zeros(1), rms=float("nan")), lambda: dict(checksum=float(sum(np.abs(part).sum() for part in np.array_split(d["packed"], 64))))

    load = B.load_arm("w5.csv")
    for workload, name, run in (
        ("J-gram", "numba-blas", gram_blas),
        ("J-gram", "numba-loops", gram_loops),
        ("J-gram", "numpy", gram_numpy),
        ("J-variances", "numba-blas", variances_blas),
        ("J-packed", "numba", packed),
    ):
        B.PEERS[(workload, name)] = (run, load, name)
