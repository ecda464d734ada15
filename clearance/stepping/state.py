"""The state of a run, declared once: numbers and arrays by name, in one piece of memory.

Compiled code and Python read and set them alike: `s.time`, `s.contacts[j, KIND]`. One step and its
dense output.
"""

from collections.abc import Callable
from functools import cache
from inspect import signature

import numpy as np

from clearance.machine.numba_record import Record, mover, packed, reader
from clearance.machine.store import COMPILED
from clearance.stepping.linear import solve
from clearance.stepping.types import DENSE_ROWS, KERNEL, MATRIX, STEP, VECTOR, inline, shared

# columns of `contacts`, the running record of each joint, and of `impacts`, the finished ones
TOUCHING, SINCE, IMPACT_SPEED, KIND, COORDINATE, CLEARANCE = range(6)
# natural rates, natural acceleration, largest damping of late [1/s]
RATE_X, RATE_Y, PULL, DAMPING = range(6, 10)
# row of `peaks` of the contact's largest force, that of its penetration follows; -1: none
PEAKS = 10
CONTACT_COLUMNS = 11
IMPACT_COLUMNS = 7  # joint, time, impact speed, peak force, penetration, duration, separation speed
# time at the end, step, error over tolerance; energies follow, where there is a ledger, then the
# state and what is carried on, where there are loops
LOG_COLUMNS = 3
TRAIL_PLACES = 3  # of a step at which it is followed: start, middle and end
# columns of `reversals`, see locating.py
FRICTION, POWER, RATE, FINE, FACTOR = range(5)
REVERSAL_COLUMNS = 5
SIDE = 9  # rates of one sign that are looked at in a reversal
CUTS = 2 * SIDE + 1
# columns of `peaks`, see locating.py
CHANNEL, PAIRED, SIGN, JOINT, VALUE, WHEN, EARLIER, LAST, NEXT, MIDDLE, SEARCHED = range(11)
PEAK_COLUMNS = 11
# rows of `integrals`, see quadrature.py: source and form of an integrand, its integral so far and
# over the last interval. Then its divided differences, or contacts at the places of the interval
SOURCE, FORM, SUM, SUMMAND, DIFFERENCE = range(5)
TOUCHED = DIFFERENCE
NODES = 6
INTEGRAL_ROWS = DIFFERENCE + NODES
# rows of `nodes`: places from the newest to the oldest, measured from the end of the last interval
# [s]. Then 1 / distance of the newest to those before. Then integrals of the products of Newton's
# polynomial
PLACE, INVERSE, MOMENT = range(3)
NODE_ROWS = 3
SQUARE, PAIR = range(2)  # forms: of a channel, of a vector; of a time in contact: row in `peaks`

SETTLED = 2  # Newton steps that settle stiff rates between the nodes of a step

