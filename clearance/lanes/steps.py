"""Steps of all methods on traced numbers: first step, control of the step, films, advance of a
lane.

The formulas of the control are those of stepping/control.py. As in kernels, arguments of one name
are of one class everywhere: piece, rows, shape, entries, watch, trial.
"""

from dataclasses import dataclass

from clearance.lanes.rows import Entry, Piece
from clearance.stepping import control, status
from clearance.stepping.control import DOUBTED, FORGET, NEWTON_FAILED, SHRINK, SQUEEZE

# a rate of convergence that Newton's method should not exceed in the next step. It is smaller than
# the loop's: with the predicted Jacobian the rate alone shows how much films change within a step
GOOD_RATE = 0.03
# phases of a lane
IDLE, START, PREPARE, ITERATE, FINISH, ARRIVED = range(6)


@dataclass(frozen=True)
class Shape:
    """Sizes of a scene: coordinates, states, and energy integrals behind them.

    films: (place of the first offset in the state, place among the spots) of each joint that only
        its film carries; contacts: (kind, place among the spots, dead band [m]) of each spot where
        contact starts and ends inside steps; gradual: of those where it sets in without a touch,
        for implicit methods.
    """

    coordinates: int
    states: int
    ledger: int
    films: tuple[tuple[int, int], ...]
    contacts: tuple[tuple[int, int, float], ...] = ()
    gradual: tuple[tuple[int, int, float], ...] = ()

    @property
    def spots(self) -> tuple[tuple[int, int, float], ...]:
        """Spots that are looked at where steps end."""
        return self.contacts or self.gradual

    @property
    def rates(self) -> int:
        """Number of states that are no coordinates."""
        return self.states - self.coordinates

    @property
    def size(self) -> int:
        """States and energy integrals."""
        return self.states + self.ledger


@dataclass(frozen=True)
class Entries:
    """Functions of the scene: y' with the powers of the ledger, Jacobian, penetrations of the
    films, penetrations of the contacts with their rates, outputs, those of samples.
    """

    rhs: Entry
    jacobian: Entry
    films: Entry
    spots: Entry
    outputs: Entry
    samples: Entry


def add_rows(rows, shape) -> None:
    """Rows that all methods need."""
    rows.add("phase status t h end longest rtol step last_step last_error refusal")
    rows.add("refusals steps rejected begun effort newton_rate")
    rows.add("y f", count=shape.size)
    rows.add("scale base", count=shape.states)
    rows.add("diagonal", count=2 * len(shape.films))
    rows.add("before damping clearance pull rate_x rate_y", count=len(shape.films))


def sizes_of_films(
    piece, shape, y: list, penetration: list, diagonal: list, damping: list
) -> tuple:
    """Natural sizes of all states, and dampings: see `weigh_films` of the loop."""
    scale, sizes, rtol = piece.all("scale"), [], piece["rtol"]
    for k, (first, _) in enumerate(shape.films):
        clearance, pull = piece.at("clearance", k), piece.at("pull", k)
        gap = piece.largest(-penetration[k], clearance * 1e-15)
        sizes.append(piece.largest(damping[k] * FORGET, *diagonal[2 * k : 2 * k + 2]))
        for i, usual in enumerate((piece.at("rate_x", k), piece.at("rate_y", k))):
            offset = clearance, gap, y[first + i], rtol
            (scale[first + i],) = piece.formula(control.offset_size, *offset)
            index = shape.coordinates + first + i
            rate = usual, pull, sizes[k], y[index], rtol
            (scale[index],) = piece.formula(control.rate_size, *rate)
    return scale, sizes


def first_step(piece, entries, rates: list, scale: list, order: float):
    """The first step, from the rates where it begins; scale: natural sizes of the states."""
    t, y, rtol, n = piece["t"], piece.all("y"), piece["rtol"], len(scale)
    f = rates[:n]
    weights = [rtol * (s + abs(v)) for s, v in zip(scale, y, strict=False)]
    size, rate = (
        piece.total((v / w) * (v / w) for v, w in zip(x, weights, strict=True)) for x in (scale, f)
    )
    h = piece.smallest(piece["longest"], piece.sqrt(size / piece.largest(rate, 1e-300)) * 0.01)
    later = piece.call(entries.rhs, t + h, [v + h * r for v, r in zip(y, rates, strict=True)])
    bend = piece.total(
        ((b - a) / w) * ((b - a) / w) for a, b, w in zip(f, later, weights, strict=False)
    )
    largest = piece.largest(piece.sqrt(rate * (1.0 / n)), piece.sqrt(bend * (1.0 / n)) / h)
    usable = (largest > 0.0) & piece.finite([largest])
    power = piece.trace.binary("pow", 0.01 / largest, 1.0 / (order + 1.0))
    return piece.choose(usable, piece.smallest(h * 100.0, power, piece["longest"]), h * 1e-3)


def start(rows, shape, entries, order: float, then: int) -> Piece:
    """First evaluation and first step (Hairer, Norsett, Wanner 1993, section II.4); then: phase
    that follows.
    """
    piece, n = Piece(rows, START), shape.states
    t, y = piece["t"], piece.all("y")
    penetration = piece.call(entries.films, t, y) if shape.films else []
    scale, damping = sizes_of_films(
        piece, shape, y, penetration, [0.0] * 2 * len(shape.films), piece.all("damping")
    )
    rates = piece.call(entries.rhs, t, y)
    begun = piece.finite(rates)
    piece.set(f=rates, scale=scale, damping=damping, before=penetration)
    step = first_step(piece, entries, rates, scale, order) if n else piece["longest"]
    piece.set(
        step=step,
        base=y[:n],
        status=piece.choose(begun, 0.0, status.NOT_FINITE),
        phase=piece.choose(begun, then, ARRIVED),
    )
    return piece


