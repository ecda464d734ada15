"""A scene file as a Python case: the same scene, written with `cl.Body`, `cl.Revolute` and so
on.
"""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import Field, fields
from pathlib import Path

from clearance.elements.body import Body
from clearance.files.texts import text_of
from clearance.film import names
from clearance.laws.materials import Lubricant, Material, steel
from clearance.scene.case import Parameter
from clearance.scene.document import KINDS, NONE, Parts, at
from clearance.scene.toml_scene import FUNCTIONS, MEASURED, PARAMETER, SECTIONS, scene_file
from clearance.values.units import quantity

WIDTH = 100  # of a line
#: functions of the package that turn a number in a unit into SI
SPELLED = {"mm": "cl.mm", "um": "cl.um", "rpm": "cl.rpm", "cP": "cl.cP", "deg": "cl.degree"}
#: formula -> Python: functions and constants of the module math
MATHS = re.compile(rf"\b({'|'.join(f for f in FUNCTIONS if f not in ('abs', 'min', 'max'))}|pi)\b")
QUANTITY = re.compile(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(\S+)\s*$")
FIRST = ("a", "b", "target", "point", "body")  # fields that are given without their names
SHARED = {"lubricant": Lubricant, "material": Material}


def python_of(path: Path, folder: Path | None = None) -> str:
    """The Python case of a scene file; folder: of the case, that of the file by default.

    Raises ValueError for a wrong file, and for laws of files that lie not below the folder.
    """
    case = scene_file(path)
    case.scene()
    return _Writer(tomllib.loads(text_of(path)), case, folder or path.parent).text()


class _Writer(Parts):
    """The text of a case, from the document of a scene file: its parts are texts.

    names: (section, name) -> variable; rows: elements by section and name; named: lines of those
    that others name; imports: lines of laws from files.
    """

    def __init__(self, document: Mapping, case, folder: Path):
        self.document = document
        self.case = case
        self.folder = folder.resolve()
        self.imports: dict[str, None] = {}
        self.names: dict[tuple[str, str], str] = {}
        self.taken = {"cl", "math", "scene", *case.parameters}
        sections = (s for s in document if s in SECTIONS)
        self.rows = {(s, n): table for s in sections for n, table in document[s].items()}
        self.named: list[str] = []

    def text(self) -> str:
        """The entire file."""
        lines = [*self._bodies(), *self._shared(), *self._scene()]
        body = "\n".join(
            f"    {line}" if line else "" for text in lines for line in text.split("\n")
        )
        head = f'"""{self.case.summary or self.case.name}"""'
        maths = "import math\n\n" if "math." in body else ""
        imports = "\n".join(["import clearance as cl", *self.imports])
        return f"{head}\n\n{maths}{imports}\n\n\n{self._function()}{body}\n"

    def _function(self) -> str:
        """The line that begins the function, and its docstring."""
        parameters = [self._parameter(p) for p in self.case.parameters.values()]
        head = _call("def scene", ["*", *parameters] if parameters else [], len(" -> cl.Scene:"))
        texts = [
            f"    {p.name}: " + f"{p.text} [{p.units}]".strip()
            for p in self.case.parameters.values()
        ]
        doc = "\n".join(
            [f'    """{self.case.summary or self.case.name}', "", *texts, '    """', ""]
        )
        return f"{head} -> cl.Scene:\n{doc}"

    def _parameter(self, p: Parameter) -> str:
        entry = self.document["parameters"][p.name]
        value = entry["value"] if isinstance(entry, Mapping) else entry
        text = self.number(value) if p.kind is float else repr(value)
        return f"{p.name}: {p.kind.__name__} = {text}"

    # --- lines
    def _variable(self, section: str, name: str) -> str:
        """A name for what a section has under a name."""
        text = name if name.isidentifier() and name not in self.taken else f"{section}_{name}"
        self.taken.add(text)
        return self.names.setdefault((section, name), text)

    def _bodies(self) -> list[str]:
        return [
            _call(
                f"{self._variable('body', name)} = cl.Body",
                [f'"{name}"', *self._fields(Body, table)],
            )
            for name, table in self.document.get("body", {}).items()
        ]

    def _shared(self) -> list[str]:
        lines = []
        for section, kind in SHARED.items():
            for name, table in self.document.get(section, {}).items():
                texts = ([f'"{name}"'] if kind is Material else []) + self._fields(kind, table)
                lines.append(_call(f"{self._variable(section, name)} = cl.{kind.__name__}", texts))
        return lines

    def _scene(self) -> list[str]:
        """Lines of elements that others name, and the line of the scene."""
        texts = {key: self._element(key) for key in self.rows}
        parts = [self.names.get(key, text) for key, text in texts.items()]
        if "gravity" in self.document:
            parts.append(f"gravity={self.number(self.document['gravity'])}")
        parts.append(f'name="{self.document.get("name", self.case.name)}"')
        return [*self.named, _call("return cl.Scene", parts)]

    def _element(self, key: tuple[str, str]) -> str:
        """The call that makes an element; elements that it names have their line first."""
        table = dict(self.rows[key])
        kind = table.pop("kind", SECTIONS[key[0]][0])
        with at(*key):
            texts = self._fields(KINDS[kind], table)
        return _call(f"cl.{kind}", [*texts, f'name="{key[1]}"'])

    # --- values
    def _fields(self, kind: type, table: Mapping) -> list[str]:
        """Arguments of a constructor."""
        order = [*(f.name for f in fields(kind)), *table]
        texts = []
        for positional, (name, text) in zip(order, self.values(kind, table).items(), strict=False):
            texts.append(text if name == positional and name in FIRST else f"{name}={text}")
        return texts

    constant = staticmethod(repr)

    def points(self, value: Mapping) -> str:
        """Points of a body, by name."""
        texts = ", ".join(f"{n!r}: {self.number(v)}" for n, v in value.items())
        return f"{{{texts}}}".replace("'", '"')

    def number(self, value: object, units: tuple[str, ...] = ()) -> str:
        """A number, a formula or a tuple of such."""
        if isinstance(value, list):
            return f"({', '.join(map(self.number, value))})"
        if not isinstance(value, str):
            return repr(value)
        if "$" in value:
            text = MEASURED.sub(lambda m: repr(quantity(m[0])), value)
            return MATHS.sub(r"math.\1", PARAMETER.sub(r"\1", text))
        match = QUANTITY.match(value)
        if match and match[2] in SPELLED:
            return f"{SPELLED[match[2]]}({match[1]})"
        return f"{quantity(value)!r}"

    def point(self, value: object) -> str:
        """A point of a body."""
        if isinstance(value, list):
            return f"cl.ground.at{self.number(value)}"
        if isinstance(value, Mapping):
            coordinates = [value.get(axis, 0) for axis in "xyz" if axis in value or axis != "z"]
            return f"{self._body(value['body'])}.at{self.number(coordinates)}"
        name, _, point = value.partition(".")
        return f'{self._body(name)}["{point}"]' if point else self._body(name)

    def _body(self, name: str) -> str:
        return "cl.ground" if name == "ground" else self.names["body", name]

    def reference(self, value: str, kinds: tuple) -> str:
        """A body or an element, by its variable."""
        section, _, name = value.rpartition(".")
        if section in ("", "body") and (name == "ground" or ("body", name) in self.names):
            return self._body(name)
        key = next(
            k for k in self.rows if k[1] == name and section in ("", k[0]) and self._fits(k, kinds)
        )
        if key not in self.names:
            text = self._element(key)
            self.named.append(f"{self._variable(*key)} = {text}")
        return self.names[key]

    def _fits(self, key: tuple[str, str], kinds: tuple) -> bool:
        """True for an element of one of these kinds."""
        kind = self.rows[key].get("kind", SECTIONS[key[0]][0])
        return issubclass(KINDS[kind], tuple(k for k in kinds if isinstance(k, type)))

    def record(self, kind: type, value: object) -> str:
        """A material, a lubricant or a balance of heat."""
        if isinstance(value, str):
            usual = "cl.steel" if value == steel.name else f'cl.Material.named("{value}")'
            return self.names.get((kind.__name__.lower(), value), usual)
        return _call(f"cl.{kind.__name__}", self._fields(kind, value))

    def law(self, value: str | Mapping, field: Field | None = None) -> str:
        """A law by its public name."""
        table = {"law": value} if isinstance(value, str) else value
        name = table["law"]
        if PARAMETER.search(name):
            raise ValueError(f"law {name!r} is no name; name one law, and convert again")
        if name == NONE:
            return "None"
        arguments = [f"{n}={self.number(v)}" for n, v in table.items() if n != "law"]
        if ":" in name:
            return _call(self._imported(*name.rsplit(":", 1)), arguments)
        return _call(f"cl.films.{name}" if name in names.__all__ else f"cl.{name}", arguments)

    def _imported(self, file: str, name: str) -> str:
        """The name of a law from a file or a module, imported."""
        module = file
        if file.endswith(".py"):
            path = (self.case.path.parent / file).resolve()
            if not path.is_relative_to(self.folder):
                raise ValueError(f"the case must lie beside {file}, to import it; give -o there")
            module = ".".join(path.relative_to(self.folder).with_suffix("").parts)
        text = self._variable(module.replace(".", "_"), name)
        self.imports[f"from {module} import {name}" + (f" as {text}" if text != name else "")] = (
            None
        )
        return text


def _call(name: str, arguments: list[str], extra: int = 8) -> str:
    """A call on one line, or with an argument a line; extra: width of what else it has."""
    text = f"{name}({', '.join(arguments)})"
    if len(text) <= WIDTH - extra and "\n" not in text:
        return text
    inner = ",\n".join(arguments).replace("\n", "\n    ")
    return f"{name}(\n    {inner},\n)"
