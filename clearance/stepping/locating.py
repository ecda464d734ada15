"""Extremes of a run's outputs, located on the dense output of its steps, and angles followed from
step to step.

A row of `peaks` follows one quantity, a channel or the length of a vector of two, times a sign. Its
largest value is always the target. Each step's end is one look. A step is looked into only
where its ends and the end before allow a larger value inside. The places are the middle, then the
summits of parabolas through three places ever closer to it. Rows of a joint belong to its contact
going on. The others begin anew with each stretch of the run, whose values and times go to `best`
and `when`. A step in which a joint's friction turns round is looked into piece by piece, between
rates around rest.
"""

import math

from clearance.stepping import control
from clearance.stepping.quadrature import (
    add_interval,
    begin_integrals,
    end_interval,
    end_turn,
    grow,
)
from clearance.stepping.state import (
    CHANNEL,
    EARLIER,
    FACTOR,
    FINE,
    FORM,
    FRICTION,
    IMPACT_SPEED,
    JOINT,
    LAST,
    MIDDLE,
    NEXT,
    PAIRED,
    PEAKS,
    POWER,
    RATE,
    SEARCHED,
    SIDE,
    SIGN,
    SINCE,
    TOUCHING,
    VALUE,
    WHEN,
    interpolate,
    observe_inside,
    rate_of,
)
from clearance.stepping.types import inline, shared

FREE = -1.0  # in the place of the impact speed: this joint is not in contact
ROUNDS = 3  # parabolas for one extreme, at most
CLOSER = 0.1  # half the width of a parabola over that of the one before
# share of a parabola's half width: a summit that moved by less since the one before stays
SETTLED = 0.03
REACH = 0.6  # of the interval: a first summit further than this from its middle is outside
EDGE = 1e-3  # of the interval: how near to its ends a summit is looked for
CLOSE = 0.1  # to rest, over the layer, a rate that counts as there
ROOTS = 12  # steps to the zero of a rate, at most
SLIVER = 1e-9  # of a step: parts of it that are not looked into


# --- angles
@inline
def unwind(s, row, ahead):
    """Make the angles of a row continuous: full turns by the mean of the rates here and at the
    last step's end.
    """
    for k in range(s.angles.shape[0]):
        angle = s.angles[k, 0]
        expected = s.turned[k, 0] + 0.5 * ahead * (s.turned[k, 1] + row[s.angles[k, 1]])
        row[angle] += 2.0 * math.pi * math.floor((expected - row[angle]) / (2.0 * math.pi) + 0.5)


@inline
def follow(s):
    """Take the angles of s.row as those of the last step's end."""
    for k in range(s.angles.shape[0]):
        s.turned[k, 0], s.turned[k, 1] = s.row[s.angles[k, 0]], s.row[s.angles[k, 1]]


# --- reversals of friction
@inline
def rubbing_rate(s, row, k):
    """Rate of a joint that rubs, from its power loss over its friction in a row of outputs."""
    friction = row[int(s.reversals[k, FRICTION])]
    return -row[int(s.reversals[k, POWER])] / friction if friction != 0.0 else 0.0


@inline
def note_rates(s):
    """Take the rates in s.row as those of the last step's end."""
    for k in range(s.reversals.shape[0]):
        s.reversals[k, RATE] = rubbing_rate(s, s.row, k)


@shared
def rate_inside(s, t, h, k, theta):
    """Rate of a joint that rubs at theta of the last step."""
    observe_inside(s, t, h, theta)
    return rubbing_rate(s, s.look, k)


@shared
def slowest(s, t, h, k, before, after):
    """Place in the last step where a rate is nearest to rest, and the rate there.

    The place is its zero by the Illinois method, or an end. before, after: rates at the ends.
    """
    if before * after >= 0.0:
        return (0.0, before) if abs(before) < abs(after) else (1.0, after)
    low, high, at_low, at_high, side = 0.0, 1.0, before, after, 0
    theta, rate = 0.0, before
    for _ in range(ROOTS):
        theta = (low * at_high - high * at_low) / (at_high - at_low)
        rate = rate_inside(s, t, h, k, theta)
        if abs(rate) < CLOSE * s.reversals[k, FINE]:
            break
        if rate * after > 0.0:
            high, at_high = theta, rate
            at_low *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            low, at_low = theta, rate
            at_high *= 0.5 if side < 0 else 1.0
            side = -1
    return theta, rate


@inline
def cut(s, count, theta):
    """Take in one place, in ascending order; how many there are then."""
    if not SLIVER < theta < 1.0 - SLIVER or count == s.cuts.size:
        return count
    k = count
    while k > 0 and s.cuts[k - 1] > theta:
        s.cuts[k] = s.cuts[k - 1]
        k -= 1
    s.cuts[k] = theta
    return count + 1


