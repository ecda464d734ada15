"""Finding cases: by name in the case library, or by path to a user's own file of the same form."""

import importlib.util
import inspect
import json
import re
import sys
import traceback
import typing
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from clearance import checks
from clearance.checks import meant
from clearance.choices import resolved
from clearance.scene import Scene
from clearance.units import quantity

_PARAMETER = re.compile(r"^\s*(\w+):\s*(.*?)\s*(?:\[([^\]]*)\])?\s*$")
_SWITCH = {"true": True, "yes": True, "on": True, "1": True, "false": False, "no": False, "off": False, "0": False}


@dataclass(frozen=True)
class Parameter:
    """One swept quantity of a case: name, type, default, unit and what it is."""

    name: str
    kind: type
    default: object
    units: str
    text: str

    def value(self, given: str) -> object:
        """A value from the command line, such as 300rpm, 0.1mm or dry; or the default's word, such as auto."""
        if isinstance(self.default, str) and given.strip() == self.default:
            return self.default
        try:
            if self.kind is bool:
                return _SWITCH[given.strip().lower()]
            return given if self.kind is str else self._number(quantity(given, self.units))
        except KeyError:
            raise ValueError(f"{self.name}: {given!r} is neither true nor false") from None
        except ValueError as error:
            raise ValueError(f"{self.name}: {error}") from None

    def _number(self, number: float) -> float | int:
        if self.kind is int and number != int(number):
            raise ValueError(f"{number:g} is not a whole number")
        return self.kind(number)


@dataclass(frozen=True)
class Case:
    """A case file: its scene function and what the docstrings say."""

    name: str
    path: Path
    function: Callable[..., Scene]
    summary: str

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """Parameters from the signature; units and texts from the docstring's `name: text [unit]` lines."""
        said = {}
        for line in (self.function.__doc__ or "").splitlines():
            if match := _PARAMETER.match(line):
                said[match[1]] = match[2], match[3] or "?"
        found = {}
        for p in inspect.signature(self.function).parameters.values():
            kind = _kind(p)
            text, units = said.get(p.name, ("", "?"))
            found[p.name] = Parameter(p.name, kind, p.default, units, text)
        return found

    @property
    def until(self) -> float:
        """Length of a run of which none is asked for and nothing turns [s]: UNTIL of the file, else 2 s."""
        return checks.positive(f"case {self.name}: UNTIL", self.function.__globals__.get("UNTIL", 2.0))

    def scene(self, **values) -> Scene:
        """The scene for given parameter values; an unknown name lists the known ones."""
        known = self.parameters
        if unknown := [n for n in values if n not in known]:
            answer = f"{meant(unknown[0], known)}; it has {', '.join(known)}"
            raise ValueError(f"case {self.name} has no parameter {unknown[0]!r}{answer}")
        try:
            scene = self.function(**values)
        except (Exception, SystemExit) as error:
            if self.path.parent == library() and isinstance(error, ValueError | TypeError):
                raise
            raise _explained(f"case {self.name}", error) from error
        if not isinstance(scene, Scene):
            raise TypeError(f"case {self.name}: scene() must return a Scene, got {type(scene).__name__}")
        scene.parameters.update(values)
        defaults = {n: p.default for n, p in known.items() if n not in values}
        scene.origin["case_file"] = self.name if self.path.parent == library() else str(self.path)
        scene.origin["defaults"] = json.dumps(defaults, default=str, sort_keys=True)
        automatic = resolved(defaults | values, scene.joints)
        scene.origin["resolved"] = json.dumps(automatic, sort_keys=True)
        return scene


def library() -> Path:
    """Folder of the cases that come with the package."""
    spec = importlib.util.find_spec("clearance.cases")
    if spec is not None and spec.submodule_search_locations:
        return Path(next(iter(spec.submodule_search_locations)))
    return Path(__file__).resolve().parent.parent / "cases"


def case_names() -> list[str]:
    """Names of the cases that come with the package."""
    return sorted(p.stem for p in library().glob("*.py") if not p.stem.startswith("_"))


def find_case(name: str | Path) -> Case:
    """A case by library name or by path. Raises ValueError for a name nobody knows or a file without `scene`."""
    path = Path(name)
    if path.suffix == ".py" or len(path.parts) > 1:
        if not path.is_file():
            raise ValueError(f"no case file {name}")
        if path.suffix != ".py":
            raise ValueError(f"{name} is no case file: the name of one ends in .py")
    elif str(name) in case_names():
        path = library() / f"{name}.py"
    else:
        names = case_names()
        answer = f"{meant(str(name), names)}; known: {', '.join(names)}"
        raise ValueError(f"unknown case {str(name)!r}{answer}, or give a path to a .py file")
    module = _module(path.resolve())
    function = getattr(module, "scene", None)
    if not callable(function):
        raise ValueError(f"case file {path} must define a function scene(...) that returns a Scene")
    bad = [p.name for p in inspect.signature(function).parameters.values() if p.default is inspect.Parameter.empty]
    if bad:
        raise ValueError(f"case {path.stem}: parameter {bad[0]!r} of scene() needs a default value")
    summary = (function.__doc__ or module.__doc__ or "").strip().splitlines()
    return Case(path.stem, path, function, summary[0] if summary else "")


def _module(path: Path):
    # a file that was changed is another module
    text, place = zlib.crc32(path.read_bytes()), zlib.crc32(str(path).encode())
    name = f"clearance_case_{path.stem}_{place:x}_{text:x}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise _explained(f"case file {path} cannot be loaded", error) from error
    return module


def _kind(parameter: inspect.Parameter) -> type:
    """Type of a parameter: its annotation (the first plain type of a union), else a number or the default's type."""
    for kind in (parameter.annotation, *typing.get_args(parameter.annotation)):
        if kind in (float, int, str, bool):
            return kind
    return float if type(parameter.default) in (int, type(None)) else type(parameter.default)


def _explained(where: str, error: BaseException) -> ValueError:
    """A user's error as one line: what, and at which line of which file."""
    if isinstance(error, SyntaxError):
        return ValueError(f"{where}: SyntaxError: {error.msg} (line {error.lineno})")
    own = str(Path(__file__).parent)
    frames = [f for f in traceback.extract_tb(error.__traceback__) if not f.filename.startswith(own)]
    place = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
    text = str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)
    kind = "" if isinstance(error, ValueError | TypeError | KeyError) else f"{type(error).__name__}: "
    return ValueError(f"{where}: {kind}{text}{place}")


def load_case(name: str | Path, **values) -> Scene:
    """The scene of a case, by library name or path, with parameter values in SI units."""
    return find_case(name).scene(**values)
