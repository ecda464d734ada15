"""Radau IIA with three stages on traced numbers: the method of stepping/radau.py, a lane for each
run.

Each step has a Jacobian of its own, of the state that the last step predicts at a share AHEAD of
the step. It is nearer to the stages than that of the step's begin, so Newton's method takes fewer
iterations and fails less often. Lanes iterate until enough of them are done.
"""

from operator import add, sub

from clearance.lanes.elimination import Complex, factor, solve
from clearance.lanes.probes import add_probes, met_inside
from clearance.lanes.rows import Piece, split
from clearance.lanes.steps import (
    ARRIVED,
    FINISH,
    ITERATE,
    PREPARE,
    Trial,
    conclude,
    proposed,
    start,
)
from clearance.lanes.watch import look
from clearance.mechanism.build import Mechanism
from clearance.stepping import control
from clearance.stepping.radau import ITERATIONS, SAFETY, STIFF
from clearance.stepping.state import SETTLED
from clearance.stepping.tableaus import RADAU5 as K

IMPLICIT = True
STAGES = 3
HELD = ("base", "polynomial", "real", "exchanges", "last_h")  # of a step, for places inside it
MOST_RATES = 16  # equations of a Newton iteration whose factors are written down
ORDER = 4  # of the error estimate's defect
NEXT = PREPARE  # phase of a step that begins
BLANK = {"effort": 0.9, "convergence": 1.0}
PAIR = complex(K.pairs[0])
NEWTON_TOLERANCE = 0.05  # error left by Newton's method, of the error tolerance
LARGER = 1.15  # factor of the estimate, with which metrics are as accurate as the ordinary way's
SPARED = 0.9  # `shortened` below which a step may be: after four in a row, the fifth is not
# of the place where contact sets in; share of a step that is its end; step over what ends there
HALVINGS, TANGENTS, NEAR, BEHIND = 6, 2, 0.01, 1.001
AHEAD = 0.8  # share of the step where the Jacobian is taken: fewest iterations over 0.3 to 1


def unfit(mechanism: Mechanism) -> str | None:
    """The reason why a mechanism does not suit this method in lanes."""
    if rubbing := sorted(mechanism.structure.forced):
        return f"friction of joint {rubbing[0]} turns round inside steps"
    rates = mechanism.size - mechanism.coordinates
    many = rates > MOST_RATES or "for column" in mechanism.structure.codes["jacobian"]
    return "its equations are too many" if many else None


def add_rows(rows, shape) -> None:
    """Rows that this method needs."""
    n, size = shape.states, shape.rates
    exchanges = size * (size - 1) // 2
    rows.add("solved factor old iteration last_h predictor convergence")
    rows.add("weight", count=n)
    rows.add("stages polynomial", count=STAGES * n)
    rows.add("transformed", count=STAGES * size)
    rows.add("powers", count=STAGES * shape.ledger)
    rows.add("real complex_real complex_imag", count=size * size)
    rows.add("exchanges complex_exchanges", count=exchanges)
    if shape.gradual:
        rows.add("begins", count=2 * len(shape.gradual))  # penetrations and rates of a step's begin
        rows.add("shortened")  # so that a step ends where contact sets in
    if shape.contacts:
        add_probes(rows, shape)
        rows.add("new slope", count=shape.size)
    rows.add("coupling", count=size * shape.coordinates)  # of the Jacobian: rates by coordinates


def followed(piece, shape, h, y: list, stages: list[list]) -> None:
    """Fill the stages of the coordinates in from those of their rates."""
    p = shape.coordinates
    for s in range(STAGES):
        for i in range(p):
            moved = piece.weighted(K.a[s], [stages[j][p + i] for j in range(STAGES)])
            stages[s][i] = h * (y[p + i] * K.c[s] + moved)


def moved(piece, shape, share) -> list:
    """Change of the states along the last step's polynomial, beyond its end by a share of it."""
    n, polynomial = shape.states, piece.all("polynomial")
    moved = piece.along(polynomial, 1.0 + share, n)
    return [*map(sub, moved, polynomial[:n])]


