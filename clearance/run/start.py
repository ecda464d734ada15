"""Start of a run: the scene's own start, the state at the end of another run, or a quasi-static
one.
"""

import math
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from pathlib import Path

import numpy as np

from clearance.elements.joint import Joint
from clearance.mechanism.assembly import rate_at
from clearance.mechanism.build import TURN, Mechanism, build
from clearance.results.record import Record
from clearance.results.result import open_result
from clearance.values.algebra import solve

QUASI_STATIC = "quasi-static"
ITERATIONS = 200  # of the search for a quasi-static state, at most
FIRST_STEP = 1e-3  # of it, over the typical time 1 / frequency
ROOM = 0.5  # share of the clearance left that one of its steps may take
THINNEST = 1e-3  # of the clearance: room that a journal at the wall has all the same
YIELDING = 0.1  # the same where a film on a layer goes on through the wall
GAINED = 1.1  # ratio of accelerations from which a step counts as one that gets on
HALVINGS = 60  # of one of its steps, at most
AT_REST = 1e-9  # of the typical acceleration: what is left of the journals' at the end
STOPPED = 1e-3  # rate over a faster one, or over that of the mechanism, that counts as rest
PHASE = 1e-6  # of a turn, or of the size: how far a drive may stand from where the scene starts


def end_state(
    mechanism: Mechanism, y: np.ndarray, work: np.ndarray, time: float, angles: np.ndarray
) -> dict:
    """Attributes of a result file that another run can start from.

    angles: of bodies whose outputs are counted on from step to step.
    """
    driven, drives = prescribed(mechanism, time), mechanism.scene.drives
    return {
        "names": mechanism.layout.names,
        "values": y[: mechanism.size],
        "sizes": mechanism.remembered(("own sizes",), partial(_own_sizes, mechanism)),
        "carried": _carried(mechanism, work),
        "driven_names": list(driven),
        "driven_values": np.array(list(driven.values())),
        "driven_rates": np.array([rate_at(d, time) for d in drives if d.prescribes]),
        "angle_names": mechanism.layout.wrapped,
        "angles": angles,
        "opened": list(mechanism.opened),
        "time": time,
    }


def prescribed(mechanism: Mechanism, time: float) -> dict[str, float]:
    """Coordinates that drives prescribe at a time: by the body or joint that is driven, rad or
    m.
    """

    def number(drive, name: str) -> float:
        return mechanism.par[mechanism.layout.parameters[f"{drive.key}/{name}"]]

    return {
        d.target.name: float(
            d.motion(time) + number(d, "turned")
            if d.speed is None
            else number(d, "start") + d.speed * time
        )
        for d in mechanism.scene.drives
        if d.prescribes
    }


def _carried(mechanism: Mechanism, work: np.ndarray) -> np.ndarray:
    """Angles and slides that Newton's method in the kernel starts from."""
    return work[mechanism.layout.carried_places]


@dataclass(frozen=True)
class Beginning:
    """A state to begin in: values of all states, carried angles, and a sentence about them.

    turns: full ones by which drives stand ahead of the scene's start, see `Mechanism.turn`. States
    are measured against these drives: a wheel on a spring, teeth. angles: from which outputs of
    `Layout.wrapped` are counted on.
    opened: joints whose loops are opened in it, see `build`.
    """

    values: tuple[float, ...]
    carried: tuple[float, ...]
    text: str
    turns: tuple[int, ...] = ()
    angles: tuple[float, ...] = ()
    opened: tuple[str, ...] = ()


def state_from(mechanism: Mechanism, start: Record | Beginning | str | Path) -> Beginning:
    """The state that a run starts with.

    start: a result, the path of its file, "quasi-static", or a state itself. Offsets in clearances
    are taken over their natural size. Raises ValueError for a run that has not stored its end,
    whose states are others, or whose drives ended elsewhere.
    """
    if (opened := opened_by(start)) == mechanism.opened:
        return _state_in(mechanism, start)
    there = build(mechanism.scene, ledger=False, opened=opened)
    begin = _state_in(there, start)
    y, work = there.y0.copy(), np.append(there.work0, 0.0)
    y[:], work[there.layout.carried_places] = begin.values, begin.carried
    there.turn(begin.turns)
    row, wrapped = (
        there.outputs(0.0, y, work),
        [there.layout.output[a] for a in there.layout.wrapped],
    )
    ahead = np.array(begin.angles or row[wrapped]) - row[wrapped]
    row[wrapped] += TURN * np.round(ahead / TURN)
    from clearance.mechanism.dead_centre import transferred

    states, carried, angles = transferred(there, y, row, mechanism)
    return Beginning(states, carried, begin.text, begin.turns, angles, mechanism.opened)


