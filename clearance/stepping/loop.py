"""The compiled time loop: step control, contact events, sampling. Any stepper, any kernel, compiled once.

The loop runs until its step budget or a buffer is used up and can be called again where it stopped; all its state lives
in the arrays it is given. Contacts start and end exactly at step ends, so that no step crosses the kink and the
stepper keeps its order; the impact speed is frozen in `work` when a contact starts.
"""

import math

from clearance.mechanism.store import KERNEL
from clearance.stepping import status
from clearance.stepping.types import (
    ERROR, HAS_PREDICTOR, INTEGERS, JACOBIAN_STATE, LAST_H, LU_STATE, MATRIX, ORDER, REJECTED, RTOL, STATES, STEP,
    STEP_SIGNATURE, STEPS, VECTOR, compiled, complex128, float64, inline, int64,
)  # fmt: skip

# entries of `clock`
TIME, STEP_SIZE, END, LARGEST, SAMPLE_EVERY, BEGIN, CONTACT_STEP, FREE_STEP, LAST_ERROR = range(9)
CLOCK_SIZE = 10
# entries of `place`
SAMPLE, SAMPLES, ROWS, LOGGED, EVENTS, STEP_LIMIT, STARTED, COMMITS, BEFORE_REJECTED, FAILED_JOINT, OBSERVES = range(11)
PLACE_SIZE = 12
# columns of `contacts`, the running record of each joint, and of `impacts`, the finished ones
TOUCHING, SINCE, IMPACT_SPEED, PENETRATION, PEAK_FORCE, IS_CONTACT = range(6)
CONTACT_COLUMNS = 6
IMPACT_COLUMNS = 7  # joint, time, impact speed, peak force, penetration, duration, separation speed
LOG_COLUMNS = 3  # time at the end, step, error over tolerance

PROBES = 8  # interior places where a step is searched for contact
BAND = 1e-13  # dead band of a touch, relative to the clearance
SAFETY, SHRINK, GROW = 0.9, 0.2, 5.0


@inline
def evaluate(dense, theta, y):
    """Dense output at theta in [0, 1]."""
    for i in range(y.size):
        value = 0.0
        for r in range(7, 0, -1):
            value += dense[r, i]
            value *= theta if r % 2 == 1 else 1.0 - theta
        y[i] = dense[0, i] + value


@inline
def probe(events, t, h, theta, dense, par, work, y, found):
    """Contact quantities at theta of the last step."""
    evaluate(dense, theta, y)
    events(t + theta * h, y, par, work, found)


@inline
def crossing(events, t, h, dense, par, work, y, found, joint, low, high, wanted):
    """theta between low and high where the penetration of a joint changes sign (wanted: sign at high)."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if high - low < 1e-15:
            break
        probe(events, t, h, middle, dense, par, work, y, found)
        if found[3 * joint] * wanted > 0.0:
            high = middle
        else:
            low = middle
    return high


@inline
def first_event(events, t, h, dense, par, work, contacts, band, y, before, found):
    """(joint, theta) of the first contact start or end inside the last step; joint -1 if none.

    A touch that begins and ends between two probes shows by the rate of penetration changing sign and is found too.
    """
    joints = contacts.shape[0]
    probe(events, t, h, 0.0, dense, par, work, y, before)
    low = 0.0
    for p in range(1, PROBES + 1):
        high = p / PROBES
        probe(events, t, h, high, dense, par, work, y, found)
        best_joint, best = -1, 2.0
        for j in range(joints):
            if contacts[j, IS_CONTACT] == 0.0:
                continue
            wanted = -1.0 if contacts[j, TOUCHING] > 0.0 else 1.0
            g, slope, old = found[3 * j], found[3 * j + 1], before[3 * j + 1]
            end = high
            if g * wanted <= band[j] and old * wanted > 0.0 and slope * wanted < 0.0:
                end = summit(events, t, h, dense, par, work, y, found, j, low, high, wanted)
                probe(events, t, h, end, dense, par, work, y, found)
                g = found[3 * j]
            if g * wanted > band[j]:
                theta = crossing(events, t, h, dense, par, work, y, found, j, low, end, wanted)
                if theta < best:
                    best_joint, best = j, theta
            probe(events, t, h, high, dense, par, work, y, found)
        if best_joint >= 0:
            return best_joint, best
        for i in range(3 * joints):
            before[i] = found[i]
        low = high
    return -1, 2.0


@inline
def summit(events, t, h, dense, par, work, y, found, joint, low, high, wanted):
    """theta of the deepest (or, for wanted < 0, the shallowest) place between two probes: the rate's sign change."""
    for _ in range(50):
        middle = 0.5 * (low + high)
        probe(events, t, h, middle, dense, par, work, y, found)
        if found[3 * joint + 1] * wanted > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@inline
