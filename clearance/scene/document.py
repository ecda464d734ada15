"""Scenes as plain data, which files hold: tables, lists, numbers and texts, in both directions."""

import importlib
import linecache
import math
import sys
import types
import typing
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, Field, fields, is_dataclass, replace
from functools import cache
from inspect import signature
from pathlib import Path

from clearance import elements
from clearance.elements.body import Body, Point, ground
from clearance.elements.element import Element
from clearance.elements.joint import Joint
from clearance.elements.quantities import Described
from clearance.files.texts import brief
from clearance.laws.law import BoundLaw, DataLaw, Law, OfJoint
from clearance.laws.materials import Lubricant, Material
from clearance.laws.oils import oil_named
from clearance.values.checks import known, meant
from clearance.values.units import amount, quantity


class Kinds(Mapping):
    """Kinds of elements, each imported on first use."""

    def __getitem__(self, name: str) -> type[Element]:
        if name not in elements.__all__:
            raise KeyError(name)
        return getattr(elements, name)

    def __iter__(self) -> Iterator[str]:
        return iter(elements.__all__)

    def __len__(self) -> int:
        return len(elements.__all__)


#: kinds of elements by name
KINDS: Mapping[str, type[Element]] = Kinds()
#: modules of the package begin so; their laws are read by name
PACKAGE = "clearance."
#: family of laws -> SI units of those parameters that have one unit in all of them
LAW_UNITS = {
    "contact": {
        "restitution": "1",
        "exponent": "1",
        "grazing_speed": "m/s",
        "modulus": "Pa",
        "length": "m",
        "radius": "m",
        "radius_difference": "m",
        "depth": "m",
    },
    "friction": {
        "coefficient": "1",
        "static": "1",
        "kinetic": "1",
        "transition_speed": "m/s",
        "stribeck_speed": "m/s",
        "dead_speed": "m/s",
        "full_speed": "m/s",
    },
    "surface_wear": {"coefficient": "m2/N", "friction": "1"},
}
NONE = "none"
#: modules that were made from the texts of documents, by name and text
_MADE: dict[tuple[str, str], types.ModuleType] = {}
#: fields of the table of a point
POINT = {"body": Body, "point": str | None, **dict.fromkeys("xyz", float)}
ENDS = ("a", "b", "point")  # of joints and loads
SECTIONS = ("bodies", "joints", "loads")
#: what makes a body with mass properties, by the field that states its shape
SHAPES: dict[str, Callable] = {"section": Body.bar, "outline": Body.plate}
RATES = ("angular_velocity", "velocity")  # of bodies at the start


class Misplaced(ValueError):
    """An error in a document.

    path: names of the tables and of the field, from outside in; `whole`: nothing stands around it.
    """

    def __init__(self, path: tuple[str, ...], text: str, complete: bool = False):
        super().__init__(f"{'.'.join(path)}: {text}")
        self.path, self.text, self.whole = path, text, complete


@contextmanager
def at(*names: str, complete: bool = False) -> Iterator[None]:
    """Add a place to errors from inside; `whole`: it is one from the outermost table on."""
    try:
        yield
    except Misplaced as error:
        if error.whole:
            raise
        raise Misplaced((*names, *error.path), error.text, complete) from error
    except (ValueError, TypeError, KeyError, ImportError) as error:
        text = str(error.args[0]) if error.args else str(error)
        raise Misplaced(names, text, complete) from error


# --- from a scene
def plain(value: object) -> object:
    """A part of a scene as plain data."""
    if isinstance(value, BoundLaw):
        parameters = {name: plain(v) for name, v in value.parameters.items()}
        return {"law": f"{value.law.__module__}:{value.law.name}"} | parameters
    if isinstance(value, Body):
        return value.name
    if isinstance(value, Point):
        coordinates = {"x": value.x, "y": value.y} | ({"z": value.z} if value.z else {})
        return {"body": value.body.name, "point": value.name, **coordinates}
    if is_dataclass(value):
        numbers = {f.name: plain(getattr(value, f.name)) for f in fields(value)}
        return {"type": type(value).__name__} | numbers
    if isinstance(value, Mapping):
        return {k: plain(v) for k, v in value.items()}
    if isinstance(value, tuple):
        return [plain(v) for v in value]
    return value


def plain_body(body: Body) -> dict:
    """A body as plain data."""
    return {f.name: plain(getattr(body, f.name)) for f in fields(Body)}


