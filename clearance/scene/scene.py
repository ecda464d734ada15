"""The scene of a mechanism: its elements and the bodies that they act on; scenes made from it."""

import dataclasses
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

from clearance.elements import declared
from clearance.elements.body import Body, ground
from clearance.elements.drive import Drive
from clearance.elements.element import Element, Spot
from clearance.elements.joint import Joint
from clearance.laws.law import BoundLaw
from clearance.scene import document
from clearance.values import checks
from clearance.values.accessors import Celled

Part = TypeVar("Part", Body, Element)


@checks.answers
class Scene(Celled):
    """A complete mechanism: joints, drives and loads.

    Bodies follow from the parts; nothing is listed twice.

    parts: elements (joints, drives, springs, forces) in any order, which fixes the order of
        outputs; gravity: acceleration (x, y) [m/s2], or (x, y, z) for a mechanism whose plane is
        not vertical; name: stored with results. `parameters`: those that its case was given;
        `origin`: texts on its source, stored with results too. `case`: the case that made it, also
        for other values of its parameters, None where none did.
    Raises ValueError naming the part for duplicate names, parts on bodies without a joint, floating
    parts.

    Example:

        >>> arm = cl.Body("arm", mass=0.5, inertia=1e-3, points={"P": (0, 0.2)})
        >>> cl.Scene(cl.Revolute(cl.ground, arm["P"], name="P"), name="pendulum")
        Scene('pendulum': 1 bodies; P:Revolute)
    """

    name: str
    gravity: tuple[float, ...]
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    loads: tuple[Element, ...]
    parameters: dict[str, object]
    origin: dict[str, str]
    case: Any

    def __init__(self, *parts, gravity: tuple[float, ...] = (0.0, -9.81), name: str = "scene"):
        for part in parts:
            if not isinstance(part, Element):
                raise TypeError(f"scene parts must be joints, drives or loads, got {part!r}")
        vars(self).update(
            name=checks.identifier("scene name", name),
            gravity=checks.point("gravity", gravity),
            joints=tuple(p for p in parts if isinstance(p, Joint)),
            loads=tuple(p for p in parts if not isinstance(p, Joint)),
            parameters={},
            origin={},
            case=None,
        )
        for part in self.elements:
            if not declared.ours(type(part)):
                declared.check(part)
        distinct = (b for p in self.elements for b in p.bodies() if b is not ground)
        vars(self).update(bodies=_distinct(distinct))
        _check_names("body", self.bodies)
        _check_names("joint", self.joints)
        _check_names("load", self.loads)
        for part, role, companion in ((p, *c) for p in parts for c in p.companions().items()):
            if companion not in parts:
                raise ValueError(
                    f"{part.label()}: its {role}, {companion.label()}, is not in the scene"
                )
        self._check_connected()

    def __setattr__(self, name: str, value: object):
        raise AttributeError(f"a scene is frozen; make another with this {name}")

    def _check_connected(self):
        if not self.bodies:
            raise ValueError(
                "the scene has no moving body: give at least one joint or load on a Body"
            )
        jointed = {b for j in self.joints for b in j.bodies()}
        for load in self.loads:
            strangers = [b.name for b in load.bodies() if b is not ground and b not in jointed]
            if strangers and not load.holds_free_bodies:
                names = ", ".join(sorted(b.name for b in jointed if b is not ground)) or "none"
                raise ValueError(
                    f"{load.label()}: unknown body {strangers[0]!r}; bodies with joints: {names}"
                )
        reached = {ground}
        links = [p.bodies() for p in (*self.joints, *self.loads)]
        while grown := {b for link in links if reached & set(link) for b in link} - reached:
            reached |= grown
        if floating := [b.name for b in self.bodies if b not in reached]:
            raise ValueError(
                f"floating: no joint, drive or spring connects {', '.join(floating)} with ground"
            )

    @cached_property
    def elements(self) -> tuple[Element, ...]:
        """All joints, then all loads."""
        return *self.joints, *self.loads

    @cached_property
    def drives(self) -> tuple[Drive, ...]:
        """Drives, in the order of the scene."""
        return tuple(load for load in self.loads if isinstance(load, Drive))

    @property
    def spots(self) -> list[tuple[Element, Spot]]:
        """Places where elements may touch, each with its element."""
        return [(element, spot) for element in self.elements for spot in element.spots()]

    @cached_property
    def soft_joints(self) -> tuple[Joint, ...]:
        """Joints that only forces hold together, in the order of the scene."""
        return tuple(j for j in self.joints if j.soft)

    @cached_property
    def clearance_joints(self) -> tuple[Joint, ...]:
        """Soft joints whose bodies may touch."""
        return tuple(j for j in self.soft_joints if j.spots())

    @cached_property
    def rubbing_joints(self) -> tuple[Joint, ...]:
        """Joints without clearance that have friction."""
        return tuple(j for j in self.joints if not j.soft and j.friction is not None)

    @cached_property
    def facts(self) -> dict[str, dict]:
        """Attributes of each joint in result files, by its group."""
        return {f"joints/{joint.name}": joint.facts for joint in self.joints}

    @cached_property
    def doubts(self) -> list[str]:
        """Warnings of its bodies, elements and laws, each once."""
        parts = (*self.bodies, *self.elements)
        texts = [doubt for part in parts for doubt in part.doubts()]
        texts += [doubt for load in self.loads for doubt in load.doubts_at_start(self.drives)]
        return [*dict.fromkeys(texts)]

    @cached_property
    def kinks(self) -> list[float]:
        """Times [s] at which slopes of laws of time jump, in their order."""
        values = [getattr(e, f.name) for e in self.elements for f in fields(e)]
        laws = [(v.law.kinks, v.values) for v in values if isinstance(v, BoundLaw)]
        return sorted({t for kinks, numbers in laws if kinks for t in kinks(numbers) if t > 0.0})

    @cached_property
    def turn(self) -> float | None:
        """Duration of one turn of the first drive that rotates at a constant or nominal speed [s],
        if there is one.
        """
        return next((d.turn for d in self.drives if d.turn is not None), None)

    @property
    def parts(self) -> list[Body | Element]:
        """Bodies, joints and loads."""
        return [*self.bodies, *self.elements]

    @cached_property
    def positions(self) -> dict[str, int]:
        """Position of each part among all, by its key."""
        return {p.key: i for i, p in enumerate(self.parts)}

    @cached_property
    def provenance(self) -> dict[str, str]:
        """Attributes of result files: case, parameters that were given (JSON), entire scene (JSON),
        joints whose contact begins with a touch (JSON).

        Of a case also its file and the defaults of the other parameters (JSON), of a command its
        line.
        """
        parameters = json.dumps(self.parameters, default=str, sort_keys=True)
        about = {"case": self.name, "parameters": parameters, "scene": self.to_json()}
        return about | {"first_touch": self.first_touch} | self.origin

    @property
    def first_touch(self) -> str:
        """JSON of the names of joints whose contact begins with a touch, a row of the events."""
        return json.dumps([j.name for j in self.clearance_joints if j.first_touch])

    def rebuilt(
        self,
        *,
        body: Callable[[Body], Body] = lambda b: b,
        element: Callable[[Element], Element] = lambda e: e,
        gravity: tuple[float, ...] | None = None,
    ) -> "Scene":
        """The scene with every body and element passed through a function; elements follow to the
        new ones.
        """
        copies: dict = {b: body(b) for b in self.bodies} | {ground: ground}

        def followed(value):
            if isinstance(value, Body):
                return copies[value]
            if not is_dataclass(value) or isinstance(value, BoundLaw):
                return value
            if isinstance(value, Element) and value in copies:
                return copies[value]
            parts = {f.name: followed(getattr(value, f.name)) for f in fields(value)}
            new = replace(value, **parts)
            return copies.setdefault(value, element(new)) if isinstance(value, Element) else new

        elements = [followed(part) for part in self.elements]
        scene = Scene(
            *elements, gravity=self.gravity if gravity is None else gravity, name=self.name
        )
        scene.parameters.update(self.parameters)
        scene.origin.update(self.origin)
        return scene

    def replaced(self, changes: Mapping[str, float]) -> "Scene":
        """The scene with some numbers changed, by their names in result files:
        {"joints/B/clearance": 1e-4}.

        Numbers of bodies, elements and their laws ("joints/B/contact/stiffness"). What a joint
        determines, such as the stiffness of its contact, follows. Raises ValueError for a name that
        the scene does not have.
        """
        rest = dict(changes)
        scene = self.rebuilt(body=lambda b: _changed(b, rest), element=lambda e: _changed(e, rest))
        if rest:
            name = next(iter(rest))
            raise ValueError(f"{name!r} {self._no_number(name)}")
        return scene

    @property
    def changeable(self) -> list[str]:
        """Names of the numbers that `replaced` changes."""
        return [n for part in self.parts for n in _changeable(part)]

    def _no_number(self, name: str) -> str:
        """The reason for which a name is no number that can change."""
        names = self.changeable
        for part in self.parts:
            value = getattr(part, name.removeprefix(f"{part.key}/"), None)
            if name.startswith(f"{part.key}/") and value is not None:
                numbers = ", ".join(_changeable(part))
                return f"is no number of this scene but {value!r}; numbers beside it: {numbers}"
        return f"is no number of this scene{checks.meant(name, names)}"

    def description(self) -> dict:
        """The scene as plain data: bodies, joints, loads with every number.

        Made once: leave it as it is.
        """
        return self._description

    @cached_property
    def _description(self) -> dict:
        return {
            "name": self.name,
            "gravity": self.gravity,
            "rates": "given",  # those of bodies, else None: a 0 is given
            "bodies": [document.plain_body(b) for b in self.bodies],
            "joints": [document.plain(j) for j in self.joints],
            "loads": [document.plain(load) for load in self.loads],
        }

    def to_json(self) -> str:
        """The scene as a JSON document: its description, and the texts of a user's laws."""
        return self._json

    @cached_property
    def _json(self) -> str:
        texts = document.sources(self.elements)
        return json.dumps(self.description() | ({"sources": texts} if texts else {}))

    @classmethod
    def from_json(cls, text: str) -> "Scene":
        """The scene of a JSON document that `to_json` wrote, as every result file has one.

        Laws of the package are read by their names. A law of a user is made by running the text
        of its file, which the document has. Raises ValueError, with the place in the document,
        for what cannot be read: a kind or a law that this version does not have, a law without
        text.
        """
        data = json.loads(text)
        return cls(*document.read(data), gravity=tuple(data["gravity"]), name=data["name"])

    def __repr__(self) -> str:
        kinds = ", ".join(f"{j.name}:{type(j).__name__}" for j in self.joints)
        return f"Scene({self.name!r}: {len(self.bodies)} bodies; {kinds})"


