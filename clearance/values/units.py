"""Units at the boundary: everything inside clearance is SI."""

import math
import re
from decimal import Decimal

from clearance.values.checks import meant

#: SI units, and the units that measure the same with their factors
_TABLE = f"""
m: m 1, cm 1e-2, mm 1e-3, um 1e-6, µm 1e-6, nm 1e-9
rad: rad 1, deg {math.pi / 180.0!r}
rad/s: rad/s 1, rpm {math.pi / 30.0!r}, deg/s {math.pi / 180.0!r}, Hz {2.0 * math.pi!r}
s: s 1, ms 1e-3, us 1e-6, min 60, h 3600
m/s: m/s 1, mm/s 1e-3
m/s2: m/s2 1, mm/s2 1e-3, gn 9.80665
Pa s: Pas 1, P 0.1, mPas 1e-3, cP 1e-3
m2/s: m2/s 1, mm2/s 1e-6, cSt 1e-6
1/s: 1/s 1
W: W 1, kW 1e3
J: J 1, kJ 1e3
K: K 1, degC 1
J/K: J/K 1
W/K: W/K 1
kg: kg 1, g 1e-3
kg m2: kgm2 1, kgmm2 1e-6, gmm2 1e-9, gcm2 1e-7
N: N 1, mN 1e-3, kN 1e3
N m: Nm 1, Nmm 1e-3, mNm 1e-3, kNm 1e3
N/m: N/m 1, MN/m 1e6, N/um 1e6, kN/m 1e3, N/mm 1e3
N s/m: Ns/m 1
N m/rad: Nm/rad 1
N m s/rad: Nms/rad 1
kg/m3: kg/m3 1
m2/N: m2/N 1, mm3/Nm 1e-9, m3/J 1
Pa: Pa 1, kPa 1e3
Pa/m: Pa/m 1, N/mm3 1e9
Pa: bar 1e5, MPa 1e6, GPa 1e9
"""
#: unit -> (SI unit it measures in, factor)
UNITS = {
    unit: (kind, float(factor))
    for kind, units in (line.split(": ") for line in _TABLE.strip().splitlines())
    for unit, factor in map(str.split, units.split(", "))
}
#: zero of a unit in SI
ZEROS = {"degC": 273.15}
#: units in which people think of numbers in SI, coarse to fine
READ_AS = {"rad/s": ("rpm",), "m": ("mm", "um"), "Pa s": ("cP",)}
KINEMATIC = "m2/s"
ROUGH = "Ra", "Rq"
RQ_OVER_RA = math.sqrt(0.5 * math.pi)
_KINDS = {kind for kind, _ in UNITS.values()}

#: most digits of a decimal factor
DECIMAL_DIGITS = 6
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_UNIT = r"[A-Za-zµ°][\w/.µ°*·^ ]*|(?<=\s)1/\w+"
_BETWEEN = str.maketrans("²³", "23", " .*·^")  # signs in units that change nothing
_QUANTITY = re.compile(rf"\s*([-+]?{_NUMBER})\s*({_UNIT})?\s*$")
_WITH_UNIT = re.compile(rf"{_NUMBER}\s*({_UNIT})")


def rpm(value: float) -> float:
    """Revolutions per minute to rad/s."""
    return si(value, "rpm")


def mm(value: float) -> float:
    """Millimetres to m."""
    return si(value, "mm")


def um(value: float) -> float:
    """Micrometres to m."""
    return si(value, "um")


def cP(value: float) -> float:
    """Centipoise to Pa s."""
    return si(value, "cP")


def degree(value: float) -> float:
    """Degrees to rad."""
    return si(value, "deg")


def behind(units: str) -> str:
    """Units as they stand behind a number; "" where there are none."""
    return "" if units in ("", "-", "1", "?") else f" {units}"