def matrices(piece, shape, h, jacobian: list[list]) -> tuple[list[list], list[list]]:
    """The Newton matrices of the rates, real and complex: g - J_u - J_q / g."""
    p, size = shape.coordinates, shape.rates
    inverse, below, over = 1.0 / h, h * (1.0 / K.real), 1.0 / PAIR
    real, pair = [], []
    for i in range(size):
        entries = jacobian[p + i]
        real.append([-entry for entry in entries[p:]])
        pair.append([Complex(value, 0.0) for value in real[i]])
        for j in range(p):
            moved = entries[j] * h
            real[i][j] = real[i][j] - entries[j] * below
            pair[i][j] = Complex(pair[i][j].real - moved * over.real, -moved * over.imag)
        real[i][i] = real[i][i] + inverse * K.real
        on = pair[i][i]
        pair[i][i] = Complex(on.real + inverse * PAIR.real, on.imag + inverse * PAIR.imag)
    return real, pair


def begin(rows, shape, entries) -> Piece:
    """The begin of a run, or of a phase of one."""
    piece = start(rows, shape, entries, ORDER, NEXT)
    if shape.spots:
        piece.set(begins=piece.call(entries.spots, piece["t"], piece.all("y")))
    if shape.contacts:
        piece.set(aimed=0.0, last_step=0.0, predictor=0.0)
    return piece


def prepare(rows, shape, entries) -> Piece:
    """Choose the step, factorise, predict the stages."""
    piece, n, p = Piece(rows, PREPARE), shape.states, shape.coordinates
    h, failed = proposed(piece, shape)
    t, y, rtol = piece["t"], piece.all("y"), piece["rtol"]
    scale = piece.all("scale")
    predicted = piece["predictor"] > 0.5
    ratio = piece.choose(predicted, h / piece.largest(piece["last_h"], 1e-300), 0.0)
    ahead = [
        a + piece.choose(predicted, b, 0.0)
        for a, b in zip(y, moved(piece, shape, ratio * AHEAD), strict=False)
    ]
    later = t + piece.choose(predicted, h * AHEAD, 0.0)
    jacobian = split(piece.call(entries.jacobian, later, [*ahead, *y[n:]]), n)
    real, pair = matrices(piece, shape, h, jacobian)
    lu, exchanges = factor(piece, real)
    complex_lu, complex_exchanges = factor(piece, pair)
    stages = [[0.0] * n for _ in range(STAGES)]
    for s in range(STAGES):
        values = moved(piece, shape, ratio * K.c[s])
        stages[s][p:] = [piece.choose(predicted, v, 0.0) for v in values[p:]]
    followed(piece, shape, h, y, stages)
    transformed = [
        piece.weighted(K.ti[s], [stages[j][i] for j in range(STAGES)])
        for s in range(STAGES)
        for i in range(p, n)
    ]
    convergence = piece.largest(piece["convergence"], 1e-16)
    piece.set(
        h=h,
        status=failed,
        weight=[1.0 / (rtol * (s + abs(v))) for s, v in zip(scale, y, strict=False)],
        coupling=[jacobian[p + i][j] for i in range(shape.rates) for j in range(p)],
        diagonal=[abs(jacobian[p + f + k][p + f + k]) for f, _ in shape.films for k in range(2)],
        real=[v for row in lu for v in row],
        complex_real=[v.real for row in complex_lu for v in row],
        complex_imag=[v.imag for row in complex_lu for v in row],
        exchanges=map(piece.flag, exchanges),
        complex_exchanges=map(piece.flag, complex_exchanges),
        stages=[v for row in stages for v in row],
        transformed=transformed,
        factor=piece.trace.binary("pow", convergence, 0.8),
        old=0.0,
        iteration=0.0,
        newton_rate=0.0,
        phase=piece.choose(failed > 0.0, ARRIVED, ITERATE),
    )
    return piece


def read(piece, shape, values: list, exchanges: str) -> tuple[list[list], list]:
    """Factors of a matrix from their rows, and where its rows are exchanged."""
    return split(values, shape.rates), [v > 0.5 for v in piece.all(exchanges)]


