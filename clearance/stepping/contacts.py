"""Contacts: where one starts or ends inside a step, the step ends there.

A contact without a first touch has a kink there, which no step crosses: its error would hide
inside. Nothing else begins. The loop calls `meet` and `swap` by their addresses, and only where a
scene has contacts: others do not compile this module.
"""

import math

from clearance.stepping import control, status
from clearance.stepping.locating import FREE, contact_peak, touch
from clearance.stepping.state import (
    IMPACT_SPEED,
    KIND,
    SINCE,
    TOUCHING,
    attempt,
    copy,
    depth_of,
    evaluate,
    interpolate,
    invalidate,
    rate_of,
    state_at,
)
from clearance.stepping.types import STEP_SIGNATURE, compiled, inline, shared
from clearance.values.spots import CONTACT, FILM

PROBES = 8  # interior places where a step is searched for contact
SETTLED = 0.1  # of the dead band: a penetration that counts as none where a crossing is located
ALIGNMENTS = 60  # steps made to end one on an event, at most
RESOLVED = 1e-15  # share of the time below which two events are one


@shared
def probe(s, t, h, theta):
    """Penetration and its rate of every joint at theta of the last step, into
    s.inside.
    """
    evaluate(s, theta)
    s.events(t + theta * h, s.trial, s.par, s.work, s.inside)


@inline
def dead_band(s, joint):
    """Dead band: of a kink as much wider as coordinates are wound up, for these are rounded so."""
    return s.band[joint] * (1.0 if s.contacts[joint, KIND] == CONTACT else s.wound)


@shared
def wind(s):
    """Note how far coordinates are wound up."""
    s.wound = 1.0
    for i in range(s.coordinates):
        s.wound = max(s.wound, abs(s.y[i]) / (control.WOUND * s.scale[i]))


@inline
def beyond(s, joint):
    """Sign of the penetration of a joint behind its next start or end of contact."""
    touching = s.contacts[joint, TOUCHING] > 0.0
    gradual = s.contacts[joint, KIND] != CONTACT
    before = depth_of(s.before, joint), rate_of(s.before, joint)
    return control.beyond(touching, gradual, *before, dead_band(s, joint))


@shared
def summit(s, t, h, joint, low, high, wanted):
    """theta of the deepest (for `wanted` < 0: the shallowest) place between two probes, where the
    rate changes its sign.
    """
    for _ in range(50):
        middle = 0.5 * (low + high)
        probe(s, t, h, middle)
        if rate_of(s.inside, joint) * wanted > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@shared
def crossing(s, t, h, joint, ends, depths):
    """theta between two ends where the penetration of a joint changes its sign, by the Illinois
    method.

    depths: penetration at the ends, times the sign at the second. Intervals that begin with none
    are halved: their other end may be the one that counts.
    """
    (low, high), (at_low, at_high) = ends, depths
    wanted, side, band = beyond(s, joint), 0.0, dead_band(s, joint)
    for _ in range(60):
        if high - low < 1e-15:
            break
        theta = 0.5 * (low + high)
        if at_low < -band:
            theta = (low * at_high - high * at_low) / (at_high - at_low)
        probe(s, t, h, theta)
        value = depth_of(s.inside, joint) * wanted
        if abs(value) < SETTLED * band:
            return theta
        if value > 0.0:
            high, at_high = theta, value
            at_low *= 0.5 if side > 0.0 else 1.0
        else:
            low, at_low = theta, value
            at_high *= 0.5 if side < 0.0 else 1.0
        side = value
    return high


@shared
def near_contact(s, h):
    """True where a contact could start or end inside a step, from values and rates at its ends."""
    for j in range(s.contacts.shape[0]):
        if s.contacts[j, KIND] == FILM:
            continue
        wanted = beyond(s, j)
        before = rate_of(s.before, j)
        after = rate_of(s.after, j)
        deepest = max(wanted * depth_of(s.before, j), wanted * depth_of(s.after, j))
        turns = wanted * before > 0.0 > wanted * after
        if s.contacts[j, KIND] == CONTACT or turns:
            deepest += h * max(abs(before), abs(after))
        if deepest > dead_band(s, j):
            return True
    return False


@shared
def event_of(s, t, h, joint, low, high):
    """theta of the first start or end of one joint's contact between two probes, 2.0 if none.

    s.probed holds the values at low, s.ahead those at high. A touch that begins and ends between
    the probes shows by its rate changing sign.
    """
    wanted = beyond(s, joint)
    value, end = depth_of(s.ahead, joint) * wanted, high
    if (
        value <= dead_band(s, joint)
        and rate_of(s.probed, joint) * wanted > 0.0
        and rate_of(s.ahead, joint) * wanted < 0.0
    ):
        end = summit(s, t, h, joint, low, high, wanted)
        probe(s, t, h, end)
        value = depth_of(s.inside, joint) * wanted
    if value <= dead_band(s, joint):
        return 2.0
    return crossing(s, t, h, joint, (low, end), (depth_of(s.probed, joint) * wanted, value))


