"""Mineral oils by their grade and temperature: viscosity, density, pressure-viscosity coefficient.

    mu(T) = mu_40 exp(B / (T + 95) - B / 135),   B = 159.56 ln(mu_40 / 0.18 mPa s)
    rho(T) = 870 kg/m3 (1 - 7.4e-4 (T - 15)),   alpha = (0.6 + 0.965 log10(mu / 1 mPa s)) 1e-8 /Pa

T in degrees Celsius, mu_40 at 40 C from the viscosity that defines the grade. This is Vogel's law
with Cameron's 95 C. Its numbers are those of German standards for plain bearings. At 100 C they
meet oils with a viscosity index of about 100 within 3 %. A grade leaves 10 % of viscosity open (SAE
15 to 20 %). The density is a paraffinic oil's (2 %). alpha is within 20 % of paraffinic oils, up to
35 % below naphthenic ones. Multigrade oils are none of these. From -10 C to 150 C.

Sources: ISO 3448 (1992), viscosity at 40 C. SAE J300 (2015), limits at 100 C, of which the middle
is taken. Vogel, Physikalische Zeitschrift 22 (1921) 645; Cameron, Principles of Lubrication (1966).
Wooster's alpha and values to compare with: Stachowiak and Batchelor, Engineering Tribology, ch. 2.
"""

import math

from clearance.laws.materials import HeatBalance, Lubricant
from clearance.values import checks

THINNEST, SLOPE, ZERO, WARM = 1.8e-4, 159.56, -95.0, 40.0  # [Pa s, K, C, C] of the law
COLDEST, HOTTEST = -10.0, 150.0
DENSITY, EXPANSION, CELSIUS = 870.0, 7.4e-4, 273.15
#: kinematic viscosity at 40 C [mm2/s]
ISO_VG = (10, 15, 22, 32, 46, 68, 100, 150, 220, 320, 460)
#: least and largest kinematic viscosity at 100 C [mm2/s]
SAE = {
    8: (4.0, 6.1),
    12: (5.0, 7.1),
    16: (6.1, 8.2),
    20: (6.9, 9.3),
    30: (9.3, 12.5),
    40: (12.5, 16.3),
    50: (16.3, 21.9),
    60: (21.9, 26.1),
}
#: name -> temperature [C] and kinematic viscosity [mm2/s] that define the grade
GRADES = {f"ISO VG {n}": (40.0, float(n)) for n in ISO_VG} | {
    f"SAE {n}": (100.0, 0.5 * (low + high)) for n, (low, high) in SAE.items()
}


def density(temperature: float) -> float:
    """Of the oil [kg/m3] at a temperature [C]."""
    return DENSITY * (1.0 - EXPANSION * (temperature - 15.0))


def _share(temperature: float) -> float:
    """ln(mu / THINNEST) over that at 40 C."""
    return 1.0 + SLOPE * (1.0 / (temperature - ZERO) - 1.0 / (WARM - ZERO))


def _warm(name: str) -> float:
    """ln(mu_40 / THINNEST) of a grade. Raises ValueError for an unknown one."""
    letters = str(name).upper().replace("ISO", "").replace("VG", "ISO VG ")
    grade = " ".join(letters.replace("-", " ").replace("_", " ").split())
    if grade not in GRADES:
        raise ValueError(
            f"oil: no grade {name!r}{checks.meant(grade, GRADES)}; it has {', '.join(GRADES)}"
        )
    at, kinematic = GRADES[grade]
    return math.log(1e-6 * kinematic * density(at) / THINNEST) / _share(at)


def coefficient(viscosity: float) -> float:
    """Pressure-viscosity coefficient [1/Pa] of an oil of this viscosity [Pa s]."""
    return max(0.6 + 0.965 * math.log10(1e3 * viscosity), 0.0) * 1e-8


def celsius(text: str) -> float:
    """Degrees Celsius of a text such as 60, 60C, "60 degC" or 333K. Raises ValueError."""
    number = text.strip().rstrip("CcKk").rstrip("°").removesuffix("deg")
    try:
        return float(number) - (CELSIUS if text.strip()[-1:] in ("k", "K") else 0.0)
    except ValueError:
        form = "a temperature is a number of C or K, as 60C"
        raise ValueError(f"oil: {form}; got {text!r}") from None


def oil(name: str, *, temperature: float | str = 40.0) -> Lubricant:
    """The oil of a grade, such as "ISO VG 46" or "SAE 30", at a temperature [C], which may be
    a text such as "60 degC" or "333K".

    Raises ValueError for an unknown grade, and outside -10 to 150 C.

    Example:

        >>> round(cl.oil("ISO VG 46", temperature=60).viscosity, 3)
        0.017
    """
    warm = _warm(name)
    if isinstance(temperature, str):
        temperature = celsius(temperature)
    if not COLDEST <= checks.finite("oil: temperature", temperature) <= HOTTEST:
        between = f"must lie in [{COLDEST:g}, {HOTTEST:g}] degrees Celsius"
        raise ValueError(f"oil: temperature {between}, got {temperature!r}")
    viscosity = THINNEST * math.exp(warm * _share(temperature))
    return Lubricant(viscosity, coefficient(viscosity))


def oil_named(text: str) -> Lubricant:
    """The oil of a text such as "ISO-VG-46@60C"; without a temperature at that of its grade."""
    name, apart, at = (part.strip() for part in str(text).partition("@"))
    if not apart:
        return oil(name, temperature=100.0 if name.upper().startswith("SAE") else WARM)
    return oil(name, temperature=at)


def oil_heat(name: str, *, temperature: float, **balance) -> HeatBalance:
    """The balance of heat of this oil, which begins at a temperature [C]; the other arguments are
    those of HeatBalance, in SI.
    """
    numbers = {"vogel": SLOPE * _warm(name), "vogel_zero": CELSIUS + ZERO}
    return HeatBalance(surroundings=CELSIUS + temperature, **numbers | balance)
