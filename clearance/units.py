"""Units at the boundary: everything inside clearance is SI."""

import math
import re

#: factor to SI of every unit a quantity on the command line may carry
FACTORS = {
    "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "nm": 1e-9,
    "rad": 1.0, "deg": math.pi / 180.0,
    "rad/s": 1.0, "rpm": math.pi / 30.0, "Hz": 2.0 * math.pi,
    "s": 1.0, "ms": 1e-3, "us": 1e-6,
    "m/s": 1.0, "mm/s": 1e-3, "m/s2": 1.0,
    "Pas": 1.0, "Pa.s": 1.0, "mPas": 1e-3, "cP": 1e-3,
    "kg": 1.0, "g": 1e-3, "kgm2": 1.0,
    "N": 1.0, "kN": 1e3, "Nm": 1.0, "N/m": 1.0,
    "Pa": 1.0, "MPa": 1e6, "GPa": 1e9,
}  # fmt: skip

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-zµ][\w/.µ]*)?\s*$")


def rpm(value: float) -> float:
    """Revolutions per minute to rad/s."""
    return value * FACTORS["rpm"]


def mm(value: float) -> float:
    """Millimetres to m."""
    return value * 1e-3


def um(value: float) -> float:
    """Micrometres to m."""
    return value * 1e-6


def cP(value: float) -> float:
    """Centipoise to Pa s."""
    return value * 1e-3


def degree(value: float) -> float:
    """Degrees to rad."""
    return value * FACTORS["deg"]


def quantity(text: str) -> float:
    """A number with an optional unit ("300rpm", "0.1 mm", "40cP", "5e-5") in SI."""
    match = _QUANTITY.match(text)
    if match is None:
        raise ValueError(f"{text!r} is not a number with an optional unit, such as 300rpm or 0.1mm")
    number, unit = match.groups()
    if unit is None:
        return float(number)
    if unit not in FACTORS:
        raise ValueError(f"unknown unit {unit!r} in {text!r}; known: {', '.join(FACTORS)}")
    return float(number) * FACTORS[unit]
