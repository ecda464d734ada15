"""One structure: the traced mechanics of a scene and the text of its kernels.

Kernels share one signature, (t, y, par, work, out):
  rhs       out = dy/dt                                    observe   out = one row of output channels
  jacobian  out = d(dy/dt)/dy, row by row, no ledger       commit    work = what is carried to the next step
  events    out = penetration, its rate, contact force for each clearance joint
State y = [free coordinates, eccentricities | their rates | bristles of friction | warming of the oil | energy input,
energy dissipated by each clearance joint and damper].
work = [impact speed of each clearance joint, negative in free flight | angles and slides of the last step (Newton
starts there) | times up to which films with a memory remember].
"""

import hashlib
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakValueDictionary

from clearance.laws.law import BoundLaw, bristle, joint_bristle, memory_film
from clearance.loads import Drive
from clearance.mechanism import kernels
from clearance.mechanism.dynamics import Dynamics
from clearance.mechanism.emission import Program, derive_text, kernel_text
from clearance.mechanism.function import Expansion, Opaque
from clearance.mechanism.interpreter import fingerprint
from clearance.mechanism.joint_forces import Calls, Memory
from clearance.mechanism.kinematics import Kinematics, Propagation
from clearance.mechanism.numbers import Numbers
from clearance.mechanism.rubbing import rubbing
from clearance.mechanism.topology import Plan
from clearance.mechanism.trace import Slots, Trace
from clearance.scene import Scene

#: derivatives of a Jacobian up to which its entries are written down, each by itself
MOST_DERIVATIVES = 12_000


class Compiled(dict):
    """Compiled kernels by role."""


#: those of all structures that are in use, by what they compute
_compiled: "WeakValueDictionary[tuple, Compiled]" = WeakValueDictionary()


@dataclass(frozen=True)
class Channel:
    """One output: where it goes in the result file, its unit and what it is.

    wrapped: an angle known in (-pi, pi] only, to be made continuous by its reader.
    """

    path: str
    units: str
    long_name: str
    wrapped: bool = False


@dataclass(frozen=True, eq=False)
class Structure:
    """All that scenes of one structure share, by names: it holds no scene and none of its numbers.

    programs: kernels by role. index: place of each number in the parameter vector;
    derive fills the `derived` parameters behind these. size: second-order degrees of freedom;
    states: first-order states without the ledger; length: with it.
    bristles, warm, remembering: joints with such a state. dissipated: joints and loads in the ledger.
    found: joints with friction whose rate is found from forces.
    carried: angles and slides that a step carries to the next.
    rubs, iterates: joint friction, and such as is solved for. spatial: loads out of the plane.
    """

    programs: dict[str, Program]
    channels: list[Channel]
    index: dict[str, int]
    modes: tuple[str, ...]
    derive: Callable
    derived: int
    size: int
    states: int
    length: int
    ledger: bool
    bristles: tuple[str, ...]
    warm: tuple[str, ...]
    remembering: tuple[str, ...]
    dissipated: tuple[str, ...]
    found: frozenset[str]
    carried: tuple[tuple[str, str], ...]
    rubs: bool
    iterates: bool
    spatial: bool

    @property
    def commits(self) -> int:
        """Number of things that an accepted step carries to the next."""
        return len(self.carried) + len(self.remembering)

    def kernel(self, role: str) -> Callable:
        """The compiled kernel of a role; compiled on first use only."""
        if role not in self.compiled:
            self.compiled[role] = kernels.kernel(self.programs[role])
        return self.compiled[role]

    @cached_property
    def compiled(self) -> Compiled:
        """Compiled kernels by role; structures that differ in names only share them."""
        apart = {f for p in self.programs.values() for f in p.functions if isinstance(f, Opaque)}
        key = self.digest, frozenset(fingerprint(f.function) for f in apart)
        return _compiled.setdefault(key, Compiled())

    @cached_property
    def texts(self) -> dict[str, str]:
        """Source of each kernel by role."""
        names = {f"par[{i}]": name for name, i in self.index.items()}
        return {role: kernel_text(program, names) for role, program in self.programs.items()}

    @cached_property
    def digest(self) -> str:
        """Equal for structures whose kernels compute the same: of their texts without comments."""
        texts = "".join(re.sub(r" *#[^\n]*", "", t) for t in self.texts.values())
        return hashlib.sha256(texts.encode()).hexdigest()[:16]


