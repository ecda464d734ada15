"""The driver of the lanes: takes points from a queue, calls the pieces, keeps results.

Every lane has its own time, step and phase; a piece changes the lanes that are in its phase. So a
run does not depend, bit for bit, on which others run beside it. Lanes iterate until enough of them
wait for the end of their step. Samples, and places inside a step in the search for extremes (see
stepping/locating.py), are evaluated several at a time. They are all of one run, in rows beside the
lanes.
"""

import math

import numpy as np

from clearance.files.sealed import digest_of_code
from clearance.lanes import steps
from clearance.lanes.steps import ARRIVED, FINISH, IDLE, ITERATE, PREPARE, START
from clearance.machine.numba_record import Record, reader
from clearance.machine.store import OPTIONS, Entry, entry_caller, types
from clearance.stepping import status
from clearance.stepping.locating import CLOSER, EDGE, FREE, REACH, ROUNDS, SETTLED, parabola
from clearance.stepping.types import DIGEST, INTEGERS, MATRIX, VECTOR, Whole, inline, int64, shared
from clearance.values.spots import CONTACT

#: pieces in the order of their addresses: one for each phase, those of samples and inner places.
#: The last two copy a step, to the place of a sample and to all places beside a lane
PIECES = ("start", "prepare", "iterate", "finish", "sample", "inside", "hold", "spread")
CALL_START, CALL_PREPARE, CALL_ITERATE, CALL_FINISH, CALL_SAMPLE, CALL_INSIDE, HOLD, SPREAD = range(
    len(PIECES)
)
NEVER = 1e300
STEPPED, TIMED = 2, 3  # in `means`
SAME = 1e-12  # share of the time within which two moments are one
#: places in a step beside its ends and middle; weights of all seven by Newton and Cotes
PLACES = (1.0 / 6.0, 1.0 / 3.0, 2.0 / 3.0, 5.0 / 6.0)
KNOTS = (1.0 / 6.0, 1.0 / 3.0, 0.5, 2.0 / 3.0, 5.0 / 6.0, 1.0)  # between which a flag changes once
FINE = 1e-5  # of a step, to which the change of a flag is located
ENDS, MIDDLE, OTHERS = 41.0 / 840.0, 272.0 / 840.0, (216.0 / 840.0, 27.0 / 840.0)
WAITING = 0.75  # share of the lanes that wait for the end of their step, when it is made

#: rows that the driver reads and sets; the place of each is a number of the driver, as `phase_row`
ROWS = (
    "phase status t end begun last_h steps rejected sample_time sample_theta share "
    "inner_time inner_theta within value last next between search found seen tracks sums "
    "summands at_begin at_middle at_end refine ideal sample_base y h step rtol work aimed "
    "event begins ends probes new slope"
)

#: columns of `spans`, a row for each point: begin of its window, end of its run [s]. Then time
#: between samples, their number, length and number of turns, and end of the window
BEGIN, UNTIL, EVERY, SAMPLES, TURN, RUN_TURNS, END = range(7)
#: columns of `progress`, a row for each lane: its point, turns made, the next sample and its time,
#: samples that wait, the phase in which it goes on
POINT, TURNS, SAMPLE, DUE, DRAWN, GOES_ON = range(6)
PROGRESS = 6
#: columns of `searches`, a row for each quantity: three places inside the step and the values
#: there. Then half the width, parabolas so far, the next place, and the best before the search
A, B, C, AT_A, AT_B, AT_C, WIDTH, ROUND, STAGE, BEST = range(10)
SEARCH_COLUMNS = 10
OVER, SUMMIT, LEFT, RIGHT = range(4)  # stages of a search
SEEKS = 12  # columns of `seeks`, see touches.py
#: columns of `impacts`: point, spot, begin, impact speed, duration, separation speed, 1 where it
#: is over
IMPACTS = 7


def layout(*, width: int, quantities: int, contacts: int) -> np.dtype:
    """Numbers of the driver, and arrays that it alone uses.

    held: rows of a step; then: phase in which a step begins; size: states and energies; filled:
    rows of `impacts`; begun: 1 once it has begun; pause: turns after which runs wait to go on.
    """
    numbers = ("held", "quantities", "active", "limit", "taken", "alive", "then", "size", "filled")
    numbers += ("begun", "pause", *(f"{name}_row" for name in ROWS.split()))
    arrays = [
        ("progress", float, (width, PROGRESS)),
        ("drawn", int, (width, width)),  # numbers of the samples that wait, by lane
        ("searches", float, (quantities, SEARCH_COLUMNS)),
        ("searched", int, (quantities,)),  # those that a search is about
        ("places", int, (width,)),  # quantities of the inner places that are looked at
        ("stages", int, (width,)),
        ("thetas", float, (width,)),  # shares of the step
        ("called", int, (width,)),
        ("seeks", float, (width, SEEKS)),
        ("since", float, (width, contacts)),  # begin of each contact
    ]
    return np.dtype([(name, int) for name in numbers] + arrays)


