"""The compiled time loop: step control, sampling; contact events stand in contacts.py.

Any stepper, any kernel, compiled once.

The loop runs until its step budget or a buffer is used up. It can be called again where it stopped,
because all its state lives in the arrays it is given. Contacts start and end exactly at step ends,
so that no step crosses the kink and the stepper keeps its order. The impact speed is frozen in
`work` when a contact with a first touch starts; others set in with short steps.
"""

import math

from clearance.stepping import status
from clearance.stepping.control import (
    CLEARLY,
    DOUBTED,
    FLIP_LIMIT,
    FORGET,
    NEWTON_FAILED,
    SHRINK,
    SQUEEZE,
    STIFF_ENOUGH,
    after_kink,
    factor,
    leaving,
    next_step,
    offset_size,
    rate_size,
    reduction,
    resolution,
    stiff_steps,
    within,
)
from clearance.stepping.locating import FREE, begin_looking, look, look_again, touch, unwind
from clearance.stepping.state import (
    CLEARANCE,
    COORDINATE,
    DAMPING,
    KIND,
    LOG_COLUMNS,
    PULL,
    RATE_X,
    TOUCHING,
    TRAIL_PLACES,
    attempt,
    copy,
    depth_of,
    interpolate,
    invalidate,
    state_at,
    state_inside,
)
from clearance.stepping.types import KERNEL, compiled, inline, int64, shared
from clearance.values.spots import BLENDED, CONTACT, FILM

GOOD_RATE = 0.2  # a rate of convergence that Newton's method should not exceed in the next step


# --- sampling
@inline
def next_sample(s):
    """Time of the next output row."""
    if s.sample == s.samples - 1:
        return s.finish
    return s.begin + s.sample * s.sample_every


@shared
def sample(s, t, h):
    """Observe at every grid time up to the end of the last step (h = 0: at the start); False if the
    buffer is full.
    """
    while s.sample < s.samples:
        at = next_sample(s)
        if at > t + h:
            return True
        if s.rows_filled == s.times.size:
            return False
        if h == 0.0:
            copy(s.y, s.trial)
        elif at == t + h:
            copy(s.y_new, s.trial)
        else:
            state_inside(s, t, h, (at - t) / h)
        row = s.rows[s.rows_filled]
        s.observe(at, s.trial, s.par, s.work, row)
        unwind(s, row, at - t)
        s.times[s.rows_filled] = at
        s.rows_filled += 1
        s.sample += 1
    return True


# --- step sizes
@shared
def weigh_films(s, values):
    """Natural sizes of the eccentricity of pure film joints and of its rate: less than usual where
    the film is thin. Of the rate in mixed joints too, once they have held up a run.

    rtol (size + |y|) is at most a share of the remaining film. A larger error could take the
    journal through the wall, or throw it back from it. That of the rate is at most this share of
    the film's closing speed under the mechanism's own acceleration, down to rounding. A larger
    error would turn approach into recession, in a whirl too, whose speed the film does not feel.
    Damping: the Jacobian's, remembered for a few steps, because a receding film has hardly any.
    """
    p, n, rtol = s.coordinates, s.states, s.rtol
    for j in range(s.contacts.shape[0]):
        contact = s.contacts[j]
        if contact[COORDINATE] < 0.0 or contact[PULL] == 0.0:
            continue
        first = int(contact[COORDINATE])
        gap = max(-depth_of(values, j), 1e-15 * contact[CLEARANCE])
        contact[DAMPING] *= FORGET
        for k in range(2):
            i = first + k
            if contact[KIND] == FILM:
                s.scale[i] = offset_size(contact[CLEARANCE], gap, s.y[i], rtol)
            contact[DAMPING] = max(contact[DAMPING], abs(s.jacobian_rows[(p + i) * n + p + i]))
        for k in range(2):
            i = p + first + k
            usual = contact[RATE_X + k]
            s.scale[i] = rate_size(usual, contact[PULL], contact[DAMPING], s.y[i], rtol)


@shared
def first_step(s, t):
    """A first step from the size of y, y' and y'' (Hairer, Norsett, Wanner 1993, section II.4)."""
    states, rtol = s.states, s.rtol
    size = rate = bend = 0.0
    for i in range(states):
        weight = rtol * (s.scale[i] + abs(s.y[i]))
        size += (s.scale[i] / weight) ** 2
        rate += (s.f[i] / weight) ** 2
    h = s.longest_step
    if rate > 0.0:
        h = min(h, 0.01 * math.sqrt(size / rate))
    for i in range(s.y.size):
        s.trial[i] = s.y[i] + h * s.f[i]
    s.rhs(t + h, s.trial, s.par, s.work, s.f_new)
    for i in range(states):
        bend += ((s.f_new[i] - s.f[i]) / (rtol * (s.scale[i] + abs(s.y[i])))) ** 2
    largest = max(math.sqrt(rate / max(states, 1)), math.sqrt(bend / max(states, 1)) / h)
    if largest > 0.0 and math.isfinite(largest):
        return min(100.0 * h, (0.01 / largest) ** (1.0 / (s.order + 1.0)), s.longest_step)
    return 1e-3 * h


