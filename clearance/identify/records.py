"""Measured joint friction: trials of a test bench, the files they are stored in, and what is
checked of them.

HDF5 (format "clearance-measurement"; SI, every dataset has `units` and `long_name`):

    /                 attributes: format, format_version, versions, created; the facts of the
                      measurement, such as bench, specimen, preload, recorded, recorded_by,
                      sensor_torque, sensor_torque_range, seed
    /trials/<name>/   attributes: kind, axis, role, order (place in the programme), and the
                      facts of the trial
        time                            [s], even steps
        rate_x rate_y rate_z            [rad/s] relative angular velocity; none: no rotation
        torque_x torque_y torque_z      [N m] torque that drives the motion; none: not measured
        angle_x angle_y angle_z         [rad] measured angle; none: that of the rate

Frame: that of the housing; x and y tilt, z is the stud, about which the joint spins. A dataset
whose `units` state ms, deg/s, N mm or kN m is converted.

CSV: one line a sample, headed by the same names, and `trial` (else the entire file is one trial),
`role` (else training), `kind`, `axis`. Other units are taken only where the name has them: time_ms,
rate_z_deg_s, torque_z_N_mm. The cells of a torque that a trial did not measure stay empty. For
what parts cells and stands above the header see identify/csv_rows.py. Lines "# name = value" and "#
trial.name = value" above the header are facts. Columns of other names are left aside.

A model of one's own may predict any columns (`read(..., predicts={"x": "m"})`). These are HDF5
datasets with their `units`, or CSV columns headed x or, in another unit, x [um].

Facts of trials are SI: preload [N], amplitude [rad], speed [rad/s], frequency [Hz].
"""

import csv
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import NamedTuple

import numpy as np

from clearance.files.locks import replacing
from clearance.files.texts import unpacked_text
from clearance.identify.csv_rows import number, rows_of
from clearance.identify.measured import Heading
from clearance.identify.trials import (
    AXES,
    COLUMNS,
    LABELS,
    OPTIONAL,
    QUANTITIES,
    Measurement,
    Series,
    Trial,
    Where,
    check,
    check_units,
)
from clearance.results.reading import Damaged, Reader, open_checked
from clearance.results.tables import provenance, save_tables
from clearance.values.checks import distinct, known
from clearance.values.units import UNITS
from clearance.values.units import plain as simple

FORMAT = "clearance-measurement"
FORMAT_VERSION = 1


# --- reading
def read(
    path: str | Path,
    *,
    trusted: bool = False,
    predicts: Mapping[str, str] | None = None,
    columns: Mapping[str, str] | None = None,
) -> Measurement:
    """Read a measurement, CSV (or packed, .csv.gz) where the file's name ends so, else HDF5.

    trusted: leave out `check_units`. predicts: columns that a model of one's own predicts, with
        their SI units. The trials are `Series` of these and all other columns of numbers, else
        `Trial`. columns: headings of any CSV file by the names of ours, such as {"rate_z": "speed
        [rad/s]"}, with or without the unit; its clock may be uneven.
    Raises FileNotFoundError, and ValueError naming trial, row and column.
    """
    path = Path(path)
    in_csv = path.name.lower().endswith((".csv", ".csv.gz"))
    if in_csv and not path.exists():
        raise FileNotFoundError(f"no measurement file {path}")
    if columns and not in_csv:
        raise ValueError(f"{path}: columns are named for CSV files; HDF5 has names of its own")
    of_file = path, "clearance measurement", FORMAT, FORMAT_VERSION
    with nullcontext() if in_csv else open_checked(*of_file) as file:
        try:
            read_from = _csv(path, predicts, columns or {}) if in_csv else _hdf5(file, predicts)
            raws, facts = read_from
            trials = (r.series(predicts) if predicts else r.trial(not columns) for r in raws)
            measurement = Measurement(tuple(trials), facts)
            if not trusted and not predicts:
                check_units(measurement, {r.name: r.row for r in raws})
        except Damaged:
            raise
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None
    return measurement


