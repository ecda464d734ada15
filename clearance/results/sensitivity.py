"""Sensitivities of a run: derivatives of its metrics by parameters, each with a stated error.

They are made in accuracy/by_differences.py and stand in the group /sensitivities of a result file.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from clearance.results.tables import Column, Group, TableLayout, texts, texts_of

TRUSTED = 0.05  # error over value up to which a sensitivity is trusted
#: error of a change relative to the metric, over that of the parameter, that hardly counts
NEGLIGIBLE = 1e-4
PERCENT = 0.01
OF_BOTH = ("metric", "parameter")
SENSITIVITIES = TableLayout(
    metric=texts("name of a metric"),
    metric_units=texts("units of the metric", "metric"),
    metric_value=Column("1", "value of the metric, in metric_units", ("metric",)),
    parameter=texts("name of a parameter"),
    parameter_units=texts("units of the parameter", "parameter"),
    size=Column("1", "size of the parameter, in parameter_units", ("parameter",)),
    value=Column(
        "1",
        "derivative of the metric by the parameter, in metric_units over parameter_units",
        OF_BOTH,
    ),
    error=Column("1", "stated error of the derivative, in its units", OF_BOTH),
)


@dataclass(frozen=True)
class Sensitivity:
    """Derivative of a metric by a parameter.

    value, error: of the derivative, in `units`; metric: value of the metric, in `metric_units`;
    size: of the parameter in `parameter_units`, its absolute value where that is not 0.
    """

    value: float
    error: float
    metric: float
    metric_units: str
    size: float
    parameter_units: str

    @property
    def units(self) -> str:
        """Units of the derivative."""
        return quotient(self.metric_units, self.parameter_units)

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

    def columns(self) -> dict[str, np.ndarray]:
        """All of it as columns over metrics, parameters or both; nan where there is none."""
        of_metric = {m: s for (m, _), s in reversed(self.rows.items())}
        of_parameter = {p: s for (_, p), s in reversed(self.rows.items())}
        metrics = [of_metric[m] for m in self.metrics]
        parameters = [of_parameter[p] for p in self.parameters]
        columns = {
            "metric": texts_of(self.metrics),
            "metric_units": texts_of(s.metric_units for s in metrics),
            "metric_value": np.array([s.metric for s in metrics]),
            "parameter": texts_of(self.parameters),
            "parameter_units": texts_of(s.parameter_units for s in parameters),
            "size": np.array([s.size for s in parameters]),
        }
        for name in ("value", "error"):
            table = [[self.rows.get((m, p)) for p in self.parameters] for m in self.metrics]
            columns[name] = np.array(
                [[math.nan if s is None else getattr(s, name) for s in row] for row in table]
            )
        return columns

    @classmethod
    def of_columns(cls, columns: Mapping[str, np.ndarray]) -> "Sensitivities":
        """From such columns. Raises ValueError for columns that do not fit one another."""
        plain = {name: column.tolist() for name, column in columns.items()}
        about = zip(plain["metric_value"], plain["metric_units"], strict=True)
        parts = list(zip(plain["size"], plain["parameter_units"], strict=True))
        rows, tables = {}, (plain["metric"], about, plain["value"], plain["error"])
        for metric, numbers, values, errors in zip(*tables, strict=True):
            cells = zip(plain["parameter"], values, errors, parts, strict=True)
            for parameter, value, error, part in cells:
                if not math.isnan(value):
                    rows[metric, parameter] = Sensitivity(value, error, *numbers, *part)
        return cls(rows)

    def groups(self) -> dict[str, Group]:
        """The group /sensitivities of a file; only the reason where there are none."""
        if self.reason:
            return {"": Group(attributes={"sensitivities_left_out": self.reason})}
        return {"sensitivities": Group(SENSITIVITIES, self.columns())}

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
