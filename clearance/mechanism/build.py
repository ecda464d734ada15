"""Scene to mechanism: structure (shared, compiled) and numbers (of this scene)."""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from itertools import zip_longest

import numpy as np

from clearance.elements.body import ABSOLUTE
from clearance.elements.declared import ours
from clearance.elements.element import Element, Spot
from clearance.laws.law import BoundLaw, DataLaw
from clearance.machine.callback import Callback
from clearance.mechanism.assembly import Start, assemble
from clearance.mechanism.kept import kept
from clearance.mechanism.kinematics import Kinematics, Pose
from clearance.mechanism.loops import check_reach, mode
from clearance.mechanism.numbers import Numbers
from clearance.mechanism.structure import Layout, Structure, Tracing, marked, named
from clearance.mechanism.topology import Plan, closed_plan, cut_plan, opens
from clearance.scene.scene import Scene, counterparts, exchanged
from clearance.tracing.trace import Trace
from clearance.values.spots import BLENDED

_structures: dict[tuple, Structure] = {}
_planned: dict[tuple, tuple[Scene, tuple[Plan, Plan], tuple]] = {}
_built: dict[tuple, "Mechanism"] = {}  # of the latest scenes
TURN = 2.0 * math.pi
ROUNDING = 1e-9  # of a turn
MOST_BUILT = 4
MOST_REMEMBERED = 16  # entries of the memory of a scene
#: what follows from a scene and is looked up once for all runs of it
SHARED = ("spots", "reach", "pace", "energy", "acceleration", "scale")
SHARED += ("offsets", "places", "share", "turning", "opens", "memory")
MOST_STRUCTURES = 200  # that a process keeps; a trace takes some 3 MB, names of its parts little


