"""One structure: the traced mechanics of a scene and the text of its kernels.

Kernels share one signature, (t, y, par, work, out):

  rhs        out = dy/dt
  jacobian   out = d(dy/dt)/dy, row by row, without the ledger
  events     out = penetration and its rate for each spot
  observe    out = one row of output channels
  commit     work = memory that goes to the next step
  follow     out = quantities of elements that wear; only where there are some

The layout holds the places in y, par, work and out.
"""

import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from weakref import WeakValueDictionary

from clearance.elements.declared import blamed, check_outputs, check_work
from clearance.machine import store
from clearance.mechanism.dynamics import Dynamics, Friction
from clearance.mechanism.kinematics import Columns, Kinematics, Propagation
from clearance.mechanism.motion import Calls, Motion
from clearance.mechanism.numbers import Numbers
from clearance.mechanism.topology import Plan
from clearance.scene.scene import Scene
from clearance.tracing import kernels
from clearance.tracing.emission import Program, derive_text, kernel_text
from clearance.tracing.function import Answer, Expansion, Opaque
from clearance.tracing.interpreter import fingerprint
from clearance.tracing.trace import DerivedParameters, Trace, is_value
from clearance.values import checks
from clearance.values.later import Later


@dataclass(frozen=True)
class Channel:
    """One output: where it goes in the result file, its unit and what it is.

    wrapped: an angle known in (-pi, pi] only, to be made continuous by its reader.
    """

    path: str
    units: str
    long_name: str
    wrapped: bool = False


@dataclass(frozen=True)
class Layout:
    """The places of a structure's numbers, by their names in result files.

    State: coordinates, their rates, states of first order, the energy put in, and the losses of
    each of `dissipated`. Last come the integrals `sums` (all where there is a ledger). Work: the
    impact speed of each spot, negative in free flight; the coordinates that a step carries to the
    next, (name, of what). Last come the times of the memory of elements. Parameters: those of the
    scene by name, then derived ones.
    followed: numbers that a run hands on step by step.
    """

    coordinates: tuple[str, ...]
    first_order: tuple[str, ...]
    ledger: bool
    dissipated: tuple[str, ...]
    spots: tuple[str, ...]
    carried: tuple[tuple[str, str], ...]
    remembering: tuple[str, ...]
    parameters: dict[str, int]
    derived: int
    channels: tuple[Channel, ...]
    sums: tuple[str, ...] = ()
    followed: tuple[str, ...] = ()

    def renamed(self, renamed: Callable[[str], str]) -> "Layout":
        """The same places, each name passed through a function."""
        paths = (
            "coordinates",
            "first_order",
            "dissipated",
            "spots",
            "remembering",
            "sums",
            "followed",
        )
        return replace(
            self,
            **{attribute: tuple(map(renamed, getattr(self, attribute))) for attribute in paths},
            carried=tuple((axis, renamed(name)) for axis, name in self.carried),
            parameters={renamed(name): index for name, index in self.parameters.items()},
            channels=tuple(
                replace(c, path=renamed(c.path), long_name=renamed(c.long_name))
                for c in self.channels
            ),
        )

    @cached_property
    def size(self) -> int:
        """Number of second-order degrees of freedom."""
        return len(self.coordinates)

    @cached_property
    def rates(self) -> slice:
        """Rates of the coordinates in the state, in the order of these."""
        return slice(self.size, 2 * self.size)

    @cached_property
    def states(self) -> int:
        """Number of first-order states without the ledger."""
        return self.rates.stop + len(self.first_order)

    @cached_property
    def length(self) -> int:
        """Number of first-order states with the ledger."""
        return self.states + (1 + len(self.dissipated) + len(self.sums) if self.ledger else 0)

    @cached_property
    def commits(self) -> int:
        """Number of things that an accepted step carries to the next."""
        return len(self.carried) + len(self.remembering)

    @cached_property
    def work(self) -> int:
        """Length of the work vector."""
        return len(self.spots) + self.commits

    @cached_property
    def names(self) -> list[str]:
        """Names of the states without the ledger, in their order."""
        return [
            *self.coordinates,
            *(f"rate of {name}" for name in self.coordinates),
            *self.first_order,
        ]

    @cached_property
    def state(self) -> dict[str, int]:
        """Place of each state without the ledger, by its name."""
        return {name: i for i, name in enumerate(self.names)}

    @cached_property
    def output(self) -> dict[str, int]:
        """Place of each output in a row, by its path."""
        return {channel.path: i for i, channel in enumerate(self.channels)}

    @cached_property
    def wrapped(self) -> list[str]:
        """Paths of angles that are made continuous."""
        return [channel.path for channel in self.channels if channel.wrapped]

    @cached_property
    def carried_places(self) -> slice:
        """Coordinates that a step carries to the next, in the work vector."""
        return slice(len(self.spots), len(self.spots) + len(self.carried))


