"""A joint that lets nothing move: two bodies made one, with the load between them as an output."""

from dataclasses import dataclass

from clearance.elements.body import Point
from clearance.elements.joint import Joint, Known
from clearance.elements.quantities import UNIT, number
from clearance.values import checks


@checks.answers
@dataclass(frozen=True)
class Weld(Joint):
    """Point b coincides with point a and b does not turn against a: what a section there carries is
    its reaction.

    angle: of b's frame against a's [rad].
    """

    a: Point
    b: Point
    angle: float = number("angle of b's frame against a's [rad]", checks.finite, 0.0, fold=UNIT)
    name: str | None = None

    turn = Known("angle")
    carries_across = True