def near_contact(before, after, h, contacts, band):
    """Whether any contact could start or end inside a step, from values and rates at its ends."""
    for j in range(contacts.shape[0]):
        if contacts[j, IS_CONTACT] == 0.0:
            continue
        if contacts[j, TOUCHING] > 0.0:
            return True
        reach = h * max(abs(before[3 * j + 1]), abs(after[3 * j + 1]))
        if max(before[3 * j], after[3 * j]) + reach > band[j]:
            return True
    return False


@inline
def track_peaks(events, t, h, dense, par, work, contacts, y, found):
    """Largest penetration and force of the contacts going on, refined between the probes."""
    for p in range(PROBES + 1):
        theta = p / PROBES
        probe(events, t, h, theta, dense, par, work, y, found)
        for j in range(contacts.shape[0]):
            if contacts[j, TOUCHING] == 0.0:
                continue
            for quantity, column in ((0, PENETRATION), (2, PEAK_FORCE)):
                if found[3 * j + quantity] > contacts[j, column]:
                    low, high = max(theta - 1.0 / PROBES, 0.0), min(theta + 1.0 / PROBES, 1.0)
                    for _ in range(40):
                        a, b = low + 0.381966 * (high - low), low + 0.618034 * (high - low)
                        probe(events, t, h, a, dense, par, work, y, found)
                        left = found[3 * j + quantity]
                        probe(events, t, h, b, dense, par, work, y, found)
                        if left > found[3 * j + quantity]:
                            high = b
                        else:
                            low = a
                        contacts[j, column] = max(contacts[j, column], left, found[3 * j + quantity])
                    probe(events, t, h, theta, dense, par, work, y, found)


@inline
def switch(joint, t, found, work, contacts, impacts, place):
    """Start or end the contact of a joint."""
    if contacts[joint, TOUCHING] > 0.0:
        row = impacts[place[EVENTS]]
        row[0], row[1], row[2] = joint, contacts[joint, SINCE], contacts[joint, IMPACT_SPEED]
        row[3], row[4] = contacts[joint, PEAK_FORCE], contacts[joint, PENETRATION]
        row[5], row[6] = t - contacts[joint, SINCE], -found[3 * joint + 1]
        place[EVENTS] += 1
        contacts[joint, TOUCHING] = 0.0
    else:
        contacts[joint, TOUCHING], contacts[joint, SINCE] = 1.0, t
        contacts[joint, IMPACT_SPEED] = max(found[3 * joint + 1], 0.0)
        contacts[joint, PENETRATION] = contacts[joint, PEAK_FORCE] = 0.0
        work[joint] = contacts[joint, IMPACT_SPEED]


@inline
def sample(observe, t, h, whole, dense, y_new, par, work, clock, place, y, times, rows):
    """Observe at every grid time up to the end of the last step; False if the buffer is full."""
    while place[SAMPLE] < place[SAMPLES]:
        at = clock[BEGIN] + place[SAMPLE] * clock[SAMPLE_EVERY]
        if place[SAMPLE] == place[SAMPLES] - 1:
            at = clock[END]
        if at > t + h:
            return True
        if place[ROWS] == times.size:
            return False
        if whole or at == t + h:
            for i in range(y.size):
                y[i] = y_new[i]
        else:
            evaluate(dense, (at - t) / h, y)
        observe(at, y, par, work, rows[place[ROWS]])
        times[place[ROWS]] = at
        place[ROWS] += 1
        place[SAMPLE] += 1
    return True


@inline
def invalidate(control, counts):
    """Forget what a method kept from earlier steps."""
    counts[JACOBIAN_STATE] = counts[LU_STATE] = counts[HAS_PREDICTOR] = 0
    control[LAST_H] = 0.0


