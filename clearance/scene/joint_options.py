"""Joints from plain words and numbers ("dry", "coulomb", 0.9), as cases and the command line have
them: laws by their names, and options of a case's joints, which are ideal, dry, lubricated or
mixed.

A law is a name, or a name with parameters in SI units: "fuzzy", "impact(damping=440,
depth=1.5e-6)".
"""

import math
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, fields
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from clearance import elements, laws
from clearance.elements import Drive
from clearance.elements.body import Body
from clearance.elements.joint import Joint
from clearance.files.texts import text_of
from clearance.film import names as films
from clearance.film.bearing import DRAG, DRAGS
from clearance.laws.materials import Lubricant, Material, steel
from clearance.values import checks
from clearance.values.checks import one_of as one_of

if TYPE_CHECKING:  # which this is imported by
    from clearance.scene.scene import Scene

MODELS = ("ideal", "dry", "lubricated", "mixed")
LAW = re.compile(r"\s*(\w+)\s*(?:\((.*)\))?\s*")


@dataclass(frozen=True)
class Pair:
    """A journal in a bearing of one material, which contact laws are made from; lengths in m.

    reach: way through the clearance; by default the clearance itself, which is infinite for a
        corner on a wall.
    """

    radius: float
    clearance: float
    length: float
    material: Material
    layer: float | None = None
    reach: float | None = None

    @property
    def stiffness(self) -> float:
        """Hertz's for the pair of radii [N/m^1.5]."""
        return laws.hertz_stiffness(self.radius, self.clearance, self.material)


def _named(family: str, trait: str, parameter: str, complete: Callable) -> dict[str, Callable]:
    """Name -> the law by a trait, and where it has none by complete(law, ...) from a parameter."""
    module = vars(import_module(f"clearance.laws.{family}"))
    members = [module[n] for n in sorted(module) if isinstance(module[n], laws.Law)]
    by_trait = {law.name: getattr(law, trait) for law in members if getattr(law, trait)}
    others = [law for law in members if parameter in law.inputs and law.name not in by_trait]
    return {law.name: partial(complete, law) for law in others} | by_trait


#: name -> the law for a pair of bodies and a restitution
CONTACTS = _named(
    "contact",
    "from_restitution",
    "restitution",
    lambda law, pair, e: law(restitution=e).of(pair),
)
#: name -> the law for a coefficient of friction
FRICTIONS = _named(
    "friction",
    "from_coefficient",
    "coefficient",
    lambda law, mu: law(coefficient=mu),
)
#: how hard a finite drive holds its speed: slope of torque over speed, over J w. A disturbance of
#: the speed dies out within a tenth of a radian, the cases with ideal joints run evenly to 5 to 17
#: %
GRIP = 10.0
SLIP = 0.2  # at the breakdown torque of an induction motor
VOLTAGE = 24.0  # of a direct current motor [V]
ELECTRIC = 0.1  # its electric time constant, over the mechanism's


def _dc_motor(slope: float, speed: float, inertia: float) -> laws.BoundLaw:
    """A motor of VOLTAGE with this slope of torque over speed."""
    constant = VOLTAGE / abs(speed)
    resistance = constant**2 / slope
    return laws.dc_motor(
        voltage=math.copysign(VOLTAGE, speed),
        resistance=resistance,
        inductance=ELECTRIC * resistance * inertia / slope,
        constant=constant,
    )


#: name -> the law for a slope of torque over speed D [N m s/rad], a speed w and an inertia J. The
#: integral of pi has the time of a turn, the others idle at w.
DRIVES: dict[str, Callable] = {
    "pi": lambda d, w, j: laws.pi_speed(
        proportional=d, integral=d * abs(w) / (2.0 * math.pi), speed=w
    ),
    "motor": lambda d, w, j: laws.motor_line(stall=d * abs(w), no_load=w),
    "kloss": lambda d, w, j: laws.kloss(breakdown=d * abs(w) * SLIP, slip=SLIP, synchronous=w),
    "dc": _dc_motor,
}
#: friction of joints without clearance
JOINT_FRICTIONS = ("none", "coulomb", "stribeck")


def _film(name: str, **options) -> laws.BoundLaw:
    """A film law by its name, whose module is imported on first use."""
    return getattr(films, name)(**options)


