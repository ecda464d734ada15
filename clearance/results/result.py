"""The result file: one HDF5 file a run, written as the run goes, complete or honestly partial.

Layout, in SI units; every dataset has `units` and `long_name`. Along time are /time, /bodies,
/joints, /springs, /drives, /energy. /events has one row per contact, /solver one per step. Along
each goes a dimension of its own, so that xarray opens the entire file as a tree. Columns carry
checksums: reading a damaged file names the place.
"""

import io
import math
import shutil
import weakref
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from clearance.files.locks import replace_file, replacing, temporary_file
from clearance.results.errors import Errors, ExtremeErrors
from clearance.results.extremes import Extremes, Integrals
from clearance.results.reading import (
    FACT_UNITS,
    Damaged,
    Entries,
    MemoryReader,
    Missing,
    Reader,
    open_checked,
)
from clearance.results.record import (
    PARTS,
    WEAR,
    Description,
    PressureFields,
    Record,
    extra,
)
from clearance.results.tables import (
    EXTREMES,
    FIELDS_OF_PRESSURE,
    FORMAT,
    FORMAT_VERSION,
    LOCATED,
    OF_ERRORS,
    OF_EXTREMES,
    Group,
    check_result,
    error_groups,
    errors_of,
    extremes_group,
    integrals_group,
    integrals_of,
    reopened,
)
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
            raise self._without(path) from None
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
        document = Description(self.reader.document("", "scene"))
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
        names, units, _, values, times = EXTREMES.read(self.reader, "extremes", LOCATED).values()
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
        return integrals_of(self.reader)

    @cached_property
    def errors(self) -> Errors:
        """Stated errors of metrics, extremes and channels; none in files of versions before 0.2."""
        if not self.reader.has("errors"):
            return Errors(
                reason=str(self.reader.attributes().get("errors_left_out", "none was requested"))
            )
        return errors_of(self.reader, self._extreme_errors())

    @cached_property
    def sensitivities(self) -> "Sensitivities":
        """Sensitivities of the metrics; none unless the run was made with some."""
        from clearance.results.sensitivity import SENSITIVITIES, Sensitivities

        if not self.reader.has("sensitivities"):
            about = self.reader.attributes().get("sensitivities_left_out", "none were requested")
            return Sensitivities(reason=str(about))
        columns = SENSITIVITIES.read(self.reader, "sensitivities")
        try:
            return Sensitivities.of_columns(columns)
        except ValueError as error:
            raise Damaged(f"{self.path}: /sensitivities: {error}") from None

    def _extreme_errors(self) -> ExtremeErrors | None:
        if self.located is None or not self.reader.has("extremes/stated"):
            return None
        columns = EXTREMES.read(self.reader, "extremes", [*OF_EXTREMES, *OF_ERRORS])
        return ExtremeErrors(*(columns[n] for n in OF_ERRORS))

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
        return Entries(f"{self.reader.path}: /events", columns)

    def pressure_fields(self, joint: str) -> PressureFields | None:
        """Pressure fields of a joint's film; None where none was requested of the run."""
        path = PATH_OF_FIELDS.format(joint)
        if not self.reader.has(path):
            return None
        return PressureFields(**FIELDS_OF_PRESSURE.read(self.reader, path))

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
        for path, group in self._tables().items():
            datasets[f"/{path}"] = xarray.Dataset(group.variables())
        return xarray.DataTree.from_dict(datasets)

    def _tables(self) -> dict[str, Group]:
        """Tables beside the channels, by their groups."""
        tables: dict[str, Group] = {}
        if self.reader.has("extremes") and self.located is not None:
            tables["extremes"] = extremes_group(self.located)
        if self.integrals is not None:
            tables["integrals"] = integrals_group(self.integrals)
        if self.errors:
            tables["errors"] = error_groups(self.errors)["errors"]
        return tables | (self.sensitivities.groups() if self.sensitivities else {})

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
        return reopened(io.BytesIO(self.image))

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
        replace_file(path, self.image)
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
    for path in [
        *groups,
        *(f"{group}/{name}" for group in groups for name in reader.names(group)),
    ]:
        about = reader.attributes(path)
        for attribute in ends.keys() & about.keys():
            columns[path + ends[attribute]] = about[attribute]
            units[path + ends[attribute]] = str(about.get("units", "N"))
    values = np.array(list(columns.values()), dtype=float).T.reshape(-1, len(columns))
    length = float(reader.attribute("", "stretch_s"))
    return Extremes(
        length, tuple(columns), tuple(units.values()), values, np.full(values.shape, np.nan)
    )


def open_result(path: str | Path) -> Result:
    """Open a result file. Raises FileNotFoundError or ValueError with a clear reason.

    Example:

        >>> path = cl.simulate(cl.load_case("slider_crank"), turns=1).save("run.h5")
        >>> cl.open_result(path).status
        'complete'
    """
    return Result(path)