@dataclass
class Mechanism:
    """A scene ready to run: kernels of its structure, its parameter vector and its start."""

    scene: Scene
    structure: Structure
    plan: Plan
    start: Start
    par: np.ndarray
    y0: np.ndarray
    work0: np.ndarray
    # joint -> data of its film law: a table or a callback
    sources: dict = field(default_factory=dict)
    opened: tuple[str, ...] = ()  # joints whose loops are opened, see `build`

    @property
    def layout(self) -> Layout:
        """Places of its numbers."""
        return self.structure.layout

    @property
    def size(self) -> int:
        """Number of first-order states without the ledger."""
        return self.layout.states

    @property
    def coordinates(self) -> int:
        """Number of second-order degrees of freedom."""
        return self.layout.size

    def copy(self) -> "Mechanism":
        """The same mechanism, with numbers that may change."""
        same = Mechanism.__new__(Mechanism)
        par = self.par.copy()
        vars(same).update(vars(self), par=par, y0=self.y0.copy(), work0=self.work0.copy())
        return same

    def kernel(self, role: str) -> Callable:
        """The compiled kernel of a role; compiled on first use only."""
        return self.structure.kernel(role)

    def outputs(self, time: float, y: np.ndarray, work: np.ndarray) -> np.ndarray:
        """One row of outputs; the work vector stays as it is."""
        row = np.empty(len(self.layout.channels))
        self.kernel("observe")(time, y, self.par, work.copy(), row)
        return row

    @cached_property
    def spots(self) -> list[tuple[Element, Spot]]:
        """Places where elements may touch, in the order of the layout."""
        return self.scene.spots

    @cached_property
    def opens(self) -> bool:
        """True where some loop has a joint that only forces hold, and can be opened there."""
        return opens(self.plan)

    @cached_property
    def memory(self) -> dict:
        """Numbers that follow from the scene alone, as runs have worked them out."""
        return {}

    def remembered(self, key: tuple, make: Callable):
        """An entry of the memory, which follows from the scene and the key: made once, as long as
        there are few.
        """
        if (entry := self.memory.get(key)) is None:
            if len(self.memory) >= MOST_REMEMBERED:
                self.memory.clear()
            entry = self.memory[key] = make()
        return entry

    @property
    def numbers(self) -> bytes:
        """Its numbers that may change from run to run: all but those of tables."""
        par = self.par[: len(self.layout.parameters) + self.layout.derived]
        return b"".join(numbers.tobytes() for numbers in (par, self.y0, self.work0))

    @cached_property
    def reach(self) -> np.ndarray:
        """Free way of each spot [m]."""
        return np.array([spot.reach for _, spot in self.spots])

    @property
    def measures(self) -> np.ndarray:
        """Lengths that each spot's penetration is a difference of [m]: its rounding goes by them.

        Offsets that are no coordinates are differences of places of bodies.
        """
        offsets, farthest = self.eccentric, self.start.farthest
        longest = (s.longest if e in offsets else farthest for e, s in self.spots)
        return np.maximum(self.reach, np.fromiter(longest, float))

    @cached_property
    def turning(self) -> list:
        """Drives that prescribe an angle."""
        return [d for d in self.scene.drives if d.prescribes and not d.slides]

    def turn(self, turns: Collection[int]) -> None:
        """Have the drives of `turning` stand so many full turns ahead of the scene's start."""
        for drive, count in zip_longest(self.turning, turns, fillvalue=0):
            begin, base = "turned", 0.0
            if drive.motion is None:
                begin = "start"
                base = self.start.coordinate(drive.target)
            self.par[self.layout.parameters[f"{drive.key}/{begin}"]] = base + TURN * count

    def count_from(self, y: np.ndarray, work: np.ndarray) -> None:
        """Have finite drives count their turns from this state on; its part of a turn stays."""
        finite = [d for d in self.scene.drives if d.nominal]
        par = self.layout.parameters
        row = self.outputs(0.0, y, work) if finite else ()
        for drive in finite:
            turns = math.floor(row[self.layout.output[f"{drive.key}/turns"]] + ROUNDING)
            self.par[par[f"{drive.key}/start"]] += math.copysign(TURN, drive.nominal) * turns

    def blend(self) -> None:
        """Give spots without a first touch a typical speed instead of that of their impact."""
        for i, (_, spot) in enumerate(self.spots):
            if spot.kind == BLENDED:
                self.work0[i] = max(spot.speed, self.reach[i] * self.frequency)

    @property
    def eccentric(self) -> list:
        """Soft joints whose offsets are coordinates."""
        return [j for j in self.scene.soft_joints if j not in self.start.measured]

    @property
    def frequency(self) -> float:
        """A typical angular frequency [rad/s]: the pace, or 1 rad/s without one."""
        return self.pace or 1.0

    @cached_property
    def pace(self) -> float:
        """The angular frequency [rad/s] of the drives, of the start or of gravity; 0 where a motion
        has none of them.
        """
        start = [abs(w[2]) for w in self.start.velocity.values()]
        start += [abs(d.nominal) for d in self.scene.drives if d.nominal]
        speeds = [abs(v[0]) / self.start.size for v in self.start.velocity.values()]
        gravity = math.sqrt(math.hypot(*self.scene.gravity) / self.start.size)
        return max([*start, *speeds, gravity])

    @cached_property
    def energy(self) -> float:
        """A typical energy [J]: of all bodies, as fast as the motion."""
        return energy_of(sum(b.mass for b in self.scene.bodies), self.start.size, self.frequency)

    @cached_property
    def acceleration(self) -> float:
        """A typical acceleration [m/s2]: of the motion and of gravity together."""
        return acceleration_of(self.start.size, self.frequency, self.scene.gravity)

    @cached_property
    def offsets(self) -> dict:
        """Places of each joint's offsets in the state, for those that are coordinates."""
        return {j: slice(at, at + len(j.soft_coordinates)) for j, at in self.places.items()}

    @cached_property
    def places(self) -> dict:
        """Place of each joint's first offset in the state, for those that are coordinates."""
        return {j: self.layout.state[f"{j.key}/{j.soft_coordinates[0][1]}"] for j in self.eccentric}

    @cached_property
    def share(self) -> float:
        """The smallest clearance that is measured over the mechanism's size, 1 without one: places
        of bodies need to be finer by so much.
        """
        measured = (s.reach for e, s in self.spots if e in self.start.measured)
        return min([1.0, *(reach / self.start.size for reach in measured)])

    @cached_property
    def scale(self) -> np.ndarray:
        """Natural size of each state: 1 rad for free angles, the size for lengths, both times the
        share of a measured clearance. Elements give that of theirs. Rates: times the frequency.
        """
        sizes = {f"{e.key}/{s.name}": s.size for e in self.scene.elements for s in e.states()}
        free = {c.key: 1.0 if c.turns else self.start.size for c in self.plan.free}
        sizes |= {key: self.share * size for key, size in free.items()}
        lengths = [sizes[name] for name in self.layout.coordinates]
        first_order = [sizes[name] for name in self.layout.first_order]
        return np.array(lengths + [x * self.frequency for x in lengths] + first_order)