#: coarse to fine: formulas and the table of the Reynolds equation
FILMS = {
    n: partial(_film, n)
    for n in ("sommerfeld", "pinkus_sternlicht", "long", "short", "harmonic", "table")
}
#: films that solve the Reynolds equation as the run goes: 1e3 times dearer and more
ONLINE_FILMS = {n: partial(_film, n) for n in ("fast", "fem", "conserving")}
#: the film that goes through the wall, as elastic(liner=1e-13, pressure_viscosity=0)
ELASTIC_FILMS = {"elastic": partial(_film, "elastic")}
ALL_FILMS = FILMS | ONLINE_FILMS | ELASTIC_FILMS
#: films of the Reynolds equation: the faces of a slide then have theirs from a table too
TABLES = ("table", *ONLINE_FILMS, *ELASTIC_FILMS)
#: needs of a film for an ambient pressure, or for the flow factors of rough surfaces
WITH_AMBIENT, WITH_FLOW_FACTORS = ("table", *ONLINE_FILMS), ("table", "fast", "fem")
ASPERITIES = {
    "greenwood_tripp": laws.greenwood_tripp,
    "greenwood_williamson": laws.greenwood_williamson,
}
#: memberships of the fuzzy transition that need no file: half-cosines between thresholds
COSINE = "cosine"
#: film thickness ratios dry, mixed, full where none are given
THRESHOLDS = (0.4, 1.0, 3.0)
#: parameters of `fuzzy` that a table of memberships leaves open
BESIDE_A_TABLE = ("datum", "squeeze")
#: words in place of a law, without parameters
AUTO, NONE = "auto", "none"
PRESCRIBED = "speed"  # the drive that is no finite one
CELLS = re.compile(r"\s*[,;\t]\s*")
#: name -> the law for the thresholds dry, mixed, full of the film thickness ratio
TRANSITIONS: dict[str, Callable] = {
    "none": laws.superposed,
    "flores": laws.flores_hybrid,
    "fuzzy": laws.fuzzy,
    "load_sharing": laws.load_sharing,
}


def spelled(
    field: str, text: str, laws_known: Collection[str], words: Collection[str] = ()
) -> tuple[str, dict[str, float]]:
    """Name and parameters of a law such as "hertz" or "impact(damping=440, depth=1.5e-6)".

    words: names without parameters, such as auto. Raises ValueError for an unknown name, for
        parameters that are no numbers or stand twice, and for a bracket that is not closed.
    """
    if "(" in text and ")" not in text:
        raise ValueError(
            f"{field}: a closing bracket is missing in {text!r}; write {text.strip()})"
        )
    match = LAW.fullmatch(text)
    name = one_of(field, match[1] if match else text, (*words, *laws_known))
    parts = [part.strip() for part in (match[2] or "").split(",") if part.strip()]
    if parts and name in words:
        raise ValueError(f"{field} {name} takes no parameters, got {text!r}")
    changes = {}
    for part in parts:
        parameter, _, value = (t.strip() for t in part.partition("="))
        if parameter in changes:
            raise ValueError(f"{field}: {parameter} is given twice in {text!r}")
        try:
            changes[parameter] = float(value)
        except ValueError:
            form = f"{name}(parameter=number, ...) in SI units"
            raise ValueError(f"{field} must be a name or {form}, got {text!r}") from None
    return name, changes


def _replaced(law: laws.BoundLaw, changes: dict[str, float]) -> laws.BoundLaw:
    try:
        return law.replaced(**changes) if changes else law
    except TypeError as error:
        raise ValueError(str(error)) from None


def joint_names(joints: str | Collection[str], candidates: Collection[str]) -> tuple[str, ...]:
    """Names from a comma list such as "B,C,E" or from a collection of names."""
    texts = joints.split(",") if isinstance(joints, str) else joints
    names = tuple(n.strip() for n in texts if n.strip())
    for name in names:
        one_of("joints", name, tuple(candidates))
    if len(set(names)) != len(names):
        raise ValueError(f"joints: a name stands twice in {joints!r}")
    if not names:
        raise ValueError(
            f"joints: name at least one of {', '.join(candidates)}, or choose model=ideal"
        )
    return names


