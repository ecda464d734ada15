"""Scene files: a scene as TOML, with units, parameters and simple formulas, without any Python.

A number may be a text with a unit ("0.1 mm"), which is checked against the field's. A text with a
`$` is a formula of parameters ("$throw / 2"). Errors name file, line and field.
"""

import ast
import logging
import math
import operator
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import Field
from functools import partial
from pathlib import Path

from clearance import laws
from clearance.files.sealed import parsed
from clearance.files.texts import shallow, text_of
from clearance.film import names as films
from clearance.film.pad_law import pad_film
from clearance.laws.law import Law
from clearance.laws.materials import Material
from clearance.laws.outline import worn
from clearance.scene.case import Case, Parameter
from clearance.scene.document import KINDS, Misplaced, Parts, at, law_in, module_of, named_table
from clearance.scene.scene import Scene
from clearance.scene.user_module import module_of as module_of_file
from clearance.values.checks import identifier, known, meant, point
from clearance.values.columns import Column, each
from clearance.values.units import UNITS, amount, quantity

LOG = logging.getLogger("clearance")
#: section of a file -> kinds of elements that may stand in it
SECTIONS: dict[str, list[str]] = {}
for _name, _kind in KINDS.items():
    SECTIONS.setdefault(_kind.group.removesuffix("s"), []).append(_name)
_FILMS = {name: getattr(films, name) for name in films.__all__}
#: family -> functions that make laws of it from settings, by their names in Python
MAKERS: dict[str, dict[str, Law | Callable]] = {
    "film": _FILMS | {f.__name__: f for f in _FILMS.values() if not isinstance(f, Law)},
    "pad": {"pad_table": pad_film},
    "transition": {"fuzzy_table": laws.fuzzy_table},
    "outline": {"worn": worn},
}
#: sections of what several elements may share
SHARED = ("lubricant", "material")
#: other names of the outermost table
HEAD = ("name", "text", "gravity", "until", "parameters", "body")
#: units of SI, which leave a number as it is
SI = {unit for unit, (kind, factor) in UNITS.items() if (kind, factor) == (unit, 1.0)}
#: names in brackets of a message, none of which is its field
SIGNATURE = re.compile(r"\([^()]*\)")
#: what a line of a scene file begins with: a table, or the key of a value
KEY = re.compile(r"\s*(\[+[^\]]+\]+|[^\s=#\[]+(?=\s*=))")
QUOTES = '; texts and numbers with a unit stand in quotes: "300 rpm"; { } is one line, with commas'
OF_PARAMETERS = ("value", "unit", "text")
PARAMETER = re.compile(r"\$([^\W\d]\w*)")
_UNITS = "|".join(re.escape(u) for u in sorted(UNITS, key=len, reverse=True))
#: a number with a unit in a formula
MEASURED = re.compile(rf"(?<![\w.])((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*({_UNITS})(?!\w)")
LONGEST = 1000  # letters of a formula
#: functions, numbers and operators of formulas
FUNCTIONS = {
    f.__name__: f for f in (math.sqrt, math.sin, math.cos, math.tan, math.atan2, math.hypot)
} | {"abs": abs, "min": min, "max": max}
CONSTANTS = {"pi": math.pi}
FORMULA = (
    'a formula such as "2 * pi / $speed" has numbers, units, parameters with a $ each, + - * / **, '
    f"brackets and {', '.join((*CONSTANTS, *FUNCTIONS))}"
)
OPERATORS = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}


def scene_file(path: Path) -> Case:
    """The case of a scene file. Raises ValueError with file, line and field for what is wrong."""
    text = text_of(path)
    try:
        with shallow(path):
            document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        words, line = _line_of_syntax(str(error), text)
        raise ValueError(f"{path}:{line}: {words}") from None
    try:
        parameters = _head(document)
        if unused := parameters.keys() - set(PARAMETER.findall(text)):
            LOG.warning("%s: nothing in the file reads %s", path, ", ".join(sorted(unused)))
        length = document.get("until")
        with at("until"):
            length = quantity(length, "s")
    except Misplaced as error:
        raise _placed(path, text, document, error) from None
    function = partial(_scene, path, text, document, parameters)
    return Case(
        path.stem,
        path,
        function,
        document.get("text", ""),
        parameters,
        length,
        reference=str(path.resolve()),
    )


def _scene(path: Path, text: str, document: Mapping, parameters: Mapping, **arguments) -> Scene:
    """The scene of a file for values of its parameters."""
    values = {name: p.default for name, p in parameters.items()} | arguments
    units = {name: p.units for name, p in parameters.items() if p.units in SI}
    parts = {n: part for n, part in document.items() if n != "parameters"}
    try:
        with shallow(path):
            filled = {n: _filled(part, values, units, n) for n, part in parts.items()}
        return _parts(filled, path)
    except Misplaced as error:
        raise _placed(path, text, document, error) from None


