"""The driver of the lanes: takes points from a queue, calls the piece that most lanes wait for,
keeps results.

Every lane has its own time, step and phase; a piece changes the lanes that are in its phase. So a
run does not depend, bit for bit, on which others run beside it. Places inside a step are searched
for extremes as in stepping/locating.py.
"""

import hashlib
import math
from pathlib import Path

from clearance.lanes.steps import (
    ARRIVED,
    FINISH,
    IDLE,
    INSIDE,
    ITERATE,
    LOOK,
    PREPARE,
    START,
)
from clearance.stepping import status
from clearance.stepping.locating import CLOSER, EDGE, REACH, ROUNDS, SETTLED
from clearance.stepping.types import DIGEST
from clearance.store import OPTIONS, cached, entry_caller, njit, types

PIECES = 7  # START to INSIDE, one for each phase, and that of samples
SAMPLE = 6  # its place among them
NEVER = 1e300
SAME = 1e-12  # share of the time within which two moments are one

#: rows that the driver reads and sets, in the order in which it is given their places
ROWS = (
    "phase",
    "status",
    "t",
    "end",
    "from",
    "last_h",
    "steps",
    "rejected",
    "theta",
    "sampled",
    "sample_time",
    "sample",
    "share",
    "due",
    "within",
    "value",
    "last",
    "next",
    "search",
    "seen",
    "middle",
    "tracks",
    "sums",
    "given",
    "base",
    "polynomial",
    "y",
)
(
    PHASE,
    STATUS,
    TIME,
    END,
    FROM,
    LAST_H,
    STEPS,
    REJECTED,
    THETA,
    SAMPLED,
    SAMPLE_TIME,
    SAMPLE_STATE,
    SHARE,
    DUE,
    WITHIN,
    VALUE,
    LAST,
    NEXT,
    SEARCHED,
    SEEN,
    MIDDLES,
    TRACKS,
    SUMS,
    GIVEN,
    BASE,
    POLYNOMIAL,
    STATE,
) = range(len(ROWS))
DEGREE = len(ROWS)  # behind their places: that of the dense output

#: columns of `spans`, a row for each point
BEGIN, UNTIL, EVERY, SAMPLES, TURN = range(5)
#: columns of `searches`, a row for each lane: the quantity, its parabola and how far it has come
QUANTITY, STAGE, ROUND, A, B, C, AT_A, AT_B, AT_C, WIDTH = range(10)
SAMPLE_INDEX, POINT, CALLED, TURNS, WAITING = range(10, 15)  # and its run's progress
SEARCH_COLUMNS = 15
MIDDLE, SUMMIT, LEFT, RIGHT = range(4)  # stages of a search

call = entry_caller(2)
helper = njit(inline="never", **OPTIONS)


@helper
def sample_time(span, index):
    """Time of a sample of a run."""
    if index >= span[SAMPLES] - 1.0:
        return span[UNTIL] if index == span[SAMPLES] - 1.0 else NEVER
    return index * span[EVERY]


@helper
def end_of_turn(span, turn):
    """End of a turn of a run, the last that of the run."""
    end = (turn + 1) * span[TURN]
    return span[UNTIL] if end > span[UNTIL] * (1.0 - SAME) else end


@helper
def load(rows, at, lane, point, blank, where, points, spans, searches):
    """Begin a point in a lane."""
    for i in range(rows.shape[0]):
        rows[i, lane] = blank[i]
    for i in range(where.size):
        rows[where[i], lane] = points[point, i]
    span = spans[point]
    rows[at[PHASE], lane] = START
    rows[at[END], lane] = end_of_turn(span, 0)
    rows[at[WITHIN], lane] = 0.0 if span[BEGIN] > 0.0 else 1.0
    searches[lane, TURNS] = searches[lane, WAITING] = 0.0
    index = math.ceil(span[BEGIN] * (1.0 - SAME) / span[EVERY])
    searches[lane, SAMPLE_INDEX] = index
    searches[lane, POINT] = point
    rows[at[DUE], lane] = sample_time(span, index)


