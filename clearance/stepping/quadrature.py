"""Integrals over time of a run's outputs, summed over its steps: squares of forces and efforts, and
times in contact.

A column of `integrals` sums the square of a channel, of the length of a vector of two, or the time
in which a channel is above zero. Squares are observed where steps end. Over an interval goes
Newton's polynomial through the six places observed last, of any spacing,

    f_0 + f_01 (x - x_0) + f_012 (x - x_0) (x - x_1) + ...,    f_01, f_012: divided differences.

Its highest term is the error without the oldest place. Where that is too large, the inner places of
Lobatto's rule are observed as well. So they are in the first interval of a phase: no polynomial
reaches across a contact. Each part of the run has sums of its own, in `totals`.
"""

import numpy as np

from clearance.stepping.state import (
    DIFFERENCE,
    FORM,
    INVERSE,
    MOMENT,
    NODES,
    PAIR,
    PLACE,
    SOURCE,
    SUM,
    SUMMAND,
    TOUCHED,
    interpolate,
    observe_inside,
)
from clearance.stepping.types import inline, shared

SLIVER = 1e-9  # of a step: an end of a part so near to that of an interval is the same
HALVINGS = 20  # of the piece of a step in which a contact begins or ends
FAR = 1e20  # before the run, where no place has been observed yet [s]
MOST = 3  # inner places
LAST = 5  # of the columns of contacts: the end of the interval; the begin is the first
#: share of the highest term that each inner place leaves: error constants are 1.4e-2, 2e-4, 7e-7
LEFT = 1.0 / 32.0
#: inner places of Lobatto's rules, in a unit interval: one, two, three
INNER = np.array(
    [
        [0.5, 0.0, 0.0],
        [0.5 - 0.05**0.5, 0.5 + 0.05**0.5, 0.0],
        [0.5 - (3.0 / 28.0) ** 0.5, 0.5, 0.5 + (3.0 / 28.0) ** 0.5],
    ]
)
#: Gauss's rule with three places, exact for the polynomials here: the outer ones, and the weights
GAUSS, OUTER, CENTRAL = 0.6**0.5, 5.0 / 9.0, 8.0 / 9.0


# --- squares
@inline
def square(s, row, k):
    """Square of a channel in a row of outputs, or of the length of a vector."""
    source = int(s.integrals[SOURCE, k])
    value, second = row[source], 0.0
    if s.integrals[FORM, k] == PAIR:
        second = row[source + 1]
    return value * value + second * second


@inline
def take(s, row, at):
    """Take in the squares in a row of outputs; at: place, from the end of the interval [s]."""
    for j in range(NODES - 1):
        s.nodes[INVERSE, j] = 1.0 / (at - s.nodes[PLACE, j])
    for j in range(NODES - 2, 0, -1):
        s.nodes[PLACE, j] = s.nodes[PLACE, j - 1]
    s.nodes[PLACE, 0] = at
    for k in range(s.squares):
        fresh = square(s, row, k)
        for j in range(NODES - 1):
            before = s.integrals[DIFFERENCE + j, k]
            s.integrals[DIFFERENCE + j, k] = fresh
            fresh = (fresh - before) * s.nodes[INVERSE, j]
        s.integrals[DIFFERENCE + NODES - 1, k] = fresh


@inline
def weigh(s, begin, end):
    """Integrals of the products of Newton's polynomial, by Gauss's rule."""
    middle = 0.5 * (begin + end)
    half = 0.5 * (end - begin)
    first = half * OUTER
    second = half * CENTRAL
    third = half * OUTER
    for j in range(NODES - 1):
        s.nodes[MOMENT, j] = first + second + third
        node = s.nodes[PLACE, j]
        first *= middle - half * GAUSS - node
        second *= middle - node
        third *= middle + half * GAUSS - node
    s.nodes[MOMENT, NODES - 1] = first + second + third


@inline
def integrate(s, begin, end):
    """Integrals of the squares between two places, into their row."""
    weigh(s, begin, end)
    for k in range(s.squares):
        s.integrals[SUMMAND, k] = s.nodes[MOMENT, 0] * s.integrals[DIFFERENCE, k]
    for j in range(1, NODES):
        for k in range(s.squares):
            s.integrals[SUMMAND, k] += s.nodes[MOMENT, j] * s.integrals[DIFFERENCE + j, k]


@inline
def excess(s, share):
    """The largest of the highest terms of these integrals, over its limit.

    share: of the time so far that the interval takes.
    """
    largest = 0.0
    limit = s.limit * share
    moment = s.nodes[MOMENT, NODES - 1]
    for k in range(s.squares):
        term = abs(moment * s.integrals[DIFFERENCE + NODES - 1, k])
        allowed = limit * (s.integrals[SUM, k] + abs(s.integrals[SUMMAND, k]))
        if term > largest * allowed:
            largest = term / allowed
    return largest


@inline
def add(s):
    """Add the integrals to the sums."""
    for k in range(s.squares):
        s.totals[s.parts, k] += s.integrals[SUMMAND, k]
        s.integrals[SUM, k] += s.integrals[SUMMAND, k]


# --- times in contact
@inline
def note(s, row, column):
    """Contacts in a row of outputs, 1 where there is one, into a column of this interval."""
    for k in range(s.squares, s.grown):
        source = int(s.integrals[SOURCE, k])
        s.integrals[TOUCHED + column, k] = 1.0 if row[source] > 0.0 else 0.0


