"""Control of steps and searches, as plain formulas: the compiled loop takes them in, lanes trace
them.
"""

import math

from clearance.stepping.types import inline

FLIP_LIMIT = 100  # contact changes without advance in time before the run counts as stuck
SQUEEZE = 0.05  # smallest part of a film that a step may leave
# error of an eccentricity, at most this share of the film left; likewise of its rate
FILM_ERROR = 0.05
RESOLVED = 1e-11  # share of a film's rate that no error need be below: rounding takes some 1e-15
FORGET = 0.3  # what of a film's damping is remembered from one step to the next
BAND = 1e-13  # dead band of a touch or a kink, share of the lengths in its penetration
WOUND = 50.0  # natural sizes beyond which rounding of coordinates exceeds that of a kink
# step over time that still advances the clock; the layer a film forms at the start needs short ones
SMALLEST = 4e-16
CLEARLY = 10.0  # first step of a phase, or one that errors let grow, over what the clock resolves
EARLIEST = 1e-20  # share of the end before which the clock resolves no less: a film's first layer
SAFETY, SHRINK, GROW = 0.9, 0.2, 4.0
# power of the error that a step refused again goes by: solutions are less smooth at a contact's
# ends
DOUBTED = 0.3
NEARLY = 0.9  # of the way to the end of a contact, which a step after one that is refused goes
ONSET = 0.01  # step over the one that a contact cut: its force bends within a part of that
NEWTON_FAILED = 0.5  # the step after one whose equations could not be solved
# stiffness at DOP853's stability limit, steps there that call for a change, and mild steps in a row
# that end a stiff stretch
UNSTABLE, STIFF_ENOUGH, MILD = 6.1, 200, 6


# --- sizes of steps
@inline
def resolution(time, end):
    """Longest step [s] that the clock does not resolve; end: of the run [s]."""
    return SMALLEST * max(abs(time), EARLIEST * end)


@inline
def within(step, longest, remaining):
    """The next step, stretched or halved so that the run does not end in a sliver."""
    h = min(step, longest)
    if 1.0001 * h >= remaining:
        return remaining
    return 0.5 * remaining if 1.9 * h >= remaining else h


@inline
def factor(error, power, effort, step, before, last_error):
    """The next step over an accepted one, from its error and from how the error grew since the step
    before.

    The second is Gustafsson's predictive control (ACM Trans. Math. Softw. 20, 1994): it sees a
    stiffer stretch coming. effort: safety factor; before: the step before, 0 for none.
    """
    value = effort * error**-power
    if before > 0.0:
        predicted = effort * step / before * (last_error / (error * error)) ** power
        value = min(value, predicted)
    return min(GROW, max(SHRINK, value))


@inline
def next_step(step, value, newton_rate, good_rate, refused, clock):
    """The step after an accepted one; value: its factor. Small changes are not worth a new
    factorisation.

    newton_rate: of convergence, which should not exceed the good rate; 0 for none. refused: the
    step before was. clock: the longest step that it does not resolve; the next is clearly longer.
    """
    if newton_rate > 0.0:
        value = min(value, max(0.5, good_rate / newton_rate))
    if refused:
        value = min(value, 1.0)
    return max(step if 1.0 <= value <= 1.2 else step * value, CLEARLY * clock)


@inline
def after_kink(step, clock):
    """The step after one that a kink cut; clock: as above."""
    return max(ONSET * step, CLEARLY * clock)


@inline
def reduction(error, power):
    """The next step over one whose error is too large."""
    return max(SHRINK, SAFETY * error**-power)


@inline
def leaving(value, before, after):
    """The next step over one that is refused, inside which a contact ends: about there.

    before, after: penetrations at its ends.
    """
    return min(max(value, NEARLY * before / (before - after)), NEARLY)


@inline
def stiff_steps(stiffness, steps, mild):
    """Steps that stability held up, and mild ones in a row, which make up for them, after one more
    step.
    """
    if stiffness > UNSTABLE:
        return steps + 1, 0
    return 0 if mild + 1 >= MILD else steps, mild + 1


# --- contacts inside a step
@inline
def beyond(touching, gradual, depth, rate, band):
    """Sign of a penetration behind the next start or end of its contact.

    touching: a first touch goes on; gradual: there is none, and the step's begin shows it, in the
    dead band by the rate.
    """
    inside = depth > band or depth >= -band and rate > 0.0
    return -1.0 if (inside if gradual else touching) else 1.0


@inline
def cubic(low, rise, high, fall, length):
    """Coefficients of x, x^2 and x^3 of the cubic through the value `low` at x = 0 and `high` at
    x = 1, with rates there over a length.
    """
    a = rise * length
    b = fall * length
    change = high - low
    return a, 3.0 * change - 2.0 * a - b, a + b - 2.0 * change


@inline
def summit(low, first, second, third):
    """Place and value of the top of such a cubic, which rises first and falls in the end."""
    root = math.sqrt(max(second * second - 3.0 * third * first, 0.0))
    x = first / max(root - second, 1e-300)
    return x, low + x * (first + x * (second + x * third))


# --- natural sizes in films
@inline
def offset_size(clearance, gap, offset, rtol):
    """Natural size of an offset in a film: rtol (size + |offset|) is at most a share of the gap."""
    size = abs(offset)
    return min(clearance + size, FILM_ERROR * gap / rtol) - size


@inline
def rate_size(usual, pull, damping, rate, rtol):
    """Natural size of its rate: the error is at most a share of the film's closing speed under the
    mechanism's acceleration, down to rounding.
    """
    size = abs(rate)
    bound = FILM_ERROR * pull / (max(damping, 1e-300) * rtol)
    return min(usual + size, max(bound, RESOLVED * size / rtol)) - size


# --- searches for extremes
@inline
def may_peak(last, now, best, slope, per_width, before, curving):
    """True where a value larger than the best may lie inside an interval: not where it rises or
    falls throughout, nor where it bends too little.

    The slope's change over the interval is taken as four times that of the chords, of this interval
    and of the last.

    last, now: values at its ends; before: slope of the last chord; curving: share of the change,
    4 width / (width + back).
    """
    change = curving * abs(slope - before)
    return abs(slope) <= change and (max(last, now) - best) * per_width + 0.25 * change > 0.0
