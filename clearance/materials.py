"""Materials and lubricants, each number with its source."""

from dataclasses import dataclass

from clearance.checks import finite, non_negative, positive


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
