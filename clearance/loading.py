"""Modules from files of a user."""

import importlib.util
import sys
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
        raise ValueError(f"{label}: {type(error).__name__}: {error}") from error
    return module
