"""The state of a compiled run: its arrays and what stands where in them, one step and its dense output."""

from collections import namedtuple

from clearance.mechanism.store import COMPILED
from clearance.stepping.record import Record, packed, reader
from clearance.stepping.types import (
    HAS_PREDICTOR,
    INTEGERS,
    JACOBIAN_STATE,
    KERNEL,
    LAST_H,
    LU_STATE,
    MATRIX,
    STEP,
    VECTOR,
    complex128,
    inline,
    int64,
    shared,
)

# entries of `clock`
TIME, STEP_SIZE, END, LARGEST, SAMPLE_EVERY, BEGIN, CONTACT_STEP, FREE_STEP, LAST_STEP, LAST_ERROR = range(10)
STRETCH = 10  # length of the stretches of a run that have extremes of their own
INTERVAL = 11  # from the last look but one at the outputs to the last; 0: their slopes have jumped since
FINISH = 12  # end of the whole run; END may stand before it, where something is to happen on the way
CLOCK_SIZE = 13
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
_FIELDS = {
    STEP: "step interpolant",
    KERNEL: "rhs jacobian events commit observe",
    VECTOR: "par work y f scale band control clock times vector row look y_new f_new trial before after probed found",
    MATRIX: "contacts impacts log rows dense matrix peaks best when turned",
    INTEGERS: "counts place ledger",
    int64[:, ::1]: "angles",
    complex128[:, ::1]: "complexes",
}
STATE = Record("of a run", {name: kind for kind, names in _FIELDS.items() for name in names.split()})
state_at = reader(STATE)


class State(namedtuple("State", STATE.fields)):
    """A run's functions and arrays."""

    @property
    def address(self) -> "State":
        """What plain Python takes for its address."""
        return self


def words(state: State):
    """A run's state as the compiled loop takes it: see record.py; the arrays must live as long as they are used."""
    return packed(STATE, state) if COMPILED else state


@inline
def copy(source, target):
    for i in range(source.size):
        target[i] = source[i]


# --- one step and its dense output
@inline
def attempt(s, t, h):
    """One step of the method from the present state; 0 if it worked (its error may still be too large)."""
    s.place[INTERPOLATED] = 0
    return s.step(s.address, t, h)


@shared
def interpolate(s, t, h):
    """Prepare the dense output of the step just made, unless it stands ready."""
    if s.place[INTERPOLATED] == 1:
        return
    s.place[INTERPOLATED] = 1
    s.interpolant(s.address, t, h)


@shared
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