class Raw(NamedTuple):
    """A trial of a file: SI columns (n,) with their units, labels, facts, and places of samples."""

    name: str
    columns: dict[str, np.ndarray]
    units: dict[str, str]
    labels: dict[str, str]
    facts: dict
    row: Where = "row {}".format

    def check(self, names: Iterable[str], even: bool = True) -> None:
        """Raise ValueError for a column that is missing, or that cannot be."""
        for name in names:
            known(f"trial {self.name!r} has no column", name, self.columns)
        check(self.name, self.columns, self.row, even)

    def trial(self, even: bool) -> Trial:
        """Rates that are missing are zero, torques that are missing were not measured."""
        columns, name = self.columns, f"trial {self.name!r}"
        measured = tuple(f"torque_{a}" in columns for a in AXES)
        if not any(measured):
            raise ValueError(f"{name} has no column torque_x, torque_y or torque_z that is filled")
        for a in itertools.compress(AXES, measured):
            if f"rate_{a}" not in columns:
                raise ValueError(f"{name} has a column torque_{a} but no column rate_{a}")
        self.check(["time"], even)
        time = columns["time"]

        def of(quantity: str, absent: float) -> np.ndarray:
            there = (columns.get(f"{quantity}_{a}", np.full_like(time, absent)) for a in AXES)
            return np.stack([*there], axis=1)

        rate, turned = of("rate", 0.0), of("angle", math.nan)
        *tilts, spins = rate.any(axis=0)
        axis = "mixed" if spins and any(tilts) else "spin" if spins else "tilt"
        return Trial(
            self.name,
            **{"kind": "other", "role": "training", "axis": axis} | self.labels,
            time=time,
            rate=rate,
            torque=of("torque", 0.0),
            measured=measured,
            facts=self.facts,
            even=even,
            turned=turned if np.isfinite(turned).any() else None,
        )

    def series(self, predicts: Mapping[str, str]) -> Series:
        """All columns, those that are predicted in their units."""
        self.check(["time", *predicts])
        columns = self.columns.copy()
        time = columns.pop("time")
        units = {n: self.units.get(n) or predicts.get(n, "?") for n in columns}
        for column, wanted in predicts.items():
            if units[column] != wanted:
                reason = f"its units are {units[column]}, the model predicts {wanted}"
                raise ValueError(f"trial {self.name!r}, column {column}: {reason}")
        role = self.labels.get("role", "training")
        return Series(self.name, role, time, columns, units, self.facts)


def _si(units: str) -> tuple[str, float]:
    """The SI unit of a unit, and what a number in it is multiplied by; a unit that is not known
    stays.
    """
    kind, factor = UNITS.get(simple(units), (units, 1.0))
    return kind, factor


def _hdf5(file: Reader, predicts: Mapping[str, str] | None) -> tuple[list[Raw], dict]:
    """Trials and facts of an HDF5 file."""
    if not (names := file.names("trials")):
        raise ValueError("the file has no trials")
    about = {name: file.attributes(f"trials/{name}") for name in names}
    names = sorted(names, key=lambda name: (about[name].get("order", 0), name))
    ours = {*provenance(), "format"}
    facts = {k: plain(v) for k, v in file.attributes().items() if k not in ours}
    return [_hdf5_trial(file, name, about[name], predicts) for name in names], facts


def _hdf5_trial(file: Reader, name: str, about: dict, predicts: Mapping[str, str] | None) -> Raw:
    """A trial of a group of datasets, in the units they state; a series of all rows of numbers."""
    columns, units, present = {}, {}, file.names(f"trials/{name}")
    for column in present if predicts else [c for c in COLUMNS if c in present]:
        path, where = f"trials/{name}/{column}", f"trial {name!r}, column {column}"
        stated, values = file.attributes(path).get("units", ""), file.column(path)
        flat = values.ndim == 1 and values.dtype.kind in "iuf"
        if predicts and not flat:
            continue
        expected = {stated: 1.0} if predicts else COLUMNS[column][1]
        if stated not in expected:
            raise ValueError(f"{where}: its units must be {' or '.join(expected)}, got {stated!r}")
        if not flat:
            raise ValueError(
                f"{where} must be one row of numbers, got {values.dtype} of shape {values.shape}"
            )
        units[column], factor = _si(stated) if predicts else ("", expected[stated])
        columns[column] = np.asarray(values, float) * factor
    lengths = {c: len(v) for c, v in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"trial {name!r} has columns of different length: {lengths}")
    facts = {k: plain(v) for k, v in about.items() if k != "order"}
    labels = {label: facts.pop(label) for label in LABELS if label in facts}
    return Raw(name, columns, units, labels, facts)