@helper
def arrive(rows, at, lane, quantities, span, energies, begun, extremes, search):
    """Take in the end of a turn: its extremes, and that the window begins; False where the run is
    over.
    """
    if rows[at[STATUS], lane] != 0.0:
        return False
    turn, time = int(search[TURNS]), rows[at[TIME], lane]
    for k in range(quantities):
        extremes[turn, k] = rows[at[VALUE] + k, lane]
        rows[at[VALUE] + k, lane] = rows[at[NEXT] + k, lane]
    if time >= span[UNTIL]:
        return False
    if rows[at[WITHIN], lane] == 0.0 and time >= span[BEGIN] * (1.0 - SAME):
        for k in range(energies.size):
            begun[k] = rows[at[STATE] + energies[k], lane]
        rows[at[WITHIN], lane] = 1.0
    search[TURNS] = turn + 1.0
    rows[at[END], lane] = end_of_turn(span, turn + 1)
    rows[at[PHASE], lane] = PREPARE
    return True


# --- places inside a step
@helper
def push(rows, at, lane, span, queue, search):
    """Put the samples of the step made last into the lane's queue: index, time, state.

    True where it is full.
    """
    h, room = rows[at[LAST_H], lane], queue.shape[0]
    while rows[at[DUE], lane] <= rows[at[TIME], lane] and search[WAITING] < room:
        due = rows[at[DUE], lane]
        theta = min((due - rows[at[FROM], lane]) / h, 1.0) if h > 0.0 else 0.0
        item = queue[int(search[WAITING])]
        item[0], item[1] = search[SAMPLE_INDEX], due
        states = item.size - 2
        for i in range(states):
            value = 0.0
            for r in range(at[DEGREE] - 1, -1, -1):
                value += rows[at[POLYNOMIAL] + r * states + i, lane]
                value *= theta if r % 2 == 0 else 1.0 - theta
            item[2 + i] = rows[at[BASE] + i, lane] + value
        search[WAITING] += 1.0
        search[SAMPLE_INDEX] += 1.0
        rows[at[DUE], lane] = sample_time(span, search[SAMPLE_INDEX])
    return search[WAITING] == room


@helper
def flush(entry, table, rows, at, lane, side, common, means, span, given, queue, tracks, search):
    """Outputs at all samples of a lane's queue, W of them at a time; side: rows for them."""
    width, count = rows.shape[1], int(search[WAITING])
    for i in range(common.size):
        for k in range(width):
            side[common[i], k] = rows[common[i], lane]
    for first in range(0, count, width):
        for k in range(width):
            item = queue[min(first + k, count - 1)]
            side[at[SAMPLED], k] = 1.0 if first + k < count else 0.0
            half, begin, end = 0.5 * span[EVERY], span[BEGIN], span[UNTIL]
            side[at[SHARE], k] = (min(item[1] + half, end) - max(item[1] - half, begin)) / (
                end - begin
            )
            side[at[SAMPLE_TIME], k] = item[1]
            for i in range(item.size - 2):
                side[at[SAMPLE_STATE] + i, k] = item[2 + i]
            for i in range(given.shape[0]):
                side[at[GIVEN] + i, k] = given[i, int(item[0])]
        call(entry, (side.ctypes.data, table))
        for k in range(min(width, count - first)):
            for i in range(tracks.shape[0]):
                tracks[i, int(queue[first + k, 0])] = side[at[TRACKS] + i, k]
    for i in range(means.size):
        for k in range(width):
            value = side[at[SUMS] + i, k]
            side[at[SUMS] + i, k] = 0.0
            before = rows[at[SUMS] + i, lane]
            rows[at[SUMS] + i, lane] = before + value if means[i] else max(before, value)
    search[WAITING] = 0.0


@helper
def searched(rows, at, lane, quantities, search):
    """Go on with the searches of a step; False where they are over."""
    while True:
        k = int(search[QUANTITY])
        if k < 0:
            for k in range(quantities):
                if rows[at[SEARCHED] + k, lane] > 0.5:
                    break
            else:
                return False
            rows[at[SEARCHED] + k, lane] = 0.0
            search[QUANTITY], search[ROUND], search[WIDTH] = k, 0.0, 1.0
            search[A], search[B], search[C] = 0.0, 0.5, 1.0
            search[AT_A], search[AT_C] = rows[at[LAST] + k, lane], rows[at[NEXT] + k, lane]
            search[AT_B] = rows[at[MIDDLES] + k, lane]
            search[STAGE] = SUMMIT
        if search[STAGE] == SUMMIT:
            theta = summit(search, rows[at[VALUE] + k, lane])
            if theta < 0.0:
                search[QUANTITY] = -1.0
                continue
            rows[at[THETA], lane] = theta
        elif search[STAGE] == LEFT:
            rows[at[THETA], lane] = search[A]
        else:
            rows[at[THETA], lane] = search[C]
        return True


