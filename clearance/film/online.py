"""Film laws that solve the Reynolds equation as the run goes: for what no table holds, and to check
the table.

`solved` is memoryless and stands where any film law stands. `conserving` has a memory: the oil
content of the gap, over the bearing, is stored from step to step (implicit Euler between accepted
states). Its liner may be elastic. Both are answered in Python (machine/callback.py), some 1e3 to
1e4 times dearer than the table. The finite elements of a run are those of film/moving.py, smooth in
the motion; film/fem.py is their reference.
"""

import math
import time as clock_of_the_wall
from collections.abc import Callable

from clearance.film.bearing import (
    CAVITATIONS,
    DRAG,
    RING,
    WET,
    Bearing,
    Groove,
    check_drag,
    check_mesh,
)
from clearance.laws.film import SIDE_FLOW
from clearance.laws.law import BoundLaw, DataLaw, FilmJoint, memory_film, wet_film
from clearance.machine.callback import KEEP, SLOPES, VALUE, Callback, answered
from clearance.values import checks

# solutions a turn at rtol 1e-6, of the feeder
USUAL = {"fem": 5000, "fast": 16_000, "conserving": 100_000}
VALUES = 15  # solutions without slopes for one with them, in usual runs
APART = 0.01  # eccentricity ratios of the stages of a step
FEELER = 1e-5  # of the clearance: step of a difference by the lift
NEAREST = 1.0 - 1e-4  # largest eccentricity ratio for a finite element mesh
FOREVER = 1e9  # time [s] after which a film is steady


def solved(eccentricity_ratio, radial_rate, entrainment, joint, data, start):
    """Film of a finite bearing, its Reynolds equation solved at every call [N, N, 1].

    The equation and its frame are those of film/bearing.py. Derivatives of finite elements are
    exact, the fast solver takes differences. Eccentricity ratios above 0.9999 count as 0.9999.
    """
    return answered(data, start, VALUE, (eccentricity_ratio, radial_rate, entrainment), 3)


def solved_side_flow(eccentricity_ratio, radial_rate, entrainment, joint, data, start):
    """Oil that leaves the bearing at both ends [m3/s]."""
    return answered(data, start, VALUE, (eccentricity_ratio, radial_rate, entrainment), 4)[3]


def conserving(film_state, joint, data, start):
    """Film that conserves its oil, on the bearing [N, N, 1]: force on the journal along the
    bearing's axes, shear.

    Jakobsson, Floberg and Olsson's film (film/conserving.py) at the time of the state, after that
    of the last accepted step.
    """
    return answered(data, start, VALUE, film_state, 3)


def conserving_side_flow(film_state, joint, data, start):
    """Oil that leaves the bearing at both ends [m3/s]."""
    return answered(data, start, VALUE, film_state, 4)[3]


def conserving_keep(film_state, joint, data, start):
    """Remember this state as the last accepted one; returns its time [s]."""
    return film_state.time + answered(data, start, KEEP, film_state, 1)[0]


def _usual(solve: Callable[[float, float], object]) -> float:
    """Mean CPU time of solutions as a step of a run requests them: values at some states apart,
    then slopes.

    The first ones prepare what the others use and do not count.
    """
    spent = []
    for eccentricity_ratio in (0.7, 0.75, 0.8, 0.85):
        began = clock_of_the_wall.process_time()
        for i in range(VALUES):
            solve(VALUE, eccentricity_ratio + APART * (i % 3))
        solve(SLOPES, eccentricity_ratio)
        spent.append((clock_of_the_wall.process_time() - began) / (VALUES + 1))
    return min(spent[1:])


def _oil(settings: dict) -> dict:
    """Settings of the oil, as a Bearing has them; old files have none."""
    return {n: settings[n] for n in ("pressure_viscosity", "roelands") if n in settings}


def _oil_settings(law: str, pressure_viscosity: float, roelands: bool, drag: str) -> dict:
    """Settings of a law, checked."""
    alpha = checks.non_negative(f"{law}: pressure_viscosity", pressure_viscosity)
    settings = {"pressure_viscosity": alpha, "roelands": bool(roelands)}
    return settings | {"drag": check_drag(law, drag)}


