"""The points of a sweep: grids, lists that go together, samples, and products of these."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain, repeat
from typing import Any

import numpy as np

from clearance.values import checks
from clearance.values.even_points import latin
from clearance.values.units import labelled, unit_in, written

KINDS = ("latin", "random")
Axis = tuple[str, ...]
# not in the brackets of a law such as impact(damping=1,depth=2)
OUTER_COMMA = re.compile(r",(?![^(]*\))")


@dataclass(frozen=True)
class Points:
    """Values of the swept parameters, point by point.

    columns: name -> one value a point; axes: what varies together, with its number of values:
        (("speed",), 20), (("clearance",), 10) for a grid of 200 points, the last axis fastest;
        units: in which sentences show values, where these are not SI.
    """

    columns: dict[str, tuple]
    axes: tuple[tuple[Axis, int], ...]
    sampled: bool = False
    units: dict[str, str] = field(default_factory=dict, compare=False)

    def __post_init__(self):
        for name, values in self.columns.items():
            if len(values) != len(self):
                raise ValueError(f"points: {name} has {len(values)} values for {len(self)} points")

    def __len__(self) -> int:
        return math.prod(count for _, count in self.axes)

    def __getitem__(self, index: int) -> dict[str, object]:
        return {name: values[index] for name, values in self.columns.items()}

    @property
    def drawn(self) -> tuple[str, ...]:
        """Parameters that were drawn rather than spread: no axis bears their names."""
        named = {n for names, _ in self.axes for n in names}
        return tuple(n for n in self.columns if n not in named)

    @property
    def along(self) -> dict[str, tuple]:
        """Values along the axis that bears each parameter."""
        columns: dict[str, tuple] = {}
        stride = len(self)
        for names, count in self.axes:
            stride //= count
            columns |= {n: self.columns[n][: stride * count : stride] for n in names}
        return {name: columns[name] for name in self.columns}

    def varying(self, names: Axis) -> Axis:
        """Parameters that vary along an axis: those it is named after, or of samples those that
        were drawn.
        """
        return self.drawn or names if names == ("run",) else names

    def __mul__(self, other: "Points") -> "Points":
        """Every point of one with every point of the other."""
        if twice := sorted(self.columns.keys() & other.columns.keys()):
            raise ValueError(f"points: {twice[0]} is swept twice")
        if self.sampled and other.sampled:
            raise ValueError("points: draw all parameters in one call of sampled")
        if (count := len(self) * len(other)) > MOST:
            raise ValueError(f"points: {count} are too many, a sweep has at most {MOST}")
        columns = {
            n: tuple(v for v in values for _ in range(len(other)))
            for n, values in self.columns.items()
        }
        columns |= {n: tuple(values) * len(self) for n, values in other.columns.items()}
        drawn = self.sampled or other.sampled
        return Points(columns, self.axes + other.axes, drawn, self.units | other.units)

    def typed(self, parameters: Mapping) -> "Points":
        """Values of the kinds that the case declares; drawn integers are rounded, texts with units
        are numbers.

        parameters: of the case, by name. Raises ValueError for what is no such value.
        """
        columns = {
            n: tuple(plain(parameters[n], v, self.sampled) for v in vs)
            for n, vs in self.columns.items()
        }
        texts = {n: vs[0] for n, vs in self.columns.items() if vs and isinstance(vs[0], str)}
        units = {n: u for n, v in texts.items() if columns[n][0] != v and (u := unit_in(v))}
        return replace(self, columns=columns, units=units | self.units)


def in_words(values: dict[str, object], units: dict[str, str]) -> str:
    """A point in words: "speed=300 rpm, clearance=0.0001"; units: in which its values are shown."""
    return ", ".join(f"{n}={written(v, units.get(n, ''))}" for n, v in values.items())


def spread_out(columns: dict[str, tuple], axes: tuple[tuple[Axis, int], ...]) -> dict[str, tuple]:
    """Values of each point; columns with those along an axis are repeated."""
    total, stride = math.prod(count for _, count in axes), 1
    bearers: dict[str, tuple[int, int]] = {}
    for names, count in reversed(axes):
        bearers |= dict.fromkeys(names, (count, stride))
        stride *= count
    spread = {}
    for name, values in columns.items():
        count, stride = bearers.get(name, (total, 1))
        if len(values) == count < total:
            once = chain.from_iterable(repeat(value, stride) for value in values)
            values = tuple(once) * (total // (count * stride))
        spread[name] = values
    return spread


def plain(parameter: Any, value: Any, drawn: bool = False) -> Any:
    """A value of a parameter of a case: 10 for a float is 10.0, and "0.1 mm" is 1e-4, so that it is
    the same point however it was written.
    """
    name, kind = parameter.name, parameter.kind
    value = value.item() if hasattr(value, "item") else value
    if kind is float and isinstance(value, str):
        value = parameter.value(value)
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if kind is str and isinstance(value, bool):  # a choice with the words true and false
        return str(value).lower()
    if kind is float and number:
        return checks.finite(name, float(value))
    if kind is int and number:
        if drawn:
            return round(value)
        if value != int(value):
            raise ValueError(f"{name}: {value!r} is not a whole number")
        return int(value)
    if kind in (float, int, bool, str) and not isinstance(value, kind):
        raise ValueError(f"{name}: expected a {kind.__name__}, got {value!r}")
    if not isinstance(value, int | float | str | bool):
        raise TypeError(f"{name}: a sweep keeps numbers and texts, got {value!r}")
    return value


ONE = Points({}, ())
MOST = 1_000_000  # values of a range, and points of a sweep


def _values(name: str, entries: object, distinct: bool = True) -> tuple:
    if isinstance(entries, str) or not isinstance(entries, Sequence | np.ndarray):
        entries = (entries,)
    values = tuple(v.item() if isinstance(v, np.generic) else v for v in entries)
    if not values:
        raise ValueError(f"{name}: the range is empty; give at least one value")
    for value in values:
        if isinstance(value, float):
            checks.finite(name, value)
        elif not isinstance(value, int | str):
            raise TypeError(f"{name}: a value must be a number or a text, got {value!r}")
    if distinct and len(set(values)) != len(values):
        raise ValueError(f"{name}: a value stands twice in {', '.join(map(str, values))}")
    return values


def grid(**values) -> Points:
    """Every combination of the values of each parameter, SI units: `grid(speed=[20, 30],
    clearance=np.geomspace(...))`.

    Raises ValueError for an empty range, a value that stands twice or is not finite.

    Example:

        >>> points = cl.grid(speed=[20.0, 30.0], clearance=[1e-5, 2e-5])
        >>> len(points), points[1]
        (4, {'speed': 20.0, 'clearance': 2e-05})
    """
    points = ONE
    for name, entries in values.items():
        axis = _values(name, entries)
        points = points * Points({name: axis}, (((name,), len(axis)),))
    return points


def zipped(**values) -> Points:
    """Lists of the same length that go together: the first of each, then the second of each.

    Raises ValueError for none, and for lists of different lengths.

    Example:

        >>> cl.zipped(speed=[20.0, 30.0], clearance=[1e-5, 2e-5])[1]
        {'speed': 30.0, 'clearance': 2e-05}
    """
    if not values:
        raise ValueError("zipped: give lists of at least one value")
    columns = {n: _values(n, entries, distinct=False) for n, entries in values.items()}
    lengths = {n: len(v) for n, v in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(
            f"zipped: lists of different lengths: "
            f"{', '.join(f'{n} {k}' for n, k in lengths.items())}"
        )
    rows = list(zip(*columns.values(), strict=True))
    if len(set(rows)) != len(rows):
        raise ValueError("zipped: a point stands twice")
    return Points(columns, ((tuple(columns), len(rows)),))


def sampled(count: int, *, kind: str = "latin", seed: int = 0, **ranges) -> Points:
    """Points drawn from a box, for each parameter its (low, high), or (low, high, "log") for a
    logarithmic one.

    kind: "latin" (Latin hypercube: each parameter is spread evenly) or "random"; seed: the same
        seed, the same points. A list in place of a range is drawn from evenly.
    Raises ValueError for bad ranges.

    Example:

        >>> len(cl.sampled(8, clearance=(1e-5, 1e-4, "log")))
        8
    """
    checks.one_of("sample", kind, KINDS)
    checks.whole("count", count, 1)
    if not ranges:
        raise ValueError("sampled: give at least one range, such as speed=(20.0, 40.0)")
    box = {name: _Range.of(name, bounds) for name, bounds in ranges.items()}
    random = np.random.default_rng(seed)
    unit = (
        latin(count, len(box), *random.spawn(1))
        if kind == "latin"
        else random.random((count, len(box)))
    )
    columns = {name: tuple(map(r, unit[:, i])) for i, (name, r) in enumerate(box.items())}
    return Points(columns, ((("run",), count),), sampled=True)


@dataclass(frozen=True)
class _Range:
    """Takes [0, 1) to the values of a parameter."""

    low: float = 0.0
    high: float = 0.0
    log: bool = False
    choice: tuple = ()

    @classmethod
    def of(cls, name: str, bounds) -> "_Range":
        if isinstance(bounds, list | np.ndarray):
            return cls(choice=_values(name, bounds))
        if (
            not isinstance(bounds, tuple)
            or len(bounds) not in (2, 3)
            or (len(bounds) == 3 and bounds[2] != "log")
        ):
            raise ValueError(
                f'{name}: expected (low, high) or (low, high, "log") or a list to draw from, got '
                f"{bounds!r}"
            )
        low, high = (checks.finite(name, labelled(name, end, ())) for end in bounds[:2])
        if not low < high:
            raise ValueError(f"{name}: the range from {low:g} to {high:g} is empty")
        if len(bounds) == 3 and low <= 0.0:
            raise ValueError(
                f"{name}: a logarithmic range must be positive, got {low:g} to {high:g}"
            )
        return cls(low, high, len(bounds) == 3)

    def __call__(self, share: float):
        if self.choice:
            return self.choice[int(share * len(self.choice))]
        if self.log:
            return float(self.low * (self.high / self.low) ** share)
        return float(self.low + (self.high - self.low) * share)


def from_words(parameter, text: str) -> list:
    """Values of a case parameter from the command line: LO:HI:N, LO:HI:N:log, or a list with commas
    or semicolons.

    parameter: a catalogue.Parameter with its units. Raises ValueError naming the parameter and what
        was given.
    """
    if ":" in text and parameter.kind in (float, int):
        return _spread(parameter, text)
    parts = text.removesuffix(";").split(";") if ";" in text else OUTER_COMMA.split(text)
    parts = [p.strip() for p in parts]
    if not all(parts):
        raise ValueError(f"{parameter.name}: {text!r} has an empty value")
    return [parameter.value(p) for p in parts]


def range_from_words(parameter, text: str):
    """A range to draw from, LO:HI or LO:HI:log, or a list, from the command line."""
    parts = text.split(":")
    if len(parts) == 1:
        return from_words(parameter, text)
    if len(parts) > 3 or (len(parts) == 3 and parts[2] != "log"):
        raise ValueError(
            f"{parameter.name}: a range to draw from is LO:HI or LO:HI:log, got {text!r}"
        )
    return (parameter.value(parts[0]), parameter.value(parts[1]), *parts[2:])


def _spread(parameter, text: str) -> list:
    parts = text.split(":")
    if len(parts) not in (3, 4) or (len(parts) == 4 and parts[3] != "log"):
        raise ValueError(f"{parameter.name}: a range is LO:HI:N or LO:HI:N:log, got {text!r}")
    low, high = (float(parameter.value(p)) for p in parts[:2])
    if not parts[2].isdigit() or int(parts[2]) < 1:
        raise ValueError(
            f"{parameter.name}: the range {text!r} is empty; N must be a whole number of at least 1"
        )
    count, log = int(parts[2]), len(parts) == 4
    if count > MOST:
        raise ValueError(
            f"{parameter.name}: {count} values are too many, at most {MOST} stand in a range"
        )
    if log and min(low, high) <= 0.0:
        raise ValueError(f"{parameter.name}: a logarithmic range must be positive, got {text!r}")
    if count == 1 and low != high:
        raise ValueError(
            f"{parameter.name}: a range of one value must begin where it ends, got {text!r}"
        )
    values = np.geomspace(low, high, count) if log else np.linspace(low, high, count)
    spread = [round(v) if parameter.kind is int else float(v) for v in values]
    if len(set(spread)) < count > 1:
        raise ValueError(f"{parameter.name}: there are no {count} different values in {text!r}")
    return spread