@helper
def summit(search, best):
    """Summit of the parabola through three places; -1 where there is nothing to find."""
    slope = (search[AT_B] - search[AT_A]) / (search[B] - search[A])
    bend = ((search[AT_C] - search[AT_B]) / (search[C] - search[B]) - slope) / (
        search[C] - search[A]
    )
    if not bend < 0.0:
        return -1.0
    top = 0.5 * (search[A] + search[B]) - 0.5 * slope / bend
    if search[ROUND] == 0.0:
        ends = max(search[AT_A], search[AT_C])
        rise = search[AT_A] + (top - search[A]) * (slope + bend * (top - search[B])) - ends
        if abs(top - search[B]) > REACH or not ends + 2.0 * rise > best:
            return -1.0
    return min(max(top, EDGE), 1.0 - EDGE)


@helper
def take(rows, at, lane, quantities, search):
    """Take in the outputs at the place that was asked for."""
    if search[STAGE] == MIDDLE:
        for k in range(quantities):
            rows[at[MIDDLES] + k, lane] = rows[at[SEEN] + k, lane]
        search[QUANTITY] = -1.0
        return
    value = rows[at[SEEN] + int(search[QUANTITY]), lane]
    if search[STAGE] == SUMMIT:
        theta = rows[at[THETA], lane]
        if search[ROUND] > 0.0 and abs(theta - search[B]) < SETTLED * search[WIDTH]:
            search[QUANTITY] = -1.0
            return
        search[WIDTH] *= CLOSER
        search[A], search[B], search[C] = (
            max(0.0, theta - search[WIDTH]),
            theta,
            min(1.0, theta + search[WIDTH]),
        )
        search[AT_B], search[ROUND] = value, search[ROUND] + 1.0
        search[STAGE] = LEFT
        if search[ROUND] >= ROUNDS:
            search[QUANTITY] = -1.0
    elif search[STAGE] == LEFT:
        search[AT_A], search[STAGE] = value, RIGHT
    else:
        search[AT_C], search[STAGE] = value, SUMMIT


# --- the loop
@helper
def keep(rows, at, lane, gathered, values):
    """Results of a run: chosen rows, status, steps."""
    for i in range(gathered.size):
        values[i] = rows[gathered[i], lane]
    code = rows[at[STATUS], lane]
    values[gathered.size] = status.DONE if code == 0.0 else code
    values[gathered.size + 1], values[gathered.size + 2] = (
        rows[at[STEPS], lane],
        rows[at[REJECTED], lane],
    )


@helper
def wanted(rows, at, counts):
    """The piece that is called next: what costs little first, else what most lanes wait for."""
    for phase in range(counts.size):
        counts[phase] = 0
    for lane in range(rows.shape[1]):
        counts[int(rows[at[PHASE], lane])] += 1
    for phase in (LOOK, INSIDE):
        if counts[phase] > 0:
            return phase - START
    best = ITERATE
    for phase in (START, PREPARE, FINISH):
        if counts[phase] > counts[best]:
            best = phase
    return best - START


@helper
def after(rows, at, lane, piece, quantities, span, energies, begun, extremes, search, limit):
    """Lead a lane on that a piece has changed; False where its run is over."""
    if rows[at[PHASE], lane] == INSIDE:
        if piece + START == INSIDE:
            take(rows, at, lane, quantities, search)
        else:  # the middle of the step is looked at first
            search[STAGE], rows[at[THETA], lane] = MIDDLE, 0.5
            return True
        if not searched(rows, at, lane, quantities, search):
            over = rows[at[TIME], lane] >= rows[at[END], lane]
            rows[at[PHASE], lane] = ARRIVED if over else PREPARE
    if (
        rows[at[PHASE], lane] == PREPARE
        and rows[at[STEPS], lane] + rows[at[REJECTED], lane] >= limit
    ):
        rows[at[STATUS], lane] = status.TOO_MANY_STEPS
        rows[at[PHASE], lane] = ARRIVED
    if rows[at[PHASE], lane] == ARRIVED:
        return arrive(rows, at, lane, quantities, span, energies, begun, extremes, search)
    return True