def sources(parts: tuple[Element, ...]) -> dict[str, dict[str, str]]:
    """File and text of the modules of a user's laws, by the name of the module.

    A law that was written at a prompt or in a notebook has no such text and is left out.
    """
    values = [getattr(part, f.name) for part in parts for f in fields(part)]
    modules = {v.law.__module__: v.law.function for v in values if isinstance(v, BoundLaw)}
    texts = {}
    for name, function in sorted(modules.items(), key=lambda item: item[0]):
        file = function.__globals__.get("__file__")
        if name.startswith(PACKAGE) or name == "__main__" or file is None:
            continue
        if text := _text(function):
            texts[name] = {"file": file, "text": text}
    return texts


def _text(function: Callable) -> str:
    """Text of the file of a function; empty where there is none."""
    return "".join(linecache.getlines(function.__code__.co_filename))


# --- laws by name
def module_of(name: str, texts: Mapping[str, Mapping[str, str]]) -> types.ModuleType:
    """A module of laws: of the package, else from its text in the document.

    Raises ValueError where the document has no text of it, or the text cannot be run.
    """
    if name.startswith(PACKAGE):
        return importlib.import_module(name)
    if name not in texts:
        reason = "was written at a prompt, in a notebook or in a script that is run"
        raise ValueError(f"no text of {name} is there, for it {reason}; put the law into a file")
    file = texts[name]["file"]
    text = texts[name]["text"]
    if (name, text) in _MADE:
        return _MADE[name, text]
    there = sys.modules.get(name)
    if any(_text(v.function) == text for v in vars(there or types).values() if isinstance(v, Law)):
        return there
    source = f"<{name} from {file}>"
    linecache.cache[source] = (len(text), None, text.splitlines(keepends=True), source)
    module = types.ModuleType(name)
    module.__file__ = file
    sys.modules[name] = module  # only as it is run: a module of this name may be another one
    try:
        exec(compile(text, source, "exec"), vars(module))
    except Exception as error:
        raise ValueError(
            f"the text of {Path(file).name} cannot be run: {type(error).__name__}: {error}"
        ) from error
    finally:
        del sys.modules[name]
        if there is not None:
            sys.modules[name] = there
    return _MADE.setdefault((name, text), module)


def law_in(module: types.ModuleType, name: str) -> Law:
    """A law of a module. Raises ValueError for a name that does not exist."""
    laws = {v.name: v for v in vars(module).values() if isinstance(v, Law)}
    known(f"{module.__name__} has no law", name, laws)
    return laws[name]


def bound_to(law: Law | Callable, values: dict) -> BoundLaw:
    """A law with its parameters, and the settings of a law that reads numbers made for its
    joint.
    """
    values = {name: _setting(law, value) for name, value in values.items()}
    if not isinstance(law, DataLaw):
        return law(**values)
    settings = {n: v for n, v in values.items() if n not in law.inputs}
    return law.bind(settings, **{n: v for n, v in values.items() if n in law.inputs})


def _setting(law: Law | Callable, value: object) -> object:
    """A setting of a law as it was: with tuples, and dataclasses that its module has."""
    if isinstance(value, list):
        return tuple(_setting(law, v) for v in value)
    if not isinstance(value, Mapping):
        return value
    kind = getattr(law, "function", law).__globals__[value["type"]]
    return kind(**{n: _setting(law, v) for n, v in value.items() if n != "type"})