#: numbers of a run that are floats
FLOATS = (
    "rtol",
    "newton_tolerance",  # error left by Newton's method, of the error tolerance
    "order",  # of the stepper's error estimate
    "longest_step",  # [s]
    "sample_every",  # [s]
    "stretch",  # length of the stretches of a run that have extremes of their own [s]
    "limit",  # of the error of an integral, over its mean, see quadrature.py
    "turn",  # that a finite drive ends next
    "begin",  # of the run [s]
    "end",  # of this call of the loop, which may stand before that of the run [s]
    "finish",  # of the run [s]
    "time",  # reached [s]
    "step_size",  # to be tried next [s]
    "last_step",  # the step accepted last [s]; 0: a phase begins
    "last_error",  # its error over tolerance
    "contact_step",  # first step of the last phase with a contact [s]
    "free_step",  # first step of the last phase without one [s]
    # from the last look but one at the outputs to the last [s]; 0: their slopes have jumped since;
    # negative: so have numbers of the mechanism
    "interval",
    "error",  # of the last trial step, over tolerance
    "last_h",  # step that the stepper's factors and predictor belong to [s]
    "convergence",  # of Newton's method: rate / (1 - rate) of its last step
    "newton_rate",  # of convergence
    "effort",  # safety factor of the next step, from the iterations of the last
    "cut_h",  # the step made again to end on a contact's start or end [s]
    "stiffness",  # step times the largest eigenvalue felt
    "gain",  # g of the factors of the last step [1/s]
    "wound",  # times the dead band of a kink for coordinates that are wound up
)
#: numbers of a run that are integers
INTEGERS = (
    "degree",  # of the dense output, beyond the state where a step begins
    "states",  # that the error estimate counts: all but the energy integrals
    "coordinates",  # of the states
    "samples",  # of the complete run
    "step_limit",
    "commits",  # numbers in `work` that steps set at their ends
    "remembering",  # films with a memory
    "evaluate_ledger",  # 1: with energy integrals
    "may_switch",  # 1: the loop returns where the method is held up by stability
    "watched",  # 1: outputs are looked at where steps end
    "started",  # 0: not yet; 2: a phase begins where the run stands, for rates have jumped
    "steps",
    "rejected",
    "evaluations",
    "jacobians",
    "factorisations",
    "sample",  # the next
    "rows_filled",  # rows of `times` and `rows` in use
    "log_filled",
    "impacts_filled",
    "stretches",  # finished
    "parts",  # finished
    "squares",  # integrals of squares, those of times follow
    "grown",  # and these; then growths of sums
    "counted",  # output with the turns of a finite drive, -1: none
    "fresh",  # 1: no interval of this phase is in the integrals yet
    "flips",  # changes of contacts without advance in time
    "touchable",  # spots where contacts start and end
    "met",  # spot whose first touch or last is where the step ends, -1: none
    "failed_joint",  # spot whose journal left its film, -1: none
    "last_refusal",  # why a step was rejected last
    "refusals",  # one after another
    "stiff_steps",
    "mild_steps",  # one after another
    "interpolated",  # 1: the dense output of the last step stands ready
    "factors",  # row in `matrix` of those that settle it, 0: it is smooth; see `settle`
    "jacobian_state",  # 1: the Jacobian is that of this place
    "lu_state",  # 1: factors belong to this Jacobian
    "has_predictor",  # 1: the last step's polynomial can be gone on with
)


#: values of each spot by the kernel `events`: penetration, its rate
SPOT_VALUES = 2


@cache
def layout(
    *,
    size,
    states,
    work,
    spots,
    outputs,
    ledger,
    logged,
    angles,
    peaks,
    stretches,
    integrals,
    parts,
    scratch,
    rows,
    log,
    impacts,
    followed,
    reversals,
) -> np.dtype:
    """All numbers and arrays of a run, as they stand in memory one after another.

    size: states and energy integrals; ledger, logged: energies, and the state with what is carried
        on, logged at the end of each step; peaks: watched quantities. integrals: quantities that
        are summed over time; parts: of the run that have sums of their own.
    scratch: rows of the stepper's scratch; rows, log, impacts: samples, steps and contacts of one
        piece of output.
    followed: numbers handed on at the start, middle and end of each step. reversals: joints whose
        friction turns round within a layer.
    """
    events = (SPOT_VALUES * spots,)
    kinds = {"angles": int, "ledger": int, "complexes": complex}
    shapes = {
        "y": (size,),
        "f": (size,),  # its rate
        "work": (work,),
        "scale": (size,),  # natural sizes of the states
        "band": (spots,),  # dead band of a touch or a kink [m]
        "contacts": (spots, CONTACT_COLUMNS),
        "peaks": (peaks, PEAK_COLUMNS),
        "best": (stretches, peaks),  # extremes of finished stretches
        "when": (stretches, peaks),
        "integrals": (INTEGRAL_ROWS, integrals),
        "nodes": (NODE_ROWS, NODES),
        "totals": (parts, integrals),  # of each part of the run
        "ends": (parts,),  # of these parts [s]
        "angles": (angles, 2),  # places of angles and their rates among the outputs
        "turned": (angles, 2),  # both at the end of the last step
        "reversals": (reversals, REVERSAL_COLUMNS),
        "cuts": (reversals * CUTS,),  # places in the last step where friction turns round
        "ledger": (ledger,),  # places of the energies
        "row": (outputs,),  # at the end of the last step
        "look": (outputs,),  # inside it
        "y_new": (size,),
        "f_new": (size,),
        "trial": (size,),
        "defect": (size,),  # rates at `trial`
        # penetration and its rate of all spots where a step begins
        "before": events,
        "after": events,
        "probed": events,  # where a part of the step begins that is searched for contact
        "ahead": events,  # where it ends
        "inside": events,
        "dense": (DENSE_ROWS, size),
        "jacobian_rows": (max(states**2, 1),),
        "matrix": (scratch + states, max(size, 1)),
        "complexes": (2 * (states + 2), max(states, 1)),
        "times": (rows,),
        "rows": (rows, outputs),
        "log": (log, LOG_COLUMNS + ledger + logged),
        "impacts": (impacts, IMPACT_COLUMNS),
        "followed": (followed,),
        "trail": (log if followed else 0, TRAIL_PLACES, followed),  # of each step in `log`
    }
    arrays = [(name, kinds.get(name, float), shape) for name, shape in shapes.items()]
    numbers = [(n, float) for n in FLOATS] + [(n, int) for n in INTEGERS]
    return np.dtype(numbers + arrays)