@shared
def first_event(s, t, h):
    """(joint, theta) of the first contact start or end inside the last step; joint -1 if there is
    none.
    """
    joints = s.contacts.shape[0]
    copy(s.before, s.probed)
    for p in range(PROBES):
        probe(s, t, h, (p + 1) / PROBES)
        copy(s.inside, s.ahead)
        best_joint, best = -1, 2.0
        for j in range(joints):
            if s.contacts[j, KIND] != FILM:
                theta = event_of(s, t, h, j, p / PROBES, (p + 1) / PROBES)
                if theta < best:
                    best_joint, best = j, theta
        if best_joint >= 0:
            return best_joint, best
        copy(s.ahead, s.probed)
    return -1, 2.0


@shared
def nudge(s, t, shift):
    """Move the end of the step by a time so short that the tangent is exact to rounding."""
    for i in range(s.y.size):
        s.y_new[i] += shift * s.f_new[i]
    s.rhs(t, s.y_new, s.par, s.work, s.f_new)
    s.evaluations += 1
    s.events(t, s.y_new, s.par, s.work, s.after)


@shared
def aligned(s, t, h, event, theta):
    """Make the step again so that it ends on the event.

    Returns (its status, its size, whether the event is at its end).

    The size is that of the step made last, moved by no more than `nudge` can: clock and state never
    part. Newton's method on the penetration at the end, or bisection where that leaves the bracket.
    A step that does not reach the event, as at a graze, ends without one.
    """
    wanted = beyond(s, event)
    size, low, high, passed = theta * h, 0.0, h, False
    last = value = 0.0
    for _ in range(ALIGNMENTS):
        invalidate(s)
        if size <= RESOLVED * max(abs(t), h):
            return status.AT_START, size, True
        if attempt(s, t, size) != status.MADE or s.error > 1.0:
            return status.MISSED, size, False
        last = size
        s.events(t + size, s.y_new, s.par, s.work, s.after)
        value = wanted * depth_of(s.after, event)
        rate = wanted * rate_of(s.after, event)
        if abs(value) <= 1e-2 * dead_band(s, event):
            return status.CUT, size, True
        if value > 0.0:
            high, passed = size, True
        else:
            low = size
        shift = -value / rate if rate > 0.0 else math.inf
        if abs(shift) < min(1e-6, 1e-3 * s.rtol) * size:
            nudge(s, t + size, shift)
            return status.CUT, size + shift, True
        if not low < size + shift < high:
            if not passed or high - low <= RESOLVED * max(abs(t), h):
                return status.CUT, size, value > 0.0
            shift = 0.5 * (low + high) - size
        size += shift
    return status.CUT, last, value > 0.0


@shared
def switch(s, joint, t, values):
    """Start or end the contact of a joint; `values` are the contact quantities at this moment."""
    contact = s.contacts[joint]
    if contact[TOUCHING] > 0.0:
        row = s.impacts[s.impacts_filled]
        row[0] = joint
        row[1] = contact[SINCE]
        row[2] = contact[IMPACT_SPEED]
        row[3], row[4] = contact_peak(s, joint, 0), contact_peak(s, joint, 1)
        row[5], row[6] = t - contact[SINCE], -rate_of(values, joint)
        s.impacts_filled += 1
        contact[TOUCHING], s.work[joint] = 0.0, FREE
    else:
        touch(s, joint, t, values)


@inline
def crosses(s, joint, values):
    """True where a contact starts or ends at this moment, within the dead band."""
    if s.contacts[joint, KIND] != CONTACT or abs(depth_of(values, joint)) > s.band[joint]:
        return False
    rate = rate_of(values, joint)
    return rate < 0.0 if s.contacts[joint, TOUCHING] > 0.0 else rate > 0.0


@compiled(STEP_SIGNATURE)
def meet(address, t, h):
    """Look for the first start or end of a contact inside the step just made: a status.

    Where there is one, the step is made again: `cut_h` is its size [s], `met` the spot whose first
    touch or last it ends on, or -1.
    """
    s = state_at(address)
    wind(s)
    if not near_contact(s, h):
        return status.NO_EVENT
    interpolate(s, t, h)
    event, theta = first_event(s, t, h)
    touches = event >= 0 and s.contacts[event, KIND] == CONTACT
    if event < 0 or not touches and theta * h <= RESOLVED * max(abs(t), h):
        return status.NO_EVENT
    outcome, s.cut_h, reached = aligned(s, t, h, event, theta)
    s.met = event if reached and touches else -1
    if outcome == status.AT_START and not touches:  # a shorter step ends before it
        s.cut_h = theta * h
        return status.MISSED
    return outcome


@compiled(STEP_SIGNATURE)
def swap(address, t, h):
    """Start or end the contact that was met, at time t.

    All others that cross their wall at this very moment switch with it: a level block touches with
    two corners.
    """
    s = state_at(address)
    switch(s, s.met, t, s.after)
    for j in range(s.contacts.shape[0]):
        if j != s.met and crosses(s, j, s.after):
            switch(s, j, t, s.after)
    return 0
