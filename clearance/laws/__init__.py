"""The physics of one joint, as plain functions: one file a family.

Families, and laws with a file of their own, have the names of these files.
"""

import sys
from types import ModuleType

from clearance.values.checks import lazily

__getattr__, __dir__, __all__ = lazily(__name__, __file__)


class _Laws(ModuleType):
    """A module whose public names no file of its own takes when it is imported."""

    def __setattr__(self, name: str, value: object) -> None:
        if name not in __all__ or not isinstance(value, ModuleType):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Laws