#: number of rows in use -> arrays of output that have so many
BUFFERS = {"rows_filled": ("times", "rows"), "log_filled": ("log",), "impacts_filled": ("impacts",)}
NUMBERS = {*FLOATS, *INTEGERS}
STEPPER, CONTACTS, KERNELS = (
    ("step", "interpolant"),
    ("meet", "swap"),
    ("rhs", "moments", "jacobian", "events", "commit", "observe", "follow"),
)
FUNCTIONS = dict.fromkeys(STEPPER + CONTACTS, STEP) | dict.fromkeys(KERNELS, KERNEL)
SMALLEST = layout(**dict.fromkeys(signature(layout).parameters, 1))
ARRAYS = {*SMALLEST.names} - NUMBERS
STATE = Record("of a run", FUNCTIONS | {"par": VECTOR, "together": MATRIX}, SMALLEST)
state_at = reader(STATE)


class State:
    """The state of a run, all zero at first; beside it the functions it calls and the mechanism's
    numbers.

    memory: all numbers and arrays in one piece; each is an attribute too. together: room for times
        and states of moments that are evaluated together, and for their rates; empty where each
        stands alone.
    """

    def __init__(self, **sizes: int):
        self.sizes = sizes
        self.memory = _memory(layout(**sizes))

    def __getattr__(self, name: str):
        if name not in ARRAYS:
            raise AttributeError(f"the state of a run has no {name!r}")
        vars(self)[name] = array = self.memory[name]
        return array

    def mould(self) -> Callable[[np.ndarray], "State"]:
        """A function that makes states with these numbers, arrays and functions, and no output.

        Its argument: the mechanism's numbers.
        """
        sizes = self.sizes
        kind = self.memory.dtype
        head = self.head.copy()
        functions = {name: vars(self)[name] for name in FUNCTIONS}
        move = mover(STATE, self) if COMPILED else None
        together = self.together

        def cast(par: np.ndarray) -> State:
            # room for output is not cleared: it would take longer than all of this
            state = State.__new__(State)
            memory = _memory(kind, np.empty)
            vars(state).update(functions, sizes=sizes, memory=memory, par=par)
            vars(state)["together"] = together.copy() if together.size else together
            state.head[:] = head
            state._stand(move(state) if move else None)
            return state

        return cast

    def without_output(self) -> "State":
        """The same numbers and arrays, but those of output, which are empty; no loop takes it."""
        sizes = self.sizes | {"rows": 0, "log": 0, "impacts": 0}
        kind = layout(**sizes)
        state = State.__new__(State)
        vars(state).update(sizes=sizes, memory=_memory(kind))
        state.head[:] = self.head
        return state

    @property
    def head(self) -> np.ndarray:
        """The bytes of all numbers and arrays but those of output."""
        return self.memory.reshape(1).view(np.uint8)[: self.memory.dtype.fields["times"][1]]

    def resized(self, **sizes: int) -> "State":
        """The same numbers and arrays; those that change their size, and output that is in use
        nowhere, all zero.
        """
        state = State(**self.sizes | sizes)
        empty = [n for filled, names in BUFFERS.items() if not getattr(self, filled) for n in names]
        for name in state.memory.dtype.names:
            if name not in empty and state.memory[name].shape == self.memory[name].shape:
                state.memory[name] = self.memory[name]
        return state

    def restore(self, image: bytes) -> None:
        """Numbers and arrays as they were when `memory.tobytes()` gave this."""
        memory = self.memory.reshape(1).view(np.uint8)
        memory[:] = np.frombuffer(image, np.uint8)

    def connect(self, par: np.ndarray, together: np.ndarray, **functions) -> None:
        """Take the functions that the loop calls and the mechanism's numbers.

        address: argument of the compiled loop, see machine/numba_record.py; in plain Python the
            state itself.
        """
        vars(self).update(functions, par=par, together=together)
        self._stand(packed(STATE, self) if COMPILED else None)

    def _stand(self, words: np.ndarray | None) -> None:
        """Take the words of the record."""
        vars(self).update(words=words, address=self if words is None else words.ctypes.data)