def shown(value: object, units: str) -> str:
    """A value in SI with its units, and in those that people think in: "300 rad/s (2865 rpm)"."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        return str(value)
    text = f"{value:g}{behind(units)}"
    scaled = [(value / UNITS[unit][1], unit) for unit in READ_AS.get(units, ())]
    if not value or not scaled:
        return text
    number, unit = next((pair for pair in scaled if abs(pair[0]) >= 0.1), scaled[-1])
    return f"{text} ({number:.4g} {unit})"


def quantity(text: str | float, units: str | None = None) -> float:
    """A number with an optional unit ("300rpm", "0.1 mm", "40cP", "5e-5") in SI; one without text
    as it is.

    units: the expected SI unit; a unit of another kind raises ValueError (kinds that this table
        lacks pass). "46cSt@870kg/m3" is a viscosity, of an oil with this density; "Ra0.4um+Ra0.8um"
        the rms roughness of two surfaces together, see `rough`.
    """
    if not isinstance(text, str):
        return text
    if text.lstrip().startswith(ROUGH):
        return rough(text, units)
    kinematic, at, heavy = text.partition("@")
    if at:
        return quantity(kinematic, KINEMATIC) * quantity(heavy, "kg/m3")
    match = _QUANTITY.match(text)
    if match is None:
        raise ValueError(f"{text!r} is not a number with an optional unit, such as 300rpm or 0.1mm")
    number, unit = match.groups()
    if unit is None:
        return float(number)
    unit = "gn" if units == "m/s2" and unit == "g" else plain(unit)
    if unit not in UNITS:
        listed = [u for u, (kind, _) in UNITS.items() if kind == units] or UNITS
        raise ValueError(
            f"unknown unit {unit!r} in {text!r}{meant(unit, listed)}; known: {', '.join(listed)}"
        )
    kind, factor = UNITS[unit]
    if units is not None and units != kind and (units in _KINDS or units in ("-", "1")):
        expected = units if units in _KINDS else "a plain number"
        hint = f"; with a density: {number}{unit}@870kg/m3" if kind == KINEMATIC else ""
        raise ValueError(f"{text!r} is in {kind}, expected {expected}{hint}")
    return scaled_by(number, factor) + ZEROS.get(unit, 0.0)


def rough(text: str, units: str | None = None) -> float:
    """Composite rms roughness [m] of surfaces, such as "Ra0.4um+Rq0.8um".

    sigma = sqrt(R_q1^2 + R_q2^2), R_q = sqrt(pi / 2) R_a

    Valid for Gaussian heights; real surfaces have R_q of 1.1 to 1.35 R_a. Raises ValueError for
    other texts, and where no length is expected.
    Source: ISO 21920-2 (2021) for R_a and R_q; Thomas, Rough Surfaces, 2nd ed. (1999).
    """
    parts = [part.strip() for part in text.split("+")]
    if not all(part.startswith(ROUGH) for part in parts) or units not in (None, "m"):
        expected = "" if units in (None, "m") else f"; expected {units}"
        raise ValueError(f"{text!r}: a roughness [m] is written as Ra0.4um+Ra0.8um{expected}")
    factors = (RQ_OVER_RA if part.startswith("Ra") else 1.0 for part in parts)
    return math.hypot(*(f * quantity(p[2:], "m") for f, p in zip(factors, parts, strict=True)))


def plain(unit: str) -> str:
    """A unit without signs of multiplication: "N m" and "N*m" are "Nm", "°C" is "degC"."""
    return unit.replace("°", "deg").translate(_BETWEEN)


def unit_in(text: str) -> str:
    """The first unit in words of numbers, such as "60rpm:120rpm:5"; empty where there is none."""
    units = (plain(match[1]) for match in _WITH_UNIT.finditer(text))
    return next((unit for unit in units if unit in UNITS), "")


def written(value: object, unit: str, digits: int = 5) -> str:
    """A value in SI in a unit of `UNITS`; without one as it stands, and so what is no number."""
    if not isinstance(value, float):
        return str(value)
    if not unit:
        return f"{value:.{digits}g}"
    return f"{(value - ZEROS.get(unit, 0.0)) / UNITS[unit][1]:.{digits}g} {unit}"


def amount(value: object, units: tuple[str, ...] = ()) -> object:
    """A number as it is, or from a text with a unit, which must be one of these; vectors too."""
    if isinstance(value, list | tuple):
        return tuple(amount(v, units) for v in value)
    if not isinstance(value, str):
        return value
    for unit in units[1:]:
        try:
            return quantity(value, unit)
        except ValueError:
            continue
    return quantity(value, units[0] if units else None)


def labelled(label: str, value: object, units: tuple[str, ...]) -> object:
    """The amount of a field, which an error names."""
    try:
        return amount(value, units)
    except ValueError as error:
        raise ValueError(f"{label}: {error}") from None


def slip(value: float, units: str, low: float, high: float) -> str:
    """A question, "; 0.06 mm?", where a number lies in a range once it has another unit; else
    nothing.
    """
    others = READ_AS.get(units) or [u for u in reversed(UNITS) if UNITS[u] != (units, 1.0)]
    fits = [u for u in others if UNITS[u][0] == units and low <= value * UNITS[u][1] <= high]
    return f"; {value:g} {fits[0]}?" if fits else ""


def unusual(field: str, value: object, units: str, low: float, high: float) -> str | None:
    """A warning that names the likely unit, for a number other than 0 beyond its usual range."""
    if not isinstance(value, int | float) or not value or low <= abs(value) <= high:
        return None
    between = f"up to {high:g}" if not low else f"{low:g} to {high:g}"
    return f"{field} is {value:g} {units}, usual is {between}{slip(abs(value), units, low, high)}"


def si(value: float, unit: str) -> float:
    """A value in a unit of `UNITS` in SI, as `quantity` reads it; arrays element by element."""
    factor = UNITS[unit][1]
    return value * factor if hasattr(value, "__len__") else scaled_by(repr(float(value)), factor)


def scaled_by(number: str, factor: float) -> float:
    """A decimal number times a factor; rounded once where the factor is decimal, as 1e-6 is."""
    exact = Decimal(repr(factor))
    if len(exact.as_tuple().digits) > DECIMAL_DIGITS:
        return float(number) * factor
    return float(Decimal(number) * exact)
