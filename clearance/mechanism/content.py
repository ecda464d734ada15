"""Values of plain fields, as parts of a structure: the code may have them as constants."""

from collections.abc import Hashable, Mapping
from dataclasses import fields, is_dataclass
from functools import partial
from types import FunctionType

import numpy as np

from clearance.elements.body import Body, Point
from clearance.elements.element import Element
from clearance.laws.law import BoundLaw
from clearance.tracing.interpreter import fingerprint

PLAIN = (bool, int, float, complex, str, bytes, np.number, np.bool_)


def content(value: object, positions: dict[str, int]) -> Hashable:
    """Equal for values that are the same to a formula. Parts of the scene are their positions.

    It has no hash where a value of unknown kind has none.
    """
    kind = type(value)
    if isinstance(value, PLAIN):
        return kind, repr(value)  # 1, 1.0 and True are equal, and nan is not
    if isinstance(value, Body | Element):
        return kind, positions.get(value.key)  # None: the ground
    if isinstance(value, Point):
        return kind, positions.get(value.body.key)  # its place is a parameter
    inner = partial(content, positions=positions)
    if isinstance(value, FunctionType):
        return value, fingerprint(value)
    if isinstance(value, BoundLaw):
        return fingerprint(value.law.function), inner(value.values)
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return kind, value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, tuple | list):
        return kind, tuple(map(inner, value))
    if isinstance(value, set | frozenset):
        return kind, frozenset(map(inner, value))
    if isinstance(value, Mapping):
        return kind, tuple((inner(k), inner(v)) for k, v in value.items())
    if is_dataclass(value) and not isinstance(value, type):
        return kind, tuple(inner(getattr(value, field.name)) for field in fields(value))
    return kind, value
