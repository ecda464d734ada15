"""Start of a run: the scene's own start, the state at the end of another run, or a quasi-static
one.
"""

import math
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from clearance.mechanism.build import Mechanism
from clearance.results import Record, open_result

QUASI_STATIC = "quasi-static"
ITERATIONS = 200  # of the search for a quasi-static state, at most
FIRST_STEP = 1e-3  # of it, over the typical time 1 / frequency
ROOM = 0.5  # share of the clearance left that one of its steps may take
THINNEST = 1e-3  # of the clearance: room that a journal at the wall has all the same
HALVINGS = 60  # of one of its steps, at most
AT_REST = 1e-9  # of the typical acceleration: what is left of the journals' at the end
PHASE = 1e-6  # of a turn, or of the size: how far a drive may stand from where the scene starts


def end_state(mechanism: Mechanism, y: np.ndarray, work: np.ndarray, time: float) -> dict:
    """Attributes of a result file that another run can start from."""
    driven = prescribed(mechanism, time)
    return {
        "names": mechanism.layout.names,
        "values": y[: mechanism.size],
        "sizes": _own_sizes(mechanism),
        "carried": _carried(mechanism, work),
        "driven_names": list(driven),
        "driven_values": np.array(list(driven.values())),
        "time": time,
    }


def prescribed(mechanism: Mechanism, time: float) -> dict[str, float]:
    """Coordinates that drives prescribe at a time: by the body or joint that is driven, rad or
    m.
    """
    drives = (d for d in mechanism.scene.drives if d.prescribes)
    return {
        d.target.name: d.motion(time)
        if d.speed is None
        else mechanism.start.coordinate(d.target) + d.speed * time
        for d in drives
    }


def _carried(mechanism: Mechanism, work: np.ndarray) -> np.ndarray:
    """Angles and slides that Newton's method in the kernel starts from."""
    return work[mechanism.layout.carried_places]


@dataclass(frozen=True)
class Beginning:
    """A state to begin in: values of all states, carried angles, and a sentence about them."""

    values: tuple[float, ...]
    carried: tuple[float, ...]
    text: str


def state_from(
    mechanism: Mechanism, start: Record | Beginning | str | Path
) -> tuple[np.ndarray, np.ndarray, str]:
    """State and carried angles that a run starts with, and a sentence about them.

    start: a result, the path of its file, "quasi-static", or a state itself. Offsets in clearances
    are taken over their natural size. Raises ValueError for a run that has not stored its end,
    whose states are others, or whose drives ended elsewhere.
    """
    if isinstance(start, Beginning):
        return np.array(start.values), np.array(start.carried), start.text
    if isinstance(start, str) and start == QUASI_STATIC:
        text = f"{QUASI_STATIC}: films carry the joint forces"
        return quasi_static(mechanism), _carried(mechanism, mechanism.work0), text
    if not isinstance(start, Record | str | Path) or not start:
        raise ValueError(
            f'start must be a result, the path of its file or "{QUASI_STATIC}", got {start!r}'
        )
    if isinstance(start, str) and get_close_matches(start, [QUASI_STATIC]):
        raise ValueError(f'start: did you mean "{QUASI_STATIC}"? There is no file {start!r}')
    record = start if isinstance(start, Record) else open_result(start)
    name = Path(record.path).name if hasattr(record, "path") else "another run"
    end = _end_of(record, name)
    names, given = mechanism.layout.names, [str(n) for n in end["names"]]
    if missing := sorted(set(names) - set(given)):
        raise ValueError(
            f"start: {name} has other states than this scene: it has no {', '.join(missing)}"
        )
    if more := sorted(set(given) - set(names)):
        raise ValueError(
            f"start: {name} has other states than this scene, which has no {', '.join(more)}"
        )
    _check_drives(mechanism, name, end)
    values = dict(zip(given, np.asarray(end["values"], dtype=float), strict=True))
    before = dict(zip(given, np.asarray(end["sizes"], dtype=float), strict=True))
    for state, size in zip(names, _own_sizes(mechanism), strict=True):
        values[state] *= size / before[state]
    carried = np.asarray(end["carried"], dtype=float)
    if carried.size != len(mechanism.layout.carried):
        carried = _carried(mechanism, mechanism.work0)
    state = np.array([values[n] for n in names])
    return state, carried, f"the end of {name}, t = {float(end['time']):.9g} s"


