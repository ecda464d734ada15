"""Thermal nodes: housings, sumps and links that several joints heat."""

from collections.abc import Iterator
from dataclasses import dataclass

from clearance.elements.element import WARMING, Load, State
from clearance.elements.quantities import NEVER, Row, number, optional
from clearance.values import checks

SURROUNDINGS = 313.15  # temperature of the surroundings where none is given [K]


@checks.answers
@dataclass(frozen=True)
class ThermalNode(Load):
    """A body of one temperature, such as a housing or a sump: joints heat it, surroundings cool it.

    C T' = sum of what flows in - h (T - T_s)   [W]

    name; capacity C [J/K]; conductance h [W/K] to the surroundings at T_s [K] (default 313.15), or
    to another node `to`. That node takes the heat, and T_s is then its temperature; start:
    temperature at
    t = 0 [K] (default that of the surroundings of the last node in the row). Joints heat a node by
    `heat=HeatBalance(..., to=node)`. Nodes make a linear network.
    Raises ValueError for a capacity that is not positive, a negative conductance, and for
    surroundings beside `to`.
    Source: lumped capacities: Incropera and DeWitt, Fundamentals of Heat and Mass Transfer, 5.1.
    """

    name: str
    capacity: float = number("heat capacity [J/K]", checks.positive)
    conductance: float = number("conductance [W/K]", checks.non_negative)
    surroundings: float | None = optional("temperature of the surroundings [K]")
    to: "ThermalNode | None" = None
    start: float | None = optional("temperature at t = 0 [K]")

    group, kind = "nodes", "node"

    def __post_init__(self):
        super().__post_init__()
        if self.to is not None and not isinstance(self.to, ThermalNode):
            raise TypeError(f"{self.label()}: to must be a ThermalNode, got {self.to!r}")
        if self.to is not None and self.surroundings is not None:
            raise ValueError(
                f"{self.label()}: surroundings beside to={self.to.name}: give one of them"
            )

    def companions(self) -> dict:
        return {} if self.to is None else {"node": self.to}

    @property
    def cold(self) -> float:
        """Temperature [K] that warming is counted from: of the surroundings of the last node."""
        if self.to is not None:
            return self.to.cold
        return SURROUNDINGS if self.surroundings is None else self.surroundings

    def numbers(self) -> Iterator[Row]:
        yield from super().numbers()
        yield f"{self.key}/cold", self.cold, NEVER

    # --- for the compiler
    def states(self) -> list[State]:
        start = 0.0 if self.start is None else self.start - self.cold
        return [State("warming", "K", WARMING, order=1, start=start)]

    def take(self, m, w, power) -> None:
        """Heat that flows in [W]."""
        w.rate(self, "warming", power / m.number(self, "capacity"))

    def temperature(self, m):
        """Its temperature [K]."""
        return m.number(self, "cold") + m.state(self, "warming").v

    def act(self, m, w) -> None:
        apart = m.state(self, "warming").v
        if self.to is not None:  # both count from the same temperature
            apart -= m.state(self.to, "warming").v
        flow = m.number(self, "conductance") * apart
        self.take(m, w, -flow)
        if self.to is not None:
            self.to.take(m, w, flow)
        w.show(self, "temperature", "K", "temperature", self.temperature(m))
        w.show(self, "flow", "W", "heat that flows to the surroundings or the next node", flow)
