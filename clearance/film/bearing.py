"""Inputs and results of the film solvers.

Reynolds equation of an aligned, rigid, isoviscous bearing, in the frame of the line of centres.
theta runs from the *widest* gap in the sense of the attitude angle, so that the thinnest film is at
theta = pi; zeta = z / L in [-1/2, 1/2]. With H = h / c = 1 + eps cos(theta), lambda = L/D and
p = mu (R/c)^2 P:

    d_theta(phi H^3 d_theta P) + (phi H^3 / (4 lambda^2)) d_zeta^2 P
        = 12 psi (v_r cos(theta) - v_t sin(theta))
    v_r = d(eps)/dt,   v_t = eps w / 2,   w = omega_J + omega_B - 2 gamma'

All rates and P are in 1/s.
phi and psi are Patir and Cheng's pressure flow factor and Wu and Zheng's contact factor, 1 for
smooth surfaces. P = 0 is the ambient pressure: P = 0 at zeta = +-1/2. The force on the journal
along n (towards the thinnest film) and t (n turned by +90 degrees) is

    F_r = mu L R^3 / c^2 W_r,   W_r = integral P cos(theta)
    F_t = mu L R^3 / c^2 W_t,   W_t = integral P sin(theta)

Source: Hamrock, Schmid and Jacobson, Fundamentals of Fluid Film Lubrication (2004), chapter 7;
Patir and Cheng (1978).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from clearance.laws.law import FilmJoint
from clearance.values import checks

if TYPE_CHECKING:
    import numpy as np

    from clearance.film.piezo import Oil

#: treatment of a film that would fall below the cavitation pressure. Swift-Stieber (P and its slope
#: vanish at the rupture); pressure cut off after the solution; none; Jakobsson-Floberg-Olsson
#: (mass-conserving).
CAVITATIONS = ("reynolds", "gumbel", "none", "mass_conserving")
#: options of the drag on the journal: that of the filled ring, or of the area that oil wets
RING, WET = DRAGS = "ring", "wet"
DRAG = RING  # closest to charts and rigs that were measured, and as formulas have it
# cells around and over half the length, at least and at most
COARSEST, FINEST = (16, 2), (2048, 128)
LARGEST = 257  # nodes of a table each way
THINNEST = 2.0  # clearance over roughness, at least, of flow factors
# errors of the load that a mesh is refused for, that a run warns of
TOO_COARSE, DOUBTFUL = 0.08, 0.01
CONTACT = 1.0 - 1e-9  # largest eccentricity ratio for a solver


@checks.answers
@dataclass(frozen=True)
class Groove:
    """Place of the oil supply, where the pressure is given.

    angle: of its middle, from the widest gap [rad] (of a joint: from the bearing body's own x
        axis); width: its extent around the bearing [rad], 0 for a line; length: its axial extent,
        centred, over the bearing's length (0 to 1);
    pressure: above ambient [Pa].
    """

    angle: float = 0.0
    width: float = 0.0
    length: float = 1.0
    pressure: float = 0.0

    def __post_init__(self):
        checks.finite("groove: angle", self.angle)
        checks.non_negative("groove: pressure", self.pressure)
        if not 0.0 <= checks.finite("groove: width", self.width) < math.pi:
            raise ValueError(f"groove: width must lie in [0, pi) rad, got {self.width!r}")
        if not 0.0 < checks.finite("groove: length", self.length) <= 1.0:
            raise ValueError(
                f"groove: length is relative to the bearing's and must lie in (0, 1], got "
                f"{self.length!r}: "
                "the groove would lie outside the bearing"
            )


@checks.answers
@dataclass(frozen=True)
class Bearing:
    """An aligned journal bearing and its oil. SI units.

    radius, clearance, length [m]; viscosity [Pa s]; cavitation: one of CAVITATIONS; ambient:
    pressure at the ends above the cavitation pressure [Pa], None where the film cavitates at
    ambient pressure; grooves: where oil is supplied; roughness: composite rms [m] of the flow
    factors, 0 for smooth surfaces; pressure_viscosity: coefficient [1/Pa] of oil that the pressure
    thickens, by Roelands' law or else by Barus' (film/piezo.py), 0: isoviscous.
    """

    radius: float
    clearance: float
    length: float
    viscosity: float
    cavitation: str = "reynolds"
    ambient: float | None = None
    grooves: tuple[Groove, ...] = ()
    roughness: float = 0.0
    pressure_viscosity: float = 0.0
    roelands: bool = False

    def __post_init__(self):
        for name in ("radius", "clearance", "length", "viscosity"):
            object.__setattr__(self, name, checks.positive(f"bearing: {name}", getattr(self, name)))
        checks.one_of("bearing: cavitation", self.cavitation, CAVITATIONS)
        if self.ambient is not None:
            checks.non_negative("bearing: ambient", self.ambient)
        if self.clearance >= self.radius:
            raise ValueError(
                f"bearing: clearance {self.clearance!r} m must be smaller than radius "
                f"{self.radius!r} m"
            )
        if checks.non_negative("bearing: roughness", self.roughness) * THINNEST > self.clearance:
            raise ValueError(
                f"bearing: roughness {self.roughness!r} m: flow factors need a clearance of "
                f"{THINNEST:g} times it"
            )
        checks.non_negative("bearing: pressure_viscosity", self.pressure_viscosity)
        object.__setattr__(self, "grooves", tuple(self.grooves))
        for groove in self.grooves:
            if not isinstance(groove, Groove):
                raise TypeError(f"bearing: grooves must be Groove(...), got {groove!r}")

    @classmethod
    def of(cls, joint: FilmJoint, **more) -> Bearing:
        """The bearing of a joint."""
        return cls(joint.radius, joint.clearance, joint.length, joint.viscosity, **more)

    @property
    def slenderness(self) -> float:
        """L / D."""
        return self.length / (2.0 * self.radius)

    @property
    def axial(self) -> float:
        """Weight of the axial flow in the Reynolds equation, (R / L)^2."""
        return (self.radius / self.length) ** 2

    @property
    def pressure_scale(self) -> float:
        """p / P [Pa s]."""
        return self.viscosity * (self.radius / self.clearance) ** 2

    @property
    def force_scale(self) -> float:
        """F / W [N s]."""
        return self.pressure_scale * self.length * self.radius

    @property
    def flow_scale(self) -> float:
        """Volume flow over its dimensionless value [m3]: c R L."""
        return self.clearance * self.radius * self.length

    @property
    def scales(self) -> tuple[float, float, float, float]:
        """Of the results of a film: both forces, shear, side flow."""
        return self.force_scale, self.force_scale, 1.0, self.flow_scale

    @property
    def thickness(self) -> float:
        """Clearance over roughness, 0 for smooth surfaces."""
        return self.clearance / self.roughness if self.roughness > 0.0 else 0.0

    @property
    def oil(self) -> Oil:
        """The oil as the film solvers have it."""
        from clearance.film.piezo import oil_of

        return oil_of(self.pressure_viscosity, self.viscosity, self.pressure_scale, self.roelands)

    @property
    def lowest(self) -> float:
        """P at cavitation [1/s], at most 0."""
        return -(self.ambient or 0.0) / self.pressure_scale


@dataclass(frozen=True)
class FilmSolution:
    """A film in one state of motion.

    theta: from the widest gap [rad], (n,); axial: z from the middle [m], (m,), 0 to L/2 (the film
        is symmetric);
    pressure: above ambient [Pa], (n, m); content: share of the gap that holds oil, (n, m); radial,
        tangential: force on the journal [N]; shear: integral of mu / mu0 / H where oil drags, of
        the unit area (theta, zeta). The Couette torque is mu R^3 L / c (omega_J - omega_B) shear
        (2 pi / sqrt(1 - eps^2) for a full film). side_flow: oil that leaves at both ends [m3/s],
        what comes in there not counted; iterations: linear systems solved; unknowns.
    """

    bearing: Bearing
    theta: np.ndarray
    axial: np.ndarray
    pressure: np.ndarray
    content: np.ndarray
    radial: float
    tangential: float
    shear: float
    side_flow: float
    iterations: int
    unknowns: int

    @property
    def load(self) -> float:
        """Size of the film force [N]."""
        return math.hypot(self.radial, self.tangential)

    @property
    def drag(self) -> float:
        """Friction torque over the difference of speeds, mu R^3 L / c shear [N m s].

        Torque on the journal -(drag (omega_J - omega_B) + e F_t / 2), see
        laws.film.wet_film_torques.
        """
        b = self.bearing
        return b.viscosity * b.radius**3 * b.length / b.clearance * self.shear

    @property
    def peak_pressure(self) -> float:
        """Largest pressure above ambient [Pa]."""
        return float(self.pressure.max())

    @property
    def centre_of_pressure(self) -> float:
        """theta [rad] in [0, 2 pi) of the line on which the film presses the journal: against the
        force on it.
        """
        return math.atan2(self.tangential, self.radial) % (2.0 * math.pi)

    @property
    def attitude_angle(self) -> float:
        """Angle [rad] between the load that this film carries and the line of centres, in [0,
        pi].
        """
        return math.atan2(abs(self.tangential), -self.radial)


def check_state(
    eccentricity_ratio: float, radial_rate: float, entrainment: float
) -> tuple[float, float, float]:
    """The state as (eps, v_r, v_t). Raises ValueError for an eccentricity at or beyond contact."""
    eps = checks.non_negative("eccentricity_ratio", eccentricity_ratio)
    if eps > CONTACT:
        raise ValueError(
            f"eccentricity_ratio {eccentricity_ratio!r} is at or beyond contact: a film needs one "
            f"below 1"
        )
    rate = checks.finite("radial_rate", radial_rate)
    return eps, rate, 0.5 * eps * checks.finite("entrainment", entrainment)


def check_drag(field: str, drag: str) -> str:
    """A drag, one of DRAGS."""
    return checks.one_of(f"{field}: drag", drag, DRAGS)


def check_nodes(field: str, nodes: int) -> int:
    """Nodes of a table each way."""
    return checks.whole(f"{field}: nodes", nodes, 5, LARGEST)


def load_error(cells: int, eccentricity_ratio: float, slenderness: float) -> float:
    """Largest relative error of the load to expect of so many equal biquadratic cells around.

    The pressure's peak is sqrt(2 (1 - eps)) rad wide each side. With n cells in it, n from 2 on,
    the error is 0.08 / n^2, for L/D from 1/2 on 0.025 / n^2. These are measured against fine meshes
    in rotation, squeeze and both, for L/D from 1/10 to 2 and eccentricity ratios up to 0.9975.
    """
    inside = cells * math.sqrt(2.0 * max(1.0 - eccentricity_ratio, 1e-12)) / (2.0 * math.pi)
    return (0.025 if slenderness >= 0.5 and inside >= 2.0 else TOO_COARSE) / inside**2


def coarseness(
    cells: int, eccentricity_ratio: float, slenderness: float, most: float = TOO_COARSE
) -> str | None:
    """Objection to so many equal cells around, where more than `most` of the load may be missed."""
    error = load_error(cells, eccentricity_ratio, slenderness)
    finer = cells
    if error <= most:
        return None
    while load_error(finer, eccentricity_ratio, slenderness) > most:
        finer *= 2
    return too_coarse(cells, at(eccentricity_ratio), error, finer)


def at(eccentricity_ratio: float) -> str:
    """An eccentricity in words."""
    return f"for eccentricity ratio {eccentricity_ratio:.6g}"


def too_coarse(cells: int, where: str, error: float, finer: int) -> str:
    """Objection to so many cells around; finer: how many would do."""
    about = f"{cells} cells around are too coarse {where}"
    return f"{about}: the load may be {error:.1%} off; take {finer}"


def check_mesh(mesh: tuple[int, int]) -> tuple[int, int]:
    """Cells around the bearing and over half its length."""
    try:
        around, along = mesh
    except (TypeError, ValueError):
        raise ValueError(
            f"mesh must be two numbers of cells (around, along half the length), got {mesh!r}"
        ) from None
    for name, cells, least, most in zip(
        ("around", "along"), (around, along), COARSEST, FINEST, strict=True
    ):
        if not isinstance(cells, int) or cells < least:
            raise ValueError(
                f"mesh: needs at least {least} cells {name} the bearing, got {cells!r}: too coarse"
            )
        if cells > most:
            raise ValueError(f"mesh: takes at most {most} cells {name} the bearing, got {cells!r}")
    return around, along