def crank_drive(
    drive: str, crank: Body, *, speed: float, inertia: float, start: float = 0.0
) -> Drive:
    """The drive of a crank for a text: "speed" prescribes it, pi, motor, kloss and dc are finite.

    drive: a name, or one with parameters in SI units, as "motor(stall=5, no_load=69)". speed
        [rad/s]: prescribed, requested, or that at which a motor idles; the crank starts with it, at
        rest where the drive has a run_up. inertia [kg m2]: that of the mechanism at the crank,
        roughly; it sizes what the text leaves open, see DRIVES.
    start: angle at t = 0 [rad]. Raises ValueError for another name, and for a finite drive of speed
        0.
    """
    name, changes = spelled("drive", drive, DRIVES, (PRESCRIBED,))
    if name == PRESCRIBED:
        return Drive(crank, speed=speed, start=start)
    if checks.finite("speed", speed) == 0.0:
        raise ValueError(f"drive {name}: speed must not be 0")
    slope = GRIP * checks.positive("inertia", inertia) * abs(speed)
    law = _replaced(DRIVES[name](slope, speed, inertia), changes)
    rests = changes.get("run_up", 0.0) > 0.0
    return Drive(crank, torque=law, start=start, speed_start=0.0 if rests else speed, nominal=speed)


def joint_friction_law(
    friction: str,
    *,
    coefficient: float,
    viscous: float,
    static: float,
    stribeck_rate: float,
    exponent: float,
    transition_rate: float,
) -> laws.BoundLaw | None:
    """The law of joints without clearance for a name and its numbers, of which coulomb takes three;
    None for none.

    Raises ValueError for another name.
    """
    one_of("friction", friction, JOINT_FRICTIONS)
    if friction == "coulomb":
        return laws.joint_coulomb(
            coefficient=coefficient, viscous=viscous, transition_rate=transition_rate
        )
    if friction == "stribeck":
        return laws.joint_stribeck(
            static=static,
            kinetic=coefficient,
            stribeck_rate=stribeck_rate,
            exponent=exponent,
            viscous=viscous,
            transition_rate=transition_rate,
        )
    return None


def thresholds_of(text: str | Collection[float]) -> tuple[float, ...]:
    """Three growing film thickness ratios from "0.4,1,3" or from numbers."""
    values = text.split(",") if isinstance(text, str) else text
    try:
        numbers = tuple(float(t) for t in values)
    except ValueError:
        raise ValueError(
            f"thresholds must be three numbers such as 0.4,1,3, got {text!r}"
        ) from None
    if len(numbers) != 3 or not 0.0 < numbers[0] < numbers[1] < numbers[2]:
        raise ValueError(
            f"thresholds must be three growing positive numbers dry,mixed,full, got {text!r}"
        )
    return numbers


def points_of(path: str | Path) -> list[tuple[float, ...]]:
    """Memberships from a CSV file: rows of film thickness ratio, full film, mixed, dry.

    Commas, semicolons or tabs stand between the numbers. A first line of names and lines that begin
    with # are passed over. Raises ValueError for a file that cannot be read or a row that is not
    four numbers.
    """
    try:
        lines = text_of(path).splitlines()
    except (OSError, ValueError) as error:
        raise ValueError(f"memberships must be {COSINE} or a CSV file: {path}: {error}") from None
    rows = [(i, CELLS.split(line.strip())) for i, line in enumerate(lines, 1)]
    rows = [(i, cells) for i, cells in rows if "".join(cells).strip()[:1] not in ("", "#")]
    if rows and not any(_numeric([cell]) for cell in rows[0][1]):
        del rows[0]
    for i, cells in rows:
        if len(cells) != 4 or not _numeric(cells):
            four = "needs four numbers: film thickness ratio, full film, mixed, dry"
            raise ValueError(f"memberships: {path}, line {i} {four}; got {','.join(cells)!r}")
    return [tuple(map(float, cells)) for _, cells in rows]


def _numeric(cells: list[str]) -> bool:
    try:
        return all(math.isfinite(float(c)) for c in cells)
    except ValueError:
        return False


def transition_of(text: str, thresholds: str, memberships: str) -> laws.BoundLaw:
    """The transition for a text, thresholds, and memberships that only the fuzzy one takes."""
    name, changes = spelled("transition", text, TRANSITIONS)
    if memberships != COSINE:
        return _tabled(name, changes, thresholds, memberships)
    dry, mixed, full = THRESHOLDS if thresholds == AUTO else thresholds_of(thresholds)
    twice = [n for n in ("dry", "mixed", "full") if n in changes and thresholds != AUTO]
    if twice:
        both = f"thresholds={thresholds} and {twice[0]}={changes[twice[0]]:g} of transition {name}"
        raise ValueError(f"{both} give the same; leave one out")
    return _replaced(TRANSITIONS[name](dry=dry, mixed=mixed, full=full), changes)


