"""Sources of what a run used, as BibTeX: the code, laws of its joints and drives, the method."""

import importlib
import re
from collections.abc import Iterator
from functools import cache

from clearance.results.record import Record
from clearance.version import VERSION

#: sources of steppers, by the method of a run
METHODS = {
    "dop853": "Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I (1993)",
    "radau5": "Hairer and Wanner, Solving Ordinary Differential Equations II (1996)",
    "radau9": "Hairer and Wanner, Solving Ordinary Differential Equations II (1996)",
    "rodas5p": "Steinebach, BIT Numer. Math. 63 (2023) 27",
}
SOURCE = re.compile(r"Source: (.+?)(?=\n\s*\n|\n\s*Raises|\Z)", re.DOTALL)
NAME = r"[A-Z][\w'-]+(?: de [A-Z]\w+)?"
NAMES = rf"(?P<author>{NAME}(?:, {NAME})* and {NAME}|{NAME}(?: et al\.)?)"
#: authors, journal and its volume, year, page
ARTICLE = re.compile(
    NAMES + r", (?P<journal>[^(]*?) (?P<volume>\d+) \((?P<year>\d{4})\)(?: (?P<pages>\d+))?"
)
#: authors, a title where there is one, and the year
BOOK = re.compile(
    NAMES + r"(?:, (?P<title>[A-Z][^(),]*[^(), ]))?(?=,| \().*?\b(?P<year>1[89]\d{2}|20\d{2})\b"
)
YEAR = re.compile(r"\b(1[89]\d{2}|20\d{2})\b")
#: words before the authors, as "see" and "teeth:"
BEFORE = re.compile(r"^(?:[a-z][\w-]*[:,]? )+")


def citations(run: Record) -> str:
    """BibTeX of what a run used: clearance, each law of the package in its scene, the integrator.

    Entries have what the docstrings state: authors, journal, volume, year and page; others have a
    note. Laws of your own are left out. A source of several laws stands once.
    """
    entries = [_entry("clearance", {"title": f"clearance {VERSION}", "note": "software"}, "misc")]
    texts: dict[str, list[str]] = {}
    for law in dict.fromkeys(_laws(run.scene)):
        for text in _sources(law):
            texts.setdefault(text, []).append(law.rpartition(":")[2])
    method = str(run.solver.get("method", "")).split()
    for name in (n for n in METHODS if n in method):
        texts.setdefault(METHODS[name], []).append(name)
    keys: dict[str, int] = {}
    for text, users in texts.items():
        fields = _fields(text)
        kind = "article" if "journal" in fields else "book" if "title" in fields else "misc"
        key = _key(fields, users)
        keys[key] = keys.get(key, 0) + 1
        key += "" if keys[key] == 1 else "abcdefghij"[keys[key] - 1]
        entries.append(_entry(key, fields | {"keywords": ", ".join(users)}, kind))
    return "\n".join(entries)


def _laws(data: object) -> Iterator[str]:
    """Names of the laws of a scene's description, as "module:name"."""
    if isinstance(data, dict):
        law = data.get("law")
        if isinstance(law, str) and law.startswith("clearance."):
            yield law
        for value in data.values():
            yield from _laws(value)
    elif isinstance(data, list):
        for value in data:
            yield from _laws(value)


@cache
def _sources(law: str) -> tuple[str, ...]:
    """Sources in the docstring of a law, one each."""
    module, _, name = law.partition(":")
    text = getattr(getattr(importlib.import_module(module), name, None), "__doc__", None) or ""
    match = SOURCE.search(text)
    parts = " ".join(match[1].split()).split("; ") if match else []
    return tuple(BEFORE.sub("", p.strip().rstrip(".")) for p in parts if YEAR.search(p))


def _fields(text: str) -> dict[str, str]:
    """Fields of an entry, as far as the text has them."""
    match = ARTICLE.match(text) or BOOK.match(text)
    fields = match.groupdict() if match else {"year": YEAR.search(text)[1]}
    return {n: v for n, v in fields.items() if v} | {"note": text}


def _key(fields: dict[str, str], users: list[str]) -> str:
    """Key of an entry: first author and year, else the law that uses it."""
    author = re.match(r"[A-Za-z]+", fields.get("author", ""))
    return f"{author[0].lower() if author else users[0]}{fields.get('year', '')}"


def _entry(key: str, fields: dict[str, str], kind: str) -> str:
    """An entry; authors are parted by `and`."""
    lines = []
    for name, value in fields.items():
        if name == "author":
            value = re.sub(r",? and |, ", " and ", value).replace(" et al.", " and others")
        lines.append(f"  {name} = {{{value.replace('&', chr(92) + '&')}}},")
    return "\n".join([f"@{kind}{{{key},", *lines, "}", ""])
