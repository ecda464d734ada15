"""Groups of tables in a result file: located extremes, integrals over time, stated errors."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field

import h5py
import numpy as np

from clearance.results.errors import Errors
from clearance.results.extremes import Extremes
from clearance.results.integrals import Integrals
from clearance.results.reading import checked
from clearance.results.tables import create_column


@dataclass(frozen=True)
class Group:
    """Tables that stand in one group of a file.

    columns: by name; about: units of each and what it is; along: names of the columns that are the
    scales of its axes, none of a scale itself; attributes: of the group.
    """

    columns: Mapping[str, np.ndarray]
    about: Mapping[str, tuple[str, str]]
    along: Mapping[str, tuple[str, ...]]
    attributes: Mapping[str, object] = field(default_factory=dict)

    def write(self, file: h5py.File, path: str) -> None:
        """Add it to a file, whose group may be there already."""
        group = file.require_group(path) if path else file
        for name, values in self.columns.items():
            create_column(group, name, values, *self.about[name])
        for name, scales in self.along.items():
            for axis, scale in enumerate(scales):
                group[name].dims[axis].attach_scale(group[scale])
            if not scales:
                group[name].make_scale(name)
        group.attrs.update(checked(self.attributes))

    def joined(self, group: "Group") -> "Group":
        """Both in one."""
        return Group(*({**entries, **vars(group)[name]} for name, entries in vars(self).items()))


#: the table of located extremes: name of a column -> (units, what it is)
EXTREME_COLUMNS = {
    "quantity": ("1", "quantity: path of a channel, or of a vector, and its end"),
    "units_of": ("1", "units of each quantity"),
    "stretch": ("s", "start of each stretch of the run"),
    "value": ("1", "smallest (_min) or largest (_max) value in each stretch, in units_of"),
    "when": ("s", "time of each value"),
}
OF_EXTREMES = ("stretch", "quantity")


def extremes_group(extremes: Extremes) -> Group:
    """The group /extremes: values and their times over the stretches of the run and the
    quantities.
    """
    columns = {
        "quantity": np.array(extremes.names, dtype=str),
        "units_of": np.array(extremes.units, dtype=str),
        "stretch": extremes.length * np.arange(len(extremes.values)),
        "value": extremes.values,
        "when": extremes.times,
    }
    along = {"quantity": (), "stretch": (), "units_of": ("quantity",)}
    along |= dict.fromkeys(("value", "when"), OF_EXTREMES)
    return Group(columns, EXTREME_COLUMNS, along, {"stretch_s": extremes.length})


#: the table of integrals over time: name of a column -> (units, what it is)
INTEGRAL_COLUMNS = {
    "integral": ("1", "integrand: path of a channel, or of a vector, and _square or _positive"),
    "integral_units": ("1", "units of each integral"),
    "part_end": ("s", "end of each part of the run; the first begins with the run"),
    "amount": ("1", "integral over each part, in integral_units"),
}


def integrals_group(integrals: Integrals) -> Group:
    """The group /integrals: amounts over the parts of the run and the integrands."""
    columns = {
        "integral": np.array(integrals.names, dtype=str),
        "integral_units": np.array(integrals.units, dtype=str),
        "part_end": integrals.ends,
        "amount": integrals.values,
    }
    along = {"integral": (), "part_end": (), "integral_units": ("integral",)}
    return Group(columns, INTEGRAL_COLUMNS, along | {"amount": ("part_end", "integral")})


#: tables of stated errors in /errors: name of a column -> (units, what it is); those of extremes
#: stand in /extremes
ERROR_COLUMNS = {
    "name": ("1", "name of a metric, of a located extreme, or trajectory (over the clearance)"),
    "units_of": ("1", "units of value, stated and film"),
    "value": ("1", "value of the run, in units_of"),
    "stated": ("1", "stated error of the integration, in units_of"),
    "film": ("1", "change by the largest error of the film tables, in units_of"),
    "kind": ("1", "way in which the error was found"),
    "channel": ("1", "path of a channel"),
    "share": (
        "1",
        "three times the largest difference of a channel from the companion over its range",
    ),
}
EXTREME_ERRORS = {
    "stated": ("1", "stated error of each value by the integration, in units_of"),
    "film": ("1", "change of each value by the largest error of the film tables, in units_of"),
}


def error_groups(errors: Errors) -> dict[str, Group]:
    """The group /errors, and errors of the located extremes in /extremes; with nothing but the
    reason, in attributes of the file, where nothing is stated.
    """
    if errors.reason:
        return {"": Group({}, {}, {}, {"errors_left_out": errors.reason})}
    rows = errors.rows.values()
    columns = {
        "name": np.array(list(errors.rows), dtype=str),
        "units_of": np.array([e.units for e in rows], dtype=str),
        "kind": np.array([e.kind for e in rows], dtype=str),
        "channel": np.array(list(errors.channels), dtype=str),
        "share": np.array(list(errors.channels.values()), dtype=float),
    }
    columns |= {n: np.array([getattr(e, n) for e in rows]) for n in ("value", "stated", "film")}
    along = {"name": (), "channel": (), "share": ("channel",)}
    along |= {name: ("name",) for name in columns if name not in along}
    rtol, companion_rtol = errors.rtol
    about = {
        "rtol": rtol,
        "companion_rtol": companion_rtol,
        "spread": errors.spread,
        "begin_s": errors.begin,
        "end_s": errors.end,
    }
    if errors.asked:
        about |= {"asked": json.dumps(dict(errors.asked)), "cannot": errors.cannot}
    of_extremes = {name: getattr(errors.extremes, name) for name in EXTREME_ERRORS}
    both = dict.fromkeys(EXTREME_ERRORS, OF_EXTREMES)
    return {
        "errors": Group(columns, ERROR_COLUMNS, along, about),
        "extremes": Group(of_extremes, EXTREME_ERRORS, both),
    }