def plain(value):
    """An HDF5 attribute as plain Python data."""
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def _csv(
    path: Path, predicts: Mapping[str, str] | None, renamed: Mapping[str, str]
) -> tuple[list[Raw], dict]:
    """Trials and facts of a CSV file."""
    comments, (_, *lines), (names, *cells) = rows_of(unpacked_text(path), 2)
    columns = _csv_series(names) if predicts else _csv_columns(names, renamed)
    table = dict(zip(names, zip(*cells, strict=True), strict=True))
    facts, by_trial = _csv_facts(comments)
    unused = [n for n in names if n not in columns and n not in ("trial", *LABELS)]
    facts |= {"columns_left_aside": unused} if unused else {}
    raws = []
    for name, part in _parts(path, table, lines):
        cells = {heading: texts[part] for heading, texts in table.items()}
        raws.append(_csv_trial(name, cells, columns, lines[part], by_trial.get(name, {})))
    return raws, facts


def _csv_columns(names: list[str], renamed: Mapping[str, str]) -> dict[str, tuple[str, float, str]]:
    """Columns of numbers by their heading: SI name, factor to SI, SI unit.

    renamed: headings by our names, with or without their unit. Raises ValueError for those that
    cannot be.
    """
    distinct("columns", names)
    heads = {name: Heading.of(name) for name in names}
    ours, present = {name: head.stem for name, head in heads.items()}, {}
    for column, heading in renamed.items():
        known("columns: no column", column, COLUMNS)
        there = {word: name for name, head in heads.items() for word in (name, *head[:2])}
        known("columns: no column", heading, there)
        ours[there[heading]] = column
    needed = tuple(q for q in QUANTITIES if q != OPTIONAL)
    for name, column in ours.items():
        if column in COLUMNS:
            of, factors = heads[name].unit, COLUMNS[column][1]
            units = {simple(unit): factor for unit, factor in factors.items()}
            if of not in ("", *units):
                raise ValueError(f"column {name!r} must be in {' or '.join(factors)}")
            present[name] = column, units.get(of, 1.0), next(iter(factors))
        elif column.lower().startswith(needed):
            headings = ", ".join(["trial", *LABELS, *COLUMNS])
            raise ValueError(f"column {name!r} is not known; known are {headings}")
    stems = [stem for stem, *_ in present.values()]
    distinct("columns in SI", stems)
    for quantity in needed:
        if not any(s.startswith(quantity) for s in stems):
            *wanted, last = [c for c in COLUMNS if c.startswith(quantity)]
            wanted = f"{', '.join(wanted)} or {last}" if wanted else last
            raise ValueError(f"there is no column {wanted}; there are {', '.join(names)}")
    return present


def _csv_series(names: list[str]) -> dict[str, tuple[str, float, str]]:
    """Columns of numbers by their heading, such as x or x [um]: name, factor to SI, SI unit (""
    where none is given).

    Raises ValueError for a name that comes twice.
    """
    series = {}
    for heading in names:
        stem, bracket, units = heading.partition("[")
        if stem.strip() in ("trial", *LABELS):
            continue
        kind, factor = _si(units.rstrip("] ")) if bracket else ("", 1.0)
        series[heading] = stem.strip(), factor, kind
    distinct("columns", (stem for stem, *_ in series.values()))
    return series


def _csv_facts(comments: Iterable[str]) -> tuple[dict, dict[str, dict]]:
    """Facts of the measurement, and of trials by their names, out of lines "# name = value"."""
    facts: dict = {}
    by_trial: dict[str, dict] = {}
    for text in comments:
        name, equals, value = text.partition("=")
        trial, dot, short = name.strip().rpartition(".")
        if not equals or not short:
            continue
        (by_trial.setdefault(trial, {}) if dot else facts)[short] = _value(value.strip())
    return facts, by_trial


def _value(text: str):
    """A number, a truth value, a list of numbers in brackets, or the text itself."""
    if text.startswith("[") and text.endswith("]"):
        parts = [_value(part.strip()) for part in text[1:-1].split(",")]
        return parts if all(isinstance(part, int | float) for part in parts) else text
    for kind in (int, float):
        try:
            number = kind(text)
        except ValueError:
            continue
        if kind is float or abs(number) < 2**63:
            return number
    return {"True": True, "False": False}.get(text, text)


def _parts(path: Path, table: dict, lines: list[int]) -> list[tuple[str, slice]]:
    """Names of trials and their rows. Raises ValueError where a trial goes on after another one."""
    if "trial" not in table:
        return [(path.stem.replace(".", "_").replace(" ", "_"), slice(None))]
    labels = np.array(table["trial"])
    starts = np.flatnonzero(np.append(True, labels[1:] != labels[:-1]))
    parts: dict[str, slice] = {}
    for begin, end in zip(starts, [*starts[1:], len(labels)], strict=True):
        name = str(labels[begin]).strip()
        if name in parts:
            raise ValueError(f"line {lines[begin]}: trial {name!r} comes a second time")
        parts[name] = slice(begin, end)
    return list(parts.items())


