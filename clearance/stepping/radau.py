"""Radau IIA with three and five stages: implicit, of order 5 and 9, stiffly accurate; simplified
Newton.

Follows Hairer and Wanner, Solving Ordinary Differential Equations II (1996), section IV.8, with two
changes that mechanics allows. The rates of the coordinates are themselves states, so the stages of
the coordinates follow from those of the rates exactly, and Newton only works on the rates: half the
unknowns. And the kernel's Jacobian is exact and as cheap as a few right-hand sides, so it is
renewed nearly every step. Starting values come from the last step's collocation polynomial. The
ledger (energy input and dissipated) does not feed back: it is integrated by the same collocation,
afterwards.

`radau5` and `radau9` are the steppers; a scheme's tables are compile-time constants of each.
"""

import math

from clearance.machine.numba_record import constant
from clearance.stepping import status
from clearance.stepping.linear import factor, rate_matrix, solve
from clearance.stepping.tableaus import Collocation
from clearance.stepping.types import inline

constant(Collocation)  # a scheme's tables are known where its stepper is compiled
ITERATIONS = 10
SAFETY = 0.9  # of the error tolerance
# correction that the stages may still need, over the error tolerance
SOLVED = 0.2
STIFF = 1e-3  # g over a pivot of g - J: from there on a rate is stiff

# rows of `matrix` after the stages, their derivatives, the transformed stages and the predictor
# polynomial
TRIAL, CORRECTION, WEIGHT, PIVOTS, LU = range(5)


@inline
def predict(k, run, m, h, y, n):
    """Stages of the rates from the last collocation polynomial, or zero; those of the coordinates
    follow.
    """
    stages, p = k.c.size, run.coordinates
    polynomial = 3 * stages
    ratio = h / run.last_h if run.has_predictor == 1 else 0.0
    for s in range(stages):
        x = 1.0 + ratio * k.c[s]
        for i in range(p, n):
            value = 0.0
            if ratio > 0.0:
                for r in range(stages - 1, -1, -1):
                    value = (value + m[polynomial + r, i]) * (x if r % 2 == 0 else 1.0 - x)
                value -= m[polynomial, i]
            m[s, i] = value
    follow(k, m, h, y, p)
    for s in range(stages):
        for i in range(p, n):
            total = 0.0
            for j in range(stages):
                total += k.ti[s, j] * m[j, i]
            m[2 * stages + s, i] = total


@inline
def follow(k, m, h, y, p):
    """Stages of the coordinates from those of their rates."""
    stages = k.c.size
    for s in range(stages):
        for i in range(p):
            total = k.c[s] * y[p + i]
            for j in range(stages):
                total += k.a[s, j] * m[j, p + i]
            m[s, i] = h * total


@inline
def factorise(k, run, vector, m, complexes, h, n):
    """LU of the Newton matrices of the rates, one real and one complex for each pair of
    eigenvalues.

    With q' = u and J the Jacobian, (g - J) (dq, du) = (0, r) is (g - J_u - J_q / g) du = r,
    dq = du / g.
    """
    p, real = run.coordinates, 4 * k.c.size + LU
    size = n - p
    rate_matrix(m[real : real + size], vector, k.real / h, p, n)
    factor(m[real : real + size], m[real - 1], size)
    for pair in range(k.pairs.size):
        first = pair * (size + 2)
        rate_matrix(complexes[first : first + size], vector, k.pairs[pair] / h, p, n)
        factor(complexes[first : first + size], complexes[first + size], size)
    run.factorisations += 1
    run.lu_state = 1


@inline
def correct_real(k, m, h, p, n):
    """One Newton correction of the real one of the transformed rates; its squared norm over
    tolerance.
    """
    stages = k.c.size
    size = n - p
    real = 4 * k.c.size + LU
    correction, weight = m[real - 3], m[real - 2]
    w, f, g = 2 * stages, stages, k.real / h
    for i in range(p, n):
        total = -g * m[w, i]
        for s in range(stages):
            total += k.ti[0, s] * m[f + s, i]
        correction[i - p] = total
    solve(m[real : real + size], m[real - 1], correction, size)
    norm = 0.0
    for i in range(size):
        m[w, p + i] += correction[i]
        weight_here = weight[p + i] ** 2 + ((weight[i] / g) ** 2 if i < p else 0.0)
        norm += weight_here * correction[i] ** 2
    return norm