def _parts(document: Mapping, path: Path) -> Scene:
    """The scene of a document without parameters."""
    tables = {}
    for section, kinds in SECTIONS.items():
        for name, table in document.get(section, {}).items():
            with at(section, name):
                tables[section, name] = _kind_of(section, kinds, table)
    bodies = document.get("body", {})
    shared = {name: document.get(name, {}) for name in SHARED}
    parts = Parts(bodies, tables, partial(_law, path.parent), shared)
    for name in Material.table().keys() - shared["material"].keys():
        parts.ready["material", name] = Material.named(name)
    for name in bodies:
        parts.body(name)
    order = [s for s in document if s in SECTIONS]
    elements = [parts.element(*key) for s in order for key in tables if key[0] == s]
    gravity = document.get("gravity", [0.0, -9.81])
    with at("gravity"):
        gravity = point("gravity", amount(gravity, ("m/s2",)))
    if not elements:
        raise ValueError(f"{path}: no joint, load or drive is there; [joint] has the joints")
    scene = Scene(*elements, gravity=gravity, name=document.get("name", path.stem))
    names = {body.name for body in scene.bodies}
    for name in bodies:
        if name not in names:
            raise Misplaced(("body", name), "no joint and no load holds this body")
    return scene


def _kind_of(section: str, kinds: list[str], table: object) -> tuple[str, dict]:
    """Kind and fields of an element; a section with one kind need not name it."""
    kind = named_table(section, table).get("kind", kinds[0] if len(kinds) == 1 else None)
    if kind not in kinds:
        answer = f"got {kind!r}{meant(str(kind), kinds)}" if kind else "it has none"
        raise ValueError(f"kind must be one of {', '.join(kinds)}; {answer}")
    return kind, {n: v for n, v in table.items() if n != "kind"}


# --- the head of a file, and its parameters
def _head(document: Mapping) -> dict[str, Parameter]:
    """Parameters of a document, its outermost names checked."""
    names = (*HEAD, *SHARED, *SECTIONS)
    for name, value in document.items():
        with at(name):
            if name not in names:
                raise ValueError(f"unknown section{meant(name, names)}; known: {', '.join(names)}")
            if name in ("name", "text") and not isinstance(value, str):
                raise ValueError(f"expected a text, got {value!r}")
            if name in names[len(HEAD) - 2 :]:
                named_table(name, value)
    with at("name"):
        identifier("name", document.get("name", "scene"))
    parameters = {}
    for name, entry in document.get("parameters", {}).items():
        with at("parameters", name):
            parameters[name] = _parameter(name, entry)
    return parameters


def _parameter(name: str, entry: object) -> Parameter:
    """A parameter from its value, or from a table of value, unit and text."""
    if not name.isidentifier():
        raise ValueError(f"the name of a parameter has letters, digits and _, got {name!r}")
    table = entry if isinstance(entry, Mapping) else {"value": entry}
    for key in table:
        known("unknown field", key, OF_PARAMETERS, " of a parameter")
    if "value" not in table:
        raise ValueError("a parameter needs a value")
    with at("value"):
        value, unit = _measured(table["value"])
    kind = float if type(value) is int else type(value)
    units = table.get("unit", unit)
    units = UNITS[units][0] if units in UNITS else units
    return Parameter(
        name, kind, float(value) if kind is float else value, units, table.get("text", "")
    )


def _measured(value: object) -> tuple[object, str]:
    """A value in SI, and its SI unit; a text that begins with no number is a word."""
    if isinstance(value, str) and re.match(r"\s*[-+.]?\d", value):
        unit = value.strip().lstrip("+-.0123456789eE").replace(" ", "")
        return quantity(value), UNITS[unit][0] if unit in UNITS else "?"
    if not isinstance(value, str | int | float):
        raise ValueError(f"expected a number, a text, true or false, got {value!r}")
    return value, "?"


# --- formulas
def _filled(
    value: object, values: Mapping[str, object], units: Mapping[str, str], *names: str
) -> object:
    """A part of a document with its formulas worked out."""
    if isinstance(value, Mapping):
        filled = {}
        for name, part in value.items():
            with at(*names):
                filled[name] = _filled(part, values, units, name)
        return filled
    if isinstance(value, list):
        return [_filled(part, values, units, *names) for part in value]
    if not isinstance(value, str) or "$" not in value:
        return value
    with at(*names):
        return formula(value, values, units)