def _csv_trial(
    name: str, cells: Mapping, meaning: Mapping, lines: Sequence[int], facts: dict
) -> Raw:
    """A trial of cells by heading; meaning: columns of numbers; lines: of its rows."""
    columns, labels = {}, {}
    for heading, (stem, factor, _) in meaning.items():
        if stem == "time" or any(t.strip() for t in cells[heading]):
            columns[stem] = _numbers(name, heading, cells[heading], lines) * factor
    for label in [label for label in LABELS if label in cells]:
        values = {t.strip() for t in cells[label]}
        if len(values) > 1:
            raise ValueError(f"trial {name!r} has several {label}s: {', '.join(sorted(values))}")
        labels[label] = values.pop()
    units = {stem: unit for stem, _, unit in meaning.values()}
    return Raw(name, columns, units, labels, facts, lambda i: f"line {lines[i]}")


def _numbers(trial: str, column: str, texts, lines: Sequence[int]) -> np.ndarray:
    """Cells of a column as numbers. Raises ValueError naming the first that is none."""
    values = [number(text) for text in texts]
    if None in values:
        text, line = texts[values.index(None)], lines[values.index(None)]
        reason = "is empty" if not text.strip() else f"{text!r} is not a number"
        raise ValueError(f"trial {trial!r}, line {line}, column {column}: {reason}")
    return np.array(values)


# --- writing
def write(path: str | Path, measurement: Measurement) -> Path:
    """Write a measurement, CSV where the file's name ends so, else HDF5; completely or not at
    all.
    """
    path = Path(path)
    if path.suffix.lower() == ".csv":
        return _write_csv(path, measurement)
    tables = {}
    for order, trial in enumerate(measurement.trials):
        columns = {c: (*_about(trial, c), v) for c, v in _columns(trial).items()}
        labels = {label: getattr(trial, label) for label in LABELS if hasattr(trial, label)}
        tables[f"trials/{trial.name}"] = {**trial.facts, **labels, "order": order}, columns
    facts = {k: v for k, v in measurement.facts.items() if k not in provenance()}
    return save_tables(path, FORMAT, {**facts, "format_version": FORMAT_VERSION}, tables)


def _about(trial: Trial | Series, column: str) -> tuple[str, str]:
    """Units and meaning of a column."""
    if isinstance(trial, Series) and column != "time":
        return trial.units[column], column
    meaning, units = COLUMNS[column]
    return next(iter(units)), meaning


def _columns(trial: Trial | Series) -> dict[str, np.ndarray]:
    """Columns of a trial in a file: time, all rates and the measured torques; of a series all."""
    if isinstance(trial, Series):
        return {"time": trial.time, **trial.columns}
    rates = {f"rate_{a}": trial.rate[:, i] for i, a in enumerate(AXES)}
    torques = {f"torque_{a}": trial.torque[:, i] for i, a in enumerate(AXES) if trial.measured[i]}
    angles = {}
    if trial.turned is not None:
        angles = {f"angle_{a}": v for a, v in zip(AXES, trial.turned.T, strict=True)}
    angles = {n: v for n, v in angles.items() if np.isfinite(v).all()}
    return {"time": trial.time, **rates, **torques, **angles}


def _write_csv(path: Path, measurement: Measurement) -> Path:
    present = [label for label in LABELS if hasattr(measurement.trials[0], label)]
    there = dict.fromkeys(n for t in measurement.trials for n in _columns(t))
    names = sorted(there, key=[*COLUMNS, *there].index)
    with replacing(path) as temporary, open(temporary, "w", newline="", encoding="utf-8") as file:
        file.writelines(f"# {k} = {v}\n" for k, v in measurement.facts.items())
        file.writelines(
            f"# {t.name}.{k} = {v}\n" for t in measurement.trials for k, v in t.facts.items()
        )
        out = csv.DictWriter(file, ["trial", *present, *names])
        out.writeheader()
        for t in measurement.trials:
            labels = {"trial": t.name, **{label: getattr(t, label) for label in present}}
            columns = {n: map(repr, values.tolist()) for n, values in _columns(t).items()}
            cells = zip(*columns.values(), strict=True)
            out.writerows(labels | dict(zip(columns, row, strict=True)) for row in cells)
    return path