#: derivatives of a Jacobian up to which its entries are written down, each by itself
MOST_DERIVATIVES = 12_000
#: steps of a structure after which a kernel of several moments has paid for its compiling
HOT = 50_000
#: likewise where the store has its machine code
WARM = 1_000
#: dyads, whose assembly mode is a number
DYADS = ("RRR", "RRP", "RPR")
#: name of a part of a marked scene
_MARK = re.compile("⟦([0-9]+)⟧")


def marked(scene: Scene) -> Scene:
    """The scene with a mark of its position as the name of each part: no trace depends on names."""

    def renamed(part):
        return replace(part, name=f"⟦{scene.positions[part.key]}⟧")

    return scene.rebuilt(body=renamed, element=renamed)


def named(text: str, names: Sequence[str]) -> str:
    """A text with the names of parts, by their positions, in place of their marks."""
    return _MARK.sub(lambda mark: names[int(mark[1])], text)


class Compiled(dict):
    """Compiled kernels by role. steps: that runs have made with them."""

    steps = 0


#: those of all structures that are in use, by what they compute
_compiled: "WeakValueDictionary[tuple, Compiled]" = WeakValueDictionary()


@dataclass(frozen=True, eq=False)
class Structure:
    """All that scenes of one structure share, by names: it holds no scene and none of its numbers.

    programs: kernels by role; derive fills the derived parameters. modes: names of assembly modes.
    forced: joints with friction whose rate is decided by forces.
    rubs, iterates: joint friction, and such as is solved for. spatial: loads out of the plane.
    names: of its parts, by their positions; its programs have marks instead. formulas: text of
    derive; written: texts of the kernels, with marks; alone: they call nothing that stands outside
    of them; takes_moments: a kernel of several moments pays.
    """

    programs: Mapping[str, Program]
    layout: Layout
    modes: tuple[str, ...]
    derive: Callable
    forced: frozenset[str]
    rubs: bool
    iterates: bool
    spatial: bool
    formulas: str = field(repr=False)
    written: Mapping[str, str] = field(repr=False)
    alone: bool
    takes_moments: bool
    names: tuple[str, ...] = ()

    def named(self, names: tuple[str, ...]) -> "Structure":
        """This structure of marks with these names of parts; it shares programs and kernels."""

        def renamed(text: str) -> str:
            return named(text, names)

        return replace(
            self,
            names=names,
            layout=self.layout.renamed(renamed),
            modes=tuple(map(renamed, self.modes)),
            forced=frozenset(map(renamed, self.forced)),
        )

    def kernel(self, role: str) -> Callable:
        """The compiled kernel of a role, or of so many "moments"; compiled on first use only."""
        if role not in self.compiled:
            self.compiled[role] = self._compiled(role)
        return self.compiled[role]

    def fuse_stages(self) -> None:
        """Count as many steps, which pay for kernels of several moments."""
        self.compiled.steps += HOT + 1

    def _compiled(self, role: str) -> Callable:
        width, _, moments = role.partition(" ")
        if moments:
            return kernels.moments(lambda: self.programs["rhs"], self.codes["rhs"], int(width))
        return kernels.kernel(lambda: self.programs[role], self.codes[role], self.alone)

    def fuses(self, width: int) -> bool:
        """True where a kernel of so many moments is compiled, or would pay for it."""
        if f"{width} moments" in self.compiled:
            return True
        steps = self.compiled.steps
        pays = steps > HOT or (steps > WARM and width in self._stored)
        return pays and self.takes_moments

    @cached_property
    def _stored(self) -> set[int]:
        """Numbers of moments whose kernels the store had when they were looked up."""
        widths = store.MOMENTS, 2 * store.MOMENTS
        text = self.codes["rhs"]
        return {w for w in widths if store.holds(kernels.text_of_moments(text, w))}

    @cached_property
    def compiled(self) -> Compiled:
        """Compiled kernels by role; structures that differ in names only share them."""
        programs = () if self.alone else self.programs.values()
        apart = {f for p in programs for f in p.functions if isinstance(f, Opaque)}
        key = self.digest, frozenset(fingerprint(f.function) for f in apart)
        return _compiled.setdefault(key, Compiled())

    @cached_property
    def texts(self) -> dict[str, str]:
        """Source of each kernel by role."""
        return {role: named(text, self.names) for role, text in self.written.items()}

    @cached_property
    def digest(self) -> str:
        """Equal for structures whose kernels compute the same: of their texts without comments."""
        return hashlib.sha256("".join(self.codes.values()).encode()).hexdigest()[:16]

    @cached_property
    def codes(self) -> dict[str, str]:
        """Texts of the kernels without comments, which have all names."""
        return {role: re.sub(r" *#[^\n]*", "", text) for role, text in self.texts.items()}