#: arrays that the driver is given.
#: pieces: addresses; rows: (rows, W); sides: rows beside each lane, for places
#: of its run (W, rows, W); data: tables; blank: rows of a lane before its point; where, points:
#: rows that a point sets, and its numbers (points, rows); common: rows that all places of a run
#: share; spans: columns BEGIN to END; ends: of the turns, where these are no TURN each (points,
#: turns), else empty; ideal: of each sample (points or 1, numbers, samples);
#: waiting: places of the points; gathered: rows stored; energies: places in the state, stored at
#: the end of each turn in ledgers (points, turns, energies); extremes: (points, turns, quantities);
#: totals: (points, turns, reductions), those over steps since the window's begin; results: (points,
#: gathered + 3) with status, steps and rejected ones; tracks: (points, outputs, samples); means: 2
#: for a sum over steps, 3 for the time of a flag, 1 for a sum over samples, 0 for a largest value;
#: inner: 1 for a quantity that is searched for inside steps. Of each contact: spots, its place
#: among all; kinds; bands: dead band [m]
CUBE = types.float64[:, :, ::1]
ARRAYS = {
    "pieces": INTEGERS,
    "rows": MATRIX,
    "sides": CUBE,
    "data": VECTOR,
    "blank": VECTOR,
    "where": INTEGERS,
    "points": MATRIX,
    "common": INTEGERS,
    "spans": MATRIX,
    "ends": MATRIX,
    "ideal": CUBE,
    "waiting": INTEGERS,
    "gathered": INTEGERS,
    "energies": INTEGERS,
    "ledgers": CUBE,
    "extremes": CUBE,
    "totals": CUBE,
    "results": MATRIX,
    "tracks": CUBE,
    "means": INTEGERS,
    "inner": INTEGERS,
    "spots": INTEGERS,
    "kinds": INTEGERS,
    "bands": VECTOR,
    "impacts": MATRIX,
}
LANE_SIGNATURE = int64(int64, int64)
#: of touches.py, called by their addresses
TOUCHES = ("begin", "aim", "approach", "leave", "close")
FUNCTIONS = dict.fromkeys(TOUCHES, types.FunctionType(LANE_SIGNATURE))
LANES = Record("of lanes", FUNCTIONS | ARRAYS, layout(width=1, quantities=1, contacts=1))
lanes_at = reader(LANES)
call_at = entry_caller(2)


@inline
def call(s, piece, rows):
    """Call a piece on some rows."""
    call_at(s.pieces[piece], (rows.ctypes.data, s.data.ctypes.data))


# --- runs
@inline
def sample_time(s, point, index):
    """Time of a sample of a run."""
    if index >= s.spans[point, SAMPLES] - 1.0:
        return s.spans[point, UNTIL] if index == s.spans[point, SAMPLES] - 1.0 else NEVER
    return index * s.spans[point, EVERY]


@inline
def end_of_turn(s, point, turn):
    """End of a turn of a run, the last that of the run."""
    if s.ends.shape[1] > 0:
        return s.ends[point, turn]
    if turn + 1.0 >= s.spans[point, RUN_TURNS]:
        return s.spans[point, UNTIL]
    return (turn + 1) * s.spans[point, TURN]


@shared
def load(s, lane, point):
    """Begin a point in a lane."""
    for i in range(s.rows.shape[0]):
        s.rows[i, lane] = s.blank[i]
    for i in range(s.where.size):
        s.rows[s.where[i], lane] = s.points[point, i]
    for k in range(s.kinds.size):
        if s.kinds[k] == CONTACT:
            s.rows[s.work_row + s.spots[k], lane] = FREE
    for i in range(SEEKS):
        s.seeks[lane, i] = 0.0
    for i in range(s.common.size):
        for k in range(s.rows.shape[1]):
            s.sides[lane, s.common[i], k] = s.rows[s.common[i], lane]
    for i in range(s.means.size):
        for k in range(s.rows.shape[1]):
            s.sides[lane, s.sums_row + i, k] = 0.0
    begin = s.spans[point, BEGIN]
    s.rows[s.phase_row, lane] = START
    s.rows[s.end_row, lane] = end_of_turn(s, point, 0)
    s.rows[s.within_row, lane] = 0.0 if begin > 0.0 else 1.0
    s.progress[lane, POINT], s.progress[lane, TURNS] = point, 0.0
    s.progress[lane, DRAWN] = 0.0
    index = math.ceil(begin * (1.0 - SAME) / s.spans[point, EVERY])
    s.progress[lane, SAMPLE], s.progress[lane, DUE] = index, sample_time(s, point, index)