def read_real(piece, shape, of: str = "") -> tuple[list[list], list]:
    """Factors of the real matrix; of: "sample_" for those of a sample's step."""
    return read(piece, shape, piece.all(f"{of}real"), f"{of}exchanges")


def iterate(rows, shape, entries) -> Piece:
    """One iteration of the simplified Newton method."""
    piece, n, p, size = Piece(rows, ITERATE), shape.states, shape.coordinates, shape.rates
    t, h, y, rtol = piece["t"], piece["h"], piece.all("y"), piece["rtol"]
    inverse = 1.0 / h
    stages, weight = split(piece.all("stages"), STAGES), piece.all("weight")
    slopes, powers = [], []
    for s in range(STAGES):
        at = t + h * K.c[s], [*map(add, y, stages[s]), *y[n:]]
        values = piece.call(entries.rhs, *at)
        slopes.append(values[:n])
        powers += values[n:]
    w = split(piece.all("transformed"), STAGES)
    turned = [
        [piece.weighted(K.ti[r], [slopes[s][p + i] for s in range(STAGES)]) for i in range(size)]
        for r in range(STAGES)
    ]
    right = [turned[0][i] - inverse * K.real * w[0][i] for i in range(size)]
    first = solve(piece, *read_real(piece, shape), right)
    z_real, z_imag = inverse * PAIR.real, inverse * PAIR.imag
    right = [
        Complex(
            turned[1][i] - (z_real * w[1][i] - z_imag * w[2][i]),
            turned[2][i] - (z_real * w[2][i] + z_imag * w[1][i]),
        )
        for i in range(size)
    ]
    pairs = list(map(Complex, piece.all("complex_real"), piece.all("complex_imag")))
    second = solve(piece, *read(piece, shape, pairs, "complex_exchanges"), right)
    norm, below, length = 0.0, h * (1.0 / K.real), h * h * (1.0 / abs(PAIR) ** 2)
    for i in range(size):
        rate = weight[p + i] * weight[p + i]
        position = weight[i] * weight[i] if i < p else 0.0
        norm = norm + (rate + position * below * below) * first[i] * first[i]
        both = second[i].real * second[i].real + second[i].imag * second[i].imag
        norm = norm + (rate + position * length) * both
    norm = piece.sqrt(norm * (1.0 / (STAGES * n)))
    corrections = [first, [v.real for v in second], [v.imag for v in second]]
    w = [[*map(add, *pair)] for pair in zip(w, corrections, strict=True)]
    failed = judge(piece, norm, rtol)
    new = [[0.0] * n for _ in range(STAGES)]
    for i in range(size):
        for s in range(STAGES):
            new[s][p + i] = piece.weighted(K.t[s], [w[j][i] for j in range(STAGES)])
    followed(piece, shape, h, y, new)
    piece.set(
        transformed=[v for row in w for v in row],
        powers=powers,
        stages=[v for row in new for v in row],
    )
    if shape.contacts:
        end, slope = end_of_step(piece, shape, new, powers)
        piece.set(
            new=end,
            slope=[*slope, *powers[len(powers) - shape.ledger :]],
            ends=piece.call(entries.spots, t + h, end),
        )
        piece.keep(failed, aimed=0.0)
    return piece


def end_of_step(piece, shape, stages: list[list], powers: list) -> tuple:
    """States with the ledger, and rates of the states, at the end of the step."""
    n, h, y, count = shape.states, piece["h"], piece.all("y"), shape.ledger
    inverse = 1.0 / h
    ledger = [y[n + i] + h * piece.weighted(K.a[-1], powers[i::count]) for i in range(count)]
    slope = [piece.weighted(K.end, [row[i] for row in stages]) * inverse for i in range(n)]
    return [*map(add, y, stages[-1]), *ledger], slope