class FilmAnswer(Callback):
    """The memoryless film behind a joint, of either solver."""

    def __init__(self, joint: FilmJoint, settings: dict):
        bearing = Bearing.of(
            joint,
            cavitation=settings["cavitation"],
            ambient=settings["ambient"],
            grooves=settings["grooves"],
            roughness=joint.roughness if settings["flow_factors"] else 0.0,
            **_oil(settings),
        )
        drag = settings.get("drag", WET)
        mesh = settings["mesh"]
        self.usual = USUAL[settings["solver"]]
        if settings["solver"] == "fem":
            from clearance.film.moving import MovingFilm

            self.film = MovingFilm(bearing, mesh, drag)
            self.filled = False
        else:
            from clearance.film.bands import FastFilm

            self.film = FastFilm(bearing, mesh)
            self.filled = drag == RING
        self.asked, self.answered, self.rows = None, VALUE, None
        super().__init__(3, 4, self._solve)

    def doubt(self, eccentricity_ratio: float) -> str | None:
        """Objection to the mesh at the largest eccentricity of a run."""
        return self.film.doubt(eccentricity_ratio) if hasattr(self.film, "doubt") else None

    def seconds(self) -> float:
        """CPU time of one solution."""
        return _usual(lambda wanted, eps: self._solve(wanted, [eps, -1.0, 30.0]))

    def _solve(self, wanted: float, state: list[float]):
        if state == self.asked and wanted <= self.answered:
            return self.rows
        motion = min(state[0], NEAREST), *state[1:]
        if wanted == VALUE:
            self.rows = self.film.outputs(*motion)[:, None]
        else:
            self.rows = self.film.linearised(*motion)
        if self.filled:
            gap = 1.0 - motion[0] * motion[0]
            shear = 2.0 * math.pi / math.sqrt(gap)
            self.rows[2] = [shear, shear * motion[0] / gap, 0.0, 0.0][: self.rows.shape[1]]
        if wanted != VALUE and motion[0] < state[0]:
            self.rows[:, 1] = 0.0
        self.asked, self.answered = list(state), wanted
        return self.rows


class MemoryAnswer(Callback):
    """The film with memory behind a joint; times only grow between two resets.

    still: it is steady until it remembers a moment, as where a run starts quasi-statically.
    """

    usual = USUAL["conserving"]

    def __init__(self, joint: FilmJoint, settings: dict):
        from clearance.film.conserving import MemoryFilm

        bearing = Bearing.of(
            joint, ambient=settings["ambient"], grooves=settings["grooves"], **_oil(settings)
        )
        depths = settings.get("bearing"), settings.get("journal")  # of a joint with worn outlines
        self.film = MemoryFilm(
            bearing,
            settings["mesh"],
            settings["liner"],
            settings["memory"],
            *depths,
            drag=settings.get("drag", WET),
        )
        self.worn = any(map(bool, depths))
        super().__init__(9, 4, self._solve)
        self.reset()

    def reset(self) -> None:
        """Back to the start of a run: full of oil."""
        super().reset()
        self.film.reset()
        self.now, self.asked, self.rows, self.worst = 0.0, None, None, 0.0
        self.answered, self.still = VALUE, False

    def _solve(self, wanted: float, state: list[float]):
        *motion, angle, lift, lift_rate, time = state
        elapsed = FOREVER if self.still else max(time - self.now, 0.0)
        if wanted == KEEP:
            self.film.commit(*motion, elapsed, angle, lift, lift_rate)
            self.still = False
            self.worst = max(self.worst, self.film.mass_defect)
            self.now, self.asked = time, None
            return None
        if state != self.asked or wanted > self.answered:
            solved = self.film.trial(*motion, elapsed, angle, lift, lift_rate)
            slopes = [(0.0, 0.0)] * len(solved)
            if wanted == SLOPES and (lift or lift_rate):
                slopes = self._by_lift(motion, elapsed, angle, lift, lift_rate)
            # Newton's method moves neither angle nor time
            self.rows = [[*row, 0.0, *by, 0.0] for row, by in zip(solved, slopes, strict=True)]
            self.asked = list(state)
            self.answered = wanted
        return self.rows

    def _by_lift(self, motion, elapsed: float, angle: float, *lift: float) -> list[tuple]:
        """Derivatives by lift and its rate, from differences."""

        def value(*lift: float):
            return self.film.trial(*motion, elapsed, angle, *lift)[:, 0]

        rows = []
        fast = max(abs(motion[4]), abs(lift[1]), 1.0)
        for step in ((FEELER, 0.0), (0.0, FEELER * fast)):
            up, down = ([at + way * h for at, h in zip(lift, step, strict=True)] for way in (1, -1))
            rows.append((value(*up) - value(*down)) / (2.0 * max(step)))
        return list(zip(*rows, strict=True))

    def facts(self) -> dict:
        """Facts of it in the report of a run."""
        return {"film_mass_defect": self.worst}

    def seconds(self) -> float:
        """CPU time of one solution."""
        return _usual(
            lambda wanted, eps: self._solve(wanted, [eps, *[0.0] * 3, 1.0, *[0.0] * 3, 1e-4])
        )

    def doubt(self, eccentricity_ratio: float) -> str | None:
        """Objection to the mesh at the largest eccentricity of a run."""
        if self.worn:  # a journal may stand in a scar, farther off than the clearance
            return None
        return self.film.doubt(eccentricity_ratio)


