"""Materials and lubricants, each number with its source."""

from dataclasses import MISSING, Field, dataclass, field, fields

from clearance.values.checks import answers, finite, fraction, known, non_negative, positive
from clearance.values.units import labelled, unusual


def measured(unit: str, default=MISSING, usual: tuple[float, float] | None = None) -> Field:
    """A field that is a number with a unit; usual: range beyond which a run warns."""
    return field(default=default, metadata={"unit": unit, "usual": usual})


class Record:
    """Base of materials, oils and balances: their numbers may be texts with a unit."""

    kind = ""

    def __post_init__(self):
        for entry in fields(self):
            if unit := entry.metadata.get("unit"):
                value = labelled(f"{self.kind}: {entry.name}", getattr(self, entry.name), (unit,))
                object.__setattr__(self, entry.name, value)

    def doubts(self) -> list[str]:
        """Warnings about its numbers."""
        stated = [(f.name, f.metadata) for f in fields(self) if f.metadata.get("usual")]
        texts = [
            unusual(f"{self.kind}: {n}", getattr(self, n), about["unit"], *about["usual"])
            for n, about in stated
        ]
        return [t for t in texts if t]


@answers
@dataclass(frozen=True)
class Material(Record):
    """Isotropic elastic solid: Young's modulus [Pa], Poisson's ratio, density [kg/m3]."""

    name: str
    young: float = measured("Pa", usual=(1e5, 2e12))
    poisson: float = measured("-")
    density: float = measured("kg/m3", usual=(10.0, 3e4))

    kind = "material"

    def __post_init__(self):
        super().__post_init__()
        positive(f"material {self.name}: young", self.young)
        positive(f"material {self.name}: density", self.density)
        if not -1.0 < finite(f"material {self.name}: poisson", self.poisson) <= 0.5:
            raise ValueError(
                f"material {self.name}: poisson must lie in (-1, 0.5], got {self.poisson!r}"
            )

    @staticmethod
    def table() -> "dict[str, BearingMaterial]":
        """Materials of bearings by name, with hardness and dry wear on steel."""
        return BEARING_MATERIALS

    @staticmethod
    def named(name: str, refusal: str = "no material") -> "Material":
        """A material of the table. Raises ValueError for a name that is not there."""
        known(refusal, name, BEARING_MATERIALS)
        return BEARING_MATERIALS[name].material

    @staticmethod
    def of(label: str, name: str, value: object) -> "Material":
        """A material, or that of a name; name: of the field. Raises ValueError or TypeError."""
        if isinstance(value, str):
            return Material.named(value, f"{label}: no {name}")
        if not isinstance(value, Material):
            raise TypeError(f"{label}: {name} must be a Material, got {value!r}")
        return value


@dataclass(frozen=True)
class BearingMaterial:
    """A material of bearings: typical values.

    hardness [Pa]: Brinell's, of polymers by ball indentation, within a fifth. wear: lowest and
    highest coefficient k of `archard` [m2/N] that is usual in dry sliding on steel, which covers
    orders of magnitude; None where that is not known to us.
    """

    material: Material
    hardness: float
    wear: tuple[float, float] | None
    source: str


@answers
@dataclass(frozen=True)
class Lubricant(Record):
    """Isoviscous oil: dynamic viscosity [Pa s].

    pressure_viscosity: Barus coefficient alpha [1/Pa] for the diagnostics of a run (a mineral oil's
        by default).

    Example:

        >>> cl.Lubricant("50 cP").viscosity, round(cl.Lubricant("46 cSt@870 kg/m3").viscosity, 6)
        (0.05, 0.04002)
    """

    viscosity: float = measured("Pa s", usual=(5e-6, 10.0))
    pressure_viscosity: float = measured("1/Pa", 2e-8)

    kind = "lubricant"

    def __post_init__(self):
        super().__post_init__()
        positive("lubricant: viscosity", self.viscosity)
        non_negative("lubricant: pressure_viscosity", self.pressure_viscosity)


#: the steel of the clearance-joint literature (Flores et al. 2004 to 2009: E = 207 GPa, nu = 0.3)
steel = Material("steel", young=207e9, poisson=0.3, density=7850.0)