def _state_in(mechanism: Mechanism, start: Record | Beginning | str | Path) -> Beginning:
    """The same where the loops are opened that were."""
    if isinstance(start, Beginning):
        return start
    if isinstance(start, str) and start == QUASI_STATIC:
        text = f"{QUASI_STATIC}: films carry the joint forces"
        carried = _carried(mechanism, mechanism.work0)
        return Beginning(tuple(quasi_static(mechanism).tolist()), tuple(carried.tolist()), text)
    record = _record(start)
    name = Path(record.path).name if hasattr(record, "path") else "another run"
    end = _end_of(record, name)
    names, stored = mechanism.layout.names, [str(n) for n in end["names"]]
    if missing := sorted(set(names) - set(stored)):
        raise ValueError(
            f"start: {name} has other states than this scene: it has no {', '.join(missing)}"
        )
    if extra := sorted(set(stored) - set(names)):
        raise ValueError(
            f"start: {name} has other states than this scene, which has no {', '.join(extra)}"
        )
    turns = _turns_made(mechanism, name, end)
    values = dict(zip(stored, np.asarray(end["values"], dtype=float), strict=True))
    before = dict(zip(stored, np.asarray(end["sizes"], dtype=float), strict=True))
    for state, size in zip(names, _own_sizes(mechanism), strict=True):
        values[state] *= size / before[state]
    carried = np.asarray(end["carried"], dtype=float)
    if carried.size != len(mechanism.layout.carried):
        carried = _carried(mechanism, mechanism.work0)
    text = f"the end of {name}, t = {float(end['time']):.9g} s"
    before = dict(zip(map(str, end.get("angle_names", ())), end.get("angles", ()), strict=False))
    angles = tuple(float(before.get(a, 0.0)) for a in mechanism.layout.wrapped)
    state = tuple(values[n] for n in names)
    return Beginning(state, tuple(carried.tolist()), text, turns, angles, mechanism.opened)


def opened_by(start: Record | Beginning | str | Path) -> tuple[str, ...]:
    """Joints whose loops are opened in a state to begin in, see `build`."""
    if isinstance(start, Beginning):
        return start.opened
    if isinstance(start, str) and start == QUASI_STATIC:
        return ()
    return tuple(map(str, _record(start).facts("state").get("opened", ())))


def _record(start: Record | str | Path) -> Record:
    """The run at whose end another begins. Raises ValueError for what is none."""
    if not isinstance(start, Record | str | Path) or not start:
        raise ValueError(
            f'start must be a result, the path of its file or "{QUASI_STATIC}", got {start!r}'
        )
    if isinstance(start, str) and get_close_matches(start, [QUASI_STATIC]):
        raise ValueError(f'start: did you mean "{QUASI_STATIC}"? There is no file {start!r}')
    return start if isinstance(start, Record) else open_result(start)


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


def _turns_made(mechanism: Mechanism, name: str, end: dict) -> tuple[int, ...]:
    """Full turns by which drives ended ahead of where this scene starts. Raises ValueError where
    they prescribe another place.
    """
    here = prescribed(mechanism, 0.0)
    there = dict(
        zip(map(str, end["driven_names"]), np.atleast_1d(end["driven_values"]), strict=True)
    )
    if set(here) != set(there):
        raise ValueError(
            f"start: the drives of {name} prescribe {', '.join(there) or 'nothing'}, "
            f"those of this scene {', '.join(here) or 'nothing'}"
        )
    _check_rates(mechanism, name, end)
    turns = {d.target.name: 0 for d in mechanism.turning}
    for target, value in here.items():
        apart, unit = (there[target] - value) / mechanism.start.size, "of the mechanism's size"
        if target in turns:
            apart, unit = (there[target] - value) / TURN, "turns"
            turns[target] = round(apart)
            apart -= turns[target]
        if abs(apart) > PHASE:
            raise ValueError(
                f"start: {name} ended with {target} {apart:.6g} {unit} from where this scene "
                f"starts; "
                "end it after full turns, or start this scene there"
            )
    return tuple(turns.values())