# --- to a scene
class Parts:
    """Bodies and elements from tables of plain data, each made at its first use.

    bodies: name -> fields; elements: (section, name) -> (kind, fields); law: makes a law from its
    name; shared: kind -> name -> fields of what several elements may share, as lubricants.
    A number may be a text with a unit. A point is a list (x, y) of ground, a text "body.point" or a
    table; a body or an element is its name. Raises Misplaced with the place in the document.
    """

    def __init__(
        self,
        bodies: Mapping[str, Mapping],
        elements: Mapping[tuple[str, str], tuple[str, Mapping]],
        law: Callable[[str, Field | None], Law | Callable],
        shared: Mapping[str, Mapping[str, Mapping]] | None = None,
    ):
        self.tables = elements
        self.law_of = law
        self.shared = shared or {}
        self.body_tables = bodies
        self._bodies: dict[str, Body] = {"ground": ground}
        self._elements: dict[tuple[str, str], Element | None] = {}
        self.ready: dict[tuple[str, str], object] = {}

    # --- bodies
    def body(self, name: str) -> Body:
        """A body by name."""
        if name not in self._bodies:
            known("unknown body", name, self.body_tables)
            with at("body", name, complete=True):
                table = named_table("body", self.body_tables[name])
                self._bodies[name] = self._body({"name": name} | table)
        return self._bodies[name]

    def _body(self, table: dict) -> Body:
        """A body with its mass properties, or one whose shape gives them."""
        make = next((m for n, m in SHAPES.items() if n in table), None)
        if make is None:
            return self._built(Body, table)
        shape = [*signature(make).parameters][:-1]
        others = [f.name for f in fields(Body) if f.name not in (*shape, "mass", "inertia")]
        _check_names(f"a {make.__name__}", table, shape + others, ())
        values = table | self.values(Body, {n: table[n] for n in others if n in table})
        if "material" in table:
            values["material"] = self.record(Material, table["material"])
        return make(**values)

    def point(self, value: object) -> Point | Body:
        """A point: [x, y] of ground, "body", "body.point", or a table of body and place."""
        if isinstance(value, list):
            return ground.at(*amount(value, ("m",)))
        if isinstance(value, str):
            name, _, point = value.partition(".")
            body = self.body(name)
            return body[point] if point else body
        if not isinstance(value, Mapping):
            raise ValueError(f'expected a point as "crank.A" or [x, y], got {value!r}')
        _check_names(f"a point {dict(value)}", value, POINT, ("body",))
        body = self.body(value["body"])
        xyz = [amount(value.get(n, 0.0), ("m",)) for n in "xyz"]
        return Point(body, value["point"], *xyz) if "point" in value else body.at(*xyz)

    # --- elements
    def element(self, section: str, name: str) -> Element:
        """An element by its section and name."""
        key = section, name
        if self._elements.get(key, "") is None:
            raise ValueError(f"{name} refers to itself")
        if key not in self._elements:
            self._elements[key] = None
            kind, table = self.tables[key]
            with at(section, name, complete=True):
                known("unknown kind", kind, KINDS)
                self._elements[key] = self._built(KINDS[kind], {"name": name, **table})
        return self._elements[key]

    def reference(self, value: object, kinds: tuple) -> object:
        """A body, else an element, by its name ("crank", "joint.A") or by the table of an
        element.
        """
        text = value.get("name") if isinstance(value, Mapping) else value
        if not isinstance(text, str):
            raise ValueError(f"expected the name of a body or an element, got {value!r}")
        section, _, name = text.rpartition(".")
        is_body = name in self.body_tables or name == ground.name
        if Body in kinds and isinstance(value, str) and is_body and section in ("", "body"):
            return self.body(name)
        places = [key for key in self.tables if key[1] == name and section in ("", key[0])]
        fits = [p for p in places if issubclass(KINDS.get(self.tables[p][0], object), kinds)]
        if fits:
            return self.element(*fits[0])
        names = [*(self.body_tables if Body in kinds else ()), *(n for _, n in self.tables)]
        raise ValueError(f"nothing of that name: {text!r}{meant(name, names)}")

    # --- values
    def _built(self, kind: type, table: Mapping) -> object:
        """A dataclass from its table."""
        fields_of = {f.name: f for f in fields(kind)}
        needed = [n for n, f in fields_of.items() if is_needed(f)]
        _check_names(kind.__name__, table, fields_of, needed)
        return kind(**self.values(kind, table))

    def values(self, kind: type, table: Mapping) -> dict[str, object]:
        """Values of the fields of a kind that a table has."""
        by_name = {f.name: f for f in fields(kind)}
        hints = typing.get_type_hints(kind)
        values = {}
        for name, value in table.items():
            with at(name):
                values[name] = self._value(by_name[name], hints[name], value)
        return values

    def _value(self, field: Field, hint: object, value: object) -> object:
        number = field.metadata.get("number")
        kinds = typing.get_args(hint) or (hint,)
        if value is None or isinstance(value, bool):
            return self.constant(value)
        if "law" in field.metadata or number and number.families and isinstance(value, Mapping):
            return self.law(value, field)
        if number:
            return self.number(value, number.units)
        if Point in kinds:
            return self.point(value)
        if typing.get_origin(hint) is Mapping:
            return self.points(value)
        if object in kinds or any(issubclass(k, Described) for k in kinds if isinstance(k, type)):
            named = tuple(k for k in kinds if k is not type(None))
            return self.reference(value, named)
        if records := [k for k in kinds if is_dataclass(k) and k is not BoundLaw]:
            return self.record(records[0], value)
        if unit := field.metadata.get("unit"):
            return self.number(value, (unit,))
        return self.constant(value)

    @staticmethod
    def constant(value: object) -> object:
        """A value that stays as it is."""
        return value

    @staticmethod
    def number(value: object, units: tuple[str, ...]) -> object:
        """A number or a tuple of such, in SI."""
        return amount(value, units)

    @staticmethod
    def points(value: object) -> object:
        """Points of a body, by name."""
        if not isinstance(value, Mapping):
            return value
        return {name: amount(coordinates, ("m",)) for name, coordinates in value.items()}

    def record(self, kind: type, value: object) -> object:
        """A material, a lubricant or a balance of heat: its table, or the name of one."""
        section = kind.__name__.lower()
        if isinstance(value, Mapping):
            return self._built(kind, {n: v for n, v in value.items() if n != "type"})
        if (section, value) in self.ready:
            return self.ready[section, value]
        tables = self.shared.get(section, {})
        known(
            f"unknown {section}",
            value,
            [*tables, *sorted(n for s, n in self.ready if s == section)],
        )
        with at(section, value, complete=True):
            return self.ready.setdefault((section, value), self._shared(kind, value, tables[value]))

    def _shared(self, kind: type, name: str, table: object) -> object:
        """A part that elements share, from its table; an oil may be a text of its grade."""
        if kind is Lubricant and isinstance(table, str):
            return oil_named(table)
        named = {"name": name} if "name" in {f.name for f in fields(kind)} else {}
        return self._built(kind, named | named_table(kind.__name__.lower(), table))

    def law(self, value: object, field: Field | None = None) -> BoundLaw | None:
        """A law: its name, or a table of its name and its parameters; None for the name none."""
        if isinstance(value, str):
            value = {"law": value}
        if value == {"law": NONE}:
            return None
        if not isinstance(value, Mapping) or not isinstance(value.get("law"), str):
            raise ValueError(f'expected a law as {{ law = "hertz", ... }}, got {value!r}')
        with at("law"):
            law = self.law_of(value["law"], field)
        parameters = {}
        for name, number in value.items():
            if name != "law":
                with at(name):
                    parameters[name] = _parameter(number, _unit_of(law, name))
        return bound_to(law, parameters)


