"""Runs of one scene from several starts in lanes, which go on turn after turn; numbers of each
turn.
"""

from collections.abc import Sequence

import numpy as np

from clearance import lanes
from clearance.accuracy.at_start import standing
from clearance.elements.regimes import DEEPEST
from clearance.lanes.code import WIDTHS, natural_width, off
from clearance.lanes.group import FILMS, GoingOn, Group, Points
from clearance.lanes.lane_metrics import LaneTurns, Wanted
from clearance.lanes.point_numbers import NotForLanes
from clearance.metrics.by_turn import Series, every
from clearance.results.extremes import BOTH
from clearance.results.record import Record
from clearance.run.diagnosis import doubtful
from clearance.run.run import Run
from clearance.stepping import status
from clearance.values.spots import FILM


class Starts:
    """Runs of a scene from several starts in lanes.

    run: as long as they may be, not begun; starts: states, (starts, states). Raises NotForLanes.
    """

    def __init__(self, run: Run, starts: Sequence[np.ndarray]):
        mechanism, method = run.mechanism, run.method.current
        if off():
            raise NotForLanes("lanes are off")
        if reason := lanes.impossible(mechanism, method):
            raise NotForLanes(reason)
        record = standing(run)
        if record.uneven:
            raise NotForLanes("a drive may stay behind its nominal speed")
        width = next((w for w in WIDTHS if w >= len(starts)), natural_width())
        self.run = run
        self.wanted, group = group_of(run, record, min(width, natural_width()))
        self.points = points_of(run, np.asarray(starts, float).T)
        self.going_on = GoingOn(group, self.points)

    def extend(self, turns: int) -> dict[str, Series]:
        """Go on to so many turns: the numbers of each turn, (starts, turns), by name.

        Raises NotForLanes where a run ends early, its energy does not add up, or it presses a
        contact deeper than it is meant for.
        """
        answers = self.going_on.extend(turns)
        if (answers.status > status.DONE).any():
            raise NotForLanes("a run failed")
        about = self.run.mechanism, self.run.labels(), answers, self.points
        seen = LaneTurns(self.wanted, *about, 0, turns)
        if self._deep(seen) or self._open(seen):
            raise NotForLanes("the energy of a run does not add up, or it presses too deep")
        return every(seen)

    def _deep(self, seen: LaneTurns) -> bool:
        """True where a contact is pressed deeper than it is meant for."""
        joints = [j for j in self.run.mechanism.scene.clearance_joints if j.contact is not None]
        depths = ((j, -seen.by_turn(f"{j.key}/gap_min").min()) for j in joints)
        return any(depth > DEEPEST * joint.solid[0] for joint, depth in depths)

    def _open(self, seen: LaneTurns) -> bool:
        """True where in some turn energy is missing, over what is turned over in one."""
        if "energy/residual_max" not in seen.peaks:
            return False
        low, high, least, most = (
            seen.by_turn(f"energy/{name}_{end}") for name in ("kinetic", "residual") for end in BOTH
        )
        turned_over = max(float((high - low).max()), 1e-300)
        return bool((most - least).max() > doubtful(self.run.solver.rtol) * turned_over)


def group_of(run: Run, record: Record, width: int) -> tuple[Wanted, Group]:
    """Outputs of runs of a scene that are looked at, and their group: those of its earlier runs.

    record: of one that stands at its start.
    """
    mechanism, method = run.mechanism, run.method.current
    key, memory = ("starts", method, width), mechanism.memory
    if key in memory and np.array_equal(memory[key][1].numbers, mechanism.par):
        return memory[key]
    wanted = Wanted(record, mechanism.layout.output, {})
    every(wanted)
    for joint in mechanism.scene.clearance_joints:
        wanted.located(f"{joint.key}/gap_min")
    for path in ("energy/kinetic", "energy/residual"):
        for end in BOTH if path in mechanism.layout.output else ():
            wanted.located(f"{path}_{end}", searched=False)
    about = wanted.watch(0, 0), wanted.channels, np.zeros((0, 2))
    memory[key] = wanted, Group(mechanism, method, run.rtol, 2, *about, width)
    return memory[key]


def points_of(run: Run, starts: np.ndarray) -> Points:
    """Runs with the numbers of one from several starts, (states, starts)."""
    state, mechanism, count = run.state, run.mechanism, starts.shape[1]
    head = len(mechanism.layout.parameters) + mechanism.layout.derived
    films = [i for i, (_, spot) in enumerate(mechanism.spots) if spot.kind == FILM]

    def alike(*numbers: float) -> np.ndarray:
        return np.tile(np.array(numbers, float)[:, None], (1, count))

    return Points(
        y=np.concatenate([starts, alike(*state.y[len(starts) :])]),
        scale=alike(*state.scale[: mechanism.size]),
        par=alike(*mechanism.par[:head]),
        work=alike(*state.work),
        films={n: alike(*state.contacts[films, column]) for n, column in FILMS.items()},
        longest=alike(state.longest_step)[0],
        begin=np.zeros(count),
        until=alike(run.span.until)[0],
        turn=alike(mechanism.scene.turn)[0],
        frequency=alike(mechanism.frequency)[0],
        numbers=np.zeros((0, count)),
        samples=np.full(count, 2),
        rtol=run.rtol,
    )