def counterparts(before: Scene, after: Scene) -> dict[Body | Element, Body | Element]:
    """The parts of one scene by those of another of the same structure; the ground is that of
    both.
    """
    return dict(zip(before.parts, after.parts, strict=True)) | {ground: ground}


def exchanged(value: Any, new: Mapping[Body | Element, Body | Element]) -> Any:
    """A plan, a start or another value with parts of a scene in it, exchanged for others."""
    if type(value) in (str, float, type(None)):
        return value
    if isinstance(value, (Body, Element)):
        return new[value]
    if isinstance(value, (tuple, list)):
        return type(value)([exchanged(v, new) for v in value])
    if isinstance(value, dict):
        return {exchanged(k, new): exchanged(v, new) for k, v in value.items()}
    return type(value)(**{n: exchanged(v, new) for n, v in vars(value).items()})


def _changed(part: Part, changes: dict[str, float]) -> Part:
    """A part with the numbers that stand under its name; they are taken out of the changes."""
    values: dict[str, Any] = {}
    for name in [name for name in _changeable(part) if name in changes]:
        field, _, parameter = name.removeprefix(f"{part.key}/").partition("/")
        value = values.get(field, getattr(part, field))
        change = changes.pop(name)
        values[field] = value.replaced(**{parameter: change}) if parameter else change
    return replace(part, **values) if values else part


