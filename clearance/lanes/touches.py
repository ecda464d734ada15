"""Contacts in lanes: where one starts or ends inside a step, the lane tries the step again, so that
it ends there.

The search is that of stepping/contacts.py, on the cubics between the places that
`probes.met_inside` looks at. The driver calls it by address: scenes without contacts do not
compile it.
"""

import math

from clearance.files.sealed import digest_of_code
from clearance.lanes import queue
from clearance.lanes.probes import PROBES
from clearance.lanes.queue import LANE_SIGNATURE, POINT, draw, lanes_at
from clearance.lanes.steps import ARRIVED, FINISH, START
from clearance.machine.store import OPTIONS, Entry
from clearance.stepping import control, status
from clearance.stepping.contacts import ALIGNMENTS, RESOLVED
from clearance.stepping.control import (
    CLEARLY,
    FLIP_LIMIT,
    after_kink,
    cubic,
    resolution,
    summit,
)
from clearance.stepping.locating import FREE
from clearance.stepping.types import DIGEST, Whole, inline, shared
from clearance.values.spots import CONTACT

HALVINGS = 60  # of the place where a cubic changes its sign
#: columns of `seeks`, a row for each lane
(
    SPOT,  # contact that the step is to end on
    SIGN,  # of its penetration beyond
    LOW,  # a size that ends before it
    HIGH,  # one that ends behind it
    PASSED,  # 1 once a step ended behind it
    TRIALS,
    PROPOSAL,  # size before the search
    MET,  # 1 where the step ends on it
    FLIPS,  # changes of contacts without an advance
    FRESH,  # 1 for the first step of a phase
    KEPT,  # first steps of phases without and with contact
) = range(11)


@inline
def touches(s, lane, k):
    """True where a contact with a first touch goes on."""
    return s.kinds[k] == CONTACT and s.rows[s.work_row + s.spots[k], lane] != FREE


@inline
def probed(s, lane, k, p):
    """Penetration and its rate at the begin of part p of the step."""
    first = s.begins_row + 2 * k
    if p == PROBES:
        first = s.ends_row + 2 * k
    elif p > 0:
        first = s.probes_row + 2 * ((p - 1) * s.kinds.size + k)
    return s.rows[first, lane], s.rows[first + 1, lane]


@inline
def beyond(s, lane, k):
    """Sign of a penetration behind the next start or end of its contact."""
    before = probed(s, lane, k, 0)
    return control.beyond(touches(s, lane, k), s.kinds[k] != CONTACT, *before, s.bands[k])


@shared
def crossing(low, high, length, sign, band):
    """Share of a part of a step where a penetration comes above the dead band, 2 if nowhere.

    low, high: penetrations and their rates at its ends, between which the cubic stands.
    """
    at_low, rise, value, fall = low[0] * sign, low[1] * sign, high[0] * sign, high[1] * sign
    (first, second, third), end = cubic(at_low, rise, value, fall, length), 1.0
    if value <= band and rise > 0.0 > fall:
        end, value = summit(at_low, first, second, third)
        end = min(end, 1.0)
    if value <= band:
        return 2.0
    begin = 0.0
    for _ in range(HALVINGS):
        x = 0.5 * (begin + end)
        if at_low + x * (first + x * (second + x * third)) > 0.0:
            end = x
        else:
            begin = x
    return end


@shared
def first_event(s, lane, h):
    """The first contact that starts or ends inside the step, and the share of the step; -1 if there
    is none.
    """
    for p in range(PROBES):
        best, first = -1, 2.0
        for k in range(s.kinds.size):
            low, high = probed(s, lane, k, p), probed(s, lane, k, p + 1)
            share = crossing(low, high, h / PROBES, beyond(s, lane, k), s.bands[k])
            if share < first:
                best, first = k, share
        if best >= 0:
            return best, (p + first) / PROBES
    return -1, 2.0