@shared
def take(s, lane):
    """Begin the next point in a lane, where there is one."""
    s.rows[s.phase_row, lane] = IDLE
    if s.taken < s.waiting.size:
        load(s, lane, s.waiting[s.taken])
        s.taken += 1
        s.alive += 1


@shared
def keep(s, lane):
    """Keep the results of a run: chosen rows, status, steps."""
    point = int(s.progress[lane, POINT])
    if s.kinds.size > 0:
        s.close(s.address, lane)
    for i in range(s.gathered.size):
        s.results[point, i] = s.rows[s.gathered[i], lane]
    code, n = s.rows[s.status_row, lane], s.gathered.size
    s.results[point, n] = status.DONE if code == 0.0 else code
    s.results[point, n + 1] = s.rows[s.steps_row, lane]
    s.results[point, n + 2] = s.rows[s.rejected_row, lane]
    s.alive -= 1


@shared
def end_turn(s, lane, point, turn):
    """Keep extremes, sums and energies of a turn."""
    draw(s, lane)
    for k in range(s.quantities):
        s.extremes[point, turn, k] = s.rows[s.value_row + k, lane]
        s.rows[s.value_row + k, lane] = s.rows[s.next_row + k, lane]
    for k in range(s.energies.size):
        s.ledgers[point, turn, k] = s.rows[s.y_row + s.energies[k], lane]
    for i in range(s.means.size):
        total = s.rows[s.sums_row + i, lane]
        for k in range(s.rows.shape[1]) if s.means[i] < STEPPED else range(0):
            value = s.sides[lane, s.sums_row + i, k]
            total = total + value if s.means[i] else max(total, value)
            s.sides[lane, s.sums_row + i, k] = 0.0
        s.totals[point, turn, i] = total


@shared
def arrive(s, lane):
    """Take in the end of a turn: its extremes, and that the window begins; False where the run is
    over.
    """
    if s.rows[s.status_row, lane] != 0.0:
        return False
    point, turn = int(s.progress[lane, POINT]), int(s.progress[lane, TURNS])
    time = s.rows[s.t_row, lane]
    end_turn(s, lane, point, turn)
    if time >= s.spans[point, UNTIL]:
        return False
    if time >= s.spans[point, BEGIN] * (1.0 - SAME):
        s.rows[s.within_row, lane] = 1.0
    s.progress[lane, TURNS] = turn + 1.0
    s.rows[s.end_row, lane] = end_of_turn(s, point, turn + 1)
    s.rows[s.phase_row, lane] = s.then
    return True


# --- places inside a step
@inline
def copy_step(s, piece, lane, column):
    """Copy the step made last of a lane to a column of the rows beside it."""
    rows, side = s.rows.ctypes.data, s.sides[lane].ctypes.data
    call_at(s.pieces[piece], (rows + 8 * lane, side + 8 * column))


@shared
def draw(s, lane):
    """Outputs at the samples of a lane that wait."""
    count, point = int(s.progress[lane, DRAWN]), int(s.progress[lane, POINT])
    if count == 0:
        return
    side = s.sides[lane]
    for k in range(count, side.shape[1]):  # copies, which have no share
        side[s.share_row, k] = 0.0
        side[s.sample_time_row, k] = side[s.sample_time_row, 0]
        side[s.sample_theta_row, k] = side[s.sample_theta_row, 0]
        for i in range(s.held):
            side[s.sample_base_row + i, k] = side[s.sample_base_row + i, 0]
        for i in range(s.ideal.shape[1]):
            side[s.ideal_row + i, k] = side[s.ideal_row + i, 0]
    call(s, CALL_SAMPLE, side)
    for i in range(s.tracks.shape[1]):
        for k in range(count):
            s.tracks[point, i, s.drawn[lane, k]] = side[s.tracks_row + i, k]
    s.progress[lane, DRAWN] = 0.0