ARCHARD = "k = K / H with K of Archard and Hirst, Proc. R. Soc. A 236 (1956) 397"
SHEETS = "data sheets of manufacturers"
WASHER = f"{SHEETS}; k of washers on steel or polymer, ASTM D3702, RTP Company"
#: name: (Young's modulus [GPa], Poisson's ratio, density [kg/m3], hardness [MPa], wear [m2/N])
_TYPICAL = {
    "steel": (207.0, 0.3, 7850.0, 1200.0, (1e-13, 1e-11), ARCHARD),
    "hardened_steel": (207.0, 0.3, 7850.0, 6500.0, (1e-15, 1e-13), ARCHARD),
    "cast_iron": (110.0, 0.26, 7200.0, 2000.0, None, SHEETS),
    "bronze": (100.0, 0.34, 8910.0, 640.0, (1e-14, 1e-12), f"UNS C93200; {ARCHARD} (brass)"),
    "tin_babbitt": (53.0, 0.35, 7300.0, 245.0, None, "ASTM B23 grade 2"),
    "lead_babbitt": (26.0, 0.4, 10000.0, 225.0, None, "ASTM B23 grade 7"),
    "PTFE": (0.5, 0.46, 2170.0, 30.0, (1e-13, 1e-12), f"{SHEETS}; {ARCHARD}"),
    "POM": (2.9, 0.37, 1410.0, 150.0, (1e-16, 1e-14), WASHER),
    "PA66": (2.5, 0.39, 1140.0, 130.0, (1e-15, 1e-13), WASHER),
    "PEEK": (3.8, 0.39, 1310.0, 230.0, (1e-15, 1e-13), f"{SHEETS}; Mens and de Gee (1991)"),
    "UHMWPE": (0.7, 0.46, 930.0, 38.0, (1e-16, 1e-14), f"{SHEETS}; {ARCHARD}"),
}
#: typical values: moduli and densities within a twentieth, those of polymers within a fifth
BEARING_MATERIALS = {
    name: BearingMaterial(Material(name, 1e9 * young, poisson, density), 1e6 * hard, wear, source)
    for name, (young, poisson, density, hard, wear, source) in _TYPICAL.items()
}


@answers
@dataclass(frozen=True)
class HeatBalance(Record):
    """Balance of heat of a joint's oil and what surrounds it: one temperature, that sets the
    viscosity.

    C T' = P - h (T - T_s) - rho c_p Q (T - T_f),
    mu(T) = mu_0 exp(B / (T - theta) - B / (T_0 - theta))

    capacity C [J/K] of the oil and the metal that warms with it; conductance h [W/K] to what
    surrounds it, at T_s. surroundings T_0 [K], where the lubricant's viscosity mu_0 is given and
    the run starts. volumetric rho c_p of the oil [J/(m3 K)]; vogel B [K] and vogel_zero theta [K].
    P is the heat that the oil takes, Q the film's side flow (film laws without a side flow cool by
    h alone).
    to: the ThermalNode that surrounds the oil, T_s is its temperature; None: T_s = T_0. With a node
        and neither capacity nor conductance the oil has the node's temperature and no state. The
        node then takes P - rho c_p Q (T - T_f): films of one oil bath. supply T_f [K]: temperature
        of fresh oil (default T_0). share in [0, 1]: part of the heat of contact, asperities and
        their friction that the oil takes, beside all heat of the film. The node takes the rest
        (surroundings at T_0 do so without warming).
    Raises ValueError for numbers out of these ranges.
    Source: Vogel, Physikalische Zeitschrift 22 (1921) 645. The defaults are an ISO VG 32 mineral
    oil's (27.6 mPa s at 40 C and 4.6 mPa s at 100 C, theta = -95 C).
    """

    capacity: float | None = measured("J/K", None)
    conductance: float | None = measured("W/K", None)
    surroundings: float = measured("K", 313.15)
    volumetric: float = measured("J/(m3 K)", 1.7e6)
    vogel: float = measured("K", 786.0)
    vogel_zero: float = measured("K", 178.15)
    to: object = None
    supply: float | None = measured("K", None)
    share: float = measured("-", 1.0)

    kind = "heat balance"

    def __post_init__(self):
        super().__post_init__()
        optional = [n for n in ("capacity", "supply") if getattr(self, n) is not None]
        for name in (*optional, "surroundings", "vogel", "vogel_zero"):
            positive(f"heat balance: {name}", getattr(self, name))
        fraction("heat balance: share", self.share)
        for name in ("conductance", "volumetric"):
            if getattr(self, name) is not None:
                non_negative(f"heat balance: {name}", getattr(self, name))
        if self.surroundings <= self.vogel_zero:
            raise ValueError(
                f"heat balance: surroundings {self.surroundings!r} K must be above vogel_zero"
            )
        missing = [n for n in ("capacity", "conductance") if getattr(self, n) is None]
        if missing and (self.to is None or len(missing) == 1):
            raise ValueError(
                f"heat balance: {missing[0]} is missing; "
                "only beside to=ThermalNode(...) may both be left out"
            )

    @property
    def stands_alone(self) -> bool:
        """True where the oil has a temperature of its own, False where it has that of its node."""
        return self.capacity is not None

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of the kernel by name."""
        values = {n: v for n, v in vars(self).items() if isinstance(v, float | int)}
        return values if self.share < 1.0 else {n: v for n, v in values.items() if n != "share"}