class Tracing:
    """Traces the mechanics of a scene and writes the kernels of its structure."""

    def __init__(
        self, scene: Scene, numbers: Numbers, plan: Plan, cut: Plan, measured: tuple, ledger: bool
    ):
        self.scene, self.plan, self.cut, self.ledger = scene, plan, cut, ledger
        self.modes = [f"mode.{g.label()}" for g in plan.groups if g.form in DYADS]
        self.index = numbers.index | {
            name: len(numbers.index) + i for i, name in enumerate(self.modes)
        }
        self.constants = numbers.constants
        self.trace = Trace()
        self.calls = Calls(self.trace, self.number)
        free = [c.address for c in plan.free]
        soft = [j for j in scene.soft_joints if j not in measured]
        self.places = free + [(j, axis) for j in soft for axis, _ in j.soft_coordinates]
        self.names = [c.key for c in plan.free] + [
            f"{j.key}/{name}" for j in soft for _, name in j.soft_coordinates
        ]
        self.soft = {(j, name): (j, axis) for j in soft for axis, name in j.soft_coordinates}
        self.first_order = [(e, s.name) for e in scene.elements for s in e.states() if s.order == 1]
        self.spots = scene.spots
        self._trace()
        self._write()
        self.trace.rules.clear()  # which hold bodies and joints

    def structure(self) -> Structure:
        """The result of tracing, without the scene."""
        layout = Layout(
            coordinates=tuple(self.names),
            first_order=tuple(f"{element.key}/{name}" for element, name in self.first_order),
            ledger=self.ledger,
            dissipated=tuple(element.key for element in self.dissipated),
            spots=tuple(f"{e.key}/{s.name}" if s.name else e.key for e, s in self.spots),
            carried=tuple(self.kinematics.remembered),
            remembering=tuple(element.key for element in self.work.commits),
            parameters=self.index,
            derived=len(self.slots.index),
            channels=tuple(self.channels),
            sums=tuple(f"{element.key}/{name}" for element, name in self.sums),
            followed=tuple(
                f"{e.key}/{name}" for e, values in self.work.followed.items() for name in values
            ),
        )
        names = {f"par[{i}]": name for name, i in self.index.items()}
        programs = self.programs
        called = [f for program in programs.values() for f in program.functions]
        return Structure(
            programs=programs,
            layout=layout,
            modes=tuple(self.modes),
            derive=self.derive,
            formulas=self.formulas,
            written=Later(lambda: {r: kernel_text(p, names) for r, p in programs.items()}),
            alone=not any(isinstance(f, Opaque | Answer) for f in called),
            takes_moments=kernels.takes_moments(self.programs["rhs"]),
            forced=frozenset(self.forced),
            rubs=bool(self.friction.efforts),
            iterates=self.friction.iterations is not None,
            spatial=bool(self.motion.reactions.across),
        )

    def number(self, name: str):
        """A scene number: folded where its value is part of the structure."""
        if name in self.constants:
            return self.constants[name]
        if name not in self.index:
            names = {*self.constants, *self.index}
            raise ValueError(f"{name} is no number of the scene{checks.meant(name, names)}")
        return self.trace.load(f"par[{self.index[name]}]")

    # --- mechanics
    def _friction(self, dynamics: Dynamics, applied, driven: dict) -> Friction:
        """Friction of joints without clearance."""
        if not self.scene.rubbing_joints:
            return Friction()
        from clearance.mechanism.friction_efforts import joint_friction

        return joint_friction(dynamics, applied, driven)

    def _trace(self) -> None:
        trace, size = self.trace, len(self.places)
        position = {c: trace.load(f"y[{i}]") for i, c in enumerate(self.places)}
        rate = {c: trace.load(f"y[{size + i}]") for i, c in enumerate(self.places)}
        self.motion = self._moving(position, rate)
        dynamics = Dynamics(self.scene, self.motion, self.cut)
        applied = dynamics.applied()
        driven = self._driven(self.cut, 2)
        self.friction = self.motion.friction = self._friction(dynamics, applied, driven)
        self.work = dynamics.with_friction(applied, self.friction.efforts)
        self.acceleration, self.motion.reactions = dynamics.solution(self.work, driven)
        trace.section = "state"
        second = [dynamics.second_rate(coordinate, self.acceleration) for coordinate in self.places]
        states = {s: {i: 1.0} for i, s in enumerate((*position.values(), *rate.values()))}
        slopes = trace.tangent(self.friction.rates.values(), states)
        self.forced = {
            j.name for j, slope in zip(self.friction.rates, slopes, strict=True) if slope
        }
        for joint, bristle_rate in self.friction.bristle_rates.items():
            (deflection,) = joint.states()
            self.work.rate(joint, deflection.name, bristle_rate)
        for element in self.scene.elements:
            check_work(element, self.work)
        for joint, effort in self.friction.efforts.items():
            self.work.lose(joint, -effort * self.friction.rates[joint])
        self.state_rate = [
            *rate.values(),
            *second,
            *(self.work.rates[key] for key in self.first_order),
        ]
        self.states = len(self.state_rate)
        losses = self.work.losses if self.ledger else {}
        self.dissipated = {e: trace.load(f"y[{self.states + 1 + i}]") for i, e in enumerate(losses)}
        sums = self.work.sums if self.ledger else {}
        first = self.states + 1 + len(losses)
        self.sums = {key: trace.load(f"y[{first + i}]") for i, key in enumerate(sums)}
        if self.ledger:
            self.state_rate += [
                self._input_power(),
                *losses.values(),
                *(rate for _, _, rate in sums.values()),
            ]

    def _moving(self, position: dict, rate: dict) -> Motion:
        """Poses and velocities from coordinates and their rates, by place."""
        trace, time = self.trace, self.trace.load("t")
        state = {key: (position[c], rate[c]) for key, c in self.soft.items()}
        first = len(self.spots)
        self.kinematics = k = Kinematics(
            trace, self.number, dict(position), state, lambda i: trace.load(f"work[{first + i}]")
        )
        first_order = {
            pair: trace.load(f"y[{i}]")
            for i, pair in enumerate(self.first_order, len(position) + len(rate))
        }
        speeds: dict = {}
        for i, (element, _) in enumerate(self.spots):
            speeds.setdefault(element, []).append(trace.load(f"work[{i}]"))
        motion = Motion(k, self.calls, time, first_order, speeds)
        trace.section = "drives"
        self.driven = {d: d.motion_at(motion) for d in self.scene.drives if d.prescribes}
        k.coordinate |= self._driven(self.plan, 0)
        k.place_all(self.plan)
        places = {c.address for g in self.plan.groups for c in g.inputs} | set(position)
        values = {c: value for c, value in (position | k.coordinate).items() if c in places}
        k.columns = Columns(k, self.plan, values)
        k.columns.poses()
        trace.section = "velocities"
        motion.at(Propagation(k, self.plan).velocities(rate | self._driven(self.plan, 1)))
        return motion

    def _driven(self, plan: Plan, order: int) -> dict:
        """Value (0), rate (1) or second rate (2) of each prescribed coordinate of a plan, by
        place.
        """
        return {c.address: self.driven[c.drive][order] for c in plan.of("drive")}

    def _input_power(self):
        power = self.work.input_power
        for drive, (_, rate, _) in self.driven.items():
            power += self.motion.effort(drive) * rate
        return power

    # --- text
    def _write(self) -> None:
        self.trace.section = "derivatives"
        jacobian, columns = self._jacobian()
        self.channels, observed = self._channels()
        carried = [*self.kinematics.values, *self.work.commits.values()]
        roles = {
            "rhs": dict(enumerate(self.state_rate)),
            "jacobian": jacobian,
            "events": dict(
                enumerate(v for e in self.work.spots.values() for spot in e for v in spot)
            ),
            "commit": dict(enumerate(carried, len(self.spots))),
            "observe": dict(enumerate(observed)),
        }
        if self.work.followed:
            followed = (v for values in self.work.followed.values() for v in values.values())
            roles["follow"] = dict(enumerate(followed))
        expansion = Expansion()
        places = {role: list(outputs) for role, outputs in roles.items()}
        values = {role: expansion.of(list(outputs.values())) for role, outputs in roles.items()}
        self.slots = DerivedParameters(len(self.index))
        for outputs in values.values():
            self.slots.claim(outputs)
        self.programs = {
            r: Program(
                r,
                dict(zip(places[r], values[r], strict=True)),
                self.slots.index,
                columns if r == "jacobian" else 0,
            )
            for r in roles
        }
        self.formulas = derive_text(self.slots.index)
        self.derive = kernels.plain(self.formulas)["derive"]

    def _jacobian(self) -> tuple[dict[int, object], int]:
        """Entries of the Jacobian by place, and 0; where they are very many, a column of it and the
        number of these.
        """
        trace, states = self.trace, self.states
        leaves = [trace.load(f"y[{i}]") for i in range(states)]
        rates = self.state_rate[:states]
        if trace.spread(rates, leaves) > MOST_DERIVATIVES:
            along = {leaf: {0: trace.load(f"dy[{i}]")} for i, leaf in enumerate(leaves)}
            return {
                row: slope.get(0, 0.0) for row, slope in enumerate(trace.tangent(rates, along))
            }, states
        slopes = trace.tangent(rates, {leaf: {i: 1.0} for i, leaf in enumerate(leaves)})
        return {
            row * states + column: v for row, s in enumerate(slopes) for column, v in s.items()
        }, 0

    def _channels(self) -> tuple[list[Channel], list]:
        rows = [
            *self._body_channels(),
            *self._element_channels(),
            *self._friction_channels(),
            *self._energy_channels(),
        ]
        wrapped = {
            f"{b.key}/theta" for b in self.scene.bodies if self.kinematics.poses[b].angle is None
        }
        return [Channel(*row[:3], row[0] in wrapped) for row in rows], [row[3] for row in rows]

    def _body_channels(self):
        k = self.kinematics
        for body in self.scene.bodies:
            pose = k.poses[body]
            v = self.motion.velocities[body]
            a = self.acceleration[body]
            self.trace.section = f"outputs of {body.name}"
            rows = (
                ("x", "m", pose.x, "position x of the centre of mass"),
                ("y", "m", pose.y, "position y of the centre of mass"),
                ("theta", "rad", k.angle(body), "angle of the body frame"),
                ("vx", "m/s", v[0], "velocity x of the centre of mass"),
                ("vy", "m/s", v[1], "velocity y of the centre of mass"),
                ("omega", "rad/s", v[2], "angular velocity"),
                ("ax", "m/s2", a[0], "acceleration x of the centre of mass"),
                ("ay", "m/s2", a[1], "acceleration y of the centre of mass"),
                ("alpha", "rad/s2", a[2], "angular acceleration"),
            )
            for name, units, value, text in rows:
                yield f"bodies/{body.name}/{name}", units, f"{body.name}: {text}", value

    def _element_channels(self):
        for element in self.scene.elements:
            self.trace.section = f"outputs of {element.label()}"
            with blamed(element, "outputs"):
                shown = [*self.work.shown.get(element, ()), *element.outputs(self.motion)]
            shown = check_outputs(element, shown, is_value)
            for name, units, text, value in vectors_together(shown):
                yield f"{element.key}/{name}", units, text, value
            if element in self.dissipated:
                yield f"{element.key}/dissipated", "J", element.lost, self.dissipated[element]
            for (_, name), value in ((key, v) for key, v in self.sums.items() if key[0] is element):
                units, text, _ = self.work.sums[element, name]
                yield f"{element.key}/{name}", units, text, value

    def _friction_channels(self):
        if self.friction.iterations is not None:
            text = "iterations of the friction of coupled joints, after a first evaluation"
            yield "friction/iterations", "1", text, self.friction.iterations
            text = "change from one evaluation to the next over the one before"
            yield "friction/contraction", "1", text, self.friction.contraction

    def _energy_channels(self):
        work = self.work
        yield "energy/kinetic", "J", "kinetic energy", work.kinetic
        yield "energy/potential", "J", "potential energy of gravity and springs", work.potential
        if self.ledger:
            supplied = self.trace.load(f"y[{self.states}]")
            lost = self.trace.sum(self.dissipated.values())
            yield "energy/input", "J", "work done by drives and loads", supplied
            yield (
                "energy/dissipated",
                "J",
                "work taken out by joints and dampers (contact: stored and lost)",
                lost,
            )
            balance = work.kinetic + work.potential - supplied + lost
            yield (
                "energy/residual",
                "J",
                "kinetic + potential - input + dissipated, minus its start value",
                balance,
            )


def vectors_together(outputs: list[tuple]) -> list[tuple]:
    """Outputs of an element, each NAME_y right after NAME_x."""
    places = {output[0]: i for i, output in enumerate(outputs)}

    def key(output: tuple) -> tuple[int, str]:
        name = output[0]
        partner = f"{name[:-2]}_x" if name.endswith("_y") else name
        return places.get(partner, places[name]), name

    return sorted(outputs, key=key)
