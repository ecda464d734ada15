"""Bodies and points on them: frozen descriptions in SI units."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from clearance.elements.quantities import ZERO, Described, Number, Row, number, optional, start
from clearance.laws.materials import Material, steel
from clearance.values import checks
from clearance.values.units import labelled

#: coordinates of a body: its centre of mass and its angle
ABSOLUTE = ("x", "y", "angle")
#: of a point in the frame of its body
PLACE = Number("place [m]", checks.point, usual=((0.0, 100.0),))


@dataclass(frozen=True)
class Point:
    """A point fixed on a body, coordinates in the body's frame [m]; z points out of the plane of
    motion.
    """

    body: "Body"
    name: str
    x: float
    y: float
    z: float = 0.0

    def __repr__(self) -> str:
        return f"{self.body.name}[{self.name!r}]"

    def numbers(self, name: str) -> Iterator[Row]:
        """Its place from the centre of mass of its body, among the numbers of the kernel."""
        com = (*self.body.com, 0.0)
        for axis, value, centre in zip("xyz", (self.x, self.y, self.z), com, strict=False):
            yield f"{name}/{axis}", value - centre, ZERO


@checks.answers
@dataclass(frozen=True, eq=False)
class Body(Described):
    """A rigid body.

    name; mass [kg] > 0; inertia about the centre of mass [kg m2] > 0; points: named points (x, y)
    in the body's own frame [m]; com: centre of mass in that frame [m]. `body["pin"]` is the named
    point. The motion is planar, the masses need not be. Points and com may have a third coordinate
    z. products are the products of inertia (integral of x z dm, of y z dm) about the centre of mass
    [kg m2]. They cause axial forces and bending moments. A rough start helps the assembly to find
    the intended configuration: angle [rad] of the body's frame, position (x, y) of its origin [m]
    (default: along the joints). What no drive prescribes and no loop decides starts as given here,
    wherever the loops close so. angular_velocity [rad/s] and velocity (of the centre of mass, m/s)
    start the motions that no drive prescribes. Where none is given, a body rests relative to the
    one that carries it; a 0 is given.

    Example:

        >>> pins = {"B": (-0.06, 0), "C": (0.06, 0)}
        >>> rod = cl.Body("rod", mass="0.2 kg", inertia=3e-4, points=pins)
        >>> rod["C"].x
        0.06
    """

    name: str
    mass: float = number("mass [kg]", checks.positive, usual=((1e-9, 1e6),))
    inertia: float = number("moment of inertia [kg m2]", checks.positive, usual=((1e-18, 1e8),))
    points: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    com: tuple[float, ...] = number("centre of mass [m]", checks.point, (0.0, 0.0), parameter=False)
    products: tuple[float, float] = number(
        "products of inertia [kg m2]", checks.pair, (0.0, 0.0), fold=ZERO, parts=("xz", "yz")
    )
    angle: float = start("rough start angle [rad]")
    position: tuple[float, float] | None = optional("rough start [m]", checks.pair)
    angular_velocity: float | None = optional("at the start [rad/s]", checks.finite)
    velocity: tuple[float, float] | None = optional("at the start [m/s]", checks.pair)

    def __post_init__(self):
        checks.identifier("body name", self.name)
        if self.name == "ground":
            raise ValueError("body name 'ground' is taken by the frame; choose another")
        self._check_fields()
        if not isinstance(self.points, Mapping):
            raise TypeError(
                f"body {self.name}: points must map names to (x, y), got {self.points!r}"
            )
        points = {
            p: PLACE.checked(f"body {self.name}: point {p!r}", xyz)
            for p, xyz in self.points.items()
        }
        self._set("points", MappingProxyType(points))

    @classmethod
    def bar(
        cls,
        name: str,
        points: Mapping[str, float],
        section: float | tuple[float, float],
        *,
        material: Material | str = steel,
        length: float | None = None,
        **more,
    ) -> "Body":
        """A straight bar along x, with the mass properties of its section.

        points: places along the bar [m], by name; length [m]: default from the first to the last
        of them, which it goes beyond by as much at both ends. section: diameter, or width and
        height in the plane of motion [m]. more: other fields of a body.

            m = rho A L,   J = m (L^2 / 12 + k^2),   k = d / 4 or h / sqrt(12)

        Raises ValueError for sizes that are not positive.
        """
        label = f"body {name}"
        points = {n: number_of(f"{label}: point {n!r}", x) for n, x in points.items()}
        sizes = section if isinstance(section, tuple | list) else (section,)
        sizes = [number_of(f"{label}: section", s, checks.positive) for s in sizes]
        first = min(points.values(), default=0.0)
        last = max(points.values(), default=0.0)
        length = last - first if length is None else number_of(f"{label}: length", length)
        checks.positive(f"{label}: length", length)
        if len(sizes) == 1:
            area = 0.25 * math.pi * sizes[0] ** 2
            radius = 0.25 * sizes[0]
        elif len(sizes) == 2:
            area = sizes[0] * sizes[1]
            radius = sizes[1] / math.sqrt(12.0)
        else:
            raise ValueError(f"{label}: section must be a diameter, or width and height")
        mass = Material.of(label, "material", material).density * area * length
        places = {n: (x, 0.0) for n, x in points.items()}
        more = {"com": (0.5 * (first + last), 0.0), "points": places} | more
        return cls(name, mass, mass * (length**2 / 12.0 + radius**2), **more)

    @classmethod
    def plate(
        cls,
        name: str,
        outline: Sequence[tuple[float, float]],
        thickness: float,
        *,
        holes: Sequence[tuple[float, float, float]] = (),
        material: Material | str = steel,
        **more,
    ) -> "Body":
        """A flat plate with the mass properties of its outline.

        outline: corners (x, y) in the frame of the body [m], in turn. holes: round ones, (x, y,
        radius) [m]. thickness [m]. more: other fields of a body, points among them.

            A = sum c / 2,   x_c = sum (x_i + x_j) c / (6 A),   c = x_i y_j - x_j y_i

        Raises ValueError for an outline without an area, and for holes that leave no mass.
        """
        label = f"body {name}"
        thickness = number_of(f"{label}: thickness", thickness, checks.positive)
        corners = [PLACE.checked(f"{label}: outline", xy) for xy in outline]
        pieces = [_polygon(corners)]
        for hole in holes:
            try:
                x, y, r = (number_of(f"{label}: hole", v) for v in hole)
            except (TypeError, ValueError):
                raise ValueError(f"{label}: a hole is (x, y, radius) [m], got {hole!r}") from None
            area = -math.pi * checks.positive(f"{label}: radius of a hole", r) ** 2
            pieces.append((area, area * x, area * y, area * (x * x + y * y + 0.5 * r * r)))
        area, by_x, by_y, polar = map(sum, zip(*pieces, strict=True))
        if not area > 0.0:
            raise ValueError(f"{label}: outline and holes leave an area of {area:g} m2")
        x, y = by_x / area, by_y / area
        heavy = Material.of(label, "material", material).density * thickness
        more = {"com": (x, y)} | more
        return cls(name, heavy * area, heavy * (polar - area * (x * x + y * y)), **more)

    def label(self) -> str:
        """Name of the body in messages."""
        return f"body {self.name}"

    def doubts(self) -> list[str]:
        """Warnings about its numbers and points."""
        far = {p: max(map(abs, xyz)) for p, xyz in self.points.items()}
        texts = [PLACE.doubt(f"{self.label()}: point {p!r}", size) for p, size in far.items()]
        return super().doubts() + [t for t in texts if t]

    def __getstate__(self) -> dict:
        return {**vars(self), "points": dict(self.points)}

    def __setstate__(self, state: dict) -> None:
        vars(self).update(state, points=MappingProxyType(state["points"]))

    def __getitem__(self, name: str) -> Point:
        if name not in self.points:
            raise KeyError(
                f"body {self.name} has no point {name!r}"
                f"{checks.meant(name, self.points)}; it has {sorted(self.points)}"
            )
        return Point(self, name, *self.points[name])

    @property
    def key(self) -> str:
        """Places of the body's numbers in the parameter vector."""
        return f"bodies/{self.name}"

    def at(self, x: float, y: float, z: float = 0.0) -> Point:
        """An unnamed point of the body's frame."""
        point = PLACE.checked(f"point of {self.name}", (x, y, z))
        return Point(self, f"({', '.join(f'{float(v):g}' for v in point)})", *point)

    def __repr__(self) -> str:
        return f"Body({self.name!r})"