@shared
def changing(s, t, h, k, low, high, at_low):
    """Place in the last step where a contact begins or ends."""
    source = int(s.integrals[SOURCE, k])
    interpolate(s, t, h)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        observe_inside(s, t, h, middle)
        if (s.look[source] > 0.0) == (at_low > 0.0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@shared
def add_time(s, k, begin, end):
    """Add a time in contact, part by part of the run."""
    part = s.parts
    while part < s.totals.shape[0] - 1 and s.ends[part] < end:
        s.totals[part, k] += max(s.ends[part] - begin, 0.0)
        begin = max(begin, s.ends[part])
        part += 1
    s.totals[part, k] += end - begin


@shared
def add_times(s, t, h, low, high, inner):
    """Add the times in contact in the last interval: at most one change between two places."""
    for k in range(s.squares, s.grown):
        s.integrals[TOUCHED + inner + 1, k] = s.integrals[TOUCHED + LAST, k]
        for i in range(inner + 1):
            before = s.integrals[TOUCHED + i, k]
            after = s.integrals[TOUCHED + i + 1, k]
            begin = low if i == 0 else low + (high - low) * INNER[inner - 1, i - 1]
            end = high if i == inner else low + (high - low) * INNER[inner - 1, i]
            if before != after:
                theta = changing(s, t, h, k, begin, end, before)
                begin, end = (begin, theta) if before > 0.0 else (theta, end)
            if before + after > 0.0:
                add_time(s, k, t + begin * h, t + end * h)
        s.integrals[TOUCHED, k] = s.integrals[TOUCHED + LAST, k]


# --- turns that end between samples
@shared
def grow(s, row):
    """Growths of sums in this part of the run, from a row of outputs."""
    for k in range(s.grown, s.integrals.shape[1]):
        s.totals[s.parts, k] = row[int(s.integrals[SOURCE, k])] - s.integrals[SUM, k]


@shared
def end_turn(s, t, h, low, high):
    """Let a part of the run end where the drive has turned round in the last interval."""
    interpolate(s, t, h)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        observe_inside(s, t, h, middle)
        if s.look[s.counted] < s.turn:
            low = middle
        else:
            high = middle
    s.turn += 1.0
    end, k = t + high * h, s.ends.size - 1
    while k > s.parts and s.ends[k - 1] > end:
        s.ends[k] = s.ends[k - 1]
        k -= 1
    s.ends[k] = end


# --- intervals
@shared
def begin_integrals(s):
    """Begin a phase with the outputs in s.row: integrands may have jumped."""
    s.fresh = 1
    for j in range(NODES - 1):
        s.nodes[PLACE, j] = -FAR
    for j in range(NODES):
        for k in range(s.squares):
            s.integrals[DIFFERENCE + j, k] = 0.0
    take(s, s.row, 0.0)
    note(s, s.row, 0)


@inline
def end_interval(s, row, width):
    """Take in the outputs at the end of an interval; places are measured from there."""
    for j in range(NODES - 1):
        s.nodes[PLACE, j] -= width
    take(s, row, 0.0)
    note(s, row, LAST)


@shared
def look_inside(s, t, h, low, high, inner, seen):
    """Take in the inner places of the last interval; seen: outputs in its middle stand in
    s.look.
    """
    middle = inner // 2 if seen and inner % 2 == 1 else -1
    if middle >= 0:
        take(s, s.look, 0.5 * (low - high) * h)
        note(s, s.look, middle + 1)
    interpolate(s, t, h)
    for i in range(inner):
        if i != middle:
            theta = low + (high - low) * INNER[inner - 1, i]
            observe_inside(s, t, h, theta)
            take(s, s.look, (theta - high) * h)
            note(s, s.look, i + 1)


@shared
def add_interval(s, t, h, low, high, seen, turning):
    """Add the last interval, part by part of the run.

    seen: outputs in its middle stand in s.look. turning: contacts that set in gradually may begin
    and end within.
    """
    begin = (low - high) * h
    now = t + high * h
    inner = 1 if seen or turning else 0
    share = -begin / (now - s.begin)
    integrate(s, begin, 0.0)
    over = excess(s, share) * LEFT**inner
    while over > 1.0 and inner < MOST:
        inner, over = inner + 1, LEFT * over
    if s.fresh == 1 or (seen and inner == 2):
        inner, s.fresh = MOST, 0
    if inner > 0:
        look_inside(s, t, h, low, high, inner, seen)
        integrate(s, begin, 0.0)
    add_times(s, t, h, low, high, inner)
    done = begin
    while s.parts < s.totals.shape[0] - 1:
        end = s.ends[s.parts] - now
        if end > -SLIVER * h:
            break
        if end > done + SLIVER * h:
            integrate(s, done, end)
            add(s)
            done = end
        if s.integrals.shape[1] > s.grown:
            observe_inside(s, t, h, high + end / h)
            grow(s, s.look)
            for k in range(s.grown, s.integrals.shape[1]):
                s.integrals[SUM, k] += s.totals[s.parts, k]
        s.parts += 1
    if done > begin:
        integrate(s, done, 0.0)
    add(s)
