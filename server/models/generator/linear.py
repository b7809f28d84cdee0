"""Bounded damped least squares (Levenberg-Marquardt) for a few dozen unknowns."""

import math


def solve_symmetric(A, b):
    """x of A x = b by Cholesky; A is positive definite."""
    n = len(b)
    L = [[0.0] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            s = A[i][j] - sum(x * y for x, y in zip(L[i][:j], L[j][:j]))
            L[i][j] = math.sqrt(max(s, 1e-18)) if i == j else s / L[j][j]
    y = []
    for i in range(n):
        y.append((b[i] - sum(l * t for l, t in zip(L[i], y))) / L[i][i])
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (y[i] - sum(L[k][i] * x[k] for k in range(i + 1, n))) / L[i][i]
    return x


def jacobian_columns(residuals, x, base, step=1e-5):
    """The Jacobian by forward differences. Rows of hinge terms that rest at zero are left out of
    all columns, and of `base`: they add nothing, and most are such."""
    columns = []
    for k in range(len(x)):
        moved = list(x)
        moved[k] += step
        columns.append([(r - s) / step for r, s in zip(residuals(moved), base)])
    active = [n for n, row in enumerate(zip(base, *columns)) if any(row)]
    base[:] = [base[n] for n in active]
    return [[column[n] for n in active] for column in columns]


def minimise(residuals, x, lower, upper, iterations):
    """The x within its bounds where the squares of `residuals(x)` sum up to least."""
    damping = 1e-2
    r = residuals(x)
    cost = sum(e * e for e in r)
    for _ in range(iterations):
        columns = jacobian_columns(residuals, x, r)
        slope = [sum(a * b for a, b in zip(c, r)) for c in columns]
        free = [k for k in range(len(x))
                if not (x[k] <= lower[k] and slope[k] > 0.0)
                and not (x[k] >= upper[k] and slope[k] < 0.0)]
        before = cost
        for _ in range(8):
            candidate = damped_step(x, columns, slope, free, damping, lower, upper)
            tried = residuals(candidate)
            tried_cost = sum(e * e for e in tried)
            if tried_cost < cost:
                x, r, cost = candidate, tried, tried_cost
                damping = max(damping * 0.3, 1e-7)
                break
            damping *= 4.0
        if before - cost < 1e-7 * before:
            break
    return x, cost


def damped_step(x, columns, slope, free, damping, lower, upper):
    A = [[sum(p * q for p, q in zip(columns[i], columns[j])) for j in free] for i in free]
    for n in range(len(free)):
        A[n][n] += damping * (A[n][n] + 1e-3)
    step = solve_symmetric(A, [-slope[k] for k in free])
    candidate = list(x)
    for k, d in zip(free, step):
        candidate[k] = min(upper[k], max(lower[k], x[k] + d))
    return candidate
