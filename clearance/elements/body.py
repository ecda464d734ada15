"""Bodies and points on them: frozen descriptions in SI units."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from clearance.elements.quantities import ZERO, Described, Number, Row, number
from clearance.values import checks

#: coordinates of a body: its centre of mass and its angle
ABSOLUTE = ("x", "y", "angle")
#: of a point in the frame of its body
PLACE = Number("place [m]", checks.place, usual=((0.0, 100.0),))


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
    """

    name: str
    mass: float = number("mass [kg]", checks.positive, usual=((1e-9, 1e6),))
    inertia: float = number("moment of inertia [kg m2]", checks.positive, usual=((1e-18, 1e8),))
    points: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    com: tuple[float, ...] = number("centre of mass [m]", checks.place, (0.0, 0.0), parameter=False)
    products: tuple[float, float] = number(
        "products of inertia [kg m2]", checks.pair, (0.0, 0.0), fold=ZERO, parts=("xz", "yz")
    )
    angle: float = number("rough start angle [rad]", checks.finite, 0.0, parameter=False)
    position: tuple[float, float] | None = number(
        "rough start [m]", checks.pair, None, parameter=False
    )
    angular_velocity: float | None = number(
        "at the start [rad/s]", checks.finite, None, parameter=False
    )
    velocity: tuple[float, float] | None = number(
        "at the start [m/s]", checks.pair, None, parameter=False
    )

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
            answer = f"{checks.meant(name, self.points)}; it has {sorted(self.points)}"
            raise KeyError(f"body {self.name} has no point {name!r}{answer}")
        return Point(self, name, *self.points[name])

    @property
    def key(self) -> str:
        """Places of the body's numbers in the parameter vector."""
        return f"bodies/{self.name}"

    def at(self, x: float, y: float, z: float = 0.0) -> Point:
        """An unnamed point of the body's frame."""
        point = PLACE.checked(f"point of {self.name}", (x, y, z))
        return Point(self, f"({', '.join(f'{v:g}' for v in point)})", *point)

    def __repr__(self) -> str:
        return f"Body({self.name!r})"


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