def _changeable(part: Body | Element) -> list[str]:
    """Names of a part's numbers, and of its laws' parameters, that can change."""
    names = []
    for field in fields(part):
        name = f"{part.key}/{field.name}"
        value = getattr(part, field.name)
        if isinstance(value, BoundLaw):
            names += [f"{name}/{parameter}" for parameter in value.law.inputs]
        elif isinstance(value, int | float) and not isinstance(value, bool):
            names.append(name)
    return names


def _distinct(items: Iterable) -> tuple:
    return tuple(dict.fromkeys(items))


def _check_names(kind: str, items: Iterable) -> None:
    names = [i.name for i in items]
    if twice := sorted({n for n in names if names.count(n) > 1}):
        raise ValueError(f"duplicate {kind} name {twice[0]!r}")


def reduced(scene: Scene) -> dict[str, Scene]:
    """The scene, and what is left of it when parts are taken out, the smallest last: what each part
    costs.
    """
    scenes = {"as it is": scene}
    clearances = scene.clearance_joints
    if any(j.friction is not None for j in scene.joints):
        scenes["without friction"] = scene.rebuilt(element=_smooth)
    if any(j.film is not None and j.film_torques for j in clearances):
        scenes["without film torques"] = scene.rebuilt(element=_without_film_torques)
    if len(clearances) > 1:
        first = clearances[0].name
        scenes[f"clearance in {first} only"] = scene.rebuilt(
            element=lambda e: e if e.name == first else _ideal(e)
        )
    if clearances:
        scenes["ideal joints"] = idealised(scene)
    return scenes


def idealised(scene: Scene) -> Scene:
    """The scene with an ideal joint for every one with clearance, and no friction in any joint."""
    return scene.rebuilt(element=_ideal)


def _smooth(element: Element) -> Element:
    rubs = getattr(element, "friction", None) is not None
    return dataclasses.replace(element, friction=None) if rubs else element


def _without_film_torques(element: Element) -> Element:
    return (
        dataclasses.replace(element, film_torques=False)
        if hasattr(element, "film_torques")
        else element
    )


def _ideal(element: Element) -> Element:
    return element.ideal() if isinstance(element, Joint) and element.soft else _smooth(element)
