"""Tables of a result file, declared once: located extremes, integrals, stated errors, fields."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import h5py
import numpy as np

from clearance.results.errors import Error, Errors, ExtremeErrors
from clearance.results.extremes import Extremes
from clearance.results.integrals import Integrals
from clearance.results.reading import Damaged, Reader, checked
from clearance.results.tables import create_column

NUMBERS, WHOLE, TEXTS = "f", "i", "U"  # kinds of columns


@dataclass(frozen=True)
class Column:
    """A column of a table: its units and what it is.

    along: names of the columns that are the scales of its axes; none of a scale itself. kind: of
    its values, as numpy has it.
    """

    units: str
    text: str
    along: tuple[str, ...] = ()
    kind: str = NUMBERS


class TableLayout(dict[str, Column]):
    """Columns of a table by name; a scale is of one axis, its own."""

    def axes(self, name: str) -> tuple[str, ...]:
        """Scales of the axes of a column."""
        return self[name].along or (name,)

    def read(self, reader: Reader, path: str, names: Iterable[str] = ()) -> dict[str, np.ndarray]:
        """Columns in a group of a file, all or some; their scales must be among them.

        Raises Damaged for a column of another kind, or one that does not fit its scales.
        """
        columns = {name: reader.column(f"{path}/{name}") for name in names or self}
        for name, values in columns.items():
            if values.dtype.kind != self[name].kind:
                raise Damaged(f"{reader.path}: /{path}/{name} is a column of another kind")
            if values.shape != tuple(columns[scale].size for scale in self.axes(name)):
                raise Damaged(f"{reader.path}: /{path}/{name} does not fit its table")
        return columns


@dataclass(frozen=True)
class Group:
    """Tables that stand in one group of a file.

    layout: of its columns; columns: by name; attributes: of the group.
    """

    layout: TableLayout = field(default_factory=TableLayout)
    columns: Mapping[str, np.ndarray] = field(default_factory=dict)
    attributes: Mapping[str, object] = field(default_factory=dict)

    @property
    def about(self) -> dict[str, tuple[str, str]]:
        """Units of each column and what it is."""
        return {name: (self.layout[name].units, self.layout[name].text) for name in self.columns}

    def write(self, file: h5py.File, path: str) -> None:
        """Add it to a file, whose group may be there already."""
        group = file.require_group(path) if path else file
        for name, values in self.columns.items():
            create_column(group, name, values, *self.about[name])
        for name in self.columns:
            if not self.layout[name].along:
                group[name].make_scale(name)
        for name in self.columns:
            for axis, scale in enumerate(self.layout[name].along):
                group[name].dims[axis].attach_scale(group[scale])
        group.attrs.update(checked(self.attributes))

    def joined(self, group: "Group") -> "Group":
        """Both in one."""
        return Group(
            TableLayout(self.layout | group.layout),
            {**self.columns, **group.columns},
            {**self.attributes, **group.attributes},
        )

    def variables(self) -> dict[str, tuple]:
        """Its columns as xarray takes them: axes, values, attributes."""
        return {
            name: (
                self.layout.axes(name),
                values,
                dict(zip(("units", "long_name"), self.about[name], strict=True)),
            )
            for name, values in self.columns.items()
        }


def texts_of(values: Iterable[str]) -> np.ndarray:
    """A column of texts."""
    return np.array(list(values), dtype=str)


OF_EXTREMES = ("stretch", "quantity")
EXTREMES = TableLayout(
    quantity=Column("1", "quantity: path of a channel, or of a vector, and its end", (), TEXTS),
    units_of=Column("1", "units of each quantity", ("quantity",), TEXTS),
    stretch=Column("s", "start of each stretch of the run"),
    value=Column(
        "1",
        "smallest (_min) or largest (_max) value in each stretch, in units_of",
        OF_EXTREMES,
    ),
    when=Column("s", "time of each value", OF_EXTREMES),
    stated=Column("1", "stated error of each value by the integration, in units_of", OF_EXTREMES),
    film=Column(
        "1",
        "change of each value by the largest error of the film tables, in units_of",
        OF_EXTREMES,
    ),
)
#: its columns in a run without stated errors, and those of the errors
LOCATED, OF_ERRORS = list(EXTREMES)[:5], list(EXTREMES)[5:]


def extremes_group(extremes: Extremes) -> Group:
    """The group /extremes: values and their times over the stretches of the run and the
    quantities.
    """
    columns = {
        "quantity": texts_of(extremes.names),
        "units_of": texts_of(extremes.units),
        "stretch": extremes.length * np.arange(len(extremes.values)),
        "value": extremes.values,
        "when": extremes.times,
    }
    return Group(EXTREMES, columns, {"stretch_s": extremes.length})


INTEGRALS = TableLayout(
    integral=Column(
        "1", "integrand: path of a channel, or of a vector, and _square or _positive", (), TEXTS
    ),
    integral_units=Column("1", "units of each integral", ("integral",), TEXTS),
    part_end=Column("s", "end of each part of the run; the first begins with the run"),
    amount=Column("1", "integral over each part, in integral_units", ("part_end", "integral")),
)


def integrals_group(integrals: Integrals) -> Group:
    """The group /integrals: amounts over the parts of the run and the integrands."""
    columns = {
        "integral": texts_of(integrals.names),
        "integral_units": texts_of(integrals.units),
        "part_end": integrals.ends,
        "amount": integrals.values,
    }
    return Group(INTEGRALS, columns)


def integrals_of(reader: Reader) -> Integrals:
    """The integrals of a file."""
    names, units, ends, values = INTEGRALS.read(reader, "integrals").values()
    return Integrals(tuple(map(str, names)), tuple(map(str, units)), ends, values)


#: stated errors; those of extremes stand in /extremes
ERRORS = TableLayout(
    name=Column(
        "1",
        "name of a metric, of a located extreme, or trajectory (over the clearance)",
        (),
        TEXTS,
    ),
    units_of=Column("1", "units of value, stated and film", ("name",), TEXTS),
    kind=Column("1", "way in which the error was found", ("name",), TEXTS),
    channel=Column("1", "path of a channel", (), TEXTS),
    share=Column(
        "1",
        "three times the largest difference of a channel from the companion over its range",
        ("channel",),
    ),
    value=Column("1", "value of the run, in units_of", ("name",)),
    stated=Column("1", "stated error of the integration, in units_of", ("name",)),
    film=Column("1", "change by the largest error of the film tables, in units_of", ("name",)),
)


def error_groups(errors: Errors) -> dict[str, Group]:
    """The group /errors, and errors of the located extremes in /extremes; with nothing but the
    reason, in attributes of the file, where nothing is stated.
    """
    if errors.reason:
        return {"": Group(attributes={"errors_left_out": errors.reason})}
    rows = errors.rows.values()
    columns = {
        "name": texts_of(errors.rows),
        "units_of": texts_of(e.units for e in rows),
        "kind": texts_of(e.kind for e in rows),
        "channel": texts_of(errors.channels),
        "share": np.array(list(errors.channels.values()), dtype=float),
    }
    columns |= {n: np.array([getattr(e, n) for e in rows]) for n in ("value", "stated", "film")}
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
    of_extremes = {name: getattr(errors.extremes, name) for name in OF_ERRORS}
    return {"errors": Group(ERRORS, columns, about), "extremes": Group(EXTREMES, of_extremes)}


def errors_of(reader: Reader, of_extremes: ExtremeErrors | None) -> Errors:
    """The stated errors of a file."""
    table = {n: values.tolist() for n, values in ERRORS.read(reader, "errors").items()}
    about = reader.attributes("errors")
    rows = zip(*(table[n] for n in ("value", "stated", "units_of", "kind", "film")), strict=True)
    return Errors(
        dict(zip(table["name"], (Error(*row) for row in rows), strict=True)),
        dict(zip(table["channel"], table["share"], strict=True)),
        "",
        (float(about["rtol"]), float(about["companion_rtol"])),
        float(about["spread"]),
        float(about["begin_s"]),
        float(about["end_s"]),
        of_extremes,
        json.loads(about.get("asked", "{}")),
        about.get("cannot", ""),
    )


OF_FIELDS = ("instant", "axial", "angle")
#: pressure fields of the film of a joint
FIELDS_OF_PRESSURE = TableLayout(
    instant=Column("1", "place of the sample in /time", (), WHOLE),
    axial=Column("m", "axial position from the middle of the bearing"),
    angle=Column("rad", "angle on the bearing from its body's own x axis"),
    time=Column("s", "time of the field", OF_FIELDS[:1]),
    line_of_centres=Column("rad", "angle of the thinnest film on the bearing", OF_FIELDS[:1]),
    eccentricity_ratio=Column("1", "eccentricity over clearance", OF_FIELDS[:1]),
    pressure=Column("Pa", "film pressure above ambient", OF_FIELDS),
    content=Column("1", "share of the gap that holds oil", OF_FIELDS),
)