@shared
def reversals(s, t, h):
    """Places in the last step where friction turns round, into s.cuts; how many there are.

    They stand at rest and at rates of both signs, each so many times the one before. They need not
    be exact: the rate is taken to be straight around rest.
    """
    count = 0
    for k in range(s.reversals.shape[0]):
        before = s.reversals[k, RATE]
        after = rubbing_rate(s, s.row, k)
        s.reversals[k, RATE] = after
        fine = s.reversals[k, FINE]
        factor = s.reversals[k, FACTOR]
        reach = fine * factor ** (SIDE - 1)
        passes = before * after <= 0.0 or min(abs(before), abs(after)) < reach
        if not passes or abs(after - before) < fine:
            continue
        interpolate(s, t, h)
        theta, rate = slowest(s, t, h, k, before, after)
        aside = min(max(fine / abs(after - before), SLIVER), 0.5)
        aside = -aside if theta > 0.5 else aside
        slope = (rate_inside(s, t, h, k, theta + aside) - rate) / aside
        if slope == 0.0:
            continue
        count = cut(s, count, theta - rate / slope)
        wanted = fine
        for _ in range(SIDE):
            count = cut(s, count, theta + (wanted - rate) / slope)
            count = cut(s, count, theta - (wanted + rate) / slope)
            wanted *= factor
    return count


# --- one quantity
@inline
def quantity(s, row, k):
    """Value of a row of peaks in a row of outputs, times its sign."""
    channel = int(s.peaks[k, CHANNEL])
    value = row[channel]
    if s.peaks[k, PAIRED] > 0.0:
        value = math.sqrt(value * value + row[channel + 1] * row[channel + 1])
    return s.peaks[k, SIGN] * value


@inline
def asleep(s, k):
    """Rows of a contact are followed while it lasts."""
    joint = int(s.peaks[k, JOINT])
    return joint >= 0 and s.contacts[joint, TOUCHING] == 0.0


@inline
def offer(s, k, value, time):
    if s.peaks[k, VALUE] < value < math.inf:  # some outputs have no value at a dead centre
        s.peaks[k, VALUE], s.peaks[k, WHEN] = value, time


@shared
def seen_inside(s, t, h, k, theta):
    """Value of a row of peaks at theta of the last step, taken in."""
    observe_inside(s, t, h, theta)
    value = quantity(s, s.look, k)
    offer(s, k, value, t + theta * h)
    return value


@inline
def may_peak(s, k, per_width, per_back, curving):
    """A larger value may lie inside an interval, see `control.may_peak`.

    In the first interval of a phase only the values at its ends show it; a contact may be over
    within that.

    per_width, per_back: 1 over the lengths of both intervals, the second 0 in the first interval;
    curving: their share of the change, 4 width / (width + back).
    """
    last, now = s.peaks[k, LAST], s.peaks[k, NEXT]
    if per_back == 0.0:
        return s.peaks[k, JOINT] >= 0.0 or max(last, now) + abs(now - last) > s.peaks[k, VALUE]
    slope = (now - last) * per_width
    before = (last - s.peaks[k, EARLIER]) * per_back
    return control.may_peak(last, now, s.peaks[k, VALUE], slope, per_width, before, curving)


@inline
def may_turn(s, per_width, per_back, curving):
    """The gap of a joint whose contact sets in gradually may have an extreme in an interval, or is
    no output.
    """
    for i in range(s.squares, s.grown):
        k = int(s.integrals[FORM, i])
        if k < 0:
            return True
        slope = (s.peaks[k, NEXT] - s.peaks[k, LAST]) * per_width
        back = (s.peaks[k, LAST] - s.peaks[k, EARLIER]) * per_back
        if abs(slope) <= curving * abs(slope - back):
            return True
    return False


@inline
def parabola(a, b, c, values):
    """Slope of the chord from a to b, and half the second derivative, of the parabola through three
    places.
    """
    slope = (values[1] - values[0]) / (b - a)
    return slope, ((values[2] - values[1]) / (c - b) - slope) / (c - a)


@shared
def refine(s, t, h, k, low, high):
    """Largest value inside [low, high] of a step: summits of parabolas through three places ever
    closer to it.
    """
    width = high - low
    a, b, c = low, low + 0.5 * width, high
    at_a = s.peaks[k, LAST]
    at_b = s.peaks[k, MIDDLE]
    at_c = s.peaks[k, NEXT]
    offer(s, k, at_b, t + b * h)
    span, ends = width, max(at_a, at_c)
    for n in range(ROUNDS):
        slope, bend = parabola(a, b, c, (at_a, at_b, at_c))
        if not bend < 0.0:
            return
        summit = 0.5 * (a + b) - 0.5 * slope / bend
        if n == 0:
            rise = at_a + (summit - a) * (slope + bend * (summit - b)) - ends
            if abs(summit - b) > REACH * width or not ends + 2.0 * rise > s.peaks[k, VALUE]:
                return
        summit = min(max(summit, low + EDGE * width), high - EDGE * width)
        value = seen_inside(s, t, h, k, summit)
        if n == ROUNDS - 1 or (n > 0 and abs(summit - b) < SETTLED * span):
            return
        span *= CLOSER
        a = max(low, summit - span)
        b = summit
        c = min(high, summit + span)
        at_a, at_b = seen_inside(s, t, h, k, a), value
        at_c = seen_inside(s, t, h, k, c)