def _tabled(
    name: str, changes: dict[str, float], thresholds: str, memberships: str
) -> laws.BoundLaw:
    """The fuzzy transition with memberships from a file, which fix its thresholds."""
    if name != "fuzzy":
        raise ValueError(f"transition {name} has no memberships; fuzzy has")
    if thresholds != AUTO:
        raise ValueError(
            f"thresholds={thresholds}: memberships={memberships} replaces them; leave one out"
        )
    for parameter, value in changes.items():
        if parameter not in BESIDE_A_TABLE:
            raise ValueError(
                f"transition fuzzy({parameter}={value:g}): "
                f"beside memberships={memberships} it takes {', '.join(BESIDE_A_TABLE)} only"
            )
    points = points_of(memberships)
    try:
        law = laws.fuzzy_table(points)
    except ValueError as error:
        words = str(error).removeprefix("fuzzy_table: ")
        raise ValueError(f"memberships: {memberships}: {words}") from None
    return _replaced(law, changes)


def asperity_of(text: str, transition: str, pair: Pair) -> laws.BoundLaw | None:
    """The asperity law of a mixed joint; only load_sharing has one, greenwood_tripp where auto."""
    name, changes = spelled("asperity", text, ASPERITIES, (AUTO, NONE))
    transition, _ = spelled("transition", transition, TRANSITIONS)
    if transition != "load_sharing":
        if name in (AUTO, NONE):
            return None
        raise ValueError(
            f"asperity={text}: transition {transition} has no asperity law; load_sharing has"
        )
    if name == NONE:
        return None
    return _replaced(ASPERITIES["greenwood_tripp" if name == AUTO else name]().of(pair), changes)


def contact_of(text: str, pair: Pair, restitution: float) -> laws.BoundLaw:
    """The contact law for a text, of a pair of bodies."""
    name, changes = spelled("contact", text, CONTACTS)
    law = CONTACTS[name](pair, checks.fraction("restitution", restitution))
    return _replaced(law, changes)


def friction_of(text: str, coefficient: float) -> laws.BoundLaw | None:
    """The friction law for a text; None for none."""
    name, changes = spelled("friction", text, FRICTIONS, (NONE,))
    if name == NONE:
        return None
    law = FRICTIONS[name](checks.non_negative("friction_coefficient", coefficient))
    return _replaced(law, changes)


def mesh_of(text: str) -> tuple[int, int]:
    """Cells around the bearing and over half its length from "16x2"."""
    try:
        around, along = (int(t) for t in text.split("x"))
    except (AttributeError, ValueError):
        form = "mesh must be auto or two numbers of cells such as 16x2"
        raise ValueError(f"{form}, got {text!r}") from None
    return around, along


def film_of(text: str, ambient: float, flow_factors: bool, mesh: str, drag: str = DRAG):
    """A film law; ambient: pressure above cavitation [Pa], 0 where the film cavitates at ambient
    pressure.
    """
    name, changes = spelled("film", text, ALL_FILMS)
    options: dict = {"ambient": ambient} if checks.non_negative("ambient", ambient) > 0.0 else {}
    if flow_factors:
        options["flow_factors"] = True
    if mesh != "auto":
        options["mesh"] = mesh_of(mesh)
    takes = {"ambient": WITH_AMBIENT, "flow_factors": WITH_FLOW_FACTORS, "mesh": ONLINE_FILMS}
    if one_of("drag", drag, DRAGS) != DRAG:
        options["drag"], takes["drag"] = drag, TABLES
    for option in options:
        if name not in takes[option]:
            raise ValueError(f"film {name} has no {option}; {', '.join(takes[option])} have")
    law = ALL_FILMS[name](**options)
    return _replaced(law, changes) if changes else law


