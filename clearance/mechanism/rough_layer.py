"""A film on a layer that summits press back, on the trace: see laws/rough_layer.py.

Newton's method, whose steps are an explicit formula with exact slopes. Dry surfaces come first, H -
P_a(H) = 1 - eps. Then comes h - q / h = 1 - eps_f, with the q of the film itself at the wall or
before it. Both less P_a are concave in the gap, so that no step goes too far. The film itself comes
last: P_a is met within 5e-3 of it at most, 2e-4 in 99 states of 100. The dry surfaces are a bound.
"""

from functools import cache

from clearance.laws.law import DataLaw, FilmJoint, Law
from clearance.laws.rough_layer import pressure_of
from clearance.tracing.function import Function
from clearance.tracing.interpreter import traced
from clearance.tracing.trace import Trace

DRY, SIMPLE, STEPS = 4, 4, 2  # steps of each
SUMMITS = (FilmJoint, "number", "number", "number")  # kinds of what their functions take at the end


def factor_of(trace: Trace, asperity: Law, numbers: list) -> list:
    """Factor of the pressure of summits [Pa], and their height [m], from the law's numbers."""
    height = numbers[list(asperity.parameters).index("summit_height")]
    return [*trace.call(traced(asperity.pressure[1]), numbers), height]


@cache
def film_behind(film: DataLaw, order: float) -> Function:
    """Eccentricity ratio that the film has, and its rate.

    Arguments: eccentricity ratio, its rate and the entrainment, the numbers of the joint, those of
    `factor_of`, the film's.
    """
    _, _, middle, *_ = film.shown["film_middle"]
    gap, pressed = traced(middle, film.kinds), traced(pressure_of(order), ("number", *SUMMITS))
    count = len(FilmJoint._fields)

    def build(trace: Trace, arguments: list) -> list:
        (ratio, rate, turning), rest = arguments[:3], arguments[3:]
        facts, summits, numbers = rest[:count], rest[count : count + 2], rest[count + 2 :]
        values = dict(zip(film.parameters, numbers, strict=True))
        clearance, apart = facts[1], 1.0 - ratio

        def film_at(ratio) -> list:
            """Gap in the middle of a film over c, and its slope."""
            h, _, slope, _ = trace.call(gap.slopes((0,)), [ratio, rate, turning, *facts, *numbers])
            return [trace.div(h, clearance), trace.div(slope, clearance)]

        def back(h) -> list:
            """P_a at a gap over c, and its slope."""
            taken = [clearance * h, *facts, values["liner"], *summits]
            p, slope = trace.call(pressed.slopes((0,)), taken)
            return [p, clearance * slope]

        def larger(a, b):
            return trace.select(trace.compare("gt", a, b), a, b)

        inside = larger(apart, 0.0)
        h, dry = film_at(1.0 - inside)[0], 0.0
        product = h * (h - inside)
        for _ in range(DRY):
            p, slope = back(dry)
            dry = dry + trace.div(apart + p - dry, 1.0 - slope)
        dry = larger(dry, 0.0)
        least = ratio - back(dry)[0]
        h = 0.5 * (apart + trace.sqrt(apart * apart + 4.0 * product))
        h = larger(dry, h)
        for _ in range(SIMPLE):
            p, slope = back(h)
            part = trace.div(product, h)
            h = h + trace.div(apart + p + part - h, 1.0 - slope + trace.div(part, h))
        behind, give = ratio - back(h)[0], 1.0
        for _ in range(STEPS):
            h, closer = film_at(behind)
            p, slope = back(h)
            give = trace.div(1.0, 1.0 + slope * closer)
            behind = larger(behind + (ratio - behind - p) * give, least)
        return [behind, rate * (1.0 - values["follows"] * (1.0 - give))]

    return Function.of("film_behind", 3 + count + 2 + len(film.parameters), build)