@shared
def shrink(s, h, share, code):
    """Reject a step; the reason is stored for the message, should steps become too small."""
    s.rejected += 1
    s.last_refusal = code
    s.refusals += 1
    s.step_size = h * share


@shared
def refuse(s, t, h):
    """Reject a step whose error is too large. After a second rejection the order of its error is
    uncertain.

    Where a contact ends inside the step, the next one ends about there.
    """
    power = 1.0 / s.order if s.refusals == 0 else DOUBTED
    share = reduction(s.error, power)
    if in_contact(s):
        s.events(t, s.y, s.par, s.work, s.before)
        s.events(t + h, s.y_new, s.par, s.work, s.after)
        for j in range(s.contacts.shape[0]):
            if (
                s.contacts[j, TOUCHING] > 0.0
                and depth_of(s.after, j) < 0.0
                and depth_of(s.before, j) > 0.0
            ):
                share = leaving(share, depth_of(s.before, j), depth_of(s.after, j))
    shrink(s, h, share, status.TOO_LONG)


@shared
def grow(s, h):
    """The step after an accepted one, see `control.factor`."""
    error = max(s.error, 1e-10)
    refused = s.last_refusal != status.MADE
    value = factor(error, 1.0 / s.order, s.effort, h, s.last_step, s.last_error)
    clock = resolution(s.time, s.end)
    s.step_size = next_step(h, value, s.newton_rate, GOOD_RATE, refused, clock)
    s.last_refusal, s.refusals = status.MADE, 0
    s.last_step, s.last_error = h, max(error, 1e-2)


@inline
def stiff(s):
    """True where the method has been held up by stability for many steps; six milder ones in a row
    clear it.
    """
    s.stiff_steps, s.mild_steps = stiff_steps(s.stiffness, s.stiff_steps, s.mild_steps)
    return s.stiff_steps >= STIFF_ENOUGH


@shared
def begin_phase(s, t):
    """Rates, next step and outputs where a phase begins. The first step of the last such phase is
    none for this one where the clock was finer then.
    """
    s.started = 1
    s.rhs(t, s.y, s.par, s.work, s.f)
    last = s.contact_step if in_contact(s) else s.free_step
    least = resolution(t, s.end)
    s.step_size = last if last > least else max(first_step(s, t), CLEARLY * least)
    s.last_step = 0.0
    invalidate(s)
    if s.watched == 1:
        look_again(s, t)


@shared
def change_phase(s, t):
    """Switch the contact that was met and begin a phase, with the step that the last such phase
    began with, or a fresh first step.
    """
    s.swap(s.address, t, 0.0)
    begin_phase(s, t)


# --- the loop
@shared
def begin(s):
    """First evaluation, contacts that exist at the start, first output row, first step.

    A joint that is given in contact began it before, and remembers its impact speed.
    """
    t = s.time
    if s.contacts.shape[0] > 0:
        s.events(t, s.y, s.par, s.work, s.before)
        for j in range(s.contacts.shape[0]):
            if s.contacts[j, KIND] == CONTACT and s.contacts[j, TOUCHING] == 0.0:
                s.work[j] = FREE
                if depth_of(s.before, j) > 0.0:
                    touch(s, j, t, s.before)
        weigh_films(s, s.before)
    s.rhs(t, s.y, s.par, s.work, s.f)
    for i in range(s.f.size):
        if not math.isfinite(s.f[i]):
            return status.NOT_FINITE
    if s.watched == 1:
        begin_looking(s, t)
    sample(s, t, 0.0)
    s.step_size = first_step(s, t)
    s.started = 1
    return status.RUNNING


@inline
def in_contact(s):
    touching = 0.0
    for j in range(s.contacts.shape[0]):
        touching += s.contacts[j, TOUCHING]
    return touching > 0.0


@inline
def buffers_full(s):
    if s.log_filled == s.log.shape[0] or s.rows_filled == s.times.size:
        return True
    return s.impacts_filled + s.contacts.shape[0] > s.impacts.shape[0]


@shared
def follow(s, t, h):
    """Hand on what wears, at the start, middle and end of the step just made; zeros in free
    flight.
    """
    trail = s.trail[s.log_filled]
    touches = in_contact(s)
    for j in range(s.contacts.shape[0]):
        touches = touches or s.contacts[j, KIND] == BLENDED
    if touches:
        interpolate(s, t, h)
    for k in range(TRAIL_PLACES):
        if touches:
            state_inside(s, t, h, 0.5 * k)
            s.follow(t + 0.5 * k * h, s.trial, s.par, s.work, s.followed)
        for i in range(s.followed.size):
            trail[k, i] = s.followed[i] if touches else 0.0