@dataclass(frozen=True, kw_only=True)
class JointOptions:
    """Options of a case's clearance joints; as the default of a parameter they become parameters.

    A law is a name, or a name with parameters in SI units: "impact(damping=440, depth=1.5e-6)".

    joints: clearance joints, a comma list of names [-]
    model: ideal, dry, lubricated or mixed (film, asperities and contact) [-]
    clearance: radial clearance of the clearance joints [m]
    viscosity: dynamic viscosity of the oil [Pa s]
    oil: grade and temperature in place of the viscosity, as ISO-VG-46@60C or SAE-30@80C; none [-]
    restitution: coefficient of restitution of the dry contact [-]
    contact: law, as hertz or impact(damping=440); auto: lankarani_nikravesh when dry and of slides,
        winkler of journals that are mixed or worn [-]
    friction: friction law of contact and asperities: none, coulomb, stribeck, lugre, ... [-]
    friction_coefficient: coefficient of friction of contact and asperities [-]
    film: film law: table (of the Reynolds equation), harmonic, short, long, pinkus_sternlicht,
        sommerfeld, fem, ...; elastic: on a surface that yields, through the wall into contact, as
        elastic(liner=1e-13) [-]
    film_torques: true where the film drags on both bodies [-]
    drag: of table, fast, fem and conserving: ring (a filled gap, as all other films have it) or wet
        (the area that oil wets) [-]
    ambient: pressure at the bearing's ends above cavitation (films table, fem, conserving); 0:
        cavitates there [Pa]
    flow_factors: true where the film of table and fem is that of rough surfaces (Patir and
        Cheng) [-]
    mesh: cells around and over half the length (films fast, fem, conserving), as 16x2; or auto [-]
    roughness: composite rms roughness; 0 leaves out the film thickness ratio, and mixed joints need
        it [m]
    transition: how film and contact share a mixed joint: none, flores, fuzzy, load_sharing, or as
        fuzzy(squeeze=0) [-]
    thresholds: film thickness ratios dry,mixed,full of the fuzzy states; auto: 0.4,1,3 or those of
        the file [-]
    memberships: of fuzzy: cosine, or a CSV file of film thickness ratio, full film, mixed, dry [-]
    asperity: of load_sharing, and beside the film elastic: greenwood_tripp, greenwood_williamson,
        none; auto: the first, none elsewhere [-]
    elastic: of fuzzy and load_sharing: true where the film is that between elastic surfaces [-]
    wear: coefficient of wear of the bearings, Archard's; 0: none; needs the contact winkler, and
        in mixed joints the film short or conserving [m2/N]
    wear_journal: that of the journals [m2/N]
    worn_depth: deepest wear of the bearings, an arc (Dufrane); 0: unworn; films and contacts as for
        wear [m]
    worn_angle: its direction in the frame of the bearing [rad]
    """

    joints: str | Collection[str]
    model: str
    clearance: float = 1e-4
    viscosity: float | str = 0.05
    oil: str = NONE
    restitution: float = 0.9
    contact: str = AUTO
    friction: str = NONE
    friction_coefficient: float = 0.1
    film: str = "table"
    film_torques: bool = True
    drag: str = DRAG
    ambient: float = 0.0
    flow_factors: bool = False
    mesh: str = AUTO
    roughness: float = 0.8e-6
    transition: str = "load_sharing"
    thresholds: str = AUTO
    memberships: str = COSINE
    asperity: str = AUTO
    elastic: str = "false"
    wear: float = 0.0
    wear_journal: float = 0.0
    worn_depth: float = 0.0
    worn_angle: float = -0.5 * math.pi

    def factory(
        self,
        joints: Collection[str],
        *,
        radius: float,
        length: float,
        material: Material = steel,
    ) -> "JointFactory":
        """`factory(name, a, b)` makes a hinge: with clearance if it is chosen, ideal otherwise.

        joints: names of the joints that can have clearance. radius of the journal, length of the
        bearing [m]. Contact stiffness and moduli come from the radii, the length and the material.
        Raises ValueError for names and numbers that give no joint.
        """
        one_of("model", self.model, MODELS)
        checks.positive("clearance", self.clearance)
        chosen = joint_names(self.joints, joints) if self.model != "ideal" else ()
        self._check()
        slots: dict = {"radius": radius, "clearance": self.clearance, "length": length}
        if self.roughness > 0.0:
            slots["roughness"] = self.roughness
        worn = {"wear": self.wear, "wear_journal": self.wear_journal}
        if self.model != "lubricated":  # a film wears nothing
            slots |= {n: laws.archard(coefficient=k) for n, k in worn.items() if k}
        try:
            if self.worn_depth:
                from clearance.laws.outline import worn, worn_arc

                arc = worn_arc(self.worn_depth, self.clearance, self.worn_angle)
                slots["outline"] = worn(bearing=arc)
            slots |= self._laws(Pair(radius, self.clearance, length, material))
        except ValueError as error:
            raise ValueError(f"joint {', '.join(chosen)}: {error}") from None
        return JointFactory(self, frozenset(chosen), slots, material)

    def _check(self) -> None:
        """Refuse names that no model has, also those that this model leaves out."""
        checks.non_negative(f"joint {self.joints}: roughness", self.roughness)
        spelled("contact", self.contact, CONTACTS, (AUTO,))
        spelled("friction", self.friction, FRICTIONS, (NONE,))
        spelled("film", self.film, ALL_FILMS)
        spelled("transition", self.transition, TRANSITIONS)
        spelled("asperity", self.asperity, ASPERITIES, (AUTO, NONE))

    def _laws(self, pair: Pair) -> dict:
        """Laws of a hinge by the field of ClearanceRevolute that takes them."""
        slots: dict = {}
        if self.model in ("dry", "mixed"):
            if pair.radius <= pair.clearance:
                sizes = f"clearance {pair.clearance!r} m must be smaller than radius"
                raise ValueError(f"{sizes} {pair.radius!r} m")
            slots |= self.solids(pair, self.model)
        if self.model in ("lubricated", "mixed"):
            film = film_of(self.film, self.ambient, self.flow_factors, self.mesh, self.drag)
            slots |= {"film": film, "lubricant": self._lubricant()}
            slots["film_torques"] = bool(self.film_torques)
        if self.model == "mixed" and film.law.through_wall:
            del slots["contact"]  # which is part of the film
            slots["asperity"] = asperity_of(self.asperity, "load_sharing", pair)
        elif self.model == "mixed":
            shared = transition_of(self.transition, self.thresholds, self.memberships)
            slots["transition"] = shared
            slots["asperity"] = asperity_of(self.asperity, self.transition, pair)
            if self._elastic():
                slots["elastic"] = laws.line_contact()
        return slots

    def _lubricant(self) -> Lubricant:
        """The oil of a grade, or one of the viscosity."""
        if self.oil == NONE:
            return Lubricant(self.viscosity)
        from clearance.laws.oils import oil_named

        return oil_named(self.oil)

    def _elastic(self) -> bool:
        """True where the film of a mixed joint is that between elastic surfaces."""
        chosen = str(self.elastic).lower()  # true and false of Python too
        return one_of("elastic", chosen, ("true", "false")) == "true"

    def solids(self, pair: Pair, model: str) -> dict:
        """Contact and friction of a dry or mixed joint."""
        contact = self.contact
        if contact.strip() == AUTO:
            worn = self.wear or self.wear_journal or self.worn_depth
            conformal = math.isfinite(pair.clearance) and (model == "mixed" or worn)
            contact = "winkler" if conformal else "lankarani_nikravesh"
        slots = {"contact": contact_of(contact, pair, self.restitution)}
        friction = friction_of(self.friction, self.friction_coefficient)
        return slots if friction is None else slots | {"friction": friction}


