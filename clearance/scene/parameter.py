"""A scene with one of its parameters varied.

A parameter is that of the case which made the scene ("clearance"), or a number of the scene itself
("joints/B/clearance"), see `Scene.replaced`.
"""

import json
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields

from clearance.laws.law import BoundLaw
from clearance.scene.scene import Scene
from clearance.values import checks
from clearance.values.units import quantity

_UNITS = re.compile(r"\[([^\]]*)\]")


@dataclass(frozen=True)
class Varied:
    """A parameter and the scenes of its values.

    value, size: in SI; size: its absolute value, or what was given where it is 0; scene: that of
        another value.
    """

    name: str
    value: float
    size: float
    units: str
    scene: Callable[[float], Scene]


#: names of parameters, also as a comma list; or their sizes by name, as numbers or in words
Wanted = str | Iterable[str] | Mapping[str, float | str | None]


def wanted(names: Wanted) -> dict[str, float | str | None]:
    """Sizes by parameter, None for its value, from any of the forms: "speed,load=1N" has one size.

    Raises ValueError.
    """
    if not names:
        raise ValueError(f"sensitivity {names!r}: give at least one parameter, such as clearance")
    if isinstance(names, Mapping):
        return dict(names)
    sizes: dict[str, float | str | None] = {}
    for text in names.split(",") if isinstance(names, str) else names:
        name, equals, size = (part.strip() for part in text.partition("="))
        if not name or name in sizes:
            problem = f"{name} is requested twice" if name else "a name is missing"
            raise ValueError(f"sensitivity {names!r}: {problem}")
        sizes[name] = size if equals else None
    return sizes


def varied(scene: Scene, name: str, size: float | str | None = None) -> Varied:
    """A parameter of a scene. Raises ValueError for one that is no number, or 0 without a size."""
    value, units, make = _of_case(scene, name) if _in_case(scene, name) else number_of(scene, name)
    if not value and size is None:
        raise ValueError(
            f"sensitivity to {name}: its value is 0, which gives no width of the difference; "
            f"give the size that counts, as {name}=1e-3"
        )
    if size is None:
        return Varied(name, value, abs(value), units, make)
    try:
        number = quantity(size, units)
    except ValueError as error:
        raise ValueError(f"size of {name}: {error}") from None
    return Varied(name, value, checks.positive(f"size of {name}", number), units, make)


def _in_case(scene: Scene, name: str) -> bool:
    """True for a parameter of the scene's case. Raises ValueError for a name of neither."""
    if scene.case is None or "/" in name:
        return False
    checks.known("sensitivity: the case has no parameter", name, scene.case.parameters)
    return True


def check_effect(scene: Scene, name: str) -> None:
    """Raises ValueError for a parameter of the case that does nothing."""
    from clearance.scene.joint_options import idle

    if reason := idle(scene).get(name):
        raise ValueError(f"{name} has no effect ({reason})")


def _of_case(scene: Scene, name: str) -> tuple[float, str, Callable[[float], Scene]]:
    """Value, units and scenes of a parameter of the case."""
    case, arguments = scene.case, scene.parameters
    parameter = case.parameters[name]
    automatic = json.loads(scene.origin["resolved"])
    value = automatic.get(name, arguments.get(name, parameter.default))
    if isinstance(value, bool | str) or not isinstance(value, int | float) or parameter.kind is int:
        check_effect(scene, name)
        raise ValueError(f"sensitivity to {name}: {value!r} is no number that can vary")
    return float(value), parameter.units, lambda v: case.scene(**arguments | {name: v})


def number_of(scene: Scene, name: str) -> tuple[float, str, Callable[[float], Scene]]:
    """Value, units and scenes of a number of the scene. Raises ValueError as `Scene.replaced`."""
    part = next((p for p in scene.parts if name.startswith(f"{p.key}/")), None)
    if part is None:
        scene.replaced({name: 0.0})
    attribute, _, parameter = name.removeprefix(f"{part.key}/").partition("/")
    value = getattr(part, attribute, None)
    text = next(
        (
            f.metadata["number"].text
            for f in fields(part)
            if f.name == attribute and "number" in f.metadata
        ),
        "",
    )
    if parameter and isinstance(value, BoundLaw):
        value, text = value.values.get(parameter), ""
    if isinstance(value, bool) or not isinstance(value, int | float):
        scene.replaced({name: 0.0})
        raise ValueError(f"sensitivity to {name}: {value!r} is no number that can vary")
    units = _UNITS.search(text)
    return float(value), units[1] if units else "?", lambda v: scene.replaced({name: v})