def _number(name: str) -> property:
    """A number of a run, as an attribute of its state."""
    return property(
        lambda state: state.memory[name][()],
        lambda state, value: state.memory.__setitem__(name, value),
    )


for _name in NUMBERS:
    setattr(State, _name, _number(_name))


def _memory(kind: np.dtype, make: Callable = np.zeros) -> np.ndarray:
    """One piece of memory; numpy takes twice the time to make one with many fields."""
    return np.ndarray((), kind, make(kind.itemsize, np.uint8))


@inline
def depth_of(values, spot):
    """Penetration of a spot, from the values of all."""
    return values[SPOT_VALUES * spot]


@inline
def rate_of(values, spot):
    """Rate of its penetration."""
    return values[SPOT_VALUES * spot + 1]


@inline
def copy(source, target):
    for i in range(source.size):
        target[i] = source[i]


# --- one step and its dense output
@inline
def attempt(s, t, h):
    """One step of the method from the present state: its status."""
    s.interpolated = s.factors = 0
    return s.step(s.address, t, h)


@shared
def interpolate(s, t, h):
    """Prepare the dense output of the step just made, unless it stands ready."""
    if s.interpolated == 1:
        return
    s.interpolated = 1
    s.interpolant(s.address, t, h)


@shared
def evaluate(s, theta):
    """Dense output at theta in [0, 1], into s.trial."""
    for i in range(s.y.size):
        value = 0.0
        for r in range(s.degree, 0, -1):
            value += s.dense[r, i]
            value *= theta if r % 2 == 1 else 1.0 - theta
        s.trial[i] = s.dense[0, i] + value


@inline
def inside(s, theta, i):
    """Dense output of state i at theta: its value, and its rate times the step."""
    value = rate = 0.0
    for r in range(s.degree, 0, -1):
        value += s.dense[r, i]
        factor, turn = (theta, 1.0) if r % 2 == 1 else (1.0 - theta, -1.0)
        rate = rate * factor + turn * value
        value *= factor
    return s.dense[0, i] + value, rate


@shared
def settle(s, t, h, theta):
    """Bring stiff rates in s.trial to the equations u' = f at theta of the last step.

    Between its nodes the dense output u misses them by f(u) - u'. The force of a thin film is
    noise there. Newton's method with the factors of the last step finds d with f(u + d) = u' + g d.
    Stiff rates take their values at the coordinates, which stay. Others change by about
    (f - u') / g, which is of the order of their error.
    """
    p, n, first = s.coordinates, s.states, s.factors
    size, correction = n - p, s.matrix[first - 3]
    s.rhs(t + theta * h, s.trial, s.par, s.work, s.defect)
    for i in range(size):
        value, rate = inside(s, theta, p + i)
        correction[i] = s.defect[p + i] - rate / h - s.gain * (s.trial[p + i] - value)
    solve(s.matrix[first : first + size], s.matrix[first - 1], correction, size)
    for i in range(size):
        s.trial[p + i] += correction[i]


@shared
def state_inside(s, t, h, theta):
    """State at theta in [0, 1] of the last step, into s.trial."""
    evaluate(s, theta)
    if s.factors > 0 and theta > 0.0:  # it begins where the one before has settled
        for _ in range(SETTLED):
            settle(s, t, h, theta)


@shared
def observe_inside(s, t, h, theta):
    """Outputs at theta of the last step, into s.look."""
    state_inside(s, t, h, theta)
    s.observe(t + theta * h, s.trial, s.par, s.work, s.look)


@inline
def invalidate(s):
    """Forget what the method has from earlier steps."""
    s.jacobian_state = s.lu_state = s.has_predictor = 0
    s.last_h, s.convergence = 0.0, 1.0
