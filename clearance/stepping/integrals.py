"""Integrals over time of a run's outputs, summed over its steps: squares of forces and efforts, and
times in contact.

A row of `integrals` sums the square of a channel, of the length of a vector of two, or the time in
which a channel is above zero. An interval of a step is one panel, or several where the integrand
bends. Over a panel of width w goes Simpson's rule with the next term of its error,

    w (a + 4 m + b) / 6 - w^5 D / 120,

D: fourth divided difference of this panel and its neighbour, the mean of both sides. Contacts and
jumps of friction are ends of panels, and D does not reach across a contact. Each part of the run
has sums of its own, in `totals`; its end is the end of a panel.
"""

from clearance.stepping.state import (
    AFTER,
    BEFORE,
    ENDING,
    FIRST,
    FORM,
    INSIDE,
    PAIR,
    PENDING,
    SECOND,
    SOURCE,
    SUM,
    TARGET,
    observe_inside,
)
from clearance.stepping.types import inline, shared

SLIVER = 1e-9  # of a step: an end of a part so near to that of an interval is the same
HALVINGS = 20  # of half a panel in which a contact begins or ends
MOST = 8  # panels of an interval


@inline
def take(s, row, column):
    """Integrands in a row of outputs, into a column: squares, then 1 for channels above zero."""
    for k in range(s.squares):
        source = int(s.integrals[SOURCE, k])
        value, other = row[source], 0.0
        if s.integrals[FORM, k] == PAIR:
            other = row[source + 1]
        s.integrals[column, k] = value * value + other * other
    for k in range(s.squares, s.integrals.shape[1]):
        s.integrals[column, k] = 1.0 if row[int(s.integrals[SOURCE, k])] > 0.0 else 0.0


@inline
def shift(s, source, target):
    """Copy a row of integrands to another."""
    for k in range(s.integrals.shape[1]):
        s.integrals[target, k] = s.integrals[source, k]


# --- time in contact
@shared
def changing(s, t, h, k, low, high, at_low):
    """Place in the last step where a channel becomes positive, or ceases to be."""
    source = int(s.integrals[SOURCE, k])
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        observe_inside(s, t, h, middle)
        if (s.look[source] > 0.0) == (at_low > 0.0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@shared
def share_of_time(s, t, h, k, low, high):
    """Share of a panel in which a channel is positive; at most one change in each half."""
    middle, share = 0.5 * (low + high), 0.0
    before, inside, after = s.integrals[BEFORE, k], s.integrals[INSIDE, k], s.integrals[AFTER, k]
    for first, last, one, two in ((low, middle, before, inside), (middle, high, inside, after)):
        part = one
        if one != two:
            place = (changing(s, t, h, k, first, last, one) - first) / (last - first)
            part = one * place + two * (1.0 - place)
        share += 0.5 * part
    return share


# --- panels
@shared
def correct(s, width):
    """Take in the fourth divided differences of this panel and the one before: correct that by the
    mean of those at its sides, and note the correction of this one.
    """
    back, middle, part = s.panel, 0.5 * width, s.panel_part
    half, entire = 0.5 * back, back + width
    w0 = 1.0 / (half * back * (back + middle) * entire)
    w1 = -1.0 / (half * half * (half + middle) * (half + width))
    w2 = 1.0 / (back * half * middle * width)
    w3 = -1.0 / ((back + middle) * (half + middle) * middle * middle)
    w4 = 1.0 / (entire * (half + width) * width * middle)
    fresh = 0.5 if s.paired == 1 else 1.0
    behind, ahead = -fresh * back**5 / 120.0, -(width**5) / 120.0
    for k in range(s.squares):
        difference = w0 * s.integrals[FIRST, k] + w1 * s.integrals[SECOND, k]
        difference += w2 * s.integrals[BEFORE, k] + w3 * s.integrals[INSIDE, k]
        difference += w4 * s.integrals[AFTER, k]
        s.totals[part, k] += behind * difference + 0.5 * s.integrals[PENDING, k]
        s.integrals[PENDING, k] = ahead * difference
    s.paired = 1


@shared
def add_panel(s, t, h, low, high):
    """Add a panel between two places in the last step, whose integrands stand in their rows."""
    width = (high - low) * h
    if s.panel > 0.0:
        correct(s, width)
    for k in range(s.squares):
        amount = s.integrals[BEFORE, k] + 4.0 * s.integrals[INSIDE, k] + s.integrals[AFTER, k]
        amount *= width / 6.0
        s.totals[s.parts, k] += amount
        s.integrals[SUM, k] += amount
    for k in range(s.squares, s.integrals.shape[1]):
        s.totals[s.parts, k] += width * share_of_time(s, t, h, k, low, high)
    s.panel, s.panel_part = width, s.parts
    shift(s, BEFORE, FIRST)
    shift(s, INSIDE, SECOND)
    shift(s, AFTER, BEFORE)


@inline
def panels(s, t, h, low, high):
    """Number of panels of an interval: by how far its integrands bend away from their chords.

    The error of Simpson's rule for a cosine of size A that bends by c is c^2 / (45 A).
    """
    width, limit, excess, count = (high - low) * h, s.bend / (t + high * h - s.begin), 1.0, 1
    for k in range(s.squares):
        a, m, b = s.integrals[BEFORE, k], s.integrals[INSIDE, k], s.integrals[TARGET, k]
        bend, size = m - 0.5 * (a + b), max(a, m, b)
        scale = limit * size * (s.integrals[SUM, k] + width * size)
        if bend * bend > excess * scale:
            excess = bend * bend / scale
    while excess > 1.0 and count < MOST:
        excess *= 0.0625
        count *= 2
    return count


@shared
def add_interval(s, t, h, low, high):
    """Add an interval of the last step, as many panels as it needs."""
    count = panels(s, t, h, low, high)
    width = (high - low) / count
    for i in range(count):
        begin, end = low + i * width, high if i == count - 1 else low + (i + 1) * width
        if count > 1:
            observe_inside(s, t, h, 0.5 * (begin + end))
            take(s, s.look, INSIDE)
        if i < count - 1:
            observe_inside(s, t, h, end)
            take(s, s.look, AFTER)
        else:
            shift(s, TARGET, AFTER)
        add_panel(s, t, h, begin, end)


@shared
def integrate(s, t, h, low, high):
    """Add an interval of the last step, part by part of the run; s.look: outputs in its middle."""
    take(s, s.look, INSIDE)
    while s.parts < s.totals.shape[0] - 1:
        end = ((s.parts + 1) * s.part - t) / h
        if end > high - SLIVER:
            break
        if end > low + SLIVER:
            observe_inside(s, t, h, 0.5 * (low + end))
            take(s, s.look, INSIDE)
            observe_inside(s, t, h, end)
            take(s, s.look, TARGET)
            add_interval(s, t, h, low, end)
            low = end
            observe_inside(s, t, h, 0.5 * (low + high))
            take(s, s.look, INSIDE)
        s.parts += 1
    shift(s, ENDING, TARGET)
    add_interval(s, t, h, low, high)


@shared
def begin_panels(s):
    """Begin a phase with the outputs in s.row: integrands may have jumped."""
    for k in range(s.squares):
        s.totals[s.panel_part, k] += s.integrals[PENDING, k]
        s.integrals[PENDING, k] = 0.0
    take(s, s.row, BEFORE)
    s.panel, s.paired = 0.0, 0