def energy_of(mass: float, size: float, frequency: float) -> float:
    """A typical energy [J] of bodies of a mass [kg] in a motion of a size [m] and angular frequency
    [rad/s].
    """
    return mass * (size * frequency) ** 2


def acceleration_of(size: float, frequency: float, gravity: tuple[float, ...]) -> float:
    """A typical acceleration [m/s2] of a motion of a size [m] and angular frequency [rad/s], under
    gravity.
    """
    return size * frequency**2 + math.hypot(*gravity)


def build(scene: Scene, ledger: bool = True, opened: Collection[str] = ()) -> Mechanism:
    """Assemble a scene and find or make its structure; the latest scenes are not assembled again.

    Raises ValueError with a clear reason for impossible scenes.

    opened: names of joints with clearance whose offsets are measured, and no coordinates: then
        places of bodies are. A loop that is opened so has no dead centre.
    """
    key = id(scene), ledger, tuple(opened)
    if (before := _built.get(key)) is None or before.scene is not scene:
        before = _assembled(scene, ledger, opened)
        if not _lasting(before):
            return before
        for name in SHARED:
            getattr(before, name)
        _built.pop(key, None)
        _built[key] = before
        while len(_built) > MOST_BUILT:
            _built.pop(list(_built)[0], None)  # noqa: RUF015 - other threads take some away, too
    return before.copy()


def _lasting(mechanism: Mechanism) -> bool:
    """True where later runs of a scene may share what follows from it.

    A film that answers belongs to one run. Numbers of a user's module may change between runs.
    """
    elements = mechanism.scene.elements
    values = (getattr(e, f.name) for e in elements for f in fields(e))
    functions = (v.law.function for v in values if isinstance(v, BoundLaw))
    answers = any(isinstance(source, Callback) for source in mechanism.sources.values())
    return not answers and all(map(ours, [*map(type, elements), *functions]))


def _assembled(scene: Scene, ledger: bool, opened: Collection[str]) -> Mechanism:
    """The mechanism of a scene."""
    numbers = Numbers(scene)
    start, extra = _started(scene, numbers, opened)
    plan, cut, way = _plans(scene, numbers, start.measured)
    for group in (*plan.groups, *cut.groups):
        check_reach(group, start.size)
    names = tuple(p.name for p in scene.parts)
    trace = numbers.signature, way, ledger

    def traced() -> Structure:
        return _traced(scene, plan, cut, start.measured, ledger)

    again = partial(_again, ledger=ledger, opened=[scene.positions[j.key] for j in extra])
    structure = _shared(
        _structures,
        (trace, names),
        lambda: _shared(_structures, (trace,), lambda: kept(trace, scene, traced, again)).named(
            names
        ),
    )
    _check_friction(scene, structure)
    sources = _sources(scene)
    par = _parameters(structure, _values(scene, structure, plan, numbers, start), sources)
    y0 = _state(scene, plan, start, structure.layout)
    work = _work(scene, structure, start)
    opened = (j.name for j in extra)
    mechanism = Mechanism(
        scene, structure, plan, start, par, y0, work, _films(sources), tuple(opened)
    )
    mechanism.blend()
    return mechanism


