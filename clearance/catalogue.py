"""Finding cases: by name in the case library, or by path to a user's own file of the same form."""

import dataclasses
import functools
import importlib.util
import inspect
import re
import sys
import typing
import zlib
from collections.abc import Callable
from pathlib import Path

from clearance.case import Case, Parameter
from clearance.checks import meant
from clearance.loading import place_in
from clearance.scene import Scene

_PARAMETER = re.compile(r"^\s*(\w+):\s*(.*?)\s*(?:\[([^\]]*)\])?\s*$")
#: where a description goes on in a line that is indented further
_CONTINUED = re.compile(r"\n +")
#: kinds of files that are cases
FILES = (".py", ".toml")
#: kinds of files that hold the description of a scene, but are no cases
RESULTS = (".h5", ".hdf5")


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
    """A case by library name, or by the path of its file, .py or .toml.

    Raises ValueError for a name that no case has, and for a file that is none.
    """
    path = Path(name)
    if path.suffix in (*FILES, *RESULTS) or len(path.parts) > 1:
        if not path.is_file():
            raise ValueError(f"no case file {name}")
        if path.suffix in RESULTS:
            raise ValueError(
                f"{name} is a result, no case; clearance run {name} --again makes it again, "
                f"clearance new {name} makes a case of it"
            )
        if path.suffix not in FILES:
            raise ValueError(f"{name} is no case file: the name of one ends in .py or .toml")
    elif str(name) in case_names():
        path = library() / f"{name}.py"
    else:
        names = case_names()
        answer = f"{meant(str(name), names)}; known: {', '.join(names)}"
        raise ValueError(
            f"unknown case {str(name)!r}{answer}, or give a path to a .py or .toml file"
        )
    if path.suffix != ".toml":
        return _python_file(path)
    from clearance.scene_files import scene_file

    return scene_file(path)


def _python_file(path: Path) -> Case:
    """The case of a Python file, its parameters those of its function `scene`."""
    module = _module(path.resolve())
    function = getattr(module, "scene", None)
    if not callable(function):
        raise ValueError(f"case file {path} must define a function scene(...) that returns a Scene")
    arguments = inspect.signature(function).parameters.values()
    if bad := [p.name for p in arguments if p.default is inspect.Parameter.empty]:
        raise ValueError(f"case {path.stem}: parameter {bad[0]!r} of scene() needs a default value")
    summary = inspect.cleandoc(function.__doc__ or module.__doc__ or "").split("\n\n")[0]
    ours = path.parent == library()
    if not ours:
        function = _explaining(f"case {path.stem}", function)
    shared = {p.name: p.default for p in arguments if dataclasses.is_dataclass(p.default)}
    return Case(
        path.stem,
        path,
        _gathering(function, shared) if shared else function,
        " ".join(summary.split()),
        _parameters(function),
        getattr(module, "UNTIL", None),
        ours,
    )


def _parameters(function: Callable[..., Scene]) -> dict[str, Parameter]:
    """Parameters from the signature; units and texts from the docstring's `name: text [unit]`
    lines.

    A default that is a dataclass stands for its fields, see JointOptions.
    """
    lines, parameters, arguments = _described(function), {}, {}
    for p in inspect.signature(function).parameters.values():
        if dataclasses.is_dataclass(p.default):
            shared = _parameters(type(p.default))
            made = [
                dataclasses.replace(one, default=getattr(p.default, name), **lines.get(name, {}))
                for name, one in shared.items()
            ]
        else:
            texts = {"units": "?", "text": ""} | lines.get(p.name, {})
            made = [Parameter(p.name, _kind(p), p.default, **texts)]
        for one in made:
            if one.name in parameters:
                raise ValueError(
                    f"scene(): its arguments {arguments[one.name]!r} and {p.name!r} both give the "
                    f"parameter {one.name!r}, for the fields of a dataclass are parameters too; "
                    f"rename or leave out the argument {one.name!r}"
                )
            parameters[one.name], arguments[one.name] = one, p.name
    return parameters


def _described(function: Callable) -> dict[str, dict[str, str]]:
    """Units and texts of parameters by name, from a docstring."""
    text = _CONTINUED.sub(" ", inspect.cleandoc(function.__doc__ or ""))
    matches = [m for line in text.splitlines() if (m := _PARAMETER.match(line))]
    return {m[1]: {"text": m[2], "units": m[3] or "?"} for m in matches}


def _gathering(function: Callable[..., Scene], shared: dict) -> Callable[..., Scene]:
    """The function with the fields of its shared dataclasses as parameters."""

    @functools.wraps(function)
    def scene(**values) -> Scene:
        for name, usual in shared.items():
            names = [f.name for f in dataclasses.fields(usual) if f.name in values]
            values[name] = dataclasses.replace(usual, **{n: values.pop(n) for n in names})
        return function(**values)

    return scene


def _explaining(label: str, function: Callable[..., Scene]) -> Callable[..., Scene]:
    """The function of a user's file, whose errors become one line with their place in it."""

    @functools.wraps(function)
    def scene(**values) -> Scene:
        try:
            return function(**values)
        except (Exception, SystemExit) as error:
            raise _explained(label, error) from error

    return scene


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
    """Type of a parameter: its annotation (the first plain type of a union), else a number or the
    default's type.
    """
    for kind in (parameter.annotation, *typing.get_args(parameter.annotation)):
        if kind in (float, int, str, bool):
            return kind
    return float if type(parameter.default) in (int, type(None)) else type(parameter.default)


def _explained(where: str, error: BaseException) -> ValueError:
    """A user's error as one line: what, and at which line of which file."""
    if isinstance(error, SyntaxError):
        return ValueError(f"{where}: SyntaxError: {error.msg} (line {error.lineno})")
    text = str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)
    kind = (
        "" if isinstance(error, ValueError | TypeError | KeyError) else f"{type(error).__name__}: "
    )
    return ValueError(f"{where}: {kind}{text}{place_in(error)}")


def load_case(name: str | Path, **values) -> Scene:
    """The scene of a case, by library name or path, with parameter values in SI units."""
    return find_case(name).scene(**values)