# they solve for the viscosity they began with
_solved = DataLaw(
    wet_film,
    solved,
    {"shown": {"side_flow": (*SIDE_FLOW, solved_side_flow)}, "linear_in_viscosity": False},
    FilmAnswer,
)


@_solved.doubts
def _grooves_do_not_turn_so(joint, settings):
    """A joint's grooves are on its bearing."""
    if settings["grooves"]:
        return (
            "grooves stand still against the line of centres here; conserving_film has them on "
            "the bearing"
        )
    return None


_conserving = DataLaw(
    memory_film,
    conserving,
    {
        "shown": {"side_flow": (*SIDE_FLOW, conserving_side_flow)},
        "keep": conserving_keep,
        "linear_in_viscosity": False,
    },
    MemoryAnswer,
)


@_conserving.doubts
def _liner_beside_contact(joint, settings):
    """A liner takes the journal through the wall by itself."""
    if settings["liner"] > 0.0 and joint.transition is not None:
        return (
            "its liner yields to the oil alone; contact and asperities stand at the gap that a "
            "rigid bearing has: leave contact and transition out"
        )
    return None


def _memoryless(solver: str, mesh, **settings) -> BoundLaw:
    checks.one_of(f"{solver}_film: cavitation", settings["cavitation"], CAVITATIONS[:3])
    settings |= {n: kind(settings[n]) for n, kind in (("grooves", tuple), ("flow_factors", bool))}
    return _solved.bind({"solver": solver} | settings | {"mesh": mesh and check_mesh(mesh)})


def fem_film(
    *,
    cavitation: str = "reynolds",
    ambient: float | None = None,
    grooves: tuple[Groove, ...] = (),
    flow_factors: bool = False,
    pressure_viscosity: float = 0.0,
    roelands: bool = False,
    drag: str = DRAG,
    mesh: tuple[int, int] | None = None,
) -> BoundLaw:
    """The film of a finite bearing by finite elements at every call, on a mesh that follows the
    gap: film/moving.py.

    cavitation: "reynolds", "gumbel" or "none"; ambient: pressure at the ends above cavitation [Pa]
        or None; grooves stand still against the *line of centres*; flow_factors: with those of the
        joint's roughness; pressure_viscosity: coefficient [1/Pa] of oil that the pressure thickens,
        by Barus or by Roelands (film/piezo.py), 0: isoviscous; drag: see `table_film`; mesh: cells
        around and over half the length. The default is 36 by 3 for L/D from 1/2 to 1, more around
        for a shorter bearing, more along for a longer one. It gives a load within 0.3 % up to an
        eccentricity ratio of 0.98. A turn of the feeder takes some 5000 solutions of 0.4 ms.
    """
    return _memoryless(
        "fem",
        mesh,
        cavitation=cavitation,
        ambient=ambient,
        grooves=grooves,
        flow_factors=flow_factors,
        **_oil_settings("fem_film", pressure_viscosity, roelands, drag),
    )


def fast_film(
    *,
    cavitation: str = "reynolds",
    ambient: float | None = None,
    grooves: tuple[Groove, ...] = (),
    flow_factors: bool = False,
    drag: str = DRAG,
    mesh: tuple[int, int] = (48, 6),
) -> BoundLaw:
    """As `fem_film`, by the fast solver that tables are made with; its oil is isoviscous."""
    return _memoryless(
        "fast",
        mesh,
        cavitation=cavitation,
        ambient=ambient,
        grooves=grooves,
        flow_factors=flow_factors,
        drag=check_drag("fast_film", drag),
    )


def conserving_film(
    *,
    ambient: float | None = None,
    grooves: tuple[Groove, ...] = (),
    liner: float = 0.0,
    pressure_viscosity: float = 0.0,
    roelands: bool = False,
    memory: bool = True,
    drag: str = DRAG,
    mesh: tuple[int, int] = (64, 6),
) -> BoundLaw:
    """The film that conserves its oil through cavitation, with a memory; see the law `conserving`.

    ambient: pressure at the ends above cavitation [Pa] or None; grooves: on the bearing; liner:
        compliance [m/Pa] of an elastic lining, 0 for rigid, with which the journal may pass the
        wall; pressure_viscosity, roelands: see `fem_film`; memory: False leaves the memory of the
        oil out (for a liner alone); drag: see `table_film`, wet counts a cavity with its content;
        mesh: cells around and over half the length. Starts full of
        oil. First order in the step, which is at most a 400th of a turn.
    """
    liner = checks.non_negative("conserving_film: liner", liner)
    settings = {
        "ambient": ambient,
        "grooves": tuple(grooves),
        "liner": liner,
        "memory": bool(memory),
        **_oil_settings("conserving_film", pressure_viscosity, roelands, drag),
    }
    return _conserving.bind(settings | {"mesh": check_mesh(mesh)})
