"""The result file: one HDF5 file a run, written as the run goes, complete or honestly partial.

Layout, in SI units; every dataset has `units` and `long_name`. Along time are /time, /bodies,
/joints, /springs, /drives, /energy. /events has one row per contact, /solver one per step. Along
each goes a dimension of its own, so that xarray opens the entire file as a tree. Columns carry
checksums: reading a damaged file names the place.
"""

import json
import math
import shutil
import weakref
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from clearance.files.replacing import replacing, temporary_file, temporary_name
from clearance.results.errors import Error, Errors, ExtremeErrors
from clearance.results.extremes import Extremes
from clearance.results.integrals import Integrals
from clearance.results.memory_reader import MemoryReader
from clearance.results.reading import FACT_UNITS, Damaged, Entries, Missing, Reader, open_checked
from clearance.results.record import FIELD_COLUMNS, PARTS, WEAR, PressureFields, Record, extra
from clearance.results.tables import FORMAT, FORMAT_VERSION, check_result, in_memory
from clearance.scene.document import check

if TYPE_CHECKING:  # what few runs have
    from clearance.results.sensitivity import Sensitivities

#: what `open_checked` looks for
KIND = "clearance result", FORMAT, FORMAT_VERSION
#: dimension of each table of a result file, a dataset beside its columns; along all other groups
#: goes time
DIMENSIONS = {"events": "event", "solver": "step_number"}
#: columns of contacts that hold texts
EVENT_TEXTS = {"joint": "joint in contact", "kind": "contact, or open_contact: not over at the end"}
#: group of the pressure fields of a joint's film, see run/pressure_fields.py
FIELDS = "film"
PATH_OF_FIELDS = f"joints/{{}}/{FIELDS}"