def _unit_of(law: object, name: str) -> str | None:
    """SI unit of a parameter of a law that comes with the package; None where it is not checked."""
    if not isinstance(law, Law) or not law.__module__.startswith(PACKAGE):
        return None
    return LAW_UNITS.get(law.family.name, {}).get(name)


def _parameter(value: object, unit: str | None = None) -> object:
    """A parameter of a law: numbers may have units, words of settings stay."""
    if isinstance(value, list):
        return [_parameter(v) for v in value]
    if isinstance(value, Mapping):
        return {name: _parameter(v) for name, v in value.items()}
    measured = isinstance(value, str) and value[:1] in "+-.0123456789"
    return quantity(value, unit) if measured else value


def named_table(section: str, table: object) -> Mapping:
    """A table of a section. Raises ValueError for anything else."""
    if not isinstance(table, Mapping):
        raise ValueError(f"expected a table, got {table!r}; [{section}.NAME] begins one")
    return table


def is_needed(field: Field) -> bool:
    """True for a field without a default."""
    return field.default is MISSING and field.default_factory is MISSING


def _check_names(owner: str, table: Mapping, names, needed) -> None:
    """Raises ValueError for a field that the owner does not have, and for a missing one."""
    for name in table:
        known("unknown field", name, names, f" of {owner}")
    if missing := [n for n in needed if n not in table]:
        raise ValueError(f"{owner} needs {', '.join(missing)}")