@shared
def hold(s, lane, time, theta, share, index):
    """Let a sample in the step made last wait for its outputs."""
    column, side = int(s.progress[lane, DRAWN]), s.sides[lane]
    copy_step(s, HOLD, lane, column)
    side[s.sample_theta_row, column], side[s.sample_time_row, column] = theta, time
    side[s.share_row, column] = share
    of = min(int(s.progress[lane, POINT]), s.ideal.shape[0] - 1)
    for i in range(s.ideal.shape[1]):
        side[s.ideal_row + i, column] = s.ideal[of, i, index]
    s.drawn[lane, column] = index
    s.progress[lane, DRAWN] = column + 1.0
    if column + 1 == side.shape[1]:
        draw(s, lane)


@inline
def share_of(s, point, due):
    """Share of the window that a sample stands for, the first and the last up to its ends; none
    behind it.
    """
    begin, end, every = s.spans[point, BEGIN], s.spans[point, END], s.spans[point, EVERY]
    if due > end * (1.0 + SAME):
        return 0.0
    low = due - 0.5 * every if due - every >= begin * (1.0 - SAME) else begin
    high = due + 0.5 * every if due + every <= end * (1.0 + SAME) else end
    return (high - low) / (end - begin)


@shared
def sample(s, lane):
    """Take the samples of the step made last."""
    time = s.rows[s.t_row, lane]
    if s.progress[lane, DUE] > time:
        return
    h, begun = s.rows[s.last_h_row, lane], s.rows[s.begun_row, lane]
    point = int(s.progress[lane, POINT])
    while s.progress[lane, DUE] <= time:
        due, index = s.progress[lane, DUE], int(s.progress[lane, SAMPLE])
        theta = min((due - begun) / h, 1.0) if h > 0.0 else 0.0
        hold(s, lane, due, theta, share_of(s, point, due), index)
        s.progress[lane, SAMPLE] = index + 1.0
        s.progress[lane, DUE] = sample_time(s, point, index + 1.0)


@inline
def look(s, lane, column, quantity, stage, theta):
    """Have a place inside the step made last looked at."""
    begun, h = s.rows[s.begun_row, lane], s.rows[s.last_h_row, lane]
    s.sides[lane, s.inner_theta_row, column] = theta
    s.sides[lane, s.inner_time_row, column] = begun + theta * h
    s.places[column], s.stages[column], s.thetas[column] = quantity, stage, theta


@shared
def see(s, lane, columns):
    """Outputs at the places of the search; the largest of each quantity stays."""
    side, rows = s.sides[lane], s.rows
    for k in range(columns, side.shape[1]):  # copies, which nobody reads
        side[s.inner_time_row, k] = side[s.inner_time_row, 0]
        side[s.inner_theta_row, k] = side[s.inner_theta_row, 0]
    call(s, CALL_INSIDE, side)
    seen, values = s.seen_row, s.value_row
    for i in range(s.quantities):
        if s.inner[i]:
            best = rows[values + i, lane]
            for k in range(columns):
                best = max(best, side[seen + i, k])
            rows[values + i, lane] = best


@shared
def summit(q):
    """Summit of the parabola through three places; -1 where there is nothing to find.

    What places of other quantities bring by chance is no reason to stop: it would be another one
    with another number of lanes.
    """
    slope, bend = parabola(q[A], q[B], q[C], (q[AT_A], q[AT_B], q[AT_C]))
    if not bend < 0.0:
        return -1.0
    top = 0.5 * (q[A] + q[B]) - 0.5 * slope / bend
    if q[ROUND] == 0.0:
        ends = max(q[AT_A], q[AT_C])
        rise = q[AT_A] + (top - q[A]) * (slope + bend * (top - q[B])) - ends
        if abs(top - q[B]) > REACH or not ends + 2.0 * rise > q[BEST]:
            return -1.0
    return min(max(top, EDGE), 1.0 - EDGE)


@shared
def go_on(q, stage, theta, value):
    """Go on with a search: the value at a place that was looked at is known."""
    if q[STAGE] == OVER:  # the sides of a summit that is near enough
        return
    if stage == LEFT:
        q[AT_A], q[STAGE] = value, RIGHT
    elif stage == RIGHT:
        q[AT_C], q[STAGE] = value, SUMMIT
    elif q[ROUND] > 0.0 and abs(theta - q[B]) < SETTLED * q[WIDTH]:
        q[STAGE] = OVER
    else:
        q[WIDTH] *= CLOSER
        q[A], q[B], q[C] = max(0.0, theta - q[WIDTH]), theta, min(1.0, theta + q[WIDTH])
        q[AT_B], q[ROUND] = value, q[ROUND] + 1.0
        q[STAGE] = LEFT if q[ROUND] < ROUNDS else OVER