@shared
def note(s, lane, k, separation, over):
    """Keep a contact that ends, or that the end of the run cuts off."""
    row, spot = s.impacts[s.filled], s.spots[k]
    row[0], row[1], row[2] = s.progress[lane, POINT], spot, s.since[lane, k]
    row[3], row[4] = (
        s.rows[s.work_row + spot, lane],
        s.rows[s.t_row, lane] - s.since[lane, k],
    )
    row[5], row[6] = separation, over
    s.filled += 1


@shared
def remember(s, lane, k, speed):
    """Set the impact speed that a contact remembers, or that it is free."""
    row = s.work_row + s.spots[k]
    s.rows[row, lane] = speed
    for i in range(s.rows.shape[1]):
        s.sides[lane, row, i] = speed


@shared
def switch(s, lane, k):
    """Start or end a contact where the run stands."""
    rate = s.rows[s.begins_row + 2 * k + 1, lane]
    if touches(s, lane, k):
        note(s, lane, k, -rate, 1.0)
        remember(s, lane, k, FREE)
    else:
        s.since[lane, k] = s.rows[s.t_row, lane]
        remember(s, lane, k, max(rate, 0.0))


@shared
def change_phase(s, lane, met):
    """Switch the contact that was met; all others that cross their wall at this moment switch with
    it.
    """
    draw(s, lane)  # samples that wait belong to the phase before
    switch(s, lane, met)
    for k in range(s.kinds.size):
        depth, rate = (
            s.rows[s.begins_row + 2 * k, lane],
            s.rows[s.begins_row + 2 * k + 1, lane],
        )
        if k != met and s.kinds[k] == CONTACT and abs(depth) <= s.bands[k]:
            crosses = rate < 0.0 if touches(s, lane, k) else rate > 0.0
            if crosses:
                switch(s, lane, k)
    s.rows[s.phase_row, lane] = START


@inline
def kept(s, lane):
    """Column of the first step of the last phase like this one."""
    touching = 0
    for k in range(s.kinds.size):
        touching |= touches(s, lane, k)
    return KEPT + touching


def begin(address, lane):
    """The first step of a phase. At the start of the run contacts may exist: 1 where it
    begins once more with them.
    """
    s = lanes_at(address)
    seek, rows, first = s.seeks[lane], s.rows, False
    if seek[FRESH] == 0.0:
        for k in range(s.kinds.size):
            depth = rows[s.begins_row + 2 * k, lane]
            if s.kinds[k] == CONTACT and not touches(s, lane, k) and depth > 0.0:
                switch(s, lane, k)
                first = True
        if first:
            rows[s.phase_row, lane] = START
            return 1
    else:
        least = resolution(rows[s.t_row, lane], rows[s.end_row, lane])
        last = seek[kept(s, lane)]
        step = last if last > least else max(rows[s.step_row, lane], CLEARLY * least)
        rows[s.step_row, lane] = step
    seek[FRESH] = 1.0
    return 0


def aim(address, lane):
    """A contact starts or ends inside the step: have it tried again to end there."""
    s = lanes_at(address)
    seek, rows = s.seeks[lane], s.rows
    h, t = rows[s.h_row, lane], rows[s.t_row, lane]
    event, share = first_event(s, lane, h)
    seek[MET], seek[SPOT] = 0.0, event
    rows[s.aimed_row, lane] = 1.0
    if event < 0 or share * h <= RESOLVED * max(t, h):
        if event >= 0 and s.kinds[event] == CONTACT:  # it is where the step begins
            seek[FLIPS] += 1.0
            rows[s.aimed_row, lane] = 0.0
            change_phase(s, lane, event)
            if seek[FLIPS] > FLIP_LIMIT:
                rows[s.status_row, lane] = status.STEP_TOO_SMALL
                rows[s.phase_row, lane] = ARRIVED
        else:  # it is taken as it is
            seek[SPOT] = -1.0
            rows[s.phase_row, lane] = FINISH
        return 0
    seek[SIGN], seek[LOW], seek[HIGH], seek[PASSED] = beyond(s, lane, event), 0.0, h, 0.0
    seek[TRIALS], seek[PROPOSAL] = 0.0, h
    rows[s.h_row, lane] = share * h
    rows[s.phase_row, lane] = s.then
    return 0