@inline
def first_step(rhs, t, y, f, par, work, scale, control, counts, clock, trial, slope):
    """A first step from the size of y, y' and y'' (Hairer, Norsett, Wanner 1993, section II.4)."""
    states = counts[STATES]
    size, rate = 0.0, 0.0
    for i in range(states):
        weight = control[RTOL] * (scale[i] + abs(y[i]))
        size += (scale[i] / weight) ** 2
        rate += (f[i] / weight) ** 2
    h = clock[LARGEST]
    if rate > 0.0:
        h = min(h, 0.01 * math.sqrt(size / rate))
    for i in range(y.size):
        trial[i] = y[i] + h * f[i]
    rhs(t + h, trial, par, work, slope)
    bend = 0.0
    for i in range(states):
        bend += ((slope[i] - f[i]) / (control[RTOL] * (scale[i] + abs(y[i])))) ** 2
    largest = max(math.sqrt(rate / max(states, 1)), math.sqrt(bend / max(states, 1)) / h)
    if largest > 0.0 and math.isfinite(largest):
        return min(100.0 * h, (0.01 / largest) ** (1.0 / (control[ORDER] + 1.0)), clock[LARGEST])
    return 1e-3 * h


@inline
def change_phase(rhs, event, t, h, y, f, after, par, work, scale, control, counts, clock, contacts, impacts, place, trial, slope):
    """Switch a contact and choose the next step: that of the last such phase, or a fresh first step."""
    starts = contacts[event, TOUCHING] == 0.0
    kept = CONTACT_STEP if starts else FREE_STEP
    clock[FREE_STEP if starts else CONTACT_STEP] = clock[STEP_SIZE]
    switch(event, t, after, work, contacts, impacts, place)
    rhs(t, y, par, work, f)
    fresh = first_step(rhs, t, y, f, par, work, scale, control, counts, clock, trial, slope)
    clock[STEP_SIZE] = max(fresh, clock[kept]) if clock[kept] > 0.0 else fresh
    invalidate(control, counts)


LOOP_SIGNATURE = int64(
    STEP, STEP, KERNEL, KERNEL, KERNEL, KERNEL, KERNEL, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, INTEGERS,
    VECTOR, INTEGERS, MATRIX, MATRIX, MATRIX, VECTOR, MATRIX, MATRIX, VECTOR, MATRIX, complex128[:, ::1], MATRIX, int64,
)  # fmt: skip