def judge(piece, norm, rtol):
    """Go on with the iteration, or end it: converged, or given up; True where it is given up."""
    iteration, old = piece["iteration"], piece["old"]
    tolerance = piece.largest(2e-15 / rtol, NEWTON_TOLERANCE)
    later = iteration > 0.5
    rate = piece.choose(later, norm / piece.largest(old, 1e-300), 0.0)
    rounds = ITERATIONS - 1 - iteration
    remaining, bound = 1.0, rate
    for bit in (1.0, 2.0, 4.0, 8.0):  # rate to the power of the rounds left
        half = rounds * (0.5 / bit)
        odd = half - piece.trace.function("floor", half) >= 0.5
        remaining = piece.choose(odd, remaining * bound, remaining)
        bound = bound * bound
    gap = piece.largest(1.0 - rate, 1e-16)
    hopeless = remaining * norm > tolerance * gap
    finite = piece.finite([norm])
    bad = piece.none(finite) | (later & ((rate >= 1.0) | hopeless))
    factor_of_rate = piece.choose(later, rate / gap, piece["factor"])
    settled = piece.none(norm > 0.0) | (factor_of_rate * norm < tolerance)
    converged = piece.none(bad) & settled
    last = iteration > ITERATIONS - 1.5
    ended = converged | bad | last
    piece.set(
        solved=piece.flag(converged),
        factor=factor_of_rate,
        convergence=piece.choose(converged, factor_of_rate, 1.0),
        newton_rate=rate,
        old=norm,
        iteration=iteration + 1.0,
        phase=piece.choose(ended, FINISH, ITERATE),
    )
    most = 2 * ITERATIONS + 1
    piece.keep(converged, effort=SAFETY * most / (iteration + most))
    return ended & piece.none(converged)


def settled(piece, shape, entries, theta, t, of: str = "") -> list:
    """States inside a step, stiff rates brought to the equations: see `settle` of the loop.

    of: "sample_" for the step of a sample.
    """
    n, p, size = shape.states, shape.coordinates, shape.rates
    h = piece[f"{of}last_h"]
    pairs = piece.moving(piece.all(f"{of}polynomial"), theta, n)
    y = [a + b for a, (b, _) in zip(piece.all(f"{of}base"), pairs, strict=True)]
    lu, exchanges = read_real(piece, shape, of)
    inverse = 1.0 / piece.largest(h, 1e-300)
    gain, between = inverse * K.real, theta > 0.0
    stiff = piece.either(*(abs(lu[i][i]) * gain < STIFF for i in range(size)))
    moves, start = stiff & between, y[p:]
    for _ in range(SETTLED):
        f = piece.call(entries.rhs, t, y + piece.all("y")[n:])
        defect = [
            f[p + i] - pairs[p + i][1] * inverse - gain * (y[p + i] - start[i]) for i in range(size)
        ]
        change = solve(piece, lu, exchanges, defect)
        y[p:] = [v + piece.choose(moves, d, 0.0) for v, d in zip(y[p:], change, strict=True)]
    return y


def error_of(piece, shape, f: list, stages: list[list]) -> tuple[list, object]:
    """Error estimate and its norm over tolerance."""
    n, p, size = shape.states, shape.coordinates, shape.rates
    h, weight, coupling = piece["h"], piece.all("weight"), piece.all("coupling")
    inverse, below = 1.0 / h, h * (1.0 / K.real)
    defect = [f[i] + piece.weighted(K.e, [row[i] for row in stages]) * inverse for i in range(n)]
    right = []
    for i in range(size):
        moved = piece.total(coupling[i * p + j] * defect[j] for j in range(p)) if p else 0.0
        right.append(defect[p + i] + moved * below)
    rates = solve(piece, *read_real(piece, shape), right)
    error = [(defect[i] + rates[i]) * below for i in range(p)] + rates
    norm = piece.length([e * w for e, w in zip(error, weight, strict=True)], n)
    return error, norm * LARGER


