"""Ways that the points of a sweep ran."""

from dataclasses import dataclass, field


@dataclass
class Ways:
    """Points that one call ran side by side in lanes, and each by itself.

    lanes: points at a time; reasons: why points are left to the ordinary way, and their numbers.
    """

    in_lanes: int = 0
    by_themselves: int = 0
    lanes: int = 0
    reasons: dict[str, int] = field(default_factory=dict)

    def left(self, reason: str, count: int) -> None:
        """So many points take the ordinary way."""
        self.reasons[reason] = self.reasons.get(reason, 0) + count

    def __str__(self) -> str:
        lanes = "no points in lanes"
        if self.in_lanes:
            lanes = f"{self.in_lanes} points in lanes, {self.lanes} at a time"
        others = "; ".join(f"{count}: {reason}" for reason, count in self.reasons.items())
        return f"{lanes}; the ordinary way for {others}" if others else lanes
