"""Structures in the store: a process that meets one again traces nothing until it needs a program.

An entry has the texts of the kernels, the layout, and a scene of the structure. Programs are traced
from this scene where machine code is missing, and for lanes and exports. Structures with parts or
laws of a user have no entry.
"""

import hashlib
import pickle
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType

from clearance.elements.declared import ours
from clearance.machine import store
from clearance.mechanism.numbers import Numbers
from clearance.mechanism.structure import Structure
from clearance.scene.scene import Scene
from clearance.tracing import kernels
from clearance.values.later import Later
from clearance.values.spelling import taken

HERE = Path(__file__).resolve().parent
#: folders of the code that a trace follows from
FOLDERS = ("values", "laws", "film", "elements", "scene", "tracing", "mechanism")
PLAIN = (bool, int, float, str, bytes, type(None))


class Unnamed(ValueError):
    """A part of a key that another process may have otherwise."""


def words(value: object) -> Iterator[str]:
    """A key in words, equal in all processes. Raises Unnamed for what has no such words."""
    if type(value) in PLAIN:
        yield f"{type(value).__name__} {value!r}"
    elif isinstance(value, tuple | list):
        yield type(value).__name__
        for entry in value:
            yield from words(entry)
        yield ")"
    elif isinstance(value, type | FunctionType) and (ours(value) or value.__module__ == "builtins"):
        yield f"{value.__module__}.{value.__qualname__}"
    elif isinstance(value, CodeType) and HERE.parent in Path(value.co_filename).resolve().parents:
        yield f"{Path(value.co_filename).name} {value.co_firstlineno} {value.co_qualname}"
    else:
        raise Unnamed(f"{type(value).__name__}")


@cache
def code() -> str:
    """Sizes and times of the files that a trace follows from."""
    paths = sorted(path for f in FOLDERS for path in (HERE.parent / f).glob("*.py"))
    stamps = ((path, path.stat()) for path in paths)
    return " ".join(f"{p} {s.st_size} {s.st_mtime_ns}" for p, s in stamps)


def kept(
    key: tuple, scene: Scene, trace: Callable[[], Structure], anew: Callable[[Scene], Structure]
) -> Structure:
    """The structure of a key, from the store where it has it.

    scene: of the structure; trace: gives the structure of it; anew: that of another such scene.
    """
    traced: list[Structure] = []

    def make() -> bytes:
        traced.append(trace())
        return packed(traced[0], scene)

    data = noted("structure", key, make)
    return traced[0] if traced else unpacked(data, anew) if data else trace()


def noted(kind: str, key: tuple, make: Callable[[], bytes]) -> bytes:
    """The bytes that a trace gives for a key, from the store where it has them; none where other
    processes may have the key otherwise.
    """
    try:
        about = " ".join(words(key)) if store.COMPILED else ""
    except Unnamed:
        about = ""
    if not about:
        return b""
    text = f"{store.PYTHON} {store.FUSES} {code()} {about}"
    return store.stored(f"{kind}_{hashlib.sha256(text.encode()).hexdigest()[:32]}", make)[0]


def packed(structure: Structure, scene: Scene) -> bytes:
    """A structure in bytes; none of one whose programs call what they do not have."""
    document = scene.to_json()
    alike = Numbers(Scene.from_json(document)).signature == Numbers(scene).signature
    if not (alike and structure.alone):
        return b""
    names = "layout modes formulas forced rubs iterates spatial takes_moments"
    about = taken(structure, names) | {"written": dict(structure.written)}
    return pickle.dumps((document, about))


def unpacked(data: bytes, anew: Callable[[Scene], Structure]) -> Structure:
    """The structure that `packed` gave these bytes for."""
    document, about = pickle.loads(data)
    programs = Later(lambda: anew(Scene.from_json(document)).programs)
    derive = kernels.plain(about["formulas"])["derive"]
    return Structure(programs=programs, derive=derive, alone=True, **about)
