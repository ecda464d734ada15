"""Reynolds equation: solvers, force tables, films solved during a run.

Called, it is the family `film`, to decorate a film law of yours with. Family and subpackage have
one name in `clearance`, so that both `@cl.film` and `cl.film.table` are right. Therefore the class
of this module has a call. The folder keeps its name, for result files name laws by it.
"""

import sys
from collections.abc import Callable
from types import ModuleType

from clearance.laws.law import film as family
from clearance.values.checks import Check


class _Decorator(ModuleType):
    """A module that decorates."""

    def __call__(self, function: Callable | None = None, /, **checks: Check):
        """As the family: decorate a film law; keyword arguments name the check of each
        parameter.
        """
        return family(function, **checks)


sys.modules[__name__].__class__ = _Decorator