# --- from the description of a scene
def check(document: object) -> None:
    """Check that the parts of a description are of the kinds that their fields declare.

    No part is made and no law is run. Fields and kinds of elements that this version does not have
    may be there. Raises Misplaced.
    """
    lists = {n: document.get(n) if isinstance(document, Mapping) else None for n in SECTIONS}
    for section, rows in lists.items():
        if not isinstance(rows, list) or not all(_is_part(row) for row in rows):
            raise Misplaced((section,), "it must be a list of objects that have a name")
    for name, hint in (("name", str), ("gravity", tuple)):
        if not _fits(document.get(name), hint, ()):
            raise Misplaced((name,), f"it cannot be {brief(document.get(name))}")
    names = {ground.name, *(body["name"] for body in lists["bodies"])}
    for section, rows in lists.items():
        for row in rows:
            kinds = _hints(Body) if section == "bodies" else _hints_of(row)
            for name in (n for n in row if not _fits(row[n], kinds.get(n, object), names)):
                path = section, row["name"], name
                raise Misplaced(path, f"it cannot be {brief(row[name])}")
            if section != "bodies" and not isinstance(row.get("type"), str):
                raise Misplaced((section, row["name"]), "it must have a type")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _is_part(row: object) -> bool:
    return isinstance(row, Mapping) and isinstance(row.get("name"), str)


@cache
def _hints(kind: type) -> dict[str, object]:
    return typing.get_type_hints(kind)


def _hints_of(row: Mapping) -> dict[str, object]:
    """Kinds of an element's fields, as far as they are known."""
    kind = row.get("type")
    if isinstance(kind, str) and kind in KINDS:
        return _hints(KINDS[kind])
    return dict.fromkeys(ENDS, Point | str | None)


@cache
def _parts_of(hint: object) -> tuple[object, tuple]:
    """Kind of a type, and its arguments."""
    return typing.get_origin(hint) or hint, typing.get_args(hint)


def _fits(value: object, hint: object, names: Collection[str]) -> bool:
    """True for plain data of a field of this kind; names: those of the bodies."""
    kind, inner = _parts_of(hint)
    if kind in (types.UnionType, typing.Union):
        return any(_fits(value, part, names) for part in inner)
    if kind is float:
        return _is_number(value)
    if kind is Body:
        return isinstance(value, str) and value in names
    if kind is tuple:
        return isinstance(value, list) and len(value) > 1 and all(map(_is_number, value))
    if not isinstance(value, Mapping):
        return kind is object or isinstance(value, kind)
    if kind is Mapping:
        return all(_fits(part, inner[1], names) for part in value.values())
    if kind is BoundLaw:
        return isinstance(value.get("law"), str)
    if not is_dataclass(kind):
        return kind is object
    hints = POINT if kind is Point else _hints(KINDS.get(str(value.get("type")), kind))
    needed = {"body", "x", "y"} if kind is Point else {"type"}
    return needed <= value.keys() and all(
        _fits(part, hints.get(name, object), names) for name, part in value.items()
    )


def read(document: Mapping) -> list[Element]:
    """Elements, with their bodies, from the description of a scene, laws from the texts that it
    has.

    Raises Misplaced for what it cannot be read of, with the place in the document.
    """
    check(document)
    texts = document.get("sources", {})
    tables = {
        (section, row["name"]): (
            row["type"],
            {n: v for n, v in row.items() if n not in ("type", "name")},
        )
        for section in ("joint", "load")
        for row in document[f"{section}s"]
    }
    bodies = {row["name"]: row for row in document["bodies"]}
    if "rates" not in document:  # before 1.0.0, where a rate of 0 was none
        bodies = {name: _without_zeros(row) for name, row in bodies.items()}

    def law(reference: str, _: Field | None) -> Law:
        module, _, name = reference.partition(":")
        return law_in(module_of(module, texts), name)

    parts = Parts(bodies, tables, law)
    parsed = [parts.element(*key) for key in tables]
    for element in parsed:
        _leave_to_joint(element)
    return parsed


def _without_zeros(row: Mapping) -> dict:
    """A body without the rates that are 0."""
    return {n: v for n, v in row.items() if n not in RATES or v not in (0.0, [0.0, 0.0])}


def _leave_to_joint(element: Element) -> None:
    """Mark the parameters of laws that the element would determine as they are here."""
    for field in fields(element) if isinstance(element, Joint) else ():
        law = getattr(element, field.name)
        if isinstance(law, BoundLaw):
            surfaces = element.seen_by(field.name)
            names = [n for n, check in law.law.checks.items() if isinstance(check, OfJoint)]
            of_joint = tuple(n for n in names if _of_joint(law, n, surfaces) == law.values[n])
            element._set(field.name, replace(law, of_joint=of_joint))


def _of_joint(law: BoundLaw, name: str, surfaces) -> float | None:
    """A parameter of a law as the element would determine it; None where it cannot."""
    try:
        return law.law.checks[name].function(surfaces, law.values)
    except ValueError:  # as a stiffness for an exponent that is not Hertz's
        return None