def run(
    pieces,
    at,
    rows,
    data,
    blank,
    where,
    points,
    spans,
    given,
    waiting,
    quantities,
    gathered,
    energies,
    begun,
    extremes,
    results,
    tracks,
    searches,
    queue,
    side,
    common,
    means,
    calls,
    counts,
    limit,
):
    """Run the points that wait; returns how many.

    pieces: addresses; at: places of ROWS; rows: (rows, W), aligned; data: tables; blank: rows of a
    lane before its point; where, points: rows that a point sets, and its numbers (points, rows);
    spans: columns BEGIN to TURN; given: (numbers, samples) of each sample; waiting: places of the
    points; quantities: how many are located; gathered: rows kept; energies: places in the state
    kept at the begin of the window, in begun (points, energies); extremes: (points, turns,
    quantities); results: (points, gathered + 3) with status, steps and rejected ones; tracks:
    (points, outputs, samples); searches: (W, SEARCH_COLUMNS); queue: samples of each lane (W, room,
    2 + states); side: rows of samples, common: those that all samples of a run share; means: 1 for
    a sum, 0 for a largest value; calls: of each piece, then the lanes that were in each; counts:
    room for those in each phase; limit: of steps.
    """
    lanes, taken, alive = rows.shape[1], 0, 0
    address, table = rows.ctypes.data, data.ctypes.data
    for lane in range(lanes):
        first = waiting[min(lane, waiting.size - 1)]
        load(rows, at, lane, first, blank, where, points, spans, searches)
        if taken < waiting.size:
            taken, alive = taken + 1, alive + 1
        else:
            rows[at[PHASE], lane] = IDLE
    while alive > 0:
        piece = wanted(rows, at, counts)
        phase = piece + START
        calls[piece] += 1
        calls[PIECES + piece] += counts[phase]
        for lane in range(lanes):
            searches[lane, CALLED] = 1.0 if rows[at[PHASE], lane] == phase else 0.0
        call(pieces[piece], (address, table))
        if phase == ITERATE:  # a lane goes on with it, or to FINISH
            continue
        for lane in range(lanes):
            search = searches[lane]
            if search[CALLED] == 0.0:
                continue
            point = int(search[POINT])
            span = spans[point]
            while phase == LOOK and push(rows, at, lane, span, queue[lane], search):
                flush(
                    pieces[SAMPLE],
                    table,
                    rows,
                    at,
                    lane,
                    side,
                    common,
                    means,
                    span,
                    given,
                    queue[lane],
                    tracks[point],
                    search,
                )
            if after(
                rows,
                at,
                lane,
                piece,
                quantities,
                span,
                energies,
                begun[point],
                extremes[point],
                search,
                limit,
            ):
                continue
            flush(
                pieces[SAMPLE],
                table,
                rows,
                at,
                lane,
                side,
                common,
                means,
                span,
                given,
                queue[lane],
                tracks[point],
                search,
            )
            keep(rows, at, lane, gathered, results[point])
            rows[at[PHASE], lane] = IDLE
            alive -= 1
            if taken < waiting.size:
                load(rows, at, lane, waiting[taken], blank, where, points, spans, searches)
                taken, alive = taken + 1, alive + 1
    return taken


VECTOR, MATRIX, CUBE = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
INTEGERS = types.int64[::1]
SIGNATURE = types.int64(
    INTEGERS,
    INTEGERS,
    MATRIX,
    VECTOR,
    VECTOR,
    INTEGERS,
    MATRIX,
    MATRIX,
    MATRIX,
    INTEGERS,
    types.int64,
    INTEGERS,
    INTEGERS,
    MATRIX,
    CUBE,
    MATRIX,
    CUBE,
    MATRIX,
    CUBE,
    MATRIX,
    INTEGERS,
    INTEGERS,
    INTEGERS,
    INTEGERS,
    types.int64,
)
SOURCE = hashlib.sha256(Path(__file__).read_bytes() + DIGEST.encode()).hexdigest()[:12]
run.__qualname__ = f"run_{SOURCE}"  # an edited source has a cache of its own
run = cached(run, SIGNATURE, SOURCE, nogil=True, **OPTIONS)