class Tracing:
    """Traces the mechanics of a scene and writes the kernels of its structure."""

    def __init__(self, scene: Scene, numbers: Numbers, plan: Plan, cut: Plan, measured: tuple, ledger: bool):
        self.scene, self.ledger, self.measured = scene, ledger, measured
        self.plan, self.cut = plan, cut
        self.modes = [f"mode.{g.label()}" for g in self.plan.groups if g.form in ("RRR", "RRP", "RPR")]
        self.index = dict(numbers.index)
        for name in self.modes:
            self.index[name] = len(self.index)
        self.constants = numbers.constants
        self.trace = Trace()
        self.calls = Calls(self.trace, self.number)
        self._trace()
        self._write()

    def structure(self) -> Structure:
        """The result of tracing, without the scene."""
        return Structure(
            programs=self.programs,
            channels=self.channels,
            index=self.index,
            modes=tuple(self.modes),
            derive=self.derive,
            derived=len(self.slots.place),
            size=self.size,
            states=self.states,
            length=len(self.state_rate),
            ledger=self.ledger,
            bristles=tuple(j.name for j in self.bristles),
            warm=tuple(j.name for j in self.warm),
            remembering=tuple(j.name for j in self.remembering),
            dissipated=tuple(part.name for part in self.dissipated),
            found=frozenset(self.found),
            carried=tuple(self.kinematics.remembered),
            rubs=bool(self.rubbing.efforts),
            iterates=self.rubbing.iterations is not None,
            spatial=bool(self.reactions.across),
        )

    def number(self, name: str):
        """A scene number: folded where its value is part of the structure."""
        if name in self.constants:
            return self.constants[name]
        return self.trace.load(f"par[{self.index[name]}]")

    # --- state
    @property
    def size(self) -> int:
        """Number of second-order degrees of freedom."""
        return len(self.plan.free) + 2 * (len(self.scene.clearance_joints) - len(self.measured))

    @property
    def bristles(self) -> list:
        """Joints whose friction law has a state of its own."""
        rubbing = [j for j in self.scene.joints if j.friction is not None]
        return [j for j in rubbing if j.friction.law.family in (bristle, joint_bristle)]

    @property
    def warm(self) -> list:
        """Joints with a balance of heat."""
        return [j for j in self.scene.clearance_joints if j.heat is not None]

    @property
    def remembering(self) -> list:
        """Joints whose film has a memory of its own."""
        films = [j for j in self.scene.clearance_joints if j.film is not None]
        return [j for j in films if j.film.law.family is memory_film]

    @property
    def states(self) -> int:
        """Number of first-order states without the ledger."""
        return 2 * self.size + len(self.bristles) + len(self.warm)

    def _trace(self) -> None:
        trace, size, everyone = self.trace, self.size, self.scene.clearance_joints
        joints = [j for j in everyone if j not in self.measured]
        time = trace.load("t")
        position = [trace.load(f"y[{i}]") for i in range(size)]
        rate = [trace.load(f"y[{size + i}]") for i in range(size)]
        count = len(self.plan.free)
        offsets = {j: tuple(position[count + 2 * i : count + 2 * i + 2]) for i, j in enumerate(joints)}
        offset_rates = {j: tuple(rate[count + 2 * i : count + 2 * i + 2]) for i, j in enumerate(joints)}
        memories = self._memories(time)
        trace.section = "drives"
        driven = {d: self._prescribed(d, time) for d in self.scene.loads if isinstance(d, Drive) and d.prescribes}
        values = dict(zip(self.plan.free, position, strict=False)) | _of_drives(self.plan, driven, 0)
        rates = dict(zip(self.plan.free, rate, strict=False)) | _of_drives(self.plan, driven, 1)
        self.kinematics = k = Kinematics(
            trace, self.number, values, offsets, lambda i: trace.load(f"work[{len(everyone) + i}]")
        )
        k.place(self.plan)
        trace.section = "velocities"
        motion = Propagation(k, self.plan).field(rates, offset_rates)
        for joint in self.measured:
            offsets[joint], offset_rates[joint] = k.separation(joint, motion)
        self.dynamics = d = Dynamics(self.scene, k, motion, self.cut, self.calls, time)
        applied, second_rates = d.applied(offsets, offset_rates, memories), _of_drives(self.cut, driven, 2)
        self.rubbing = rubbing(
            d, applied, second_rates, {j: m.deflection for j, m in memories.items() if j not in everyone}
        )
        self.applied = d.rubbed(applied, self.rubbing.efforts)
        self.acceleration, self.reactions = d.solution(self.applied, second_rates)
        self.efforts = self.reactions.efforts
        trace.section = "state"
        placed = {a.body: a.joint for g in self.plan.groups for a in g.attachments}
        second = [d.coordinate_acceleration(c, placed[c.body], self.acceleration) for c in self.plan.free]
        for joint in joints:
            second += d.offset_acceleration(joint, self.acceleration)
        self.driven, self.motion = driven, motion
        states = {trace.load(f"y[{i}]"): {i: 1.0} for i in range(2 * size)}
        rates_found = trace.tangent(self.rubbing.rates.values(), states)
        #: joints with friction whose rate is found from forces, by name
        self.found = {j.name for j, slope in zip(self.rubbing.rates, rates_found, strict=True) if slope}
        bending = {j: f.deflection_rate for j, f in self.applied.joints.items()} | self.rubbing.deflection_rates
        self.state_rate = [*rate, *second, *(bending[j] for j in self.bristles)]
        self.state_rate += [self.applied.joints[j].warming_rate for j in self.warm]
        for joint, effort in self.rubbing.efforts.items():
            self.applied.ledger.lose(joint, -effort * self.rubbing.rates[joint])
        losses = self.applied.ledger.losses if self.ledger else {}
        self.dissipated = {part: trace.load(f"y[{self.states + 1 + i}]") for i, part in enumerate(losses)}
        if self.ledger:
            self.state_rate += [self._input_power(), *losses.values()]

    def _memories(self, time) -> dict:
        """Memories of clearance joints and of bristles, which forces depend on."""
        trace, first = self.trace, 2 * self.size
        impact = {j: trace.load(f"work[{i}]") for i, j in enumerate(self.scene.clearance_joints) if j.contact}
        own = {j: trace.load(f"y[{first + i}]") for i, j in enumerate(self.bristles)}
        first += len(self.bristles)
        warming = {j: trace.load(f"y[{first + i}]") for i, j in enumerate(self.warm)}
        return {
            j: Memory(time, impact.get(j, 0.0), own.get(j, 0.0), warming.get(j, 0.0))
            for j in dict.fromkeys((*self.scene.clearance_joints, *own))
        }

    def _prescribed(self, drive: Drive, time):
        """Coordinate, rate and acceleration of a prescribed drive."""
        if drive.speed is not None:
            speed = self.number(f"{drive.key}.speed")
            return self.number(f"{drive.key}.start") + speed * time, speed, 0.0
        law: BoundLaw = drive.motion
        numbers = [self.number(f"{drive.key}.motion.{p}") for p in law.law.parameters]
        function = self.calls.traced(law.law.function)
        value, rate, _, second = self.trace.call(function.slopes((0,)).slopes((0,)), [time, *numbers])
        return value, rate, second

    def _input_power(self):
        power = self.applied.ledger.input_power
        for drive, (_, rate, _) in self.driven.items():
            power = power + self.efforts[drive] * rate
        return power

    # --- text
    def _write(self) -> None:
        trace = self.trace
        trace.section = "derivatives"
        jacobian, columns = self._jacobian()
        self.channels, observed = self._channels()
        kept = [self.applied.joints[j].kept for j in self.remembering]
        roles = {
            "rhs": dict(enumerate(self.state_rate)),
            "jacobian": jacobian,
            "events": dict(enumerate(self._events())),
            "commit": dict(enumerate([*self.kinematics.values, *kept], len(self.scene.clearance_joints))),
            "observe": dict(enumerate(observed)),
        }
        expansion = Expansion()
        places = {role: list(outputs) for role, outputs in roles.items()}
        values = {role: expansion.of(list(outputs.values())) for role, outputs in roles.items()}
        self.slots = Slots(len(self.index))
        for outputs in values.values():
            self.slots.claim(outputs)
        self.programs = {
            r: Program(
                r, dict(zip(places[r], values[r], strict=True)), self.slots.place, columns if r == "jacobian" else 0
            )
            for r in roles
        }
        self.derive = kernels.plain(derive_text(self.slots.place))["derive"]

    def _jacobian(self) -> tuple[dict[int, object], int]:
        """Entries of the Jacobian by place, and 0; where they are very many, a column of it and the number of these."""
        trace, states = self.trace, self.states
        leaves = [trace.load(f"y[{i}]") for i in range(states)]
        rates = self.state_rate[:states]
        if trace.spread(rates, leaves) > MOST_DERIVATIVES:
            along = {leaf: {0: trace.load(f"dy[{i}]")} for i, leaf in enumerate(leaves)}
            return {row: slope.get(0, 0.0) for row, slope in enumerate(trace.tangent(rates, along))}, states
        slopes = trace.tangent(rates, {leaf: {i: 1.0} for i, leaf in enumerate(leaves)})
        return {row * states + column: v for row, s in enumerate(slopes) for column, v in s.items()}, 0

    def _events(self) -> list:
        found = [self.applied.joints[j] for j in self.scene.clearance_joints]
        return [v for f in found for v in (f.penetration, f.penetration_rate, f.contact_force)]

    def _channels(self) -> tuple[list[Channel], list]:
        rows = [*self._body_channels(), *self._joint_channels(), *self._spring_channels(), *self._drive_channels()]
        rows += [*self._friction_channels(), *self._energy_channels()]
        wrapped = {f"bodies/{b.name}/theta" for b in self.scene.bodies if self.kinematics.poses[b].angle is None}
        return [Channel(*row[:3], row[0] in wrapped) for row in rows], [row[3] for row in rows]

    def _body_channels(self):
        k = self.kinematics
        for body in self.scene.bodies:
            pose, v, a = k.poses[body], self.motion[body], self.acceleration[body]
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
            for name, units, value, what in rows:
                yield f"bodies/{body.name}/{name}", units, f"{body.name}: {what}", value

    def _joint_channels(self):
        for joint in self.scene.joints:
            here = f"joints/{joint.name}"
            if joint in self.applied.joints:
                found = self.applied.joints[joint]
                yield from self._forces(joint, found.force)
                for name, value in found.channels.items():
                    yield f"{here}/{name}", *_JOINT_CHANNELS[name], value
            else:
                yield from self._reaction_channels(here, joint)
            if joint in self.dissipated:
                yield f"{here}/dissipated", *_JOINT_CHANNELS["dissipated"], self.dissipated[joint]

    def _reaction_channels(self, here: str, joint):
        """A joint without clearance: its reaction, in the plane and out of it, and its friction."""
        fx, fy, moment = self.reactions.forces[joint]
        slides, body, effort = hasattr(joint, "axis"), joint.b.body.name, self.rubbing.efforts.get(joint, 0.0)
        if slides:  # all that passes from a to b there; what a drive prescribes has its effort in the reaction already
            pushed = self.trace.sum(e for d, e in self.applied.efforts.items() if d.target is joint)
            dx, dy = self.kinematics.axis(joint, joint.a.body)
            fx, fy = fx + (effort + pushed) * dx, fy + (effort + pushed) * dy
        yield from self._forces(joint, (fx, fy), self._along(joint) if slides else "")
        if slides:
            yield f"{here}/moment", "N m", f"moment on {body} about its joint point", moment
        if self.reactions.across:
            rows = zip(("axial_force", "bending_x", "bending_y"), ("N", "N m", "N m"), "zxy", strict=True)
            for (name, units, axis), value in zip(rows, self.reactions.across.get(joint, (0.0,) * 3), strict=True):
                what = "force" if units == "N" else "moment about the joint point,"
                yield f"{here}/{name}", units, f"{what} {axis} on {body}, out of the plane", value
        if joint in self.rubbing.efforts:
            kind, units = ("force", "N") if slides else ("torque", "N m")
            what = f"friction {kind} on {body}, opposed to its motion against {joint.a.body.name}"
            yield f"{here}/friction", units, what, effort
            if joint in self.rubbing.deflections:
                what = "deflection of the friction law's bristles"
                yield f"{here}/bristle_deflection", "m" if slides else "rad", what, self.rubbing.deflections[joint]
            if joint in self.rubbing.loads:
                yield f"{here}/friction_load", units, "what friction makes of the reaction", self.rubbing.loads[joint]
            yield f"{here}/power_loss", *_JOINT_CHANNELS["power_loss"], -effort * self.rubbing.rates[joint]

    def _spring_channels(self):
        for load in self.scene.loads:
            here = f"springs/{load.name}"
            if load in self.applied.springs:
                length, tension = self.applied.springs[load]
                yield f"{here}/length", "m", "length", length
                yield f"{here}/tension", "N", "tension of spring and damper", tension
            if load in self.dissipated:
                yield f"{here}/dissipated", "J", "work the damper has taken out since the start", self.dissipated[load]

    def _along(self, joint) -> str:
        """Parts of a slide's force along its axis, in words."""
        parts = [f"drive {d.name}" for d in self.efforts if d.target is joint]
        parts += ["friction"] if joint in self.rubbing.efforts else []
        return f", with that of {' and '.join(parts)} along the slide" if parts else ""

    def _forces(self, joint, force, more=""):
        for axis, value in zip("xy", force, strict=True):
            yield f"joints/{joint.name}/force_{axis}", "N", f"force {axis} on {joint.b.body.name}{more}", value

    def _drive_channels(self):
        for drive, effort in self.efforts.items():
            here, name = f"drives/{drive.name}", drive.effort_kind
            units = "N" if name == "force" else "N m"
            rate = self.driven[drive][1] if drive in self.driven else self.dynamics.drive_coordinate(drive)[1]
            yield f"{here}/{name}", units, f"driving {name}", effort
            if drive in self.rubbing.ideal:
                yield f"{here}/{name}_ideal", units, f"driving {name} without joint friction", self.rubbing.ideal[drive]
            yield f"{here}/power", "W", "power put in by the drive", effort * rate

    def _friction_channels(self):
        if self.rubbing.iterations is not None:
            what = "iterations of the friction of coupled joints, after a first evaluation"
            yield "friction/iterations", "1", what, self.rubbing.iterations
            what = "change from one evaluation to the next over the one before"
            yield "friction/contraction", "1", what, self.rubbing.contraction

    def _energy_channels(self):
        ledger = self.applied.ledger
        yield "energy/kinetic", "J", "kinetic energy", ledger.kinetic
        yield "energy/potential", "J", "potential energy of gravity and springs", ledger.potential
        if self.ledger:
            work, lost = self.trace.load(f"y[{self.states}]"), self.trace.sum(self.dissipated.values())
            yield "energy/input", "J", "work done by drives and loads", work
            yield "energy/dissipated", "J", "work taken out by joints and dampers (contact: stored and lost)", lost
            balance = ledger.kinetic + ledger.potential - work + lost
            yield "energy/residual", "J", "kinetic + potential - input + dissipated, minus its start value", balance


