"""Materials and lubricants, each number with its source."""

from dataclasses import dataclass

from clearance.checks import answers, finite, non_negative, positive


@answers
@dataclass(frozen=True)
class Material:
    """Isotropic elastic solid: Young's modulus [Pa], Poisson's ratio, density [kg/m3]."""

    name: str
    young: float
    poisson: float
    density: float

    def __post_init__(self):
        positive(f"material {self.name}: young", self.young)
        positive(f"material {self.name}: density", self.density)
        if not -1.0 < finite(f"material {self.name}: poisson", self.poisson) <= 0.5:
            raise ValueError(f"material {self.name}: poisson must lie in (-1, 0.5], got {self.poisson!r}")


@answers
@dataclass(frozen=True)
class Lubricant:
    """Isoviscous oil: dynamic viscosity [Pa s].

    pressure_viscosity: Barus coefficient alpha [1/Pa] for the diagnostics of a run (a mineral oil's by default).
    """

    viscosity: float
    pressure_viscosity: float = 2e-8

    def __post_init__(self):
        positive("lubricant: viscosity", self.viscosity)
        non_negative("lubricant: pressure_viscosity", self.pressure_viscosity)


#: the steel of the clearance-joint literature (Flores et al. 2004 to 2009: E = 207 GPa, nu = 0.3)
steel = Material("steel", young=207e9, poisson=0.3, density=7850.0)


@answers
@dataclass(frozen=True)
class HeatBalance:
    """Balance of heat of a joint's oil and what surrounds it: one temperature, that sets the viscosity.

    C T' = P - h (T - T_0) - rho c_p Q (T - T_0),   mu(T) = mu_0 exp(B / (T - theta) - B / (T_0 - theta))

    capacity C [J/K] of the oil and the metal that warms with it; conductance h [W/K] to the surroundings; surroundings
    T_0 [K], where the lubricant's viscosity mu_0 is given and the run starts, also the temperature of fresh oil;
    volumetric rho c_p of the oil [J/(m3 K)]; vogel B [K] and vogel_zero theta [K]. P is the joint's power loss, Q the
    film's side flow (film laws that do not know theirs cool by h alone).
    Source: Vogel, Physikalische Zeitschrift 22 (1921) 645; the defaults are an ISO VG 32 mineral oil's (27.6 mPa s at
    40 C and 4.6 mPa s at 100 C, theta = -95 C).
    """

    capacity: float
    conductance: float
    surroundings: float = 313.15
    volumetric: float = 1.7e6
    vogel: float = 786.0
    vogel_zero: float = 178.15

    def __post_init__(self):
        for name in ("capacity", "surroundings", "vogel", "vogel_zero"):
            positive(f"heat balance: {name}", getattr(self, name))
        for name in ("conductance", "volumetric"):
            non_negative(f"heat balance: {name}", getattr(self, name))
        if self.surroundings <= self.vogel_zero:
            raise ValueError(f"heat balance: surroundings {self.surroundings!r} K must be above vogel_zero")
