"""Inputs of a run: version, files the case imports or names, text of its kernels, numbers of its
scene.

The definition of a sweep holds the request. Each outcome holds what was run, and so do each stage
of a life and a branch. What goes on after a change of an imported file, a law or the package must
not put two physics in one table.
"""

import ast
import hashlib
import importlib.util
import json
import logging
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from importlib.machinery import ModuleSpec, PathFinder
from itertools import accumulate
from pathlib import Path

from clearance.files.sealed import parsed
from clearance.files.texts import digest
from clearance.mechanism.build import Mechanism
from clearance.scene.case import Case
from clearance.version import VERSION

LOG = logging.getLogger("clearance")
#: modules in these folders come with Python, a package or this one: their versions identify them
FOREIGN = tuple(Path(sysconfig.get_path(n)) for n in ("stdlib", "platstdlib", "purelib", "platlib"))
FOREIGN += (Path(__file__).resolve().parent.parent,)
#: names of folders of installed packages, whichever Python they are of
INSTALLED = {"site-packages", "dist-packages"}


def inputs_of(mechanism: Mechanism, modules: dict[str, str], files: dict[str, str]) -> dict:
    """Inputs of the runs of a mechanism, as plain data; modules, files: see `modules_of`,
    `files_named`.
    """
    scene = json.dumps(sorted(numbers(mechanism.scene.to_json()).items()))
    return common(modules, files) | {"text": mechanism.structure.digest, "numbers": _digest(scene)}


def of_case(mechanism: Mechanism, case: Case | None, values: Iterable[object]) -> dict:
    """The same with the files of a case and of these values of its parameters; None: of a scene."""
    if case is None:
        return inputs_of(mechanism, {}, {})
    source = {"source": case.source}
    return inputs_of(mechanism, modules_of(case.files), files_named(values)) | source


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
        return ["they do not state their inputs (an older version wrote them)"]
    differences = []
    if before.get("version") != now["version"]:
        differences.append(f"clearance {before.get('version')}, here {now['version']}")
    if before.get("source") != now.get("source"):
        differences.append("the case file has been changed")
    old = before.get("modules", {})
    new = now.get("modules", {})
    changed = [n for n in sorted({*old, *new}) if old.get(n) != new.get(n)]
    differences += [f"the imported module {n} has been changed" for n in changed]
    there = now.get("files", {})
    return differences + [
        f"the file {n} has been changed"
        for n, d in before.get("files", {}).items()
        if there.get(n) != d
    ]


def point_differences(
    before: dict, now: dict, before_scene: str | None = None, scene: str = ""
) -> list[str]:
    """Changes of a point's inputs, in words. before_scene, scene: JSON of the scenes, if known."""
    differences = (
        ["the law or kernel text has been changed"] if before.get("text") != now["text"] else []
    )
    if before.get("numbers") == now["numbers"]:
        return differences
    old, new = (numbers(text) if before_scene else {} for text in (before_scene, scene))
    changed = [n for n in dict.fromkeys([*old, *new]) if old.get(n) != new.get(n)]
    if not changed:
        return [*differences, "the scene's numbers have been changed"]
    first = changed[0]
    rest = f" (and {len(changed) - 1} more)" if len(changed) > 1 else ""
    return [
        *differences,
        f"{first} was {old.get(first, 'not there')}, is now {new.get(first, 'not there')}{rest}",
    ]


def differences(before: dict, now: dict, *scenes: str) -> list[str]:
    """All changes of inputs, in words."""
    return common_differences(before, now) + point_differences(before, now, *scenes)


def accept(words: str, changed: Iterable[str], accept_changes: bool) -> str:
    """The sentence that states changes of inputs, which the log gets. words: what was there before.

    Raises ValueError with it unless the changes are accepted.
    """
    sentence = f"{words}, and since then: {'; '.join(changed)}"
    if not accept_changes:
        raise ValueError(
            f"{sentence}. Give another directory; "
            "with --accept-changes (accept_changes=True) the rest is run all the same"
        )
    LOG.warning("%s; what is there stays", sentence)
    return f"{sentence}; what is there stays"


def modules_of(paths: Iterable[Path]) -> dict[str, str]:
    """Digests of the user's own modules that files import, directly or not, by name; the files
    themselves left out.
    """
    digests: dict[str, str] = {}
    for root in map(Path, paths):
        todo = [(root, "")]
        while todo:
            path, package = todo.pop()
            for name in _imported(path, package):
                file = None if name in digests else _own_file(name, str(root.parent))
                if file is not None:
                    digests[name] = digest(file)
                    inside = name if file.name == "__init__.py" else name.rpartition(".")[0]
                    todo.append((file, inside))
    return dict(sorted(digests.items()))


def _imported(path: Path, package: str) -> Iterator[str]:
    """Names that may be modules in the import statements of a file; a scene file has none."""
    if path.suffix != ".py":
        return
    for node in ast.walk(parsed(path.read_bytes())):
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


def _own_file(name: str, beside: str) -> Path | None:
    """The file of a user's own module; None for others and for what is no module. beside: folder of
    the file that imports it. Nothing is imported.
    """
    spec, where = None, [beside, *sys.path]
    for part in accumulate(name.split("."), "{}.{}".format):
        spec = PathFinder.find_spec(part, where)
        if spec is None or _foreign(part, spec):
            return None
        where = list(spec.submodule_search_locations or ())
    return Path(spec.origin) if spec and str(spec.origin).endswith(".py") else None


def _foreign(name: str, spec: ModuleSpec) -> bool:
    """A module of Python, of this package, or of an installed distribution.

    The package may be there twice, installed and as a checkout; its version is stated by itself.
    """
    if name.partition(".")[0] == __name__.partition(".")[0]:
        return True
    path = Path(spec.origin or next(iter(spec.submodule_search_locations or ()), ""))
    if INSTALLED & {*path.parts} or any(
        path.is_relative_to(f) or path.resolve().is_relative_to(f) for f in FOREIGN
    ):
        return True
    folder = path.parent.parent if path.name == "__init__.py" else path.parent
    return "." not in name and name in _distributed(str(folder))


@cache
def _distributed(folder: str) -> set[str]:
    """Modules of the distributions that are installed in a folder, such as that of PYTHONPATH."""
    from importlib.metadata import distributions

    files = [
        line.partition(",")[0]
        for distribution in distributions(path=[folder])
        for line in (distribution.read_text("RECORD") or "").splitlines()
    ]
    return {Path(file).parts[0].removesuffix(".py") for file in files if file}