def formula(
    text: str, values: Mapping[str, object], units: Mapping[str, str] | None = None
) -> object:
    """The value of a formula: "$throw / 2 + 1 mm", in SI units; "$model" alone may be a word.

    It has numbers with or without units, parameters, + - * / **, brackets, pi, sqrt, sin, cos, tan,
    atan2, hypot, abs, min and max; angles in rad. units: SI units of parameters by name; such a
    parameter alone becomes a text with its unit, which the field checks. A formula of columns
    (values/columns.py) is a column, without a unit. Raises ValueError for anything else.
    """
    for name in PARAMETER.findall(text):
        if name not in values:
            raise ValueError(
                f"unknown parameter ${name}"
                f"{meant(name, values)}; [parameters] has {', '.join(values) or 'none'}"
            )
    if alone := PARAMETER.fullmatch(text.strip()):
        value = values[alone[1]]
        unit = (units or {}).get(alone[1])
        return f"{value!r} {unit}" if unit and not isinstance(value, Column) else value
    if len(text) > LONGEST:
        raise ValueError(f"a formula may have {LONGEST} letters, this one has {len(text)}")
    plain = MEASURED.sub(lambda m: repr(quantity(m[0])), text)
    plain = PARAMETER.sub(lambda m: f"given_{m[1]}", plain)
    names = CONSTANTS | {f"given_{name}": value for name, value in values.items()}
    try:
        with shallow("the formula"):
            value = _value(parsed(plain.strip(), "eval").body, names)
        return value if isinstance(value, Column) else float(value)
    except (SyntaxError, TypeError):
        raise ValueError(f"cannot read the formula {text!r}; {FORMULA}") from None
    except (ArithmeticError, ValueError) as error:
        raise ValueError(f"{text!r}: {error}") from None


def _value(node: ast.expr, names: Mapping[str, object]) -> float:
    """A number from a formula's syntax tree. Raises TypeError for what no formula has."""
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return float(node.value)
    if isinstance(node, ast.Name) and type(names.get(node.id)) in (int, float, Column):
        return names[node.id]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
        value = _value(node.operand, names)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        return OPERATORS[type(node.op)](_value(node.left, names), _value(node.right, names))
    if (
        isinstance(node, ast.Call)
        and getattr(node.func, "id", None) in FUNCTIONS
        and not node.keywords
    ):
        return each(FUNCTIONS[node.func.id], *(_value(part, names) for part in node.args))
    raise TypeError("not in a formula")


# --- laws
def _law(folder: Path, name: str, field: Field | None) -> Law | Callable:
    """A law by its name, or by "my_laws.py:name" with a path from the folder of the file."""
    file, colon, inside = name.rpartition(":")
    if file.endswith(".py"):
        path = (folder / file).resolve()
        if not path.is_file():
            raise ValueError(f"no file {path}")
        return law_in(module_of_file(path, "laws", file), inside)
    if colon:
        return law_in(module_of(file, {}), inside)
    choices = laws_for(field)
    known("unknown law", name, choices)
    return choices[name]


def laws_for(field: Field | None) -> dict[str, Law | Callable]:
    """Laws of the package that may stand in a field, by name."""
    number = field.metadata.get("number")
    families = number.families if number else field.metadata["law"]
    every = {n: getattr(laws, n) for n in laws.__all__}
    by_name = {n: v for n, v in every.items() if isinstance(v, Law) and v.family in families}
    for family in families:
        by_name |= MAKERS.get(family.name, {})
    return dict(sorted(by_name.items()))


# --- places of errors
def _placed(path: Path, text: str, document: Mapping, error: Misplaced) -> ValueError:
    """An error with file, line and field."""
    names, words = error.path, error.text
    if len(names) == 2:
        words = words.removeprefix(f"{names[0]} {names[1]}: ").removeprefix(f"{names[1]}: ")
    table = _part(document, names)
    read = SIGNATURE.sub("", words)
    if isinstance(table, Mapping):  # the field that the message names first
        places = {m.start(): n for n in table if (m := re.search(rf"\b{re.escape(n)}\b", read))}
        names = (*names, places[min(places)]) if places else names
    value = _part(document, names)
    formed = f', from "{value}"' if isinstance(value, str) and "$" in value else ""
    return ValueError(f"{path}:{_line(text, names)}: {'.'.join(names)}: {words}{formed}")


def _part(document: object, names: tuple[str, ...]) -> object:
    """Entry at a place; None where there is none."""
    for name in names:
        document = document.get(name) if isinstance(document, Mapping) else None
    return document


def _line(text: str, names: tuple[str, ...]) -> int:
    """The line at which what stands at a place begins, or the innermost table around it that is
    there.
    """
    lines = text.splitlines()
    document = tomllib.loads(text)
    while names and _part(document, names) is None:
        names = names[:-1]
    begin = 0
    for end in range(1, len(lines) + 1):
        try:
            part = tomllib.loads("\n".join(lines[:end]))
        except tomllib.TOMLDecodeError:  # inside a value of several lines
            continue
        if _part(part, names) is not None:
            return begin + 1
        begin = end
    return 1


def _line_of_syntax(words: str, text: str) -> tuple[str, int]:
    """Reason and line of an error of TOML's syntax."""
    match = re.search(r" \(at line (\d+), column (\d+)\)$", words)
    if not match:
        return words.replace(" (at end of document)", ""), len(text.splitlines())
    line, words = int(match[1]), words[: match.start()]
    keys = [key[1] for row in text.splitlines()[:line] if (key := KEY.match(row))]
    if keys and words.startswith(("Cannot overwrite a value", "Cannot declare", "Cannot mutate")):
        return f"{keys[-1]} stands there twice", line
    return f"{words} (column {match[2]}){QUOTES}", line