@compiled(LOOP_SIGNATURE)
def run(
    step, interpolant, rhs, jacobian, events, commit, observe, par, work, y, f, scale, band, control, counts,
    clock, place, contacts, impacts, log, times, rows, dense, vector, matrix, complexes, scratch, budget,
):  # fmt: skip
    """Advance until done, failed, a buffer is full or `budget` steps are spent. Returns a status code."""
    joints, size = contacts.shape[0], y.size
    y_new, f_new, trial, other = scratch[0], scratch[1], scratch[2], scratch[3]
    before, after, found = scratch[4, : 3 * joints], scratch[5, : 3 * joints], scratch[6, : 3 * joints]
    t = clock[TIME]
    if place[STARTED] == 0:
        if joints > 0:
            events(t, y, par, work, before)
        for j in range(joints):
            if contacts[j, IS_CONTACT] > 0.0 and before[3 * j] > 0.0:
                switch(j, t, before, work, contacts, impacts, place)
        rhs(t, y, par, work, f)
        for i in range(size):
            if not math.isfinite(f[i]):
                return status.NOT_FINITE
        if not sample(observe, t, 0.0, True, dense, y, par, work, clock, place, trial, times, rows):
            return status.RUNNING
        clock[STEP_SIZE] = first_step(rhs, t, y, f, par, work, scale, control, counts, clock, y_new, f_new)
        place[STARTED] = 1
    answer = status.RUNNING
    for _ in range(budget):
        t = clock[TIME]
        if t >= clock[END]:
            answer = status.DONE
            break
        if place[LOGGED] == log.shape[0] or place[EVENTS] + joints > impacts.shape[0]:
            break
        if place[ROWS] > 0 and place[ROWS] == times.size:
            break
        if counts[STEPS] + counts[REJECTED] >= place[STEP_LIMIT]:
            answer = status.TOO_MANY_STEPS
            break
        h = min(clock[STEP_SIZE], clock[LARGEST])
        if t + 1.0001 * h >= clock[END]:
            h = clock[END] - t
        elif t + 1.9 * h >= clock[END]:
            h = 0.5 * (clock[END] - t)
        if h <= 4e-16 * max(abs(t), abs(clock[END])) and clock[END] - t > h:
            answer = status.STEP_TOO_SMALL if place[BEFORE_REJECTED] < 2 else status.NOT_FINITE
            break
        code = step(
            rhs, jacobian, t, h, y, f, par, work, y_new, f_new, dense, scale, control, counts, vector, matrix, complexes
        )
        if code != 0:
            counts[REJECTED] += 1
            place[BEFORE_REJECTED] = 2 if code == 2 or math.isnan(control[ERROR]) else 1
            clock[STEP_SIZE] = 0.25 * h
            continue
        error = control[ERROR]
        if error > 1.0:
            counts[REJECTED] += 1
            place[BEFORE_REJECTED] = 1
            clock[STEP_SIZE] = h * max(SHRINK, SAFETY * error ** (-1.0 / control[ORDER]))
            continue
        event = -1
        have_dense = False
        if joints > 0:
            events(t, y, par, work, before)
            events(t + h, y_new, par, work, after)
            if near_contact(before, after, h, contacts, band):
                interpolant(
                    rhs, jacobian, t, h, y, f, par, work, y_new, f_new, dense, scale, control, counts, vector, matrix,
                    complexes,
                )  # fmt: skip
                event, theta = first_event(events, t, h, dense, par, work, contacts, band, trial, other, found)
                have_dense = event < 0
                if event >= 0:
                    # make the step again so that it ends on the event, and once more to correct the end
                    whole = h
                    h = theta * h
                    for _correction in range(4):
                        invalidate(control, counts)
                        if h <= 1e-15 * max(abs(t), whole):
                            h = 0.0
                            break
                        code = step(
                            rhs, jacobian, t, h, y, f, par, work, y_new, f_new, dense, scale, control, counts, vector,
                            matrix, complexes,
                        )  # fmt: skip
                        if code != 0 or control[ERROR] > 1.0:
                            break
                        events(t + h, y_new, par, work, after)
                        miss = after[3 * event] / after[3 * event + 1] if after[3 * event + 1] != 0.0 else 0.0
                        if abs(after[3 * event]) <= 1e-2 * band[event] or not abs(miss) < 0.5 * h:
                            break
                        h -= miss
                    if h > 0.0 and (code != 0 or control[ERROR] > 1.0):
                        counts[REJECTED] += 1
                        invalidate(control, counts)
                        clock[STEP_SIZE] = 0.5 * h
                        place[BEFORE_REJECTED] = 1
                        continue
                    if h == 0.0:
                        events(t, y, par, work, after)
                        switch(event, t, after, work, contacts, impacts, place)
                        continue
        # --- the step is accepted
        needs_dense = place[SAMPLE] < place[SAMPLES] and (
            clock[BEGIN] + place[SAMPLE] * clock[SAMPLE_EVERY] <= t + h
        )
        touching = False
        for j in range(joints):
            touching = touching or contacts[j, TOUCHING] > 0.0
        if (needs_dense or touching) and not have_dense:
            interpolant(
                rhs, jacobian, t, h, y, f, par, work, y_new, f_new, dense, scale, control, counts, vector, matrix,
                complexes,
            )  # fmt: skip
        if touching:
            track_peaks(events, t, h, dense, par, work, contacts, trial, found)
        if not sample(observe, t, h, False, dense, y_new, par, work, clock, place, trial, times, rows):
            break
        end = clock[END] if t + h >= clock[END] else t + h
        for i in range(size):
            y[i] = y_new[i]
            f[i] = f_new[i]
        clock[TIME] = end
        counts[STEPS] += 1
        log[place[LOGGED], 0], log[place[LOGGED], 1], log[place[LOGGED], 2] = end, h, control[ERROR]
        place[LOGGED] += 1
        if place[COMMITS] > 0:
            commit(end, y, par, work, work)
        growth = GROW
        if control[ERROR] > 0.0:
            growth = min(GROW, max(SHRINK, SAFETY * control[ERROR] ** (-1.0 / control[ORDER])))
        if place[BEFORE_REJECTED] > 0:
            growth = min(growth, 1.0)
        place[BEFORE_REJECTED] = 0
        if event < 0 and not 1.0 <= growth <= 1.2:
            clock[STEP_SIZE] = h * growth
        elif event < 0:
            clock[STEP_SIZE] = h
        else:
            change_phase(rhs, event, end, h, y, f, after, par, work, scale, control, counts, clock, contacts, impacts, place, y_new, f_new)
        for j in range(joints):
            if contacts[j, IS_CONTACT] == 0.0 and after[3 * j] >= 0.0:
                place[FAILED_JOINT] = j
                return status.FILM_LEFT
    return answer


__all__ = ["STEP_SIGNATURE", "float64", "run"]
