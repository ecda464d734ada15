"""Film between elastic surfaces on the trace, see laws/elastic_gap.py.

Unknown is ln (delta h), in which both sides are nearly straight. A guess by asymptotes and STEPS of
Newton's method are an explicit formula; its slopes are exact.
"""

from collections.abc import Callable
from functools import cache

from clearance.laws import elastic_gap
from clearance.laws.law import FilmJoint, Law
from clearance.laws.line_contact import LineScales
from clearance.tracing.function import Function
from clearance.tracing.interpreter import traced
from clearance.tracing.trace import Trace

STEPS = 2
STATE = 6  # numbers before the scales
SCALES = 6  # of `gap_scales`


def film_of(trace: Trace, number: Callable, contact: Law, state: list, facts: list) -> list:
    """`elastic_surfaces` at gap, speed and approach of a joint; facts: see FilmJoint.

    number: a number of the joint by its name. What follows from these alone is computed once.
    """
    roughness = facts[-1]
    shape = FilmJoint, *["number"] * 4
    of_contact = [number(f"contact/{n}") for n in contact.parameters]
    law = [number(f"elastic/{n}") for n in ("modulus", "pressure_viscosity")]
    force = trace.call(traced(contact.function), [roughness, 0.0, 1.0, *of_contact])
    scales = traced(elastic_gap.gap_scales, shape)
    sizes = trace.call(scales, [*facts, *law, roughness, *force])
    numbers = [facts[1], roughness, number("elastic/rest"), *sizes, *of_contact]
    return trace.call(elastic_surfaces(contact), [*state, *numbers])


@cache
def elastic_surfaces(contact: Law) -> Function:
    """(film, gap of the rigid film, rate of that, rate of the deflection).

    Arguments: gap, speed, approach, clearance, roughness, the speed of rest, the scales of the gap,
    the numbers of the contact.
    Rates are over that of the journal.
    """
    count = STATE + SCALES + len(contact.parameters)

    def balance(trace: Trace, arguments: list) -> list:
        """Mismatch, and ln of rigid film over film."""
        z, gap, speed, approach, rest, *numbers = arguments
        (*sizes, _, squeeze), of_contact = numbers[:SCALES], numbers[SCALES:]
        parts = trace.call(traced(elastic_gap.unfolded), [z, gap])
        (load,) = trace.call(traced(contact.function), [parts[1], 0.0, 1.0, *of_contact])
        load = trace.select(load, load, 1e-300)
        state = [*parts, load, speed, approach, squeeze, rest]
        return trace.call(_sized(elastic_gap.mismatch, 7), [*state, *sizes])

    law = Function.of("elastic_balance", 5 + SCALES + len(contact.parameters), balance)

    def build(trace: Trace, arguments: list) -> list:
        gap, speed, approach, clearance, roughness, rest, *numbers = arguments
        *sizes, stiff, squeeze = numbers[:SCALES]
        state = [gap, speed, approach, roughness, rest]
        guess = _sized(elastic_gap.guessed, 5, 2)
        (z,) = trace.call(guess, [*state, *sizes, stiff, squeeze])
        ratio = 0.0
        for _ in range(STEPS):
            inputs = [z, gap, speed, approach, rest, *numbers]
            miss, ratio, slope, rise = trace.call(law.slopes((0,)), inputs)
            move = trace.div(-miss, slope)
            z += move
            ratio += rise * move
        film, deflection = trace.call(traced(elastic_gap.unfolded), [z, gap])
        values = trace.call(traced(elastic_gap.parted), [film, deflection, ratio])
        (rigid,) = trace.call(traced(elastic_gap.centred), [gap, clearance])
        pairs = zip((gap, gap, 1.0, 0.0), (film, *values), strict=True)
        return [trace.call(traced(elastic_gap.blended), [rigid, a, b])[0] for a, b in pairs]

    return Function.of("elastic_surfaces", count, build)


@cache
def _sized(function, before: int, behind: int = 0) -> Function:
    """A function of the scales of a line contact between so many numbers."""
    return traced(function, (*["number"] * before, LineScales, *["number"] * behind))