@dataclass(frozen=True)
class JointFactory:
    """Joints of a case: with clearance for the chosen names, ideal for all others.

    hinge: what a hinge with clearance has.
    """

    options: JointOptions
    chosen: frozenset[str]
    hinge: dict
    material: Material

    def __call__(self, name: str, a, b) -> Joint:
        """A hinge."""
        if name not in self.chosen:
            return elements.Revolute(a, b, name=name)
        return elements.ClearanceRevolute(a, b, name=name, **self.hinge)

    def slide(
        self,
        name: str,
        a,
        b,
        *,
        overlap: float,
        height: float,
        clearance: float | None = None,
        corner_radius: float = 1e-3,
        width: float | None = None,
        axis=(1.0, 0.0),
        angle: float = 0.0,
        **start,
    ) -> Joint:
        """A slide; see ClearancePrismatic for its numbers and its start.

        Raises ValueError for a model without one.
        """
        if name not in self.chosen:
            return elements.Prismatic(a, b, axis=axis, angle=angle, name=name)
        if clearance is None:
            clearance = self.options.clearance
        checks.positive("clearance", clearance)
        pair = Pair(corner_radius, math.inf, width, self.material, reach=clearance)
        model = "mixed" if self.options.model == "mixed" else "dry"
        try:
            slots = self.options.solids(pair, model)
        except ValueError as error:
            raise ValueError(f"joint {name}: {error}") from None
        return elements.ClearancePrismatic(
            a,
            b,
            axis=axis,
            angle=angle,
            name=name,
            clearance=clearance,
            overlap=overlap,
            height=height,
            width=width,
            corner_radius=corner_radius,
            material=self.material,
            **slots,
            **self._film(),
            **start,
        )

    def _film(self) -> dict:
        """Films of a slide; edges touch where the model has no transition either."""
        from clearance.film.pad_law import pad_film

        if self.options.model == "dry":
            return {}
        wet = {n: self.hinge[n] for n in ("lubricant", "roughness") if n in self.hinge}
        name, _ = spelled("film", self.options.film, ALL_FILMS)
        wet["film"] = pad_film() if name in TABLES else laws.full_pad()
        return wet | {"transition": self.hinge.get("transition", laws.superposed())}


