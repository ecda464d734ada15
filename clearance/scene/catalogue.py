"""Finding cases: by name in the case library, or by path to a user's own file of the same form."""

import dataclasses
import functools
import importlib.util
import inspect
import re
import typing
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import partial
from importlib import import_module
from os.path import isfile  # of a name that no file can have too
from pathlib import Path
from types import ModuleType

from clearance.scene.case import Case, Parameter
from clearance.scene.scene import Scene
from clearance.scene.user_module import executed, explained, place_in, words_of
from clearance.values.checks import meant

#: whatever is a case
AnyCase = str | Path | Case | Scene | Callable[..., Scene]
_PARAMETER = re.compile(r"^\s*(\w+):\s*(.*?)\s*(?:\[([^\]]*)\])?\s*$")
#: the package of the cases that come with this one
LIBRARY = "clearance.cases"
#: where a description goes on in a line that is indented further
_CONTINUED = re.compile(r"\n +")
#: kinds of files that are cases
FILES = (".py", ".toml")
#: kinds of files that hold the description of a scene, but are no cases
RESULTS = (".h5", ".hdf5")


@functools.cache
def library() -> Path:
    """Folder of the cases that come with the package."""
    return Path(importlib.util.find_spec(LIBRARY).origin).parent


def beside_cases(name: str) -> ModuleType:
    """A module in a folder beside the cases that come with the package: none of them."""
    return import_module(f"{LIBRARY}.{name}")


def case_names() -> list[str]:
    """Names of the cases that come with the package."""
    return sorted(p.stem for p in library().glob("*.py") if not p.stem.startswith("_"))


def find_case(case: AnyCase) -> Case:
    """A case: by library name, by the path of its file (.py or .toml), by "file.py:function", of a
    function, of a scene or of its JSON.

    The parameters of a function are its keyword arguments. Those of a scene that no case made are
    its numbers, such as "joints/B/clearance". Raises ValueError for a name that no case has, and
    for a file that is none.
    """
    if isinstance(case, Case):
        return case
    if isinstance(case, Scene):
        return case.case or _of_scene(case)
    if callable(case):
        return _of_function(case)
    if not isinstance(case, str | Path):
        kinds = "the name of a case, a file, a function or a Scene"
        raise TypeError(f"a case is {kinds}, got {case!r}")
    if str(case).startswith("{"):
        return _of_scene(Scene.from_json(str(case)))
    file, _, function = str(case).rpartition(":")
    return _python_file(Path(file), function) if file.endswith(".py") else _of_file(case)


def _of_scene(scene: Scene) -> Case:
    """The case of a scene that no case made."""
    from clearance.scene.parameter import number_of

    def changed(**values) -> Scene:
        return scene.replaced(values)

    parameters = {}
    for name in scene.changeable:
        with suppress(ValueError):  # a number that cannot vary
            value, units, _ = number_of(scene, name)
            parameters[name] = Parameter(name, float, value, units, "")
    return Case(scene.name, None, changed, "", parameters, reference=scene.to_json())


def _of_function(function: Callable[..., Scene]) -> Case:
    """The case of a function: that of its file, where it stands at the top level of one."""
    inner = inspect.unwrap(function)
    code = getattr(inner, "__code__", None)
    name = getattr(inner, "__name__", str(function))
    path = Path(code.co_filename if code else "")
    top = getattr(inner, "__qualname__", "") == name and name.isidentifier()
    if top and path.suffix == ".py" and path.is_file() and inner.__module__ != "__main__":
        return _python_file(path, name)
    return _made_by(function, name, None, inspect.getdoc(function) or "")


def _of_file(name: str | Path) -> Case:
    """A case by library name, or by the path of its file."""
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
    elif str(name).isidentifier() and str(name)[0] != "_" and isfile(library() / f"{name}.py"):
        path = library() / f"{name}.py"
    else:
        names = case_names()
        answer = f"{meant(str(name), names)}; known: {', '.join(names)}"
        raise ValueError(
            f"unknown case {str(name)!r}{answer}, or give a path to a .py or .toml file"
        )
    if path.suffix != ".toml":
        return _python_file(path)
    from clearance.scene.toml_scene import scene_file

    return scene_file(path)


def _python_file(path: Path, name: str = "scene") -> Case:
    """The case of a Python file, its parameters those of its function."""
    if not path.is_file():
        raise ValueError(f"no case file {path}")
    module = _module(path.resolve())
    label = path.stem if name == "scene" else name
    function = getattr(module, name, None)
    if not callable(function):
        raise ValueError(
            f"case file {path} must define a function {name}(...) that returns a Scene"
        )
    text = function.__doc__ or module.__doc__ or ""
    length = getattr(module, "UNTIL", None)
    reference = str(path.resolve()) + ("" if name == "scene" else f":{name}")
    return _defined(function, label, path, text, length, reference)