def _end_of(record: Record, name: str) -> dict:
    """The end that a result keeps. Raises ValueError where it has none, or a damaged one."""
    end = record.facts("state")
    if not end or "clearances" in end:  # before 0.2.0 was released
        raise ValueError(
            f"start: {name} lacks the state at its end; it was written by an older clearance"
        )
    try:
        columns = ("values", "sizes", "carried", "driven_values", "time")
        numbers = [np.asarray(end[n], dtype=float) for n in columns]
        intact = all(np.isfinite(v).all() for v in numbers)
        intact &= (
            len(end["names"]) == numbers[0].size and len(end["driven_names"]) == numbers[3].size
        )
    except (KeyError, TypeError, ValueError):
        intact = False
    if not intact:
        raise ValueError(f"start: /state of {name} is damaged: it is not a number for each state")
    return end


def _own_sizes(mechanism: Mechanism) -> np.ndarray:
    """Natural sizes of offsets in joints with clearance and of their rates; 1 for all other
    states.
    """
    sizes = np.ones(mechanism.size)
    for joint in mechanism.eccentric:
        for state in joint.states()[: len(joint.soft_coordinates)]:
            for name in (f"{joint.key}/{state.name}", f"rate of {joint.key}/{state.name}"):
                sizes[mechanism.layout.state[name]] = state.size
    return sizes


def _check_drives(mechanism: Mechanism, name: str, end: dict) -> None:
    """Drives prescribe at the start the same as at the other run's end, but for full turns."""
    here = prescribed(mechanism, 0.0)
    there = dict(
        zip(map(str, end["driven_names"]), np.atleast_1d(end["driven_values"]), strict=True)
    )
    if set(here) != set(there):
        raise ValueError(
            f"start: the drives of {name} prescribe {', '.join(there) or 'nothing'}, "
            f"those of this scene {', '.join(here) or 'nothing'}"
        )
    slides = {d.target.name for d in mechanism.scene.drives if d.prescribes and d.slides}
    for target, value in here.items():
        apart, unit = (there[target] - value) / mechanism.start.size, "of the mechanism's size"
        if target not in slides:
            turns = (there[target] - value) / (2.0 * math.pi)
            apart, unit = turns - round(turns), "turns"
        if abs(apart) > PHASE:
            raise ValueError(
                f"start: {name} ended with {target} {apart:.6g} {unit} from where this scene "
                f"starts; "
                "end it after whole turns, or start this scene there"
            )


def quasi_static(mechanism: Mechanism) -> np.ndarray:
    """State in which journals neither move in their clearances nor are accelerated, where the scene
    starts.

    Pseudo-transient continuation: implicit Euler steps of de/dt = a(e), longer and longer, which
    become Newton's method on the accelerations a of the eccentricities e at rest. Raises ValueError
    where there is no such state or where it is not reached.
    """
    if not mechanism.places:
        raise ValueError('start: "quasi-static" is for scenes with clearance joints')
    y, size, sizes = mechanism.y0.copy(), mechanism.size, _own_sizes(mechanism)
    offsets = [np.arange(size)[place] for place in mechanism.offsets.values()]
    places = np.concatenate(offsets)
    rates = mechanism.layout.rates.start + places
    y[rates] = 0.0
    work = np.append(mechanism.work0, 0.0)
    work[: len(mechanism.layout.spots)] = 0.0  # contacts of dry joints carry too
    slope, rate = np.zeros(size * size), np.zeros(y.size)
    rhs, jacobian = mechanism.kernel("rhs"), mechanism.kernel("jacobian")
    step, enough = FIRST_STEP / mechanism.frequency**2, AT_REST * mechanism.acceleration
    last = math.inf
    for _ in range(ITERATIONS):
        rhs(0.0, y, mechanism.par, work, rate)
        pull = rate[rates]
        left = float(np.abs(pull).max())
        if left <= enough:
            return y[:size]
        jacobian(0.0, y, mechanism.par, work, slope)
        stiffness = slope.reshape(size, size)[np.ix_(rates, places)]
        if not (np.isfinite(pull).all() and np.isfinite(stiffness).all()):
            break
        step *= min(max(last / left, 0.5), 10.0) if math.isfinite(last) else 1.0
        last = left
        move = np.zeros(y.size)
        move[places] = np.linalg.solve(np.eye(places.size) / step - stiffness, pull)
        y += move * min(_share_of_room(y[at] / sizes[at], move[at] / sizes[at]) for at in offsets)
    raise ValueError(
        "start: there is no quasi-static state: the joint forces at the start move the journals "
        "through "
        f"{left / mechanism.acceleration:.2g} of the typical acceleration still"
    )


def _share_of_room(place: np.ndarray, move: np.ndarray) -> float:
    """Share of a joint's move, halved until it goes no further outward than a part of the room
    left.

    place, move: offsets over their natural sizes. Along the wall it may go further than across.
    """
    before, share = np.linalg.norm(place), 1.0
    room = ROOM * max(1.0 - before, THINNEST)
    for _ in range(HALVINGS):
        if np.linalg.norm(place + share * move) - before <= room:
            break
        share *= 0.5
    return share