class Result(Record):
    """A result file, read lazily.

    What of it cannot be read raises Damaged, naming the file and the place.
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.reader = open_checked(self.path, *KIND)
        self.file = self.reader.file

    def names(self, group: str) -> tuple[str, ...]:
        aside = {"time", DIMENSIONS.get(group)} if group else set()
        aside |= {FIELDS, WEAR} if group.startswith("joints/") else set()
        return tuple(n for n in self.reader.names(group) if n not in aside)

    def values(self, path: str) -> np.ndarray:
        along = None if path.partition("/")[0] in DIMENSIONS else self._samples
        try:
            column = self.reader.column(path, along)
        except Missing:
            if path == "time":
                raise
            raise KeyError(
                f"{self.reader.path.name} has no channel {path!r}; it may not have been stored "
                f"when the file was written"
            ) from None
        if column.dtype.kind != "f" or column.ndim != 1:
            raise Damaged(
                f"{self.path}: /{path} is no row of numbers, but {column.dtype} of shape "
                f"{column.shape}"
            )
        return column

    @cached_property
    def _samples(self) -> int:
        return math.prod(self.reader.shape("time"))

    def facts(self, group: str) -> dict:
        facts = self.reader.attributes(group) if self.reader.has(group) else {}
        return {
            n: v
            for n, v in facts.items()
            if n.removesuffix("_units") not in FACT_UNITS or not isinstance(v, str)
        }

    def units(self, path: str) -> str:
        return self.reader.attribute(path, "units")

    def _about(self, path: str) -> dict[str, str]:
        return {n: self.reader.attribute(path, n) for n in ("units", "long_name")}

    @property
    def attributes(self) -> dict:
        """Provenance: format, versions, scene JSON, kernel source, status."""
        return self.reader.attributes()

    @cached_property
    def scene(self) -> dict:
        """The scene's description, as plain data."""
        document = dict(self.reader.document("", "scene"))
        try:
            check(document)
        except ValueError as error:
            raise Damaged(f"{self.path}: attribute scene: {error}") from None
        return document

    @property
    def solver(self) -> dict:
        """Method, tolerances, counts and wall time of the run."""
        return self.reader.attributes("solver")

    @property
    def warnings(self) -> list[str]:
        """Warnings of the run, joint by joint."""
        return [str(w) for w in np.atleast_1d(self.reader.attribute("", "warnings"))]

    def range(self, path: str) -> tuple[float, float]:
        """Smallest and largest sample of a channel, without reading it."""
        low, high = self.reader.attribute(path, "actual_range")
        return float(low), float(high)

    @cached_property
    def located(self) -> Extremes | None:
        """Extremes that were located as the run went; of files of format 1 those of step ends,
        without their times.
        """
        if self.reader.has_attribute("", "stretch_s"):
            return _extremes_of_format_1(self.reader)
        if not self.reader.has("extremes"):
            return None
        columns = ("quantity", "units_of", "value", "when")
        names, units, values, times = (self.reader.column(f"extremes/{n}") for n in columns)
        if (
            values.shape != times.shape
            or values.shape[1:] != names.shape
            or names.shape != units.shape
        ):
            raise Damaged(f"{self.path}: /extremes holds columns that do not fit one another")
        if {names.dtype.kind, units.dtype.kind} != {"U"} or {
            values.dtype.kind,
            times.dtype.kind,
        } != {"f"}:
            raise Damaged(f"{self.path}: /extremes holds columns of another kind")
        length = float(self.reader.attribute("extremes", "stretch_s"))
        if not 0.0 < length < math.inf:
            raise Damaged(
                f"{self.path}: /extremes: attribute stretch_s must be positive, got {length!r}"
            )
        return Extremes(length, tuple(map(str, names)), tuple(map(str, units)), values, times)

    @cached_property
    def integrals(self) -> Integrals | None:
        """Integrals over time that were summed as the run went; none in files of versions before
        0.2.
        """
        if not self.reader.has("integrals"):
            return None
        names, units = self._columns("integrals", "U", "integral", "integral_units")
        (ends,) = self._columns("integrals", "f", "part_end")
        values = self.reader.column("integrals/amount")
        shape = len(ends), len(names)
        if values.dtype.kind != "f" or values.shape != shape or len(units) != len(names):
            raise Damaged(f"{self.path}: /integrals holds columns that do not fit one another")
        return Integrals(tuple(map(str, names)), tuple(map(str, units)), ends, values)

    @cached_property
    def errors(self) -> Errors:
        """Stated errors of metrics, extremes and channels; none in files of versions before 0.2."""
        if not self.reader.has("errors"):
            return Errors(
                reason=str(self.reader.attributes().get("errors_left_out", "none was requested"))
            )
        texts = self._columns("errors", "U", "name", "units_of", "kind", "channel")
        value, stated, film, share = self._columns(
            "errors", "f", "value", "stated", "film", "share"
        )
        (names, units, kinds, channels), about = texts, self.reader.attributes("errors")
        if not len(names) == len(units) == len(kinds) == len(value) == len(stated) == len(film):
            raise Damaged(f"{self.path}: /errors holds columns that do not fit one another")
        rows = zip(
            value.tolist(),
            stated.tolist(),
            map(str, units),
            map(str, kinds),
            film.tolist(),
            strict=True,
        )
        return Errors(
            dict(zip(map(str, names), (Error(*row) for row in rows), strict=True)),
            dict(zip(map(str, channels), share.tolist(), strict=False)),
            "",
            (float(about["rtol"]), float(about["companion_rtol"])),
            float(about["spread"]),
            float(about["begin_s"]),
            float(about["end_s"]),
            self._extreme_errors(),
            json.loads(about.get("asked", "{}")),
            about.get("cannot", ""),
        )

    def _columns(self, group: str, kind: str, *names: str) -> list[np.ndarray]:
        """Columns of a table, texts or numbers. Raises Damaged for those of another kind."""
        columns = [self.reader.column(f"{group}/{name}") for name in names]
        for name, column in zip(names, columns, strict=True):
            if column.dtype.kind != kind or column.ndim != 1:
                raise Damaged(f"{self.path}: /{group}/{name} is a column of another kind")
        return columns

    @cached_property
    def sensitivities(self) -> "Sensitivities":
        """Sensitivities of the metrics; none unless the run was made with some."""
        from clearance.results.sensitivity import Sensitivities

        if not self.reader.has("sensitivities"):
            about = self.reader.attributes().get("sensitivities_left_out", "none were requested")
            return Sensitivities(reason=str(about))
        texts = "metric", "metric_units", "parameter", "parameter_units"
        numbers = "metric_value", "size"
        columns = dict(zip(texts, self._columns("sensitivities", "U", *texts), strict=True))
        columns |= zip(numbers, self._columns("sensitivities", "f", *numbers), strict=True)
        columns |= {n: self.reader.column(f"sensitivities/{n}") for n in ("value", "error")}
        shape = len(columns["metric"]), len(columns["parameter"])
        if any(
            columns[n].dtype.kind != "f" or columns[n].shape != shape for n in ("value", "error")
        ):
            raise Damaged(f"{self.path}: /sensitivities holds no table of numbers")
        try:
            return Sensitivities.of_columns(columns)
        except ValueError as error:
            raise Damaged(f"{self.path}: /sensitivities: {error}") from None

    def _extreme_errors(self) -> ExtremeErrors | None:
        if self.located is None or not self.reader.has("extremes/stated"):
            return None
        columns = [self.reader.column(f"extremes/{n}") for n in ("stated", "film")]
        if any(f.dtype.kind != "f" or f.shape != self.located.values.shape for f in columns):
            raise Damaged(f"{self.path}: /extremes holds errors that do not fit its values")
        return ExtremeErrors(*columns)

    @property
    def events(self) -> dict[str, np.ndarray]:
        """The impact table: one entry per column, one row per contact."""
        columns = {
            name: self.reader.column(f"events/{name}") for name in ("time", *self.names("events"))
        }
        if any(column.shape != (columns["time"].size,) for column in columns.values()):
            raise Damaged(f"{self.path}: the columns of /events differ in length")
        if any((c.dtype.kind == "U") != (n in EVENT_TEXTS) for n, c in columns.items()):
            raise Damaged(f"{self.path}: a column of /events is of another kind")
        return Entries(f"{self.path}: /events", columns)

    def pressure_fields(self, joint: str) -> PressureFields | None:
        """Pressure fields of a joint's film; None where none was requested of the run."""
        place = PATH_OF_FIELDS.format(joint)
        if not self.reader.has(place):
            return None
        fields = PressureFields(**{n: self.reader.column(f"{place}/{n}") for n in FIELD_COLUMNS})
        shape = fields.instant.size, fields.axial.size, fields.angle.size
        if not fields.pressure.shape == fields.content.shape == shape:
            raise Damaged(f"{self.path}: /{place} holds columns that do not fit one another")
        return fields

    def to_xarray(self):
        """All of it as an xarray DataTree in memory, with the groups, units and attributes of the
        file.
        """
        xarray = extra("xarray")
        groups = [f"{kind}/{n}" for kind in PARTS for n in self.names(kind)]
        datasets = {"/": xarray.Dataset(attrs=self.attributes)}
        for group in [*groups, "energy", "friction", *DIMENSIONS]:
            if not (names := self.names(group)):
                continue
            along, columns = DIMENSIONS.get(group, "time"), {}
            for name in ("time", *names):
                values, about = (
                    self.reader.column(f"{group}/{name}"),
                    self.reader.attributes(f"{group}/{name}"),
                )
                columns[name] = (along, values, {n: about[n] for n in ("units", "long_name")})
            data = xarray.Dataset(columns, attrs=self.reader.attributes(group))
            datasets[f"/{group}"] = data.set_coords("time")
        if self.reader.has("extremes") and (located := self.located) is not None:
            along = ("stretch", "quantity")
            columns = {
                "value": (along, located.values),
                "when": (along, located.times, {"units": "s"}),
            }
            starts = located.length * np.arange(len(located.values))
            names = {
                "stretch": starts,
                "quantity": list(located.names),
                "units_of": ("quantity", list(located.units)),
            }
            datasets["/extremes"] = xarray.Dataset(columns, names)
        if (integrals := self.integrals) is not None:
            columns = {"amount": (("part_end", "integral"), integrals.values)}
            names = {"part_end": integrals.ends, "integral": list(integrals.names)}
            names["integral_units"] = "integral", list(integrals.units)
            datasets["/integrals"] = xarray.Dataset(columns, names)
        if errors := self.errors:
            columns = {
                n: ("name", [getattr(e, n) for e in errors.values()])
                for n in ("value", "stated", "film")
            }
            columns["units_of"] = "name", [e.units for e in errors.values()]
            columns["share"] = "channel", list(errors.channels.values())
            datasets["/errors"] = xarray.Dataset(
                columns, {"name": list(errors), "channel": list(errors.channels)}
            )
        if sensitivities := self.sensitivities:
            from clearance.results.sensitivity import COLUMNS

            columns = {n: (COLUMNS[n][0], values) for n, values in sensitivities.columns().items()}
            names = {n: columns.pop(n) for n in ("metric", "parameter")}
            datasets["/sensitivities"] = xarray.Dataset(columns, names)
        return xarray.DataTree.from_dict(datasets)

    def save(self, path: str | Path) -> Path:
        """Copy the file to `path`, under a temporary name until it is complete.

        Raises ValueError where that would replace a file that is no result.
        """
        path = Path(path)
        check_result(path)
        with replacing(path) as temporary:
            shutil.copyfile(self.path, temporary)
        return path

    def close(self) -> None:
        """Close the file; channels already read stay."""
        self.reader.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __repr__(self) -> str:
        return super().__repr__() if self.reader.is_open else "<Result, closed>"

    @property
    def _label(self) -> str:
        return self.reader.path.name