def proposed(piece, shape):
    """The next step, stretched or halved so that the run does not end in a very short one, or of
    the size that the search for a contact gives. The status is other than 0 where the step is too
    small.
    """
    t, end = piece["t"], piece["end"]
    remaining = end - t
    (h,) = piece.formula(control.within, piece["step"], piece["longest"], remaining)
    (clock,) = piece.formula(control.resolution, t, end)
    stuck = piece.none(h > clock) & (remaining > h)
    refusal = piece["refusal"]
    left_film = refusal > status.OUT_OF_FILM - 0.5
    unsolved = refusal > status.NO_NUMBERS - 0.5
    reason = piece.choose(unsolved, status.NOT_FINITE, status.STEP_TOO_SMALL)
    reason = piece.choose(left_film, status.FILM_LEFT, reason)
    failed = piece.choose(stuck, reason, 0.0)
    if not shape.contacts:
        return h, failed
    aimed = piece["aimed"] > 0.5
    return piece.choose(aimed, piece["h"], h), piece.choose(aimed, 0.0, failed)


@dataclass
class Trial:
    """A step tried: state with the ledger, and rates, at its end, error over tolerance, whether the
    method worked at all.
    """

    y: list
    f: list
    error: object
    solved: object
    finite: object
    diagonal: list
    met: tuple = ()  # where a contact sets in or ends inside it, and the share of the step


def conclude(piece, shape, entries, trial, order: float) -> tuple:
    """Accept or refuse a trial step and choose the next; returns where it is accepted, and the time
    at its end.
    """
    t, h, n = piece["t"], piece["h"], shape.states
    states = zip(trial.y[:n], piece.all("y"), strict=False)
    y = [
        piece.choose(trial.solved, a, b) for a, b in states
    ]  # no look-ups where there is no number
    penetration = piece.call(entries.films, t + h, [*y, *piece.all("y")[n:]]) if shape.films else []
    ends = zip(penetration, piece.all("before"), strict=True)
    near = [after >= before * SQUEEZE for after, before in ends]
    accurate = trial.solved & piece.none(trial.error > 1.0)
    usable = accurate & trial.finite
    taken = usable & piece.none(piece.either(*near)) if near else usable
    error = piece.largest(trial.error, 1e-10)
    shorter = refused(piece, trial, accurate, usable, order)
    if trial.met:
        met = taken & trial.met[0]
        taken, shorter = (
            taken & piece.none(met),
            piece.choose(met, trial.met[1], shorter),
        )
    step = piece.choose(taken, grown(piece, h, error, order), h * shorter)
    scale, damping = sizes_of_films(
        piece, shape, y, penetration, trial.diagonal, piece.all("damping")
    )

    now, arrived = advance(piece, shape, taken, error, trial.y, trial.f)
    piece.keep(taken, scale=scale, damping=damping, before=penetration)
    piece.keep(piece.none(taken), rejected=piece["rejected"] + 1.0)
    piece.set(
        refusals=piece.choose(taken, 0.0, piece["refusals"] + 1.0),
        refusal=piece.choose(taken, 0.0, reason(piece, trial, accurate, usable)),
        step=step,
        phase=piece.choose(arrived, ARRIVED, PREPARE),
    )
    return taken, now


def advance(piece, shape, taken, error, y: list, f: list) -> tuple:
    """Advance where a step is taken: state and rates at its end, clock, counts.

    Returns the time at its end, and where the end of the run or turn is reached.
    """
    t, h, end = piece["t"], piece["h"], piece["end"]
    reached = (h >= end - t) | (t + h >= end)
    now = piece.choose(reached, end, t + h)
    piece.keep(
        taken,
        y=y,
        f=f,
        base=piece.all("y")[: shape.states],
        begun=t,
        t=now,
        last_step=h,
        last_error=piece.largest(error, 1e-2),
        steps=piece["steps"] + 1.0,
    )
    return now, taken & reached


def reason(piece, trial, accurate, usable):
    """Number of the reason of a refusal."""
    unsolved = piece.choose(trial.finite, status.TOO_LONG, status.NO_NUMBERS)
    value = piece.choose(accurate, status.NO_NUMBERS, unsolved)
    return piece.choose(usable, status.OUT_OF_FILM, value)


def refused(piece, trial, accurate, usable, order: float):
    """The step over one that is refused: see `refuse` and `shrink` of the loop."""
    bounded = piece.smallest(piece.largest(trial.error, 1.0), 1e30)
    (first,), (again,) = (
        piece.formula(control.reduction, bounded, power) for power in (1.0 / order, DOUBTED)
    )
    factor = piece.choose(piece["refusals"] > 0.5, again, first)
    factor = piece.choose(trial.solved, factor, NEWTON_FAILED)
    factor = piece.choose(piece.none(trial.finite), NEWTON_FAILED, factor)
    factor = piece.choose(accurate, NEWTON_FAILED, factor)
    return piece.choose(usable, SHRINK, factor)


def grown(piece, h, error, order: float):
    """The step after one that is taken: see `grow` of the loop."""
    before, last_error = piece["last_step"], piece["last_error"]
    sizes = error, 1.0 / order, piece["effort"], h, before, last_error
    (factor,) = piece.formula(control.factor, *sizes)
    after, rate = piece["refusal"] > 0.5, piece["newton_rate"]
    (clock,) = piece.formula(control.resolution, piece["t"], piece["end"])
    (step,) = piece.formula(control.next_step, h, factor, rate, GOOD_RATE, after, clock)
    return step