@inline
def log_state(s, row, first):
    """The state, then what steps carry on, into the rest of a row of the log, if it has room."""
    carried = first + s.y.size
    for i in range(first, min(carried, row.size)):
        row[i] = s.y[i - first]
    for i in range(carried, row.size):
        row[i] = s.work[s.contacts.shape[0] + i - carried]


@shared
def accept(s, t, h, cut):
    """Take the step just made: sample, look for extremes, advance, log; `cut`: an event ended it.

    False if the output buffer is full (the step is made again).
    """
    if s.sample < s.samples and next_sample(s) <= t + h:
        interpolate(s, t, h)
    if not sample(s, t, h):
        return False
    # t + (end - t) may round to below the end: the rest would be a step that the clock has not
    s.time = s.end if h >= s.end - t or t + h >= s.end else t + h
    if s.watched == 1:
        look(s, t, h)
    # the first step of a phase: where the next such phase starts
    if s.last_step == 0.0 and not cut:
        if in_contact(s):
            s.contact_step = h
        else:
            s.free_step = h
    if s.followed.size > 0:
        follow(s, t, h)
    copy(s.y_new, s.y)
    copy(s.f_new, s.f)
    weigh_films(s, s.after)
    s.steps += 1
    s.flips = 0
    row = s.log[s.log_filled]
    row[0], row[1], row[2] = s.time, h, s.error
    for i in range(s.ledger.size):
        row[LOG_COLUMNS + i] = s.row[s.ledger[i]]
    log_state(s, row, LOG_COLUMNS + s.ledger.size)
    s.log_filled += 1
    if s.commits > 0:
        s.commit(s.time, s.y, s.par, s.work, s.work)
        if s.remembering > 0:  # what was remembered changed the film
            s.rhs(s.time, s.y, s.par, s.work, s.f)
    return True


@inline
def outside(s):
    """A joint whose journal has left its film with nothing to carry it, or come too near to the
    wall at once; or -1.

    The error of a step may exceed the film left: without the second a step could end anywhere next
    to the wall.
    """
    for j in range(s.contacts.shape[0]):
        if s.contacts[j, KIND] == FILM and depth_of(s.after, j) >= SQUEEZE * depth_of(s.before, j):
            return j
    return -1


@inline
def advance(s):
    """One trial step: rejected, or accepted up to its first contact event.

    Returns a status code.
    """
    t = s.time
    h = within(s.step_size, s.longest_step, s.end - t)
    if h <= resolution(t, s.end) and s.end - t > h:
        refusal = s.last_refusal
        if refusal == status.OUT_OF_FILM:
            return status.FILM_LEFT
        return status.NOT_FINITE if refusal == status.NO_NUMBERS else status.STEP_TOO_SMALL
    code = attempt(s, t, h)
    if code != status.MADE:
        shrink(s, h, NEWTON_FAILED, code)
        return status.RUNNING
    if s.error > 1.0:
        refuse(s, t, h)
        return status.RUNNING
    met, proposal = status.NO_EVENT, h
    if s.contacts.shape[0] > 0:
        s.events(t, s.y, s.par, s.work, s.before)
        s.events(t + h, s.y_new, s.par, s.work, s.after)
        s.failed_joint = outside(s)
        if s.failed_joint >= 0:
            invalidate(s)
            shrink(s, h, SHRINK, status.OUT_OF_FILM)
            return status.RUNNING
        if s.touchable > 0:
            met = s.meet(s.address, t, h)
    if met == status.MISSED:
        shrink(s, s.cut_h, 0.5, status.TOO_LONG)
        return status.RUNNING
    if met == status.AT_START:
        s.events(t, s.y, s.par, s.work, s.after)
        change_phase(s, t)
        s.flips += 1
        return status.STEP_TOO_SMALL if s.flips > FLIP_LIMIT else status.RUNNING
    cut = met == status.CUT
    if cut:
        h = s.cut_h
    if not accept(s, t, h, cut):
        invalidate(s)
        return status.RUNNING
    grow(s, h)
    if cut and s.met >= 0:
        change_phase(s, s.time)
    elif cut:
        s.step_size = after_kink(proposal, resolution(s.time, s.end))
    if stiff(s) and s.may_switch == 1:
        return status.STIFF
    return status.RUNNING


@compiled(KERNEL.signature, unrolled=False)
def copy_state(t, y, par, work, out):
    """Instead of an observe kernel: the state itself."""
    copy(y, out)


@compiled(int64(int64, int64), unrolled=False)
def run(address, budget):
    """Advance until done, failed, a buffer is full or `budget` trial steps are spent.

    Returns a status code.

    address: of the run's state, see state.words.
    """
    s = state_at(address)
    answer = status.RUNNING
    if s.started == 0:
        answer = begin(s)
    elif s.started == 2:
        begin_phase(s, s.time)
    for _ in range(budget):
        if answer != status.RUNNING or buffers_full(s):
            return answer
        if s.time >= s.end:
            return status.DONE
        if s.steps + s.rejected >= s.step_limit:
            return status.TOO_MANY_STEPS
        answer = advance(s)
    return answer
