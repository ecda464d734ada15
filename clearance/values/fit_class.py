"""Fits of the hole basis by ISO 286: clearances of a bearing from classes such as "H7/f7".

    hole    H:    0 to IT                          of the nominal diameter D, both in micrometres
    shaft   c..h: es - IT to es    js: -IT/2 to IT/2    k..s: ei to ei + IT
    diametral clearance: from EI - es to ES - ei; the radial one is half of it

Standard tolerances IT and fundamental deviations es, ei stand in tables by steps of the diameter.
Validity: D up to 500 mm, grades 5 to 11. Source: ISO 286-1:2010, tables 1 (IT), 4 and 5 (shafts).
"""

import bisect
import re
from dataclasses import dataclass

from clearance.values import checks
from clearance.values.units import quantity

LARGEST = 0.5  # nominal diameter [m]
SIGMAS = 6.0  # standard deviations of a dimension in its tolerance zone


def _table(text: str) -> dict[str, tuple[int, ...]]:
    """Rows of a table by their first words."""
    rows = map(str.split, text.strip().splitlines())
    return {name: tuple(map(int, numbers)) for name, *numbers in rows}


#: upper ends of the steps of the diameter [mm]
STEPS, FINE = _table("""
coarse 3 6 10 18 30 50 80 120 180 250 315 400 500
fine 3 6 10 18 30 40 50 65 80 100 120 140 160 180 200 225 250 280 315 355 400 450 500
""").values()
#: standard tolerances [um] by grade
TOLERANCES = {
    int(grade): row
    for grade, row in _table("""
 5 4 5 6 8 9 11 13 15 18 20 23 25 27
 6 6 8 9 11 13 16 19 22 25 29 32 36 40
 7 10 12 15 18 21 25 30 35 40 46 52 57 63
 8 14 18 22 27 33 39 46 54 63 72 81 89 97
 9 25 30 36 43 52 62 74 87 100 115 130 140 155
10 40 48 58 70 84 100 120 140 160 185 210 230 250
11 60 75 90 110 130 160 190 220 250 290 320 360 400
""").items()
}
#: distances of shafts from the zero line [um]: below it, then above
BELOW = _table("""
 c 60 70 80 95 110 120 130 140 150 170 180 200 210 230 240 260 280 300 330 360 400 440 480
 d 20 30 40 50 65 80 100 120 145 170 190 210 230
 e 14 20 25 32 40 50 60 72 85 100 110 125 135
 f 6 10 13 16 20 25 30 36 43 50 56 62 68
 g 2 4 5 6 7 9 10 12 14 15 17 18 20
 h 0 0 0 0 0 0 0 0 0 0 0 0 0
""")
#: k: of grades 4 to 7; 0 of coarser ones
ABOVE = _table("""
 k 0 1 1 1 2 2 2 3 3 4 4 4 5
 m 2 4 6 7 8 9 11 13 15 17 20 21 23
 n 4 8 10 12 15 17 20 23 27 31 34 37 40
 p 6 12 15 18 22 26 32 37 43 50 56 62 68
 r 10 15 19 23 28 34 34 41 43 51 54 63 65 68 77 80 84 94 98 108 114 126 132
 s 14 19 23 28 35 43 43 53 59 71 79 92 100 108 122 130 140 158 170 190 208 232 252
""")
SHAFTS = (*BELOW, "js", *ABOVE)
FINEST_K = 7
_CLASS = re.compile(r"\s*H(\d+)\s*/\s*([A-Za-z]+)(\d+)\s*(?:@\s*(\S.*?))?\s*$")


