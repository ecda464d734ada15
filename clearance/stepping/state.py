"""The state of a compiled run: its arrays and what stands where in them, one step and its dense output."""

from collections import namedtuple

from clearance.stepping.types import HAS_PREDICTOR, JACOBIAN_STATE, LAST_H, LU_STATE, inline

# entries of `clock`
TIME, STEP_SIZE, END, LARGEST, SAMPLE_EVERY, BEGIN, CONTACT_STEP, FREE_STEP, LAST_STEP, LAST_ERROR = range(10)
STRETCH = 10  # length of the stretches of a run that have extremes of their own
INTERVAL = 11  # from the last look but one at the outputs to the last; 0: their slopes have jumped since
CLOCK_SIZE = 12
# entries of `place`
SAMPLE, SAMPLES, ROWS, LOGGED, EVENTS, STEP_LIMIT, STARTED, COMMITS, LAST_REFUSAL, FAILED_JOINT, FLIPS = range(11)
REFUSALS, INTERPOLATED, STIFF_STEPS, MILD_STEPS, MAY_SWITCH, REMEMBERING, WATCHED, STRETCHES = range(11, 19)
PLACE_SIZE = 19
# columns of `contacts`, the running record of each joint, and of `impacts`, the finished ones
TOUCHING, SINCE, IMPACT_SPEED, KIND, COORDINATE, CLEARANCE = range(6)
RATE_X, RATE_Y, PULL, DAMPING = range(6, 10)  # natural rates, natural acceleration, largest damping of late [1/s]
PEAKS = 10  # row of `peaks` of the contact's largest force, that of its penetration follows; -1: none
CONTACT_COLUMNS = 11
FILM, CONTACT, BLENDED = range(3)  # kinds: never beyond the wall; with a first touch; with neither
IMPACT_COLUMNS = 7  # joint, time, impact speed, peak force, penetration, duration, separation speed
LOG_COLUMNS = 3  # time at the end, step, error over tolerance; energies follow, where there is a ledger
# columns of `peaks`, see locating.py
CHANNEL, PAIRED, SIGN, JOINT, VALUE, WHEN, EARLIER, LAST, NEXT, MIDDLE, SEARCHED = range(11)
PEAK_COLUMNS = 11

# what a run is made of: the compiled functions it calls, and its arrays
Calls = namedtuple("Calls", "step interpolant rhs jacobian events commit observe")
State = namedtuple(
    "State",
    "par work y f scale band control counts clock place contacts impacts log times rows dense vector matrix complexes "
    "peaks best when angles turned ledger row look y_new f_new trial before after probed found",
)


@inline
def copy(source, target):
    for i in range(source.size):
        target[i] = source[i]


# --- one step and its dense output
@inline
def attempt(call, s, t, h):
    """One step of the method from the present state; 0 if it worked (its error may still be too large)."""
    s.place[INTERPOLATED] = 0
    return call.step(
        call.rhs, call.jacobian, t, h, s.y, s.f, s.par, s.work, s.y_new, s.f_new, s.dense, s.scale, s.control, s.counts,
        s.vector, s.matrix, s.complexes,
    )  # fmt: skip


@inline
def interpolate(call, s, t, h):
    """Prepare the dense output of the step just made, unless it stands ready."""
    if s.place[INTERPOLATED] == 1:
        return
    s.place[INTERPOLATED] = 1
    call.interpolant(
        call.rhs, call.jacobian, t, h, s.y, s.f, s.par, s.work, s.y_new, s.f_new, s.dense, s.scale, s.control, s.counts,
        s.vector, s.matrix, s.complexes,
    )  # fmt: skip


@inline
def evaluate(s, theta):
    """Dense output at theta in [0, 1], into s.trial."""
    for i in range(s.y.size):
        value = 0.0
        for r in range(7, 0, -1):
            value += s.dense[r, i]
            value *= theta if r % 2 == 1 else 1.0 - theta
        s.trial[i] = s.dense[0, i] + value


@inline
def invalidate(s):
    """Forget what the method kept from earlier steps."""
    s.counts[JACOBIAN_STATE] = s.counts[LU_STATE] = s.counts[HAS_PREDICTOR] = 0
    s.control[LAST_H] = 0.0