class HeldResult(Result):
    """The result of a run whose file has just been written: it is read from memory.

    reader: of its content.
    """

    def __init__(self, path: Path, reader: MemoryReader):
        self.path, self.reader = path, reader

    @cached_property
    def file(self):
        """Its file, opened."""
        return open_checked(self.path, *KIND).file


class MemoryResult(HeldResult):
    """A result without a file; `path` writes one, which goes with the result.

    image: makes the bytes of its file.
    """

    _label = Record._label

    def __init__(self, reader: MemoryReader, image: Callable[[], bytes]):
        self.reader, self._image = reader, image

    @cached_property
    def image(self) -> bytes:
        """The bytes of its file."""
        return self._image()

    @cached_property
    def file(self):
        """Its file, in memory."""
        return in_memory(temporary_name(self.reader.path), self.image)

    @cached_property
    def path(self) -> Path:
        """A temporary file."""
        path = temporary_file()
        path.write_bytes(self.image)
        weakref.finalize(self, shutil.rmtree, path.parent, ignore_errors=True)
        return path

    def save(self, path: str | Path) -> Path:
        """Write the file, see `Result.save`."""
        path = Path(path)
        check_result(path)
        with replacing(path) as temporary:
            temporary.write_bytes(self.image)
        return path


def _extremes_of_format_1(reader: Reader) -> Extremes:
    """Extremes of step ends, which were attributes of each channel and joint."""
    ends = {"lowest": "_min", "highest": "_max", "force_highest": "/force_max"}
    groups = [
        f"{kind}/{name}"
        for kind in ("bodies", "joints", "springs", "drives")
        for name in reader.names(kind)
    ]
    columns, units = {}, {}
    for place in [
        *groups,
        *(f"{group}/{name}" for group in groups for name in reader.names(group)),
    ]:
        about = reader.attributes(place)
        for attribute in ends.keys() & about.keys():
            columns[place + ends[attribute]] = about[attribute]
            units[place + ends[attribute]] = str(about.get("units", "N"))
    values = np.array(list(columns.values()), dtype=float).T.reshape(-1, len(columns))
    length = float(reader.attribute("", "stretch_s"))
    return Extremes(
        length, tuple(columns), tuple(units.values()), values, np.full(values.shape, np.nan)
    )


def open_result(path: str | Path) -> Result:
    """Open a result file. Raises FileNotFoundError or ValueError with a clear reason."""
    return Result(path)