def _started(scene: Scene, numbers: Numbers, opened: Collection[str]) -> tuple[Start, list]:
    """The start of a scene, and joints that are opened besides those that are measured anyway."""
    start = assemble(scene, numbers)
    extra = [j for j in scene.soft_joints if j.name in opened and j not in start.measured]
    return replace(start, measured=(*start.measured, *extra)), extra


def _again(scene: Scene, ledger: bool, opened: list[int]) -> Structure:
    """The structure of a scene, traced; opened: positions of joints."""
    numbers = Numbers(scene)
    start, _ = _started(scene, numbers, [scene.parts[i].name for i in opened])
    plan, cut, _ = _plans(scene, numbers, start.measured)
    return _traced(scene, plan, cut, start.measured, ledger)


def _shared(memory: dict, key: tuple, make: Callable):
    """The entry of a memory, made where it has none; a full one loses its oldest."""
    if key not in memory:
        entry = make()
        if len(memory) >= MOST_STRUCTURES:
            del memory[next(iter(memory))]
        memory[key] = entry
    return memory[key]


def _traced(scene: Scene, plan: Plan, cut: Plan, measured: tuple, ledger: bool) -> Structure:
    """The structure of a scene, with marks for the names of its parts."""
    nameless = marked(scene)
    way = exchanged((plan, cut, measured), counterparts(scene, nameless))
    try:
        return Tracing(nameless, Numbers(nameless), *way, ledger).structure()
    except Exception as error:
        names = [p.name for p in scene.parts]
        error.args = tuple(named(a, names) if isinstance(a, str) else a for a in error.args)
        raise


def _plans(scene: Scene, numbers: Numbers, measured: tuple) -> tuple[Plan, Plan, tuple]:
    """Plans with the clearance joints closed and cut, and what a trace depends on of them; scenes
    of one structure and the same lengths share them.
    """
    lengths = tuple((p.x, p.y) for j in scene.joints for p in (j.a, j.b))
    key = numbers.signature, tuple(scene.positions[j.key] for j in measured), lengths

    def planned() -> tuple:
        plans = closed_plan(scene, measured), cut_plan(scene)
        return scene, plans, (key[1], *(plan.signature(scene.positions) for plan in plans))

    before, plans, way = _shared(_planned, key, planned)
    if before is not scene:
        plans = exchanged(plans, counterparts(before, scene))
    return *plans, way


def changed(mechanism: Mechanism, changes: dict[str, float], time: float = 0.0) -> Mechanism:
    """The mechanism with other numbers and all that depends on them, in its structure; see
    Scene.replaced.

    A drive whose speed changes goes on from where it stands at the given time [s].
    Raises ValueError for a number that the code has folded in, such as one that becomes 0.
    """
    scene = mechanism.scene.replaced(changes)
    layout = mechanism.layout
    before = Numbers(mechanism.scene)
    numbers = Numbers(scene)
    if numbers.signature != before.signature:
        raise ValueError(
            f"{', '.join(changes)}: the change needs another kernel; make another scene"
        )
    values = list(mechanism.par[: len(layout.parameters)])
    old = np.array(before.values)
    new = np.array(numbers.values)
    for index in np.flatnonzero((old != new) & ~np.isnan(new)):
        values[index] = numbers.values[index]
    for drive in (d for d in scene.drives if d.prescribes and d.motion is None):
        start, speed = (numbers.index[f"{drive.key}/{name}"] for name in ("start", "speed"))
        values[start] += (old[speed] - new[speed]) * time
    sources = _sources(scene)
    par = _parameters(mechanism.structure, values, sources)
    start = exchanged(mechanism.start, counterparts(mechanism.scene, scene))
    return replace(mechanism, scene=scene, start=start, par=par, sources=_films(sources))


def _films(sources: dict) -> dict:
    """Sources of films by joint: tables, or solvers that answer."""
    return {element: source for (element, name), source in sources.items() if name == "film"}


def _parameters(structure: Structure, values: list[float], sources: dict) -> np.ndarray:
    """The parameter vector: numbers, what is derived from them, and what laws read as a block."""
    data = _data(sources, structure, values)
    par = np.zeros(len(values) + structure.layout.derived)
    par[: len(values)] = values
    with np.errstate(all="ignore"):
        structure.derive(par)
    return np.concatenate([par, *data])