def number_of(label: str, value: float | str, check: Callable = checks.finite) -> float:
    """A length of a body [m], which may have a unit."""
    return check(label, labelled(label, value, ("m",)))


def _polygon(corners: Sequence[tuple[float, ...]]) -> tuple[float, float, float, float]:
    """Area of a polygon and its moments: of x, of y, and of x^2 + y^2 about the origin."""
    sums = [0.0, 0.0, 0.0, 0.0]
    for (x, y), (u, v) in zip(corners, [*corners[1:], *corners[:1]], strict=True):
        cross = x * v - u * y
        polar = x * x + x * u + u * u + y * y + y * v + v * v
        parts = (cross / 2.0, (x + u) * cross / 6.0, (y + v) * cross / 6.0, polar * cross / 12.0)
        sums = [total + part for total, part in zip(sums, parts, strict=True)]
    sign = math.copysign(1.0, sums[0])
    return tuple(sign * total for total in sums)


class Ground(Body):
    """The fixed frame. `ground.at(x, y)` is a point of it; `ground` alone its origin."""

    def __init__(self):
        for name, value in {
            "name": "ground",
            "points": {},
            "com": (0.0, 0.0),
            "products": (0.0, 0.0),
            "angle": 0.0,
            "position": (0.0, 0.0),
            "mass": float("inf"),
            "inertia": float("inf"),
            "angular_velocity": 0.0,
            "velocity": (0.0, 0.0),
        }.items():
            object.__setattr__(self, name, value)

    def __reduce__(self):
        return "ground"

    def __repr__(self) -> str:
        return "ground"


ground = Ground()


def as_point(owner: str, value: object) -> Point:
    """A point, or a body standing for the origin of its frame."""
    if isinstance(value, Point):
        return value
    if isinstance(value, Body):
        return Point(value, "origin", 0.0, 0.0)
    raise TypeError(
        f"{owner}: expected a point such as crank['pin'] or ground.at(x, y), got {value!r}"
    )
