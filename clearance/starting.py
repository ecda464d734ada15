"""Where a run starts: the scene's own start, the state at the end of another run, or a quasi-static one."""

import math
from pathlib import Path

import numpy as np

from clearance.loads import Drive
from clearance.mechanism.build import Mechanism
from clearance.results import Record, open_result

QUASI_STATIC = "quasi-static"
ITERATIONS = 200  # of the search for a quasi-static state, at most
FIRST_STEP = 1e-3  # of it, over the typical time 1 / frequency
ROOM = 0.5  # share of the clearance left that one of its steps may take
THINNEST = 1e-3  # of the clearance: room that a journal at the wall has all the same
HALVINGS = 60  # of one of its steps, at most
AT_REST = 1e-9  # of the typical acceleration: what is left of the journals' at the end
PHASE = 1e-6  # of a turn: a drive that stands further from its start there begins another motion


def state_names(mechanism: Mechanism) -> list[str]:
    """Names of the states of a mechanism without its ledger, in their order."""
    structure = mechanism.structure
    coordinates = [f"bodies/{c.body.name}/{c.what}" for c in mechanism.plan.free]
    coordinates += [f"joints/{j.name}/eccentricity_{axis}" for j in mechanism.eccentric for axis in "xy"]
    bristles = [f"joints/{name}/bristle_deflection" for name in structure.bristles]
    warmings = [f"joints/{name}/warming" for name in structure.warm]
    return [*coordinates, *(f"rate of {name}" for name in coordinates), *bristles, *warmings]


def end_state(mechanism: Mechanism, y: np.ndarray, work: np.ndarray, time: float) -> dict:
    """Attributes of a result file that another run can start from."""
    joints = len(mechanism.scene.clearance_joints)
    carried = work[joints : joints + len(mechanism.structure.carried)]
    return {"names": state_names(mechanism), "values": y[: mechanism.size], "carried": carried, "time": time}


def state_from(mechanism: Mechanism, start: Record | str | Path) -> tuple[np.ndarray, np.ndarray, str]:
    """State and carried angles that a run starts with, and a sentence about them.

    start: a result, the path of its file, or "quasi-static". Raises ValueError for a run that has not kept its end,
    whose states are others, or that ended with the drive elsewhere in its turn.
    """
    if start == QUASI_STATIC:
        return quasi_static(mechanism), _carried(mechanism), "quasi-static: films carry the joint forces"
    record = start if isinstance(start, Record) else open_result(start)
    name = Path(record.path).name if hasattr(record, "path") else "another run"
    end = record.facts("state")
    if not end:
        raise ValueError(f"start: {name} has not kept the state at its end; it was written by an older clearance")
    names, given = state_names(mechanism), [str(n) for n in end["names"]]
    if set(names) != set(given):
        missing = ", ".join(sorted(set(names) - set(given))) or "none"
        more = ", ".join(sorted(set(given) - set(names))) or "none"
        raise ValueError(f"start: {name} has other states than this scene: missing {missing}; too many {more}")
    _check_phase(mechanism, name, float(end["time"]), record)
    values = dict(zip(given, np.asarray(end["values"], dtype=float), strict=True))
    carried = np.asarray(end["carried"], dtype=float)
    if carried.size != _carried(mechanism).size:
        carried = _carried(mechanism)
    state = np.array([values[n] for n in names])
    return state, carried, f"the end of {name}, t = {float(end['time']):.9g} s"


def _carried(mechanism: Mechanism) -> np.ndarray:
    joints = len(mechanism.scene.clearance_joints)
    return mechanism.work0[joints : joints + len(mechanism.structure.carried)]


def _check_phase(mechanism: Mechanism, name: str, time: float, record: Record) -> None:
    """Drives at constant speed stand where they start, but for whole turns."""
    described = {d["name"]: d for d in record.scene["loads"] if d["type"] == "Drive"}
    for drive in (d for d in mechanism.scene.loads if isinstance(d, Drive) and d.speed is not None):
        other = described.get(drive.name)
        if other is None or not other.get("speed") or record.turn is None:
            continue
        turns = other["speed"] * time / (2.0 * math.pi)
        if abs(turns - round(turns)) > PHASE:
            raise ValueError(
                f"start: {name} ended {turns:.6g} turns of drive {drive.name} after its start; "
                "only the end of a whole number of turns is a start of this scene"
            )


def quasi_static(mechanism: Mechanism) -> np.ndarray:
    """State in which journals neither move in their clearances nor are accelerated, where the scene starts.

    Pseudo-transient continuation: implicit Euler steps of de/dt = a(e), longer and longer, which become Newton's method
    on the accelerations a of the eccentricities e at rest. Raises ValueError where there is no such state or where it
    is not reached.
    """
    if not mechanism.places:
        raise ValueError('start: "quasi-static" is for scenes with clearance joints')
    places = np.concatenate([[at, at + 1] for at in mechanism.places.values()])
    clearances = np.repeat([j.clearance for j in mechanism.places], 2)
    y, size, p = mechanism.y0.copy(), mechanism.size, mechanism.coordinates
    y[p + places] = 0.0
    work = np.append(mechanism.work0, 0.0)
    work[: len(mechanism.scene.clearance_joints)] = 0.0  # contacts of dry joints carry too
    slope, rate = np.zeros(size * size), np.zeros(y.size)
    rhs, jacobian = mechanism.kernel("rhs"), mechanism.kernel("jacobian")
    step, enough = FIRST_STEP / mechanism.frequency**2, AT_REST * mechanism.acceleration
    last = math.inf
    for _ in range(ITERATIONS):
        rhs(0.0, y, mechanism.par, work, rate)
        pull = rate[p + places]
        left = float(np.abs(pull).max())
        if left <= enough:
            return y[:size]
        jacobian(0.0, y, mechanism.par, work, slope)
        stiffness = slope.reshape(size, size)[np.ix_(p + places, places)]
        if not (np.isfinite(pull).all() and np.isfinite(stiffness).all()):
            break
        step *= min(max(last / left, 0.5), 10.0) if math.isfinite(last) else 1.0
        last = left
        move = np.linalg.solve(np.eye(places.size) / step - stiffness, pull)
        y[places] += move * _share_of_room(y[places], move, clearances)
    raise ValueError(
        'start: no quasi-static state was found: the joint forces at the start move the journals through '
        f"{left / mechanism.acceleration:.2g} of the typical acceleration still"
    )


def _share_of_room(place: np.ndarray, move: np.ndarray, clearances: np.ndarray) -> float:
    """Share of a move, halved until no journal goes further outward than a part of the room that it has left.

    Along the wall it may go further than across.
    """
    clearance = clearances[::2]
    before = np.hypot(*place.reshape(-1, 2).T)
    room = ROOM * np.maximum(clearance - before, THINNEST * clearance)
    share = 1.0
    for _ in range(HALVINGS):
        after = np.hypot(*(place + share * move).reshape(-1, 2).T)
        if (after - before <= room).all():
            break
        share *= 0.5
    return share