def approach(address, lane):
    """A step that is to end on a contact was tried: it is taken, or tried with another size; see
    `aligned` of stepping/contacts.py.
    """
    s = lanes_at(address)
    seek, rows = s.seeks[lane], s.rows
    if seek[SPOT] < 0.0 or seek[TRIALS] < 0.0:
        return 0
    k, h, t = int(seek[SPOT]), rows[s.h_row, lane], rows[s.t_row, lane]
    end = s.ends_row + 2 * k
    value, rate = seek[SIGN] * rows[end, lane], seek[SIGN] * rows[end + 1, lane]
    seek[TRIALS] += 1.0
    shift = -value / rate if rate > 0.0 else math.inf
    near = abs(value) <= 1e-2 * s.bands[k]
    tiny = abs(shift) < min(1e-6, 1e-3 * rows[s.rtol_row, lane]) * h
    if near or tiny:
        if not near:
            nudge(s, lane, shift)
        seek[MET], seek[TRIALS] = 1.0, -1.0
        return 0
    if value > 0.0:
        seek[HIGH], seek[PASSED] = h, 1.0
    else:
        seek[LOW] = h
    closed = seek[HIGH] - seek[LOW] <= RESOLVED * max(t, h)
    if not seek[LOW] < h + shift < seek[HIGH]:
        shift = 0.5 * (seek[LOW] + seek[HIGH]) - h
        closed = closed or seek[PASSED] == 0.0
    else:
        closed = False
    if closed or seek[TRIALS] >= ALIGNMENTS:
        seek[MET], seek[TRIALS] = 1.0 if value > 0.0 else 0.0, -1.0
        return 0
    rows[s.h_row, lane] = h + shift
    rows[s.phase_row, lane] = s.then
    return 0


@inline
def nudge(s, lane, shift):
    """Move the end of the step by a time so short that the tangent is exact to rounding."""
    rows = s.rows
    for i in range(s.size):
        rows[s.new_row + i, lane] += shift * rows[s.slope_row + i, lane]
    for k in range(s.kinds.size):
        rows[s.ends_row + 2 * k, lane] += shift * rows[s.ends_row + 2 * k + 1, lane]
    rows[s.h_row, lane] += shift


def leave(address, lane):
    """After a step that is taken: contacts that it ends on, and the step after it."""
    s = lanes_at(address)
    seek, rows = s.seeks[lane], s.rows
    aimed = rows[s.aimed_row, lane] > 0.5 and seek[SPOT] >= 0.0
    seek[FLIPS], rows[s.aimed_row, lane] = 0.0, 0.0
    if seek[FRESH] == 1.0 and not aimed:
        seek[kept(s, lane)] = rows[s.last_h_row, lane]
    seek[FRESH] = 2.0
    if not aimed:
        return 0
    k = int(seek[SPOT])
    if seek[MET] == 1.0 and s.kinds[k] == CONTACT:
        change_phase(s, lane, k)
    else:
        clock = resolution(rows[s.t_row, lane], rows[s.end_row, lane])
        rows[s.step_row, lane] = after_kink(seek[PROPOSAL], clock)
    return 0


def close(address, lane):
    """At the end of a run: contacts that it cuts off."""
    s = lanes_at(address)
    for k in range(s.kinds.size):
        if touches(s, lane, k):
            note(s, lane, k, 0.0, 0.0)
    return 0


SOURCE = f"{digest_of_code(__file__, queue.__file__)} {DIGEST}"
FUNCTIONS = {
    f.__name__: Entry(f, LANE_SIGNATURE, SOURCE, pipeline_class=Whole, **OPTIONS)
    for f in (begin, aim, approach, leave, close)
}