@inline
def correct(k, m, complexes, h, p, n):
    """One Newton correction of the transformed rates; returns its squared norm over tolerance."""
    stages = k.c.size
    size = n - p
    weight = m[4 * k.c.size + WEIGHT]
    w, f = 2 * stages, stages
    norm = correct_real(k, m, h, p, n)
    for pair in range(k.pairs.size):
        first, row = pair * (size + 2), 1 + 2 * pair
        right = complexes[first + size + 1]
        z = k.pairs[pair] / h
        for i in range(p, n):
            a = b = 0.0
            for s in range(stages):
                a += k.ti[row, s] * m[f + s, i]
                b += k.ti[row + 1, s] * m[f + s, i]
            right[i - p] = complex(a, b) - z * complex(m[w + row, i], m[w + row + 1, i])
        solve(complexes[first : first + size], complexes[first + size], right, size)
        length = z.real * z.real + z.imag * z.imag
        for i in range(size):
            a, b = right[i].real, right[i].imag
            m[w + row, p + i] += a
            m[w + row + 1, p + i] += b
            weight_here = weight[p + i] ** 2 + (weight[i] ** 2 / length if i < p else 0.0)
            norm += weight_here * (a * a + b * b)
    return norm


@inline
def rates(k, run, t, h):
    """Rates at the stages, into the rows behind them; of several at once where the run can."""
    y, par, work, m, n = run.y, run.par, run.work, run.matrix, run.states
    stages, together = k.c.size, run.together
    if together.shape[0] == 0:
        trial = m[4 * stages + TRIAL]
        for i in range(n, y.size):
            trial[i] = y[i]
        for s in range(stages):
            for i in range(n):
                trial[i] = y[i] + m[s, i]
            run.rhs(t + k.c[s] * h, trial, par, work, m[stages + s])
        return
    for lane in range(k.moments):
        s = min(lane, stages - 1)
        together[0, lane] = t + k.c[s] * h
        for i in range(n):
            together[0, (1 + i) * k.moments + lane] = y[i] + m[s, i]
    run.moments(t, together[0], par, work, together[1])
    for s in range(stages):
        for i in range(y.size):
            m[stages + s, i] = together[1, i * k.moments + s]


@inline
def newton(k, run, t, h):
    """Simplified Newton on the transformed stages. 0 converged, 1 not, 2 not finite; and the rate
    of convergence.
    """
    y, m, n = run.y, run.matrix, run.states
    stages, p = k.c.size, run.coordinates
    tolerance = max(2e-15 / run.rtol, run.newton_tolerance)
    old = 0.0
    rate = 0.0
    factor_of_rate = max(run.convergence, 1e-16) ** 0.8
    for iteration in range(ITERATIONS):
        rates(k, run, t, h)
        run.evaluations += stages
        norm = math.sqrt(correct(k, m, run.complexes, h, p, n) / (stages * n))
        if not math.isfinite(norm):
            return status.NO_NUMBERS, 1.0
        if iteration > 0:
            rate = norm / old if old > 0.0 else 0.0
            predicted = norm
            for _ in range(ITERATIONS - 1 - iteration):
                predicted *= rate
            if rate >= 1.0 or predicted > tolerance * (1.0 - rate):
                return status.TOO_LONG, rate
            factor_of_rate = rate / (1.0 - rate)
        for s in range(stages):
            for i in range(p, n):
                total = 0.0
                for j in range(stages):
                    total += k.t[s, j] * m[2 * stages + j, i]
                m[s, i] = total
        follow(k, m, h, y, p)
        if norm == 0.0 or factor_of_rate * norm < tolerance:
            run.convergence = factor_of_rate
            run.newton_rate = rate
            run.effort = SAFETY * (2 * ITERATIONS + 1) / (2 * ITERATIONS + 1 + iteration)
            return status.MADE, rate
        old = norm
    return status.TOO_LONG, rate


@inline
def error_norm(k, run, t, h):
    """Error over tolerance; filtered a second time where the first answer would reject the step."""
    y, f, vector, m, n = run.y, run.f, run.jacobian_rows, run.matrix, run.states
    stages = k.c.size
    p = run.coordinates
    real = 4 * k.c.size + LU
    size = n - p
    correction = m[real - 3]
    trial = m[real - 4]
    weight = m[real - 2]
    g, norm = k.real / h, 0.0
    for attempt in range(2):
        for i in range(n):
            total = f[i] if attempt == 0 else m[stages, i]
            for s in range(stages):
                total += k.e[s] * m[s, i] / h
            trial[i] = total
        for i in range(size):
            total, row = trial[p + i], (p + i) * n
            for j in range(p):
                total += vector[row + j] * trial[j] / g
            correction[i] = total
        solve(m[real : real + size], m[real - 1], correction, size)
        total = 0.0
        for i in range(n):
            trial[i] = (trial[i] + correction[i]) / g if i < p else correction[i - p]
            total += (trial[i] * weight[i]) ** 2
        norm = math.sqrt(total / n)
        if attempt == 1 or norm < 1.0 or not math.isfinite(norm):
            break
        for i in range(n):
            trial[i] += y[i]
        for i in range(n, y.size):
            trial[i] = y[i]
        run.rhs(t, trial, run.par, run.work, m[stages])
        run.evaluations += 1
    return norm