def place_named(scene: Scene, axis: str, name: str) -> tuple:
    """The place of a coordinate that a step carries on, from its name and that of its body or
    joint.
    """
    parts = scene.bodies if axis in ABSOLUTE else scene.joints
    return next(p for p in parts if p.name == name), axis


def _check_friction(scene: Scene, structure: Structure) -> None:
    """A sign function at rest cannot be integrated where the rate follows from the forces."""
    for joint in (j for j in scene.joints if j.name in structure.forced):
        law = joint.friction
        if law.law.smooth and not law.law.smooth(law.values):
            raise ValueError(
                f"{joint.label()}: friction {law.law.name} has a sign function at rest, but forces "
                f"decide on the "
                "joint's motion here; give it transition_rate > 0"
            )


def _sources(scene: Scene) -> dict:
    """(element, field) -> what its law reads, of laws with data."""
    laws = ((e, f.name, getattr(e, f.name)) for e in scene.elements for f in fields(e))
    return {
        (element, name): law.source(element.facts_for(name))
        for element, name, law in laws
        if isinstance(law, BoundLaw) and isinstance(law.law, DataLaw)
    }


def tables_of(scene: Scene) -> list:
    """Sources of the blocks of numbers that laws read, ordered as in `_data`, shared ones once."""
    return list({id(s): s for s in _sources(scene).values()}.values())


def _data(sources: dict, structure: Structure, values: list[float]) -> list[np.ndarray]:
    """Numbers that laws read as a block, such as film tables; they stand behind all others, shared
    ones once.
    """
    end = len(values) + structure.layout.derived
    placed = {}
    for (joint, slot), source in sources.items():
        if id(source) not in placed:
            placed[id(source)] = (end, source.numbers)
            end += len(source.numbers)
        values[structure.layout.parameters[f"{joint.key}/{slot}/start"]] = float(
            placed[id(source)][0]
        )
    return [numbers for _, numbers in placed.values()]


def _values(
    scene: Scene, structure: Structure, plan: Plan, numbers: Numbers, start: Start
) -> list[float]:
    """The scene's numbers, start values of drives, and the assembly modes of its dyads."""
    values = list(numbers.values)
    for drive in (d for d in scene.drives if f"{d.key}/start" in numbers.index):
        values[numbers.index[f"{drive.key}/start"]] = start.coordinate(drive.target)
    all_numbers = {**numbers.constants, **dict(zip(numbers.index, values, strict=True))}
    state = {
        (j, s.name): (s.start, s.start_rate)
        for j in scene.joints
        for s in j.states()
        if j not in start.measured
    }
    k = Kinematics(Trace(), all_numbers.__getitem__, {}, state)
    for body, (x, y, angle) in start.pose.items():
        k.poses[body] = Pose(x, y, math.cos(angle), math.sin(angle), angle)
    return values + [mode(k, g) for g in plan.groups if f"mode.{g.label()}" in structure.modes]


def _state(scene: Scene, plan: Plan, start: Start, layout: Layout) -> np.ndarray:
    """Start state: coordinates, their rates, states of elements, and zeros for the ledger."""
    y = np.zeros(layout.length)
    values = {c.key: start.value(c.address) for c in plan.free}
    for element in scene.elements:
        values |= {f"{element.key}/{s.name}": (s.start, s.start_rate) for s in element.states()}
    for name, index in layout.state.items():
        rate = name.startswith("rate of ")
        y[index] = values[name.removeprefix("rate of ")][rate]
    return y


def _work(scene: Scene, structure: Structure, start: Start) -> np.ndarray:
    """Impact speeds (from the start velocities), then the coordinates that kernels carry from step
    to step.
    """
    layout = structure.layout
    work = np.zeros(layout.work)
    speeds = [spot.speed for _, spot in scene.spots]
    work[: len(speeds)] = speeds
    work[layout.carried_places] = [
        start.value(place_named(scene, *pair))[0] for pair in layout.carried
    ]
    return work
