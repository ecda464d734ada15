"""DOP853 on traced numbers: the method of stepping/dop853.py, a lane for each run.

A step in which a contact starts or ends is tried again at the size that ends it there, see
touches.py. Whatever differs between lanes is this size: no lane waits for another's contact.
"""

from clearance.lanes.probes import add_probes, falling, met_inside
from clearance.lanes.rows import Piece, split
from clearance.lanes.steps import (
    ARRIVED,
    FINISH,
    ITERATE,
    Trial,
    advance,
    grown,
    proposed,
    refused,
    start,
)
from clearance.lanes.watch import look
from clearance.mechanism.build import Mechanism
from clearance.stepping import control, status
from clearance.stepping.control import NEWTON_FAILED, STIFF_ENOUGH
from clearance.stepping.dop853 import (
    DEGREE,
    E3,
    E5,
    FIFTH,
    ORDER,
    OUTWEIGHED,
    STAGES,
    A,
    B,
    C,
    D,
)
from clearance.values.spots import FILM

IMPLICIT = False
HELD = ("base", "polynomial")  # of a step, for places inside it
NEXT = ITERATE  # phase of a step that begins
BLANK = {"effort": 0.9}
HELD_UP = 5.0 * STIFF_ENOUGH  # steps after which a run is given up: it starts once more then


def unfit(mechanism: Mechanism) -> str | None:
    """The reason why a mechanism does not suit this method in lanes."""
    if films := [e.name for e, spot in mechanism.spots if spot.kind == FILM]:
        return f"the film of joint {films[0]} asks for an implicit method"
    return None


def add_rows(rows, shape) -> None:
    """Rows that this method needs."""
    n = shape.states
    rows.add("error last_h felt stiff mild")
    rows.add("new slope", count=shape.size)
    rows.add("stages", count=STAGES * n)
    rows.add("polynomial", count=DEGREE * n)
    if shape.contacts:
        add_probes(rows, shape)


def begin(rows, shape, entries) -> Piece:
    """The begin of a phase of a run: rates, contacts, first step."""
    piece = start(rows, shape, entries, ORDER, NEXT)
    if shape.contacts:
        piece.set(begins=piece.call(entries.spots, piece["t"], piece.all("y")), aimed=0.0)
    piece.set(last_step=0.0)
    return piece


def prepare(rows, shape, entries) -> Piece:
    """Nothing: a trial begins with its step."""
    return Piece(rows, NEXT)


def sum_of(piece, weights, slopes: list[list], i: int):
    """Weighted sum of the slopes of a state."""
    return piece.weighted(weights, [slope[i] for slope in slopes])


def add_stages(piece, shape, entries, h, slopes: list[list], count: int) -> list:
    """Add slopes to those of the first stages, up to so many; the states of the last stage."""
    t, y, n, inner = piece["t"], piece.all("y"), shape.states, []
    for s in range(len(slopes), count):
        inner = [y[i] + h * sum_of(piece, A[s, :s], slopes, i) for i in range(n)]
        slopes.append(piece.call(entries.rhs, t + h * C[s], [*inner, *y[n:]]))
    return inner


def iterate(rows, shape, entries) -> Piece:
    """One trial step, of the size that the control or the search for a contact gives."""
    piece, n = Piece(rows, ITERATE), shape.states
    t, y = piece["t"], piece.all("y")
    h, failed = proposed(piece, shape)
    slopes = [piece.all("f")]
    inner = add_stages(piece, shape, entries, h, slopes, STAGES)
    new = [y[i] + h * sum_of(piece, B, slopes, i) for i in range(shape.size)]
    slope = piece.call(entries.rhs, t + h, new)
    error = error_of(piece, shape, h, new, [*slopes, slope])
    finite = piece.finite([*new, *slope, error])
    accurate = finite & piece.none(error > 1.0)
    piece.set(
        felt=stiffness(piece, n, h, (new, inner), (slope, slopes[-1])),
        h=h,
        error=error,
        new=new,
        slope=slope,
        stages=[v for row in slopes for v in row[:n]],
    )
    trial = Trial(new, slope, error, piece.none(h < 0.0), finite, [])
    factor = refused(piece, trial, accurate, accurate, ORDER)
    if shape.contacts:
        ends = piece.call(entries.spots, t + h, new)
        piece.set(ends=ends)
        factor = falling(piece, shape, finite, ends, factor)
        factor = piece.choose(piece["aimed"] > 0.5, NEWTON_FAILED, factor)
        piece.keep(piece.none(accurate), aimed=0.0)
    give_way(piece, accurate, h * factor)
    phase = piece.choose(accurate, FINISH, ITERATE)
    piece.set(status=failed, phase=piece.choose(failed > 0.0, ARRIVED, phase))
    return piece


