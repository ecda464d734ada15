"""Inputs of a point's run: version, files the case imports or names, text of its kernels, numbers
of its scene.

The definition of a sweep holds the request. Each outcome holds what was run. A sweep that goes on
after a change of an imported file, a law or the package must not put two physics in one table.
"""

import ast
import hashlib
import importlib.util
import json
import sysconfig
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from clearance.mechanism.build import Mechanism
from clearance.sweeping.definition import digest
from clearance.version import VERSION

#: modules in these folders come with Python, a package or this one: their versions identify them
FOREIGN = tuple(Path(sysconfig.get_path(n)) for n in ("stdlib", "platstdlib", "purelib", "platlib"))
FOREIGN += (Path(__file__).resolve().parent.parent,)


def made(mechanism: Mechanism, modules: dict[str, str], files: dict[str, str]) -> dict:
    """Inputs of the runs of a mechanism, as plain data; modules, files: see `modules_of`,
    `files_named`.
    """
    scene = json.dumps(sorted(numbers(mechanism.scene.to_json()).items()))
    return common(modules, files) | {"text": mechanism.structure.digest, "numbers": _digest(scene)}


def common(modules: dict[str, str], files: dict[str, str] | None = None) -> dict:
    """The part of it that all points share."""
    origins = {"version": VERSION, "modules": modules, "files": files}
    return {name: value for name, value in origins.items() if value}


def files_named(values: Iterable[object]) -> dict[str, str]:
    """Digests of the files that values of a case's parameters name, such as
    `memberships=points.csv`.
    """
    texts = {v for v in values if isinstance(v, str) and Path(v).suffix}
    return {text: digest(Path(text)) for text in sorted(texts) if Path(text).is_file()}


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def numbers(scene: str) -> dict[str, str]:
    """All values of a scene's JSON by name: "joints C contact restitution" -> "0.9", numbers to
    nine digits.
    """
    numbers: dict[str, str] = {}
    for key, value in json.loads(scene).items():
        if key != "sources":  # the text of the kernels has the laws
            _name(numbers, key, value)
    return numbers


def _name(numbers: dict[str, str], name: str, value: object) -> None:
    if isinstance(value, dict):
        for key, entry in value.items():
            _name(numbers, f"{name} {key}", entry)
    elif isinstance(value, list):
        for i, entry in enumerate(value):
            _name(
                numbers, f"{name} {entry.get('name', i) if isinstance(entry, dict) else i}", entry
            )
    elif name.endswith(" law"):  # a case file's module is called otherwise in each process
        numbers[name] = str(value).rpartition(":")[2]
    else:
        numbers[name] = f"{value:.9g}" if isinstance(value, float) else str(value)


def common_differences(before: dict, now: dict) -> list[str]:
    """Changes of the inputs that all points share, in words."""
    if not before:
        return ["its points do not state their inputs (version 0.1 wrote them)"]
    differences = []
    if before["version"] != now["version"]:
        differences.append(f"clearance {before['version']}, here {now['version']}")
    one, two = before.get("modules", {}), now.get("modules", {})
    changed = [n for n in sorted({*one, *two}) if one.get(n) != two.get(n)]
    differences += [f"the imported module {n} has been changed" for n in changed]
    there = now.get("files", {})
    return differences + [
        f"the file {n} has been changed"
        for n, d in before.get("files", {}).items()
        if there.get(n) != d
    ]


def point_differences(before: dict, now: dict, before_scene: str | None, scene: str) -> list[str]:
    """Changes of a point's inputs, in words. `kept`: JSON of the scene, where its file has it."""
    differences = (
        ["the law or kernel text has been changed"] if before.get("text") != now["text"] else []
    )
    if before.get("numbers") == now["numbers"]:
        return differences
    one, two = numbers(before_scene) if before_scene else {}, numbers(scene)
    changed = (
        [n for n in dict.fromkeys([*one, *two]) if one.get(n) != two.get(n)] if before_scene else []
    )
    if not changed:
        return [*differences, "the scene's numbers have been changed"]
    first = changed[0]
    more = f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
    return [
        *differences,
        f"{first} was {one.get(first, 'not there')}, is now {two.get(first, 'not there')}{more}",
    ]


def modules_of(paths: Iterable[Path]) -> dict[str, str]:
    """Digests of the user's own modules that files import, directly or not, by name; the files
    themselves left out.
    """
    digests: dict[str, str] = {}
    todo = [(Path(path), "") for path in paths]
    while todo:
        path, package = todo.pop()
        for name in _imported(path, package):
            place = None if name in digests else _own_file(name)
            if place is not None:
                digests[name] = digest(place)
                todo.append(
                    (place, name if place.name == "__init__.py" else name.rpartition(".")[0])
                )
    return dict(sorted(digests.items()))


def _imported(path: Path, package: str) -> Iterator[str]:
    """Names that may be modules in the import statements of a file; a scene file has none."""
    if path.suffix != ".py":
        return
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = _absolute(node, package)
            names = [base, *(f"{base}.{alias.name}" for alias in node.names)]
        else:
            continue
        for name in names:
            parts = name.split(".")
            yield from (".".join(parts[: i + 1]) for i in range(len(parts)))


def _absolute(node: ast.ImportFrom, package: str) -> str:
    """The module that `from ... import` names."""
    if not node.level:
        return node.module or ""
    with suppress(ImportError):
        return importlib.util.resolve_name("." * node.level + (node.module or ""), package)
    return node.module or ""


def _own_file(name: str) -> Path | None:
    """The file of a user's own module; None for others and for what is no module."""
    place = None
    with suppress(ImportError, AttributeError, ValueError):
        place = importlib.util.find_spec(name)
    if place is None or not place.has_location or not str(place.origin).endswith(".py"):
        return None
    path = Path(place.origin)
    foreign = any(path.is_relative_to(f) or path.resolve().is_relative_to(f) for f in FOREIGN)
    return None if foreign else path