def onset(piece, shape, ends: list) -> tuple:
    """True where a contact sets in or ends amidst a step, without a touch; the share of the step.

    The loop, too, has such a step end there. Here it ends a little behind: the next would cross
    the place otherwise, or end before it again, and so on.
    """
    h, begins, met, share = piece["h"], piece.all("begins"), [], 1.0
    for k in range(len(shape.gradual)):
        low, rise, high, fall = *begins[2 * k : 2 * k + 2], *ends[2 * k : 2 * k + 2]
        first, second, third = piece.formula(control.cubic, low, rise, high, fall, h)
        begin, end = 0.0, 1.0
        for _ in range(HALVINGS):
            x = (begin + end) * 0.5
            before = (low + x * (first + x * (second + x * third))) * low > 0.0
            begin, end = piece.choose(before, x, begin), piece.choose(before, end, x)
        for _ in range(TANGENTS):
            slope = first + x * (2.0 * second + x * (3.0 * third))
            value = low + x * (first + x * (second + x * third))
            x = piece.smallest(piece.largest(x - value / slope, begin), end)
        inside = abs(x - 0.5) < 0.5 - NEAR
        met.append((low * high < 0.0) & inside)
        share = piece.choose(met[-1], piece.smallest(share, x * BEHIND), share)
    return piece.either(*met) & (piece["shortened"] < SPARED), share


def tried(piece, shape, entries, stages: list[list]) -> Trial:
    """The step with its error."""
    n, t, y, f = shape.states, piece["t"], piece.all("y"), piece.all("f")
    solved = piece["solved"] > 0.5
    estimate, norm = error_of(piece, shape, f, stages)
    doubtful = piece.on & solved & (norm >= 1.0) & piece.finite([norm])
    again = [*map(add, y, estimate), *y[n:]]
    _, second = error_of(piece, shape, piece.call(entries.rhs, t, again)[:n], stages)
    error = piece.choose(doubtful, second, norm)
    if shape.contacts:  # which may have moved the end
        end, slope = piece.all("new"), piece.all("slope")[:n]
    else:  # powers are those where Newton's method looked last
        end, slope = end_of_step(piece, shape, stages, piece.all("powers"))
    finite = piece.finite([*end[:n], *slope, error])
    return Trial(end, slope, error, solved, finite, piece.all("diagonal"))


def touched(piece, shape, entries, trial, polynomial: list) -> list:
    """Penetrations at the end of a step, whose trial has it where a contact sets in or ends."""
    if shape.gradual:
        end = trial.y[: shape.states] + piece.all("y")[shape.states :]
        ends = piece.call(entries.spots, piece["t"] + piece["h"], end)
        trial.met = onset(piece, shape, ends)
        return ends
    met, inaccurate = met_inside(piece, shape, entries, polynomial), trial.error > 1.0
    trial.met = met & trial.solved & trial.finite & piece.none(inaccurate), 1.0
    return piece.all("ends")


def note(piece, shape, met, taken) -> None:
    """Keep for the driver, or for the next step, where a contact sets in or ends."""
    if shape.gradual:
        cut, last = piece.flag(met), piece["shortened"]
        piece.set(shortened=piece.choose(taken, 0.5 * last, last + cut))
        return
    piece.leave(met, "rejected", "refusals", "refusal")
    piece.set(event=piece.choose(met, 1.0, piece.choose(taken, 0.0, -1.0)))
    piece.keep(piece.none(taken), aimed=0.0)


def finish(rows, shape, entries, watch) -> Piece:
    """Error of the step, whether it is taken, outputs at its end."""
    piece = Piece(rows, FINISH)
    h, stages = piece["h"], split(piece.all("stages"), STAGES)
    trial = tried(piece, shape, entries, stages)
    polynomial = [
        piece.weighted(row, column) for row in K.basis for column in zip(*stages, strict=True)
    ]
    ends = touched(piece, shape, entries, trial, polynomial) if shape.spots else []
    taken, now = conclude(piece, shape, entries, trial, ORDER)
    if shape.spots:
        piece.keep(taken, begins=ends)
        note(piece, shape, trial.met[0], taken)
    near = piece.choose(h > piece["last_h"], 1.0, 0.0)  # see `radau.advance`
    usable = piece.choose(trial.solved, 1.0, near)
    piece.set(predictor=piece.choose(taken, 1.0, piece["predictor"] * usable))
    piece.keep(taken, polynomial=polynomial, last_h=h)
    look(piece, shape, entries, watch, now, trial.y, polynomial, taken)
    return piece