def give_way(piece, accurate, step) -> None:
    """Make the next step shorter after one that is refused."""
    piece.keep(
        piece.none(accurate),
        rejected=piece["rejected"] + 1.0,
        refusals=piece["refusals"] + 1.0,
        refusal=status.TOO_LONG,
        step=step,
    )


def error_of(piece, shape, h, new: list, slopes: list[list]):
    """Error over tolerance, see `dop853.step`."""
    n, y, rtol, high, low = shape.states, piece.all("y"), piece["rtol"], 0.0, 0.0
    for i, scale in enumerate(piece.all("scale")):
        size = scale + piece.largest(abs(y[i]), abs(new[i]))
        weight = 1.0 / (rtol * size)
        five, three = (sum_of(piece, w, slopes, i) * weight for w in (E5, E3))
        high, low = high + five * five, low + three * three
    root = piece.sqrt((high + low * 0.01) * n)
    error = piece.choose(root > 0.0, h * high / piece.largest(root, 1e-300), 0.0)
    share = piece.trace.binary("pow", rtol, 1.0 - 5.0 / 8.0)
    return piece.largest(error, h * piece.sqrt(high * (1.0 / max(n, 1))) * share * (1.0 / FIFTH))


def stiffness(piece, n: int, h, states: tuple, slopes: tuple):
    """Step times the largest eigenvalue felt."""
    apart, change = 0.0, 0.0
    for i, scale in enumerate(piece.all("scale")):
        unit = 1.0 / (scale + abs(states[0][i]))
        a, b = ((pair[0][i] - pair[1][i]) * unit for pair in (states, slopes))
        apart, change = apart + a * a, change + b * b
    return h * piece.sqrt(change / piece.largest(apart, 1e-300))


# --- the end of a step
def dense(piece, shape, entries) -> list:
    """Dense output of the trial step, see `dop853.interpolant`."""
    h, y = piece["h"], piece.all("y")
    new, slope, values = piece.all("new"), piece.all("slope"), piece.all("stages")
    slopes = [*split(values, STAGES), slope]
    add_stages(piece, shape, entries, h, slopes, 16)
    rows: list[list] = [[] for _ in range(DEGREE)]
    within, at_ends = 0.0, 0.0
    for i, scale in enumerate(piece.all("scale")):
        change = new[i] - y[i]
        column = [change, h * slopes[0][i] - change, 2.0 * change - h * (slopes[0][i] + slope[i])]
        column += [h * sum_of(piece, weights, slopes, i) for weights in D]
        unit = 1.0 / (scale + abs(new[i]))
        parts = [(v * unit) * (v * unit) for v in column]
        at_ends, within = at_ends + piece.total(parts[:3]), within + piece.total(parts[3:])
        for row, value in zip(rows, column, strict=True):
            row.append(value)
    cubic = within > at_ends * OUTWEIGHED
    high = [[piece.choose(cubic, 0.0, v) for v in row] for row in rows[3:]]
    return [v for row in (*rows[:3], *high) for v in row]


def settled(piece, shape, entries, theta, t, of: str = "") -> list:
    """States inside a step, where no rate is stiff; of: "sample_" for the step of a sample."""
    moved = piece.along(piece.all(f"{of}polynomial"), theta, shape.states)
    return [a + b for a, b in zip(piece.all(f"{of}base"), moved, strict=True)]


def finish(rows, shape, entries, watch) -> Piece:
    """The end of a step, with its outputs, unless a contact starts or ends inside it."""
    piece = Piece(rows, FINISH)
    h, new = piece["h"], piece.all("new")
    polynomial, taken = dense(piece, shape, entries), h >= 0.0
    if shape.contacts:
        event = met_inside(piece, shape, entries, polynomial)
        taken = piece.none(event)
        piece.set(event=piece.flag(event))
        piece.keep(taken, begins=piece.all("ends"))
    error = piece.largest(piece["error"], 1e-10)
    now, arrived = advance(piece, shape, taken, error, new, piece.all("slope"))
    step = grown(piece, h, error, ORDER)
    piece.keep(taken, step=step, refusals=0.0, refusal=0.0, polynomial=polynomial, last_h=h)
    stuck = count_stiff(piece, taken)
    piece.set(
        status=piece.choose(stuck, status.STIFF, 0.0),
        phase=piece.choose(arrived | stuck, ARRIVED, NEXT),
    )
    look(piece, shape, entries, watch, now, new, polynomial, taken)
    return piece


def count_stiff(piece, taken):
    """True where stability has held the method up for many steps."""
    before = piece["stiff"], piece["mild"]
    now = piece.formula(control.stiff_steps, piece["felt"], *before)
    piece.keep(taken, stiff=now[0], mild=now[1])
    return taken & (now[0] >= HELD_UP)
