"""Files of a user: their modules, these modules' neighbours, the place of an error in them."""

import builtins
import importlib.util
import sys
import traceback
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType

#: of modules beside a user's file: clearance_beside_<folder>.<name>
BESIDE = "clearance_beside"


def _look_anew() -> None:
    """Have Python look for files that came a moment ago; once more where another thread imports."""
    while True:
        with suppress(RuntimeError):  # "dictionary changed size during iteration"
            importlib.invalidate_caches()
            return


class Neighbours:
    """The modules beside a user's file, which its import statements see first.

    Python's working folder and path do not matter. Each folder has a name of its own in
    `sys.modules`, so that neighbours of the same name in two folders do not mix. texts: checksums
    of the files as they were loaded; once one has been changed, all are loaded anew.
    """

    known: dict[Path, "Neighbours"] = {}

    def __init__(self, folder: Path, version: int):
        self.folder = folder
        self.version = version
        self.texts = {}
        self.name = f"{BESIDE}_{zlib.crc32(str(folder).encode()):x}_{version}"
        self.names = vars(builtins) | {"__import__": self._imported}
        package = ModuleType(self.name, f"Files in {folder}.")
        package.__path__ = [str(folder)]
        package.neighbours = self
        sys.modules[self.name] = package
        _look_anew()

    @classmethod
    def of(cls, folder: Path) -> "Neighbours":
        """Those of a folder, as its files are now."""
        before = cls.known.get(folder)
        if before is None or any(_sum(path) != text for path, text in before.texts.items()):
            cls.known[folder] = cls(folder, before.version + 1 if before else 0)
        return cls.known[folder]

    def _imported(self, name: str, globals=None, locals=None, fromlist=(), level: int = 0):
        """`__import__` for the files of the folder."""
        top = name.partition(".")[0]
        if level or not self._has(top):
            return builtins.__import__(name, globals, locals, fromlist, level)
        module = builtins.__import__(f"{self.name}.{name}", globals, locals, fromlist)
        return module if fromlist else getattr(module, top)

    def _has(self, top: str) -> bool:
        """A module of this name is a neighbour, and none of Python or this package."""
        if top in sys.stdlib_module_names or top == "clearance":
            return False
        if f"{self.name}.{top}" in sys.modules:
            return True
        spec = PathFinder.find_spec(top, [str(self.folder)])
        # a folder without __init__.py may hold anything
        return spec is not None and (spec.has_location or importlib.util.find_spec(top) is None)


class _Loader(SourceFileLoader):
    """Loads a neighbour, which sees its neighbours too; from its text, never from byte code."""

    def __init__(self, name: str, path: str, neighbours: Neighbours):
        super().__init__(name, path)
        self.neighbours = neighbours

    def get_code(self, name: str) -> CodeType:
        text = self.get_data(self.path)
        self.neighbours.texts[self.path] = zlib.crc32(text)
        return self.source_to_code(text, self.path)

    def exec_module(self, module: ModuleType) -> None:
        vars(module)["__builtins__"] = self.neighbours.names
        super().exec_module(module)


class _Finder:
    """Finds users' files by the names of their modules, and the neighbours of all folders.

    Python's own import then runs each once, and lets other threads wait until it has been run.
    """

    files: dict[str, Path] = {}

    @classmethod
    def find_spec(
        cls, name: str, path: Sequence[str] | None = None, target=None
    ) -> ModuleSpec | None:
        if name in cls.files:
            file = cls.files[name]
            loader = _Loader(name, str(file), Neighbours.of(file.parent))
            return importlib.util.spec_from_file_location(name, file, loader=loader)
        if not name.startswith(BESIDE):
            return None
        spec = PathFinder.find_spec(name, path)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            package = sys.modules[name.partition(".")[0]]
            spec.loader = _Loader(name, spec.loader.path, package.neighbours)
        return spec


sys.meta_path.insert(0, _Finder)


def _sum(path: str) -> int:
    """Checksum of a file; 0 of one that is not there."""
    return zlib.crc32(Path(path).read_bytes()) if Path(path).is_file() else 0


def executed(path: Path, kind: str) -> ModuleType:
    """The module of a user's file, which is run once and sees its neighbours.

    A file that was changed, or beside which one was, is another module. kind: of such files, in
    the module's name. The error of a file that raises one is raised, and the module is forgotten.
    """
    path = path.resolve()
    beside = Neighbours.of(path.parent).name.removeprefix(BESIDE)
    stem = path.stem.replace(".", "_")
    name = f"clearance_{kind}_{stem}{beside}_{zlib.crc32(path.read_bytes()):x}"
    _Finder.files[name] = path
    return __import__(name)


def module_of(path: str | Path, kind: str, label: str) -> ModuleType:
    """The module of a file, as by `executed`.

    Raises ValueError, beginning with the label, for whatever the file raises.
    """
    file = str(Path(path).resolve())
    with explained(lambda error: ValueError(f"{label}: {located(error, file)}")):
        return executed(Path(path), kind)


@contextmanager
def explained(words: Callable[[BaseException], ValueError]) -> Iterator[None]:
    """Within it, whatever a user's code raises, but an interrupt, becomes one ValueError."""
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001 - SystemExit, or a class of the user's
        raise words(error) from error


def words_of(error: BaseException) -> str:
    """The text of an error, in one line; a user's exception may have none that can be read."""
    try:
        text = str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)
        return " ".join(text.split())
    except Exception:  # noqa: BLE001
        return "(its text cannot be read)"


def place_in(error: BaseException) -> str:
    """File and line of a user that an error came from, as " (case.py, line 3)"; "" for none.

    Lines of this package and of code without a file, such as that of a dataclass, do not count.
    """
    package = str(Path(__file__).parents[1])
    frames = [
        f
        for f in traceback.extract_tb(error.__traceback__)
        if not f.filename.startswith((package, "<"))
    ]
    return f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""


def located(error: BaseException, path: str | None = None) -> str:
    """An error as "file, line 3, in function: KeyError: 'x'", at the innermost line of a file.

    path: that file, by default the one of the function called first. Without a line in it the place
        is left out.
    """
    frames = traceback.extract_tb(error.__traceback__)[1:]  # without the caller's own
    path = path or (frames[0].filename if frames else None)
    text = f"{type(error).__name__}: {words_of(error)}"
    inside = [f for f in frames if f.filename == path]
    if not inside:
        return text
    frame = inside[-1]
    function = "" if frame.name == "<module>" else f", in {frame.name}"
    return f"{frame.filename}, line {frame.lineno}{function}: {text}"
