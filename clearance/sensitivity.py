"""Sensitivities of a run: derivatives of its metrics by parameters, each with a stated error.

They are made in sensing.py and stand in the group /sensitivities of a result file.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

TRUSTED = 0.05  # error over value up to which a sensitivity is trusted
#: error of a change relative to the metric, over that of the parameter, that hardly counts
NEGLIGIBLE = 1e-4
PERCENT = 0.01


@dataclass(frozen=True)
class Sensitivity:
    """Derivative of a metric by a parameter.

    value, error: of the derivative, in `units`; metric: value of the metric, in `metric_units`;
    size: of the parameter in SI, its absolute value where that is not 0.
    """

    value: float
    error: float
    units: str
    metric: float
    metric_units: str
    size: float

    @property
    def trusted(self) -> bool:
        """True where the error is small beside the derivative, or hardly changes the metric."""
        hardly = NEGLIGIBLE * abs(self.metric) / self.size
        return self.error <= max(TRUSTED * abs(self.value), hardly)

    @property
    def change(self) -> float:
        """Change of the metric where the parameter grows by 1 % of its size, in `metric_units`."""
        return PERCENT * self.size * self.value

    @property
    def change_error(self) -> float:
        """Error of `change`."""
        return PERCENT * self.size * self.error


@dataclass(frozen=True)
class Sensitivities(Mapping):
    """Sensitivities of a run by metric and parameter:
    `result.sensitivities["joint_B_gap_min", "clearance"]`.

    reason: why there are none, "" where there are some.
    """

    rows: Mapping[tuple[str, str], Sensitivity] = field(default_factory=dict)
    reason: str = ""

    @cached_property
    def metrics(self) -> list[str]:
        """Names of the metrics."""
        return list(dict.fromkeys(metric for metric, _ in self.rows))

    @cached_property
    def parameters(self) -> list[str]:
        """Names of the parameters."""
        return list(dict.fromkeys(parameter for _, parameter in self.rows))

    def telling(self, clearances: Iterable[str]) -> list[str]:
        """The metrics: extremes of joints with clearance first, then those of drives.

        clearances: names of these joints.
        """
        joints = [f"joint_{j}_{end}" for j in clearances for end in ("force_max", "gap_min")]
        drives = [n for n in self.metrics if n.startswith("drive_") and n.endswith(("max", "min"))]
        first = [n for n in (*joints, *drives) if n in self.metrics]
        return list(dict.fromkeys([*first, *self.metrics]))

    def __getitem__(self, key: tuple[str, str]) -> Sensitivity:
        if key not in self.rows:
            raise KeyError(f"no sensitivity {key!r}: {self.reason or 'the run has none of it'}")
        return self.rows[key]

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        if not self.rows:
            return f"<no sensitivities: {self.reason}>"
        return f"<sensitivities of {len(self.metrics)} metrics by {', '.join(self.parameters)}>"


def quotient(units: str, parameter: str) -> str:
    """Units of a derivative: "N" by "Pa s" is "N/(Pa s)"."""
    if parameter in ("-", "1", "", units):
        return "1" if parameter == units else units
    above = f"({units})" if "/" in units else units
    below = f"({parameter})" if " " in parameter or "/" in parameter else parameter
    return f"{above}/{below}"
