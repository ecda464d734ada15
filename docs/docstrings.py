"""Docstrings of the package as reStructuredText: lines `name: text` are parameters, `code` is
code.
"""

import inspect
import re

FIELD = re.compile(r"^(\w+): (.+)$")
RAISES = re.compile(r"^(?:It )?[Rr]aises ((?:\w+)(?:(?:,| or| and) [A-Z]\w+)*)[ :]*(.*)$")
#: other sentences that are fields, by their first word
NAMED = re.compile(r"^(Returns|Valid|Source):? (.+)$")
FIELDS = {"Returns": "returns", "Valid": "Valid", "Source": "Source"}
#: sentences that begin a field, in a line
SENTENCES = re.compile(r"(?<=[.;]) (?=(?:(?:It )?[Rr]aises [A-Z]|Returns |Valid |Source: ))")


def as_restructured_text(app, kind, name, thing, options, lines):
    """Handler of autodoc: change the lines of a docstring in place."""
    named = parameters_of(thing) if kind in KINDS else {}
    lines[:] = restructured(lines, set(named), {n: p for n, p in named.items() if p}, True)
    called = kind in ("function", "method")
    if called and not any(n.startswith(":returns:") for n in lines) and (text := returned(thing)):
        lines += ["", f":returns: {text}", ""]


KINDS = ("function", "class", "method")


def parameters_of(thing) -> dict[str, str]:
    """Arguments of a function or class, with the texts of their defaults."""
    try:
        parameters = inspect.signature(thing).parameters
    except (TypeError, ValueError):
        return {}
    empty = (inspect.Parameter.empty, None)
    return {n: "" if p.default in empty else repr(p.default) for n, p in parameters.items()}


def returned(thing) -> str:
    """Text about the returned value of a function, from its annotation; empty for none."""
    try:
        kind = inspect.signature(thing).return_annotation
    except (TypeError, ValueError):
        return ""
    if kind in (inspect.Signature.empty, None, "None"):
        return ""
    name = getattr(kind, "__name__", None) or str(kind)
    about = inspect.getdoc(kind) if inspect.isclass(kind) and "clearance" in kind.__module__ else ""
    return f"``{name}``{': ' + prose(first_line(about)) if about else ''}"


def first_line(text: str | None) -> str:
    """The first sentence of a docstring."""
    paragraph = " ".join((text or "").partition("\n\n")[0].split())
    return (
        re.split(r"(?<=[a-z\])`\"0-9][.;:]) (?=[A-Za-z`\"])", paragraph)[0].rstrip(";:")
        if paragraph
        else ""
    )


def restructured(
    lines: list[str],
    parameters: set[str] = frozenset(),
    defaults: dict[str, str] | None = None,
    sentences: bool = False,
) -> list[str]:
    """Lines of a docstring: parameters as fields, indented lines as they are, the rest as prose.

    defaults: texts of the defaults of parameters. sentences: those with "Raises" and "Returns" are
        fields too.
    """
    lines_out: list[str] = []
    field = literal = False
    if sentences:
        lines = [part for line in lines for part in SENTENCES.split(line)]
    for line in apart(lines, parameters):
        hit = FIELD.match(line)
        raises, named = (p.match(line) if sentences else None for p in (RAISES, NAMED))
        if not line.strip():
            field = False
            lines_out.append("")
        elif hit and hit[1] in parameters:
            lines_out += [] if field else [""]
            default = (defaults or {}).get(hit[1])
            shown = f"(default ``{default}``) " if default and "default" not in hit[2] else ""
            lines_out.append(f":param {hit[1]}: {shown}{prose(hit[2])}")
            field, literal = True, False
        elif raises or named:
            lines_out += [] if field else [""]
            label = f"raises {raises[1]}" if raises else FIELDS[named[1]]
            lines_out.append(f":{label}: {prose((raises or named)[2])}")
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