def _check_rates(mechanism: Mechanism, name: str, end: dict) -> None:
    """A prescribed motion does not begin at rest where the other run ended fast, nor the other way
    round: a run-up would begin anew.
    """
    rates = dict(zip(map(str, end["driven_names"]), end.get("driven_rates", ()), strict=False))
    for drive in (d for d in mechanism.scene.drives if d.motion is not None):
        size = mechanism.start.size if drive.slides else 1.0
        here = rate_at(drive)
        low, high = sorted(map(abs, (here, there := rates.get(drive.target.name, here))))
        if low < STOPPED * high and high > STOPPED * size * mechanism.frequency:
            unit = "m/s" if drive.slides else "rad/s"
            raise ValueError(
                f"start: {name} ended with {drive.target.name} at {there:.6g} {unit}, and the "
                f"motion of this scene begins with {here:.6g} {unit}: laws of time begin anew; "
                "give the scene the speed that was reached"
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
    offsets = [np.arange(size)[part] for part in mechanism.offsets.values()]
    places, least = np.concatenate(offsets), [_room_at_wall(j) for j in mechanism.offsets]
    rates = mechanism.layout.rates.start + places
    y[rates] = 0.0
    stand_still(mechanism)
    work = np.append(mechanism.work0, 0.0)
    work[: len(mechanism.layout.spots)] = 0.0  # contacts of dry joints carry too
    slope, rate = np.zeros(size * size), np.zeros(y.size)
    rhs, jacobian = mechanism.kernel("rhs"), mechanism.kernel("jacobian")
    step, enough = FIRST_STEP / mechanism.frequency**2, AT_REST * mechanism.acceleration
    last, move, back = math.inf, np.zeros(y.size), False
    for _ in range(ITERATIONS):
        rhs(0.0, y, mechanism.par, work, rate)
        pull = rate[rates]
        largest = float(np.abs(pull).max())
        if largest <= enough:
            return y[:size]
        jacobian(0.0, y, mechanism.par, work, slope)
        stiffness = slope.reshape(size, size)[np.ix_(rates, places)]
        if not (np.isfinite(pull).all() and np.isfinite(stiffness).all()):
            break
        gain = last / largest if math.isfinite(last) else 1.0
        if back and gain < GAINED:  # to and fro over a bend
            gain = 0.5
        step *= min(max(gain, 0.5), 10.0)
        last = largest
        before, move = move, np.zeros(y.size)
        move[places] = solve(np.eye(places.size) / step - stiffness, pull)
        share = min(
            _share_of_room(y[at] / sizes[at], move[at] / sizes[at], room)
            for at, room in zip(offsets, least, strict=True)
        )
        y, back = y + share * move, float(move @ before) < 0.0
    ends = np.cumsum([at.size for at in offsets])[:-1]
    pulls = map(np.linalg.norm, np.split(pull, ends))
    moved = _moved(dict(zip(mechanism.offsets, pulls, strict=True)))
    raise ValueError(f"start: there is no quasi-static state: {moved}")


def _moved(pulls: dict) -> str:
    """The journal that is accelerated most where none moves, and the reason, in words.

    pulls: acceleration of each joint [m/s2].
    """
    joint = max(pulls, key=pulls.get)
    text = f"joint {joint.name} is accelerated by {pulls[joint]:.3g} m/s2 still"
    if joint.film_reach is None:
        return text
    return f"{text}; a film alone carries where its journal turns or slides, and up to its wall"


def stand_still(mechanism: Mechanism, still: bool = True) -> None:
    """Films with a memory count as steady, until a step has ended."""
    for source in (s for s in mechanism.sources.values() if hasattr(s, "still")):
        source.still = still


def _room_at_wall(joint: Joint) -> float:
    """Room over the natural size that a journal at the wall has."""
    return YIELDING if joint.contact is None and joint.film_reach is None else THINNEST


def _share_of_room(offset: np.ndarray, move: np.ndarray, least: float) -> float:
    """Share of a joint's move, halved until it goes no further outward than a part of the room
    left.

    offset, move: offsets over their natural sizes; least: room at the wall. Along the wall it may
    go further than across.
    """
    before, share = math.hypot(*offset), 1.0
    room = ROOM * max(1.0 - before, least)
    for _ in range(HALVINGS):
        if math.hypot(*(offset + share * move)) - before <= room:
            break
        share *= 0.5
    return share
