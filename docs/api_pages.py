"""Pages of the Python interface, made from the package: every public name, by subject."""

import inspect
from dataclasses import fields, is_dataclass
from functools import cache
from importlib import import_module

from docstrings import first_line
from fields import described

import clearance as cl
from clearance.laws.law import Family, Law

#: page: title, and the modules whose public names it has; a name has the page of the longest one
SUBJECTS = {
    "scene": (
        "Scenes",
        ["elements.body", "scene", "laws.materials", "laws.oils", "values.fit_class"],
    ),
    "elements": ("Elements", ["elements"]),
    "running": ("Running", ["simulation", "run", "motions"]),
    "results": ("Results", ["results", "metrics", "postprocess", "values.checks"]),
    "sweeps": ("Sweeps", ["sweeping"]),
    "studies": ("Lives, fits, optima, exports", ["wearing", "identify", "studies", "exporting"]),
    "films": ("Films", ["film"]),
    "own_laws": ("Tools for laws", ["laws"]),
    "units": ("Units", ["values.units"]),
}
#: classes that these return, by page
RETURNED = {
    "running": ["motions.steady.Steady", "motions.chaos.Statistics", "motions.follow.Branch"],
    "results": [
        "results.record.Record",
        "results.record.Channels",
        "results.record.PressureFields",
        "results.extremes.Extreme",
        "results.errors.Error",
        "results.errors.Errors",
        "postprocess.pictures.Pictures",
    ],
    "sweeps": ["sweeping.sweep.Progress", "sweeping.scatter.Scatter"],
    "studies": ["identify.scene_parameters.SceneFit", "identify.designs.Optimum"],
}
#: members for those who write elements and studies
INSIDE = {
    "numbers",
    "doubts",
    "key",
    "label",
    "kinks",
    "spots",
    "soft_joints",
    "first_touch",
    "positions",
    "provenance",
    "parts",
    "write",
}


@cache
def names() -> dict[str, list[str]]:
    """Public names by page, as they are imported; laws have a page of their own."""
    pages: dict[str, list[str]] = {page: [] for page in SUBJECTS}
    for name in dict.fromkeys(cl.__all__):
        thing = getattr(cl, name)
        if not inspect.ismodule(thing) and not isinstance(thing, Law) and name != "FAMILIES":
            pages[_page(thing)].append(f"clearance.{name}")
    for page, paths in RETURNED.items():
        pages[page] += [f"clearance.{path}" for path in paths]
    return pages


def _page(thing: object) -> str:
    module = getattr(thing, "__module__", None) or type(thing).__module__
    module = module.removeprefix("clearance.") + "."
    fits = {
        len(m): page for page, (_, ms) in SUBJECTS.items() for m in ms if module.startswith(f"{m}.")
    }
    return fits[max(fits)]


def thing_of(path: str) -> object:
    """The thing of a dotted path."""
    module, _, name = path.rpartition(".")
    return getattr(cl if module == "clearance" else import_module(module), name)


def page_text(page: str) -> str:
    """A table with a line for each name, then each of them."""
    lines = [f"# {SUBJECTS[page][0]}", "", *table((p, thing_of(p)) for p in names()[page]), ""]
    for path in names()[page]:
        lines += ["", f"## {path.rpartition('.')[2]}", "", *_entry(path, thing_of(path))]
    return "\n".join(lines)


def table(things) -> list[str]:
    """A line for each thing: a link and its first sentence."""
    public = {p for paths in names().values() for p in paths}
    rows = []
    for path, thing in things:
        owner, _, name = path.rpartition(".")
        shown = f"{{py:obj}}`{name} <{path}>`" if {path, owner} & public else f"`{name}`"
        rows.append(f"| {shown} | {about(thing)} |")
    return ["| name | |", "|---|---|", *rows]


def about(thing: object) -> str:
    """The first sentence about a thing."""
    if isinstance(thing, Family):
        state = ", ".join(f"`{s}`" for s in thing.state)
        return (
            f"Decorates a {thing.name.replace('_', ' ')} of yours; its first arguments are {state}."
        )
    thing = getattr(thing, "__func__", thing)
    constant = not (callable(thing) or isinstance(thing, property) or hasattr(thing, "func"))
    text = f"{type(thing).__name__}: {thing!r}" if constant else first_line(inspect.getdoc(thing))
    return text.replace("|", "\\|")


def _entry(path: str, thing: object) -> list[str]:
    """A thing in full: its members with a line each, the rest by autodoc."""
    if not inspect.isclass(thing):
        kind = "function" if inspect.isfunction(thing) else "data"
        more = [] if kind == "function" else [f"   {about(thing)}"]
        directive = f".. autofunction:: {path}" if kind == "function" else f".. py:data:: {path}"
        return ["```{eval-rst}", directive, "", *more, "```"]
    static = {n: inspect.getattr_static(thing, n) for n in dir(thing) if n[0] != "_"}
    members = {n: m for n, m in static.items() if n not in INSIDE and _described(m)}
    mine = [n for n in members if n in vars(thing)]
    lines = ["```{eval-rst}", f".. autoclass:: {path}"]
    lines += [f"   :members: {', '.join(mine)}", "```"] if mine else ["```"]
    if any(f.metadata for f in (fields(thing) if is_dataclass(thing) else ())):
        lines += ["", "| field, meaning, default |", "|---|"]
        lines += [f"| {text} |" for _, text in described(thing)]
    rows = [(_path_of(thing, path, n), m) for n, m in members.items()]
    return [*table(rows), "", *lines] if rows else lines


def _path_of(thing: type, path: str, name: str) -> str:
    """Path of a member, of the class that has it if the pages have that class."""
    owner = next(c for c in thing.__mro__ if name in vars(c))
    if owner is thing:
        return f"{path}.{name}"
    return f"{owner.__module__}.{owner.__qualname__}.{name}"


def _described(member: object) -> bool:
    """A method or property of ours with a docstring, not one of an exception."""
    inner = getattr(member, "__func__", member)
    code = inner if inspect.isfunction(inner) else getattr(inner, "fget", None)
    return bool((code or getattr(inner, "func", None)) and inspect.getdoc(inner))


def index_text() -> str:
    """The page of pages, with all names."""
    lines = ["# Python interface", "", "`import clearance as cl` has these names.", ""]
    for page, (title, _) in SUBJECTS.items():
        public = [p.rpartition(".")[2] for p in names()[page] if p.count(".") == 1]
        lines.append(f"- [{title}]({page}.md): {', '.join(f'`{n}`' for n in public)}")
    laws = "- [Laws](laws.md): `cl.laws`, by family"
    return "\n".join(
        [*lines, laws, "", "```{toctree}", ":hidden:", "", *SUBJECTS, "laws", "```", ""]
    )