@shared
def asked(s, lane):
    """Have the places looked at that searches wait for, as many as there are lanes; their
    number.
    """
    columns, width = 0, s.rows.shape[1]
    for index in range(s.active):
        i = s.searched[index]
        q = s.searches[i]
        if q[STAGE] == SUMMIT and columns < width:
            theta = summit(q)
            if theta < 0.0:
                q[STAGE] = OVER
                continue
            look(s, lane, columns, i, SUMMIT, theta)
            columns += 1
            if q[ROUND] + 1.0 < ROUNDS:  # its sides, where there is room
                half = CLOSER * q[WIDTH]
                if columns < width:
                    look(s, lane, columns, i, LEFT, max(0.0, theta - half))
                    columns += 1
                if columns < width:
                    look(s, lane, columns, i, RIGHT, min(1.0, theta + half))
                    columns += 1
        for stage, side in ((LEFT, A), (RIGHT, C)):
            if LEFT <= q[STAGE] <= stage and columns < width:
                look(s, lane, columns, i, stage, q[side])
                columns += 1
    return columns


@shared
def search(s, lane):
    """Locate extremes inside the step made last, whose middle is there."""
    s.active = 0
    for i in range(s.quantities):
        if s.rows[s.search_row + i, lane] > 0.5:
            q = s.searches[i]
            q[A], q[B], q[C], q[WIDTH], q[ROUND], q[STAGE] = 0.0, 0.5, 1.0, 1.0, 0.0, SUMMIT
            q[AT_A], q[AT_C] = s.rows[s.last_row + i, lane], s.rows[s.next_row + i, lane]
            q[AT_B], q[BEST] = s.rows[s.between_row + i, lane], s.rows[s.value_row + i, lane]
            s.searched[s.active] = i
            s.active += 1
    columns = asked(s, lane)
    if columns > 0:
        copy_step(s, SPREAD, lane, 0)
    while columns > 0:
        see(s, lane, columns)
        for k in range(columns):
            i = s.places[k]
            go_on(s.searches[i], s.stages[k], s.thetas[k], s.sides[lane, s.seen_row + i, k])
        columns = asked(s, lane)


@shared
def refine(s, lane):
    """Add the step made last to the sums over steps, by seven places."""
    rows, side, h, width = s.rows, s.sides[lane], s.rows[s.last_h_row, lane], s.rows.shape[1]
    copy_step(s, SPREAD, lane, 0)
    for i in range(s.means.size):
        if s.means[i] == STEPPED:
            ends = rows[s.at_begin_row + i, lane] + rows[s.at_end_row + i, lane]
            middle = rows[s.at_middle_row + i, lane]
            rows[s.sums_row + i, lane] += h * (ENDS * ends + MIDDLE * middle)
        elif s.means[i] == TIMED:
            add_time(s, lane, i)
    for first in range(0, len(PLACES), width):
        columns = min(width, len(PLACES) - first)
        for k in range(columns):
            look(s, lane, k, 0, SUMMIT, PLACES[first + k])
        see(s, lane, columns)
        for k in range(columns):
            weight = h * OTHERS[min(first + k, len(PLACES) - 1 - first - k)]
            for i in range(s.means.size):
                if s.means[i] == STEPPED:
                    rows[s.sums_row + i, lane] += weight * side[s.summands_row + i, k]


@shared
def switching(s, lane, i, flag, low, high):
    """Place between two in the step made last at which a flag changes from what it is at the
    first.
    """
    side, width = s.sides[lane], s.rows.shape[1]
    while high - low > FINE:
        step = (high - low) / (width + 1)
        for k in range(width):
            look(s, lane, k, 0, SUMMIT, low + (k + 1) * step)
        see(s, lane, width)
        same = 0
        while same < width and side[s.summands_row + i, same] == flag:
            same += 1
        low += same * step
        high = min(high, low + step)
    return 0.5 * (low + high)


