"""Names that a folder has from its modules, imported on first use."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module

from clearance.values.checks import absent


def lazily(package: str, modules: Mapping[str, str]) -> Callable[[str], object]:
    """`__getattr__` of a package that has these names from these modules of it."""
    missing = absent(package, modules)

    def __getattr__(name: str):
        if name not in modules:
            return missing(name)
        value = getattr(import_module(f"{package}.{modules[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    return __getattr__