@dataclass(frozen=True)
class FitClass:
    """A fit: its name, nominal diameter and limits of the **radial** clearance [m].

    hole, shaft: lower and upper deviations of the diameters [m].
    """

    name: str
    diameter: float
    hole: tuple[float, float]
    shaft: tuple[float, float]

    @property
    def smallest(self) -> float:
        """Smallest radial clearance."""
        return 0.5 * (self.hole[0] - self.shaft[1])

    @property
    def largest(self) -> float:
        """Largest radial clearance."""
        return 0.5 * (self.hole[1] - self.shaft[0])

    @property
    def mean(self) -> float:
        """Mean radial clearance."""
        return 0.5 * (self.smallest + self.largest)

    @property
    def diametral(self) -> tuple[float, float]:
        """Smallest and largest clearance of the diameters."""
        return 2.0 * self.smallest, 2.0 * self.largest

    @property
    def deviation(self) -> float:
        """Standard deviation of the radial clearance: hole and shaft are independent and normal,
        each tolerance zone six of its deviations wide.
        """
        (a, b), (c, d) = self.hole, self.shaft
        return 0.5 * ((b - a) ** 2 + (d - c) ** 2) ** 0.5 / SIGMAS

    @property
    def value(self) -> "Fitted":
        """The mean radial clearance, with its fit."""
        return Fitted(self)

    def __str__(self) -> str:
        low, mean, high = (1e6 * v for v in (self.smallest, self.mean, self.largest))
        radial = f"radial clearance {low:g} to {high:g} um, mean {mean:g} um"
        return f"{self.name} at {1e3 * self.diameter:g} mm: {radial}"


class Fitted(float):
    """The mean radial clearance of a fit, `fit`."""

    fit: FitClass

    def __new__(cls, fit: FitClass):
        value = super().__new__(cls, fit.mean)
        value.fit = fit
        return value

    def __getnewargs__(self):
        return (self.fit,)


def is_fit_class(text: object) -> bool:
    """True for words of a fit, such as "H7/f7" or "H7/f7@20mm"."""
    return isinstance(text, str) and _CLASS.match(text) is not None


def has_diameter(name: str) -> bool:
    """True for a class with a diameter: "H7/f7@20mm"."""
    return "@" in name


def fit_class(name: str, diameter: float | str | None = None) -> FitClass:
    """The fit of a class at a nominal diameter [m], which the name may have: "H7/f7@20mm".

    Raises ValueError for other classes than H with shafts c to s of grades 5 to 11, for a diameter
    above 500 mm, and for a fit with interference.

    Example:

        >>> fit = cl.fit_class("H7/f7", "20 mm")
        >>> round(fit.smallest * 1e6, 1), round(fit.largest * 1e6, 1)
        (10.0, 31.0)
    """
    match = _CLASS.match(name)
    if match is None:
        raise ValueError(f"{name!r} is no fit of the hole basis, such as H7/f7")
    hole = match[1]
    letter = match[2]
    grade = match[3]
    inside = match[4]
    checks.known(f"{name}: no shaft", letter, SHAFTS)
    for g in (hole, grade):
        if int(g) not in TOLERANCES:
            raise ValueError(f"{name}: grade {g} is not one of 5 to 11")
    nominal = inside if inside is not None else diameter
    if nominal is None:
        raise ValueError(f"{name} needs a diameter: {name}@20mm")
    size = quantity(nominal, "m")
    size = checks.positive(f"{name}: diameter", size)
    if size > LARGEST * (1.0 + 1e-12):
        raise ValueError(f"{name}: diameters up to 500 mm have classes, got {1e3 * size:g} mm")
    plain = f"H{hole}/{letter}{grade}"
    low, high = (1e-6 * v for v in _shaft(letter, int(grade), size))
    fit = FitClass(plain, size, (0.0, 1e-6 * _of(TOLERANCES[int(hole)], size)), (low, high))
    if high > 0.0:
        raise ValueError(
            f"{plain} at {1e3 * size:g} mm has no clearance for sure: "
            f"{letter}{grade} interferes by up to {1e6 * high:g} um of the diameter"
        )
    return fit


def _of(table: tuple[int, ...], diameter: float) -> int:
    """The entry of a table for a diameter [m]; the end of a step belongs to it."""
    steps = FINE if len(table) == len(FINE) else STEPS
    return table[bisect.bisect_left(steps, round(1e3 * diameter, 9))]


def _shaft(letter: str, grade: int, diameter: float) -> tuple[float, float]:
    """Lower and upper deviations of a shaft [um]."""
    width = _of(TOLERANCES[grade], diameter)
    if letter == "js":
        return -0.5 * width, 0.5 * width
    if letter in BELOW:
        upper = -_of(BELOW[letter], diameter)
        return upper - width, upper
    lower = 0 if letter == "k" and grade > FINEST_K else _of(ABOVE[letter], diameter)
    return lower, lower + width