@shared
def add_time(s, lane, i):
    """Add the time in the step made last in which a flag is set, from knot to knot."""
    rows, side = s.rows, s.sides[lane]
    before, after = rows[s.at_begin_row + i, lane], 0.0
    low, share = 0.0, 0.0
    for k in range(len(KNOTS)):
        high = KNOTS[k]
        if high < 1.0:
            look(s, lane, 0, 0, SUMMIT, high)
            see(s, lane, 1)
            after = side[s.summands_row + i, 0]
        else:
            after = rows[s.at_end_row + i, lane]
        middle = high
        if after != before:
            middle = switching(s, lane, i, before, low, high)
        share += (middle - low) * before + (high - middle) * after
        low, before = high, after
    rows[s.sums_row + i, lane] += rows[s.last_h_row, lane] * share


# --- the loop
@shared
def lead_on(s, lane):
    """After a step or the start: samples, extremes, the end of a turn or of the run, contacts."""
    sample(s, lane)
    if s.rows[s.refine_row, lane] > 0.5:
        refine(s, lane)
    if s.rows[s.found_row, lane] > 0.5:
        search(s, lane)
    trials = s.rows[s.steps_row, lane] + s.rows[s.rejected_row, lane]
    if s.rows[s.phase_row, lane] == s.then and trials >= s.limit:
        s.rows[s.status_row, lane] = status.TOO_MANY_STEPS
        s.rows[s.phase_row, lane] = ARRIVED
    if s.rows[s.phase_row, lane] == ARRIVED and not arrive(s, lane):
        keep(s, lane)
        take(s, lane)
    elif s.kinds.size > 0 and s.called[lane] == FINISH and s.rows[s.event_row, lane] == 0.0:
        s.leave(s.address, lane)
    if s.progress[lane, TURNS] >= s.pause and s.rows[s.phase_row, lane] != IDLE:
        s.progress[lane, GOES_ON] = s.rows[s.phase_row, lane]
        s.rows[s.phase_row, lane] = IDLE
        s.alive -= 1


@shared
def lead(s, lane):
    """After the start or the end of a step."""
    if s.kinds.size > 0 and s.rows[s.phase_row, lane] != ARRIVED:
        if s.called[lane] == START and s.begin(s.address, lane) == 1:
            return
        if s.called[lane] == FINISH and s.rows[s.event_row, lane] > 0.5:
            s.aim(s.address, lane)
            return
    lead_on(s, lane)


@shared
def give_up(s):
    """Take in the lanes whose step became too small."""
    for lane in range(s.rows.shape[1]):
        if s.rows[s.phase_row, lane] == ARRIVED:
            keep(s, lane)
            take(s, lane)


@shared
def begin_and_end(s):
    """Make the ends of the steps that wait for it, begin what is to begin, and the next steps."""
    beginning = ending = 0
    for lane in range(s.rows.shape[1]):
        phase = s.rows[s.phase_row, lane]
        beginning += phase == START
        ending += phase == FINISH
        s.called[lane] = int(phase) if phase in (START, FINISH) else IDLE
    if beginning > 0:
        call(s, CALL_START, s.rows)
    if ending > 0:
        call(s, CALL_FINISH, s.rows)
    for lane in range(s.rows.shape[1]):
        if s.called[lane] != IDLE:
            lead(s, lane)
    if s.then == PREPARE:
        call(s, CALL_PREPARE, s.rows)
    give_up(s)


@shared
def iterate(s):
    """An iteration, or a trial step, of all lanes that wait for one."""
    call(s, CALL_ITERATE, s.rows)
    for lane in range(s.rows.shape[1]) if s.kinds.size > 0 else range(0):
        if s.rows[s.phase_row, lane] == FINISH and s.rows[s.aimed_row, lane] > 0.5:
            s.approach(s.address, lane)
    if s.then == ITERATE:
        give_up(s)


def run(address):
    """Run the points that wait, of the record at an address, until they are over or pause, or
    `impacts` is full; returns how many go on.
    """
    s = lanes_at(address)
    width = s.rows.shape[1]
    for lane in range(width) if s.begun == 0 else range(0):
        load(s, lane, s.waiting[min(lane, s.waiting.size - 1)])  # idle lanes compute something, too
        take(s, lane)
    s.begun = 1
    while s.alive > 0:
        if s.impacts.shape[0] - s.filled < 2 * width * s.kinds.size:
            return s.alive
        iterating = 0
        for lane in range(width):
            if s.rows[s.phase_row, lane] == ITERATE:
                iterating += 1
        if iterating > 0 and s.alive - iterating < WAITING * s.alive:
            iterate(s)
        else:
            begin_and_end(s)
    return s.alive


SOURCE = f"{digest_of_code(__file__, steps.__file__)} {DIGEST}"
run = Entry(run, types.int64(types.int64), SOURCE, pipeline_class=Whole, **OPTIONS)
