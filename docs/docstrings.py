"""Docstrings of the package as reStructuredText: lines `name: text` are parameters, `code` is
code.
"""

import inspect
import re

FIELD = re.compile(r"^(\w+): (.+)$")


def as_restructured_text(app, what, name, thing, options, lines):
    """Handler of autodoc: change the lines of a docstring in place."""
    lines[:] = restructured(lines, parameters_of(thing) if what in KINDS else set())


KINDS = ("function", "class", "method")


def parameters_of(thing) -> set[str]:
    """Names of the arguments of a function or class."""
    try:
        return set(inspect.signature(thing).parameters)
    except (TypeError, ValueError):
        return set()


def restructured(lines: list[str], parameters: set[str] = frozenset()) -> list[str]:
    """Lines of a docstring: parameters as fields, indented lines as they are, the rest as prose."""
    lines_out: list[str] = []
    field = literal = False
    for line in apart(lines, parameters):
        hit = FIELD.match(line)
        if not line.strip():
            field = False
            lines_out.append("")
        elif hit and hit[1] in parameters:
            lines_out += [] if field else [""]
            lines_out.append(f":param {hit[1]}: {prose(hit[2])}")
            field, literal = True, False
        elif field:
            lines_out.append("    " + prose(line.strip()))
        elif line.startswith(" "):
            lines_out += [] if literal else ["", "::", ""]
            lines_out.append(line)
            literal = True
        else:
            lines_out += [""] if literal and lines_out[-1].strip() else []
            lines_out.append(prose(line))
            literal = False
    return lines_out


def apart(lines: list[str], parameters: set[str]) -> list[str]:
    """Lines of which each begins at most one parameter."""
    if not parameters:
        return list(lines)
    names = "|".join(map(re.escape, sorted(parameters)))
    begins = re.compile(rf"(?<=[.;]) (?=(?:{names}): )")
    return [part for line in lines for part in begins.split(line)]


def prose(line: str) -> str:
    """A line with code in double marks, in which |, * and trailing underscores stay themselves."""
    if line.count("`") % 2:  # code that goes on in the next line
        return line.replace("`", "")
    parts = line.split("`")
    for i in range(0, len(parts), 2):
        escaped = re.sub(r"([|*\\])", r"\\\1", parts[i])
        parts[i] = re.sub(r"(?<=\w)_(?=\W|$)", r"\\_", escaped)
    return "``".join(parts)
