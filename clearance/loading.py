"""Files of a user: their modules, and the place in them where an error was raised."""

import importlib.util
import sys
import traceback
import zlib
from pathlib import Path
from types import ModuleType


def module_of(path: str | Path, kind: str, label: str) -> ModuleType:
    """The module of a file, which is run; kind: of such files, in the module's name.

    Raises ValueError, beginning with the label, for whatever the file raises.
    """
    name = f"clearance_{kind}_{zlib.crc32(str(path).encode()):x}"
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ValueError(f"{label}: {located(error, str(path))}") from error
    return module


def place_in(error: BaseException) -> str:
    """File and line of a user that an error came from, as " (case.py, line 3)"; "" for none.

    Lines of this package and of code without a file, such as that of a dataclass, do not count.
    """
    package = str(Path(__file__).parent)
    frames = [
        f
        for f in traceback.extract_tb(error.__traceback__)
        if not f.filename.startswith((package, "<"))
    ]
    return f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""


def located(error: Exception, path: str | None = None) -> str:
    """An error as "file, line 3, in function: KeyError: 'x'", at the innermost line of a file.

    path: that file, by default the one of the function called first. Without a line in it the place
        is left out.
    """
    frames = traceback.extract_tb(error.__traceback__)[1:]  # without the caller's own
    path = path or (frames[0].filename if frames else None)
    text = f"{type(error).__name__}: {error}"
    inside = [f for f in frames if f.filename == path]
    if not inside:
        return text
    frame = inside[-1]
    function = "" if frame.name == "<module>" else f", in {frame.name}"
    return f"{frame.filename}, line {frame.lineno}{function}: {text}"