# --- looks
@shared
def look_into(s, t, h, low, high, row):
    """Extremes and integrals between low and high of the last step; row: outputs at high."""
    width = (high - low) * h
    back = s.interval
    searched = False
    if s.integrals.shape[1] > 0:
        end_interval(s, row, width)
        if s.counted >= 0 and row[s.counted] >= s.turn:
            end_turn(s, t, h, low, high)
    per_width = 1.0 / width
    per_back = 1.0 / back if back > 0.0 else 0.0
    curving = 4.0 * width / (width + back)
    for k in range(s.peaks.shape[0]):
        s.peaks[k, NEXT] = quantity(s, row, k)
        s.peaks[k, SEARCHED] = 0.0
        if asleep(s, k):
            continue
        offer(s, k, s.peaks[k, NEXT], t + high * h)
        if may_peak(s, k, per_width, per_back, curving):
            s.peaks[k, SEARCHED], searched = 1.0, True
    if searched:
        interpolate(s, t, h)
        observe_inside(s, t, h, 0.5 * (low + high))
        for k in range(s.peaks.shape[0]):
            s.peaks[k, MIDDLE] = quantity(s, s.look, k)
    if s.integrals.shape[1] > 0:
        turning = may_turn(s, per_width, per_back, curving)
        add_interval(s, t, h, low, high, searched, turning)
        grow(s, row)
    if searched:
        for k in range(s.peaks.shape[0]):
            if s.peaks[k, SEARCHED] > 0.0:
                refine(s, t, h, k, low, high)
    for k in range(s.peaks.shape[0]):
        s.peaks[k, EARLIER], s.peaks[k, LAST] = s.peaks[k, LAST], s.peaks[k, NEXT]
    s.interval = width


@shared
def look_along(s, t, h, low, high, count):
    """Extremes from one place in the last step to the last reversal before another, which it
    returns.
    """
    for k in range(count):
        theta = s.cuts[k]
        if low + SLIVER < theta < high - SLIVER:
            observe_inside(s, t, h, theta)
            look_into(s, t, h, low, theta, s.look)
            low = theta
    return low


@shared
def end_stretch(s, time):
    """Keep the extremes of a stretch; the next begins with the values at its end."""
    for k in range(s.peaks.shape[0]):
        if s.peaks[k, JOINT] < 0.0:
            s.best[s.stretches, k], s.when[s.stretches, k] = s.peaks[k, VALUE], s.peaks[k, WHEN]
            s.peaks[k, VALUE] = s.peaks[k, LAST]
            s.peaks[k, WHEN] = time
    s.stretches += 1


@shared
def look_again(s, t):
    """Outputs where a phase begins: values may have jumped, slopes have."""
    s.observe(t, s.y, s.par, s.work, s.row)
    unwind(s, s.row, 0.0)
    note_rates(s)
    for k in range(s.peaks.shape[0]):
        s.peaks[k, LAST] = quantity(s, s.row, k)
        if not asleep(s, k):
            offer(s, k, s.peaks[k, LAST], t)
    begin_integrals(s)
    s.interval = 0.0


@shared
def look(s, t, h):
    """Take in the step just made: its end into s.row, its extremes and integrals, stretch by
    stretch.
    """
    if s.interval < 0.0:
        look_again(s, t)
    s.observe(t + h, s.y_new, s.par, s.work, s.row)
    unwind(s, s.row, h)
    follow(s)
    low, count = 0.0, reversals(s, t, h)
    while s.stretches < s.best.shape[0] - 1:
        boundary = (s.stretches + 1) * s.stretch
        if boundary > t + h:
            break
        theta = (boundary - t) / h
        if theta > low + SLIVER:
            interpolate(s, t, h)
            low = look_along(s, t, h, low, theta, count)
            observe_inside(s, t, h, theta)
            look_into(s, t, h, low, theta, s.look)
            low = theta
        end_stretch(s, boundary)
    if low < 1.0 - SLIVER:
        low = look_along(s, t, h, low, 1.0, count)
        look_into(s, t, h, low, 1.0, s.row)


@shared
def begin_looking(s, t):
    """Outputs at the start of the run; angles there are the nearest to those that it goes on
    from.
    """
    s.observe(t, s.y, s.par, s.work, s.row)
    unwind(s, s.row, 0.0)
    follow(s)
    look_again(s, t)


# --- contacts
@shared
def contact_peak(s, joint, which):
    """Largest normal force (which = 0) or penetration (1) of the contact that ends; the next one
    begins with none.
    """
    row = int(s.contacts[joint, PEAKS])
    if row < 0:
        return 0.0
    value = s.peaks[row + which, VALUE]
    s.peaks[row + which, VALUE] = -math.inf
    return value


@shared
def touch(s, joint, t, values):
    """Start the contact of a joint; `values` are the contact quantities at this moment."""
    contact = s.contacts[joint]
    contact[TOUCHING], contact[SINCE] = 1.0, t
    contact[IMPACT_SPEED] = max(rate_of(values, joint), 0.0)
    s.work[joint] = contact[IMPACT_SPEED]