#: options of films, of solids, and of their transition
OF_FILMS = {"viscosity", "oil", "film", "film_torques", "drag", "ambient", "flow_factors", "mesh"}
OF_SOLIDS = {"restitution", "contact", "friction", "friction_coefficient", "wear", "wear_journal"}
OF_TRANSITIONS = {"transition", "thresholds", "memberships", "asperity", "elastic"}
#: options that do nothing with a value of another one
IDLE_WITH = {
    ("friction", NONE): {"friction_coefficient"},
    ("model", "dry"): OF_FILMS | OF_TRANSITIONS,
    ("model", "lubricated"): OF_TRANSITIONS,
}
DECIDING = ("model", "joints", "friction", "oil")  # options that `idle` reads


def idle(scene: "Scene") -> dict[str, str]:
    """Parameters of the case of a scene that do nothing, by name, each with the option that makes
    it so. Those of a case without JointOptions all do something.
    """
    options = {f.name for f in fields(JointOptions)}
    case = scene.case
    if case is None or not options <= case.parameters.keys():
        return {}
    values = {n: p.default for n, p in case.parameters.items()} | scene.parameters
    if values["model"] == "ideal":
        return dict.fromkeys(options - {"model"}, "model = ideal")
    reasons = {"viscosity": f"oil = {values['oil']}"} if values["oil"] != NONE else {}
    rough = any(j.rough_layer for j in scene.joints)
    if not any(j.contact for j in scene.soft_joints):  # slides touch in lubricated models too
        unread = OF_SOLIDS - {"friction", "friction_coefficient"} if rough else OF_SOLIDS
        reasons |= dict.fromkeys(unread, f"model = {values['model']}")
    if rough:
        reasons |= dict.fromkeys(OF_TRANSITIONS - {"asperity"}, f"film = {values['film']}")
    for (option, value), names in IDLE_WITH.items():
        if values[option] == value:
            reasons |= dict.fromkeys(names, f"{option} = {value}")
    return reasons


#: what became of an option that is auto, from a joint; None where the joint does not have it
RESOLVED: dict[str, Callable[[Joint], object]] = {
    "viscosity": lambda joint: getattr(joint, "viscosity", None),
    "contact": lambda joint: joint.contact and joint.contact.law.name,
    "thresholds": lambda joint: _thresholds(joint.transition),
    "asperity": lambda joint: (
        _name(getattr(joint, "asperity", None)) if joint.transition or joint.rough_layer else None
    ),
}


def _name(law: laws.BoundLaw | None) -> str:
    return NONE if law is None else law.law.name


def _thresholds(law: laws.BoundLaw | None) -> str | None:
    """Thresholds as a text; None for a transition without."""
    parameters = {} if law is None else law.parameters
    if not {"dry", "mixed", "full"} <= set(parameters):
        return None
    return ",".join(f"{parameters[n]:g}" for n in ("dry", "mixed", "full"))


def resolved(values: Mapping[str, object], joints: Collection[Joint]) -> dict[str, object]:
    """Values of a case's parameters that are auto, in its first clearance joint, by name."""
    first = next((j for j in joints if j.soft), None)
    names = [n for n in RESOLVED if isinstance(values.get(n), str) and values[n] == AUTO]
    values_of = {n: RESOLVED[n](first) for n in names} if first is not None else {}
    return {n: v for n, v in values_of.items() if v is not None}