@functools.lru_cache(maxsize=16)
def _defined(
    function: Callable[..., Scene], name: str, path: Path, text: str, length, reference: str
) -> Case:
    """The case of a function of a file; length: that of its runs [s], where the file states it."""
    case = _made_by(function, name, path, text)
    ours = path.parent == library()
    return dataclasses.replace(
        case,
        function=_gathering(function) if ours else case.function,
        length=length,
        library=ours,
        reference=path.stem if ours else reference,
    )


def _made_by(function: Callable[..., Scene], name: str, path: Path | None, text: str) -> Case:
    """The case of a user's function, whose text describes it."""
    for p in inspect.signature(function).parameters.values():
        if p.kind is p.POSITIONAL_ONLY:
            raise ValueError(f"case {name}: parameter {p.name!r} cannot be given by name")
        if p.default is p.empty:
            word = "scene" if path and path.stem == name else name
            raise ValueError(f"case {name}: parameter {p.name!r} of {word}() needs a default value")
    summary = " ".join(inspect.cleandoc(text).split("\n\n")[0].split())
    explained_function = _explaining(f"case {name}", _gathering(function))
    return Case(name, path, explained_function, summary, _parameters(function))


def _parameters(function: Callable[..., Scene]) -> dict[str, Parameter]:
    """Parameters from the signature; units and texts from the docstring's `name: text [unit]`
    lines.

    A default that is a dataclass stands for its fields, see JointOptions.
    """
    lines = _described(function)
    parameters = {}
    arguments = {}
    for p in inspect.signature(function).parameters.values():
        if dataclasses.is_dataclass(p.default):
            shared = _parameters(type(p.default))
            of_argument = [
                dataclasses.replace(new, default=getattr(p.default, name), **lines.get(name, {}))
                for name, new in shared.items()
            ]
        else:
            texts = {"units": "?", "text": ""} | lines.get(p.name, {})
            of_argument = [Parameter(p.name, _kind(p), p.default, **texts)]
        for new in of_argument:
            if new.name in parameters:
                raise ValueError(
                    f"scene(): its arguments {arguments[new.name]!r} and {p.name!r} both give the "
                    f"parameter {new.name!r}, for the fields of a dataclass are parameters too; "
                    f"rename or leave out the argument {new.name!r}"
                )
            parameters[new.name], arguments[new.name] = new, p.name
    return parameters


def _described(function: Callable) -> dict[str, dict[str, str]]:
    """Units and texts of parameters by name, from a docstring."""
    text = _CONTINUED.sub(" ", inspect.cleandoc(function.__doc__ or ""))
    matches = [m for line in text.splitlines() if (m := _PARAMETER.match(line))]
    return {m[1]: {"text": m[2], "units": m[3] or "?"} for m in matches}


def _gathering(function: Callable[..., Scene]) -> Callable[..., Scene]:
    """The function with the fields of its shared dataclasses as parameters."""
    arguments = inspect.signature(function).parameters.values()
    shared = {p.name: p.default for p in arguments if dataclasses.is_dataclass(p.default)}
    if not shared:
        return function

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
        with explained(partial(_explained, label)):
            return function(**values)

    return scene


def _module(path: Path):
    with explained(partial(_explained, f"case file {path} cannot be loaded")):
        return executed(path, "case")


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
    kind = (
        "" if isinstance(error, ValueError | TypeError | KeyError) else f"{type(error).__name__}: "
    )
    return ValueError(f"{where}: {kind}{words_of(error)}{place_in(error)}")


def case_with(
    case: AnyCase, fixed: Mapping[str, object] | None, varied: Iterable[str]
) -> tuple[Case, dict[str, object]]:
    """A case, and the values of the parameters that do not vary: of a scene also those that its
    case was given.
    """
    values = case.parameters if isinstance(case, Scene) and case.case is not None else {}
    return find_case(case), {n: v for n, v in values.items() if n not in varied} | dict(fixed or {})


def load_case(name: AnyCase, **values) -> Scene:
    """The scene of a case.

    name: library name, path, "file.py:name", or a function; a scene without values is itself.
    values: parameters of the case, in SI or as texts with a unit.
    Raises ValueError for cases and parameters that do not exist, and what the case raises.

    Example:

        >>> scene = cl.load_case("six_bar_feeder", model="dry", speed="300 rpm", joints="B,C")
        >>> [joint.name for joint in scene.clearance_joints]
        ['B', 'C']
    """
    if isinstance(name, Scene):
        return name if not values else find_case(name).scene(**name.parameters | values)
    return find_case(name).scene(**values)