_JOINT_CHANNELS = {
    "eccentricity_x": ("m", "eccentricity of the journal in the bearing, x"),
    "eccentricity_y": ("m", "eccentricity of the journal in the bearing, y"),
    "eccentricity_ratio": ("1", "eccentricity of the journal over the radial clearance"),
    "gap": ("m", "nominal minimum film thickness, clearance minus eccentricity"),
    "film_thickness_ratio": ("1", "nominal minimum film thickness over composite roughness"),
    "contact_force": ("N", "normal contact force"),
    "asperity_force": ("N", "load of the asperities"),
    "asperity_share": ("1", "share of asperities and contact in the load of film, asperities and contact"),
    "membership_full_film": ("1", "membership of the film thickness ratio in the state full film"),
    "membership_mixed": ("1", "membership of the film thickness ratio in the state mixed"),
    "membership_dry": ("1", "membership of the film thickness ratio in the state dry"),
    "bristle_deflection": ("m", "deflection of the friction law's bristles"),
    "film_radial": ("N", "film force on the journal along the line of centres"),
    "film_tangential": ("N", "film force on the journal across the line of centres"),
    "film_pressure": ("Pa", "estimate of the film's largest pressure"),
    "side_flow": ("m3/s", "oil that leaves the film at both ends"),
    "oil_temperature": ("K", "temperature of the oil"),
    "friction": ("N", "friction force on the journal, positive along the turned line of centres"),
    "power_loss": ("W", "power the joint takes out of the mechanism"),
    "dissipated": ("J", "work the joint has taken out since the start (contact: stored and lost)"),
}


def _of_drives(plan, driven: dict, order: int) -> dict:
    """Value (0), rate (1) or acceleration (2) of each prescribed coordinate of a plan."""
    coordinates = [c for g in plan.groups for a in g.attachments for c in a.coordinates if c.source == "drive"]
    return {c: driven[c.drive][order] for c in coordinates}
