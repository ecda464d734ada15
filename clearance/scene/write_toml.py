"""A scene as the text of a scene file, with the numbers that it has."""

import inspect
import json
from collections.abc import Callable
from dataclasses import MISSING, fields
from pathlib import Path

from clearance.elements.body import Body, Point, ground
from clearance.elements.element import Element
from clearance.laws.law import BoundLaw, Law
from clearance.scene.document import KINDS, PACKAGE, plain
from clearance.scene.scene import Scene
from clearance.scene.toml_scene import laws_for

WIDTH = 100  # of a line


def toml_of(scene: Scene, text: str = "", folder: Path = Path()) -> str:
    """The text of a scene file that has this scene; text: its summary; folder: of the file.

    Laws of a user's file are named by its path. Raises ValueError for a law without a file, and for
    an element of a user.
    """
    head = [f"name = {json.dumps(scene.name)}"]
    head += [f"text = {json.dumps(text)}"] if text else []
    head += [f"gravity = {_value(list(scene.gravity))}"]
    parts = [("body", b.name, _fields(b, folder)) for b in scene.bodies]
    for element in scene.elements:
        kind = type(element).__name__
        if kind not in KINDS:
            raise ValueError(f"{element.name}: a scene file has no {kind}; keep the Python case")
        values = {"kind": json.dumps(kind)} | _fields(element, folder)
        parts.append((element.group.removesuffix("s"), element.name, values))
    sections: dict[str, list[str]] = {}
    for section, name, values in parts:
        sections.setdefault(section, []).extend(_rows(_key(name), values))
    tables = ["\n".join([f"[{section}]", *rows]) for section, rows in sections.items()]
    return "\n\n".join(["\n".join(head), *tables]) + "\n"


def _rows(name: str, values: dict[str, str]) -> list[str]:
    """A table on one line, or a field a line."""
    line = f"{name} = {_table(values)}"
    return [line] if len(line) <= WIDTH else [f"{name}.{n} = {v}" for n, v in values.items()]


def _fields(part: Body | Element, folder: Path) -> dict[str, str]:
    """Fields of a body or an element that are not as usual, as texts."""
    entries = {}
    for field in fields(part):
        value = getattr(part, field.name)
        if field.name == "name" or value == _usual(field):
            continue
        is_law = isinstance(value, BoundLaw)
        entries[field.name] = _law(value, field, folder) if is_law else _value(value)
    return entries


def _usual(field) -> object:
    return field.default_factory() if field.default_factory is not MISSING else field.default


def _value(value: object) -> str:
    """A value as TOML."""
    if isinstance(value, Point):
        return _point(value)
    if isinstance(value, Body):
        return json.dumps(f"body.{value.name}" if value is not ground else value.name)
    if isinstance(value, Element):
        return json.dumps(f"{value.group.removesuffix('s')}.{value.name}")
    if isinstance(value, str | bool | int | float):
        return json.dumps(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if hasattr(value, "items"):
        return _table({_key(n): _value(v) for n, v in value.items()})
    members = {f.name: getattr(value, f.name) for f in fields(value)}
    return _table({n: _value(v) for n, v in members.items() if v is not None})


def _table(values: dict[str, str]) -> str:
    return f"{{ {', '.join(f'{name} = {value}' for name, value in values.items())} }}"


def _key(name: str) -> str:
    """A name as a key of TOML, in quotes where it needs them."""
    bare = name.isascii() and name.replace("-", "").replace("_", "").isalnum()
    return name if bare else json.dumps(name)


def _point(point: Point) -> str:
    body, coordinates = point.body, (point.x, point.y, point.z)
    if point.name == "origin" and not any(coordinates) and "origin" not in body.points:
        return json.dumps(body.name)
    if point.name in body.points and "." not in point.name and body[point.name] == point:
        return json.dumps(f"{body.name}.{point.name}")
    if body is ground and ground.at(*coordinates) == point:
        return _value(coordinates if point.z else coordinates[:2])
    return _table({name: _value(value) for name, value in plain(point).items()})


def _law(law: BoundLaw, field, folder: Path) -> str:
    """A law by its name, with the parameters that are neither usual nor its joint's."""
    numbers = {n: v for n, v in law.parameters.items() if n not in law.of_joint}
    if not str(law.law.__module__).startswith(PACKAGE):
        file = Path(law.law.function.__code__.co_filename)
        folder = folder.resolve()
        if not file.is_file():
            raise ValueError(f"the law {law.law.name} has no file: put it into one")
        path = file.relative_to(folder) if file.is_relative_to(folder) else file
        return _spelled(f"{path.as_posix()}:{law.law.name}", numbers)
    for name, candidate in laws_for(field).items():
        if candidate is law.law:
            usual = law.law.parameters
            return _spelled(name, {n: v for n, v in numbers.items() if v != usual[n]})
    for name, make in laws_for(field).items():
        if isinstance(make, Law):
            continue
        usual = {n: p.default for n, p in inspect.signature(make).parameters.items()}
        changed = {n: v for n, v in numbers.items() if n in usual and v != usual[n]}
        for parameters in (changed, {n: v for n, v in changed.items() if v is not False}):
            if _makes(make, parameters, law):
                return _spelled(name, parameters)
    raise ValueError(f"{law!r} has no name in scene files")


def _makes(make: Callable, parameters: dict, law: BoundLaw) -> bool:
    """True where a function makes this law of these parameters, and its joint the others."""
    try:
        return make(**parameters) == (law.replaced() if law.of_joint else law)
    except (TypeError, ValueError):
        return False


def _spelled(name: str, parameters: dict) -> str:
    """A law with its parameters; those of settings may be dataclasses."""
    if not parameters:
        return json.dumps(name)
    return _table({"law": json.dumps(name)} | {n: _value(plain(v)) for n, v in parameters.items()})