@inline
def solved(k, run, t, h):
    """True where rates at the stages, which the ledger needs anyway, agree with the stages.

    An iteration that ends by the convergence of earlier steps has not seen them. Friction may turn
    round there within a narrow range of speeds, and neither it nor the error estimate shows that.
    """
    rates(k, run, t, h)
    run.evaluations += k.c.size
    n = run.states
    residual = correct_real(k, run.matrix, h, run.coordinates, n) / (k.c.size * n)
    return residual < SOLVED * SOLVED


@inline
def ledger(k, h, y, m, n):
    """Stages of the energy integrals from the powers at the converged stages."""
    stages = k.c.size
    for i in range(n, y.size):
        for s in range(stages):
            total = 0.0
            for j in range(stages):
                total += k.a[s, j] * m[stages + j, i]
            m[s, i] = h * total


@inline
def collocate(k, m, size):
    """Rows of the nested dense output through the stages: the predictor of the next step."""
    stages = k.c.size
    for i in range(size):
        for r in range(stages):
            total = 0.0
            for s in range(stages):
                total += k.basis[r, s] * m[s, i]
            m[3 * stages + r, i] = total


@inline
def slopes(k, h, f_new, m, size):
    """y' at the end of the step: that of the collocation polynomial, which is f(y_new) once Newton
    has converged.
    """
    stages = k.c.size
    for i in range(size):
        total = 0.0
        for s in range(stages):
            total += k.end[s] * m[s, i]
        f_new[i] = total / h


@inline
def advance(k, run, t, h):
    """One step from y with f = y' to y_new with f_new; error over tolerance in `run.error`. 0 if it
    worked.
    """
    y, par, work = run.y, run.par, run.work
    y_new, f_new, scale, vector = run.y_new, run.f_new, run.scale, run.jacobian_rows
    m, complexes = run.matrix, run.complexes
    size, n, stages = y.size, run.states, k.c.size
    weight = m[4 * stages + WEIGHT]
    for i in range(n):
        weight[i] = 1.0 / (run.rtol * (scale[i] + abs(y[i])))
    answer, rate = status.TOO_LONG, 1.0
    for _attempt in range(2):
        fresh = run.jacobian_state != 1
        if fresh:
            run.jacobian(t, y, par, work, vector)
            run.jacobians += 1
            run.jacobian_state, run.lu_state = 1, 0
        if run.lu_state != 1 or run.last_h != h:
            factorise(k, run, vector, m, complexes, h, n)
        predict(k, run, m, h, y, n)
        answer, rate = newton(k, run, t, h)
        if answer == status.MADE or fresh:
            break
        run.jacobian_state = 0
    if answer != status.MADE:
        # far ahead the last polynomial is worse than nearer
        if h <= run.last_h:
            run.has_predictor = 0
        run.lu_state, run.convergence = 0, 1.0
        return answer
    error = error_norm(k, run, t, h)
    run.error = error
    if error > 1.0 or not math.isfinite(error):
        run.lu_state = 0
        return status.MADE if math.isfinite(error) else status.NO_NUMBERS
    if size > n and run.evaluate_ledger > 0:
        if not solved(k, run, t, h):
            run.lu_state, run.convergence = 0, 1.0
            return status.TOO_LONG
        ledger(k, h, y, m, n)
    for i in range(size):
        y_new[i] = y[i] + m[stages - 1, i]
    collocate(k, m, size)
    slopes(k, h, f_new, m, size)
    run.has_predictor = 1
    run.last_h = h
    if rate > 1e-3:
        run.jacobian_state = 0
    for i in range(size):
        if not math.isfinite(y_new[i]) or not math.isfinite(f_new[i]):
            return status.NO_NUMBERS
    return status.MADE


@inline
def judge(k, run, h):
    """Have the dense output settled where a rate is so stiff that its error shows in forces."""
    first, run.gain = 4 * k.c.size + LU, k.real / h
    for i in range(run.states - run.coordinates):
        if abs(run.matrix[first + i, i]) * run.gain < STIFF:
            run.factors = first


@inline
def interpolate(k, y, dense, m):
    """Dense output of the step just made: its collocation polynomial."""
    stages = k.c.size
    for i in range(y.size):
        dense[0, i] = y[i]
        for r in range(stages):
            dense[1 + r, i] = m[3 * stages + r, i]
        for r in range(1 + stages, dense.shape[0]):
            dense[r, i] = 0.0
    return 0
