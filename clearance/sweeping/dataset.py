"""Labelled records of a case: drawn parameters, computed channels, the noise of a sensor.

A record has channels at even angles of the drive, of settled turns. They have passed the filter of
a sensor and have its noise. `records.h5` has the labels and records of all points, `card.md` the
facts about them. Runs are a sweep in the folder `sweep`. The same seed
gives the same bytes with the same version on the same kind of processor.
"""

import json
import shlex
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from clearance.files.locks import replace_file
from clearance.files.texts import listed, markdown
from clearance.metrics.sensor import crossed, deviation, filtered, turned
from clearance.results.tables import FORMAT_VERSION, provenance, save_tables
from clearance.scene.catalogue import find_case, load_case
from clearance.scene.parameter import varied
from clearance.sweeping.index import Sweep
from clearance.sweeping.points import sampled
from clearance.sweeping.sweep import sweep
from clearance.values import checks
from clearance.values.units import quantity

FORMAT = "clearance-dataset"
KIND = "clearance dataset", FORMAT, FORMAT_VERSION
RECORDS, CARD = "records.h5", "card.md"
AROUND = 2.0  # usual ranges: the default over and times this
USUAL = ("clearance", "viscosity", "speed")  # parameters that are drawn by default


def dataset(
    case: str | Path,
    folder: str | Path,
    channels: str | Iterable[str],
    *,
    ranges: Mapping[str, tuple] | None = None,
    fixed: Mapping[str, object] | None = None,
    points: int = 1000,
    seed: int = 0,
    turns: int = 2,
    settle: int = 2,
    samples_per_turn: int = 360,
    noise: float | str = "1%",
    lowpass: tuple[int, float] | None = None,
    mounting: float | str = 0.0,
    workers: int | None = None,
    progress: Callable | None = None,
) -> Path:
    """Make labelled records of a case and return the path of their file.

    channels: of a run, such as "bodies/slider/ax". ranges: (low, high) or (low, high, "log") by
        parameter; default clearance, viscosity and speed of the case, each within a factor of 2 of
        its default. fixed: other parameters. turns: of a record, after `settle` turns. noise:
        standard deviation in SI, or over the range of each record ("1%"). lowpass: order and corner
        [Hz] of a Butterworth filter. mounting: standard deviation [rad] of the angle at which a
        sensor of x, y or both is mounted, drawn for each record. workers, progress: see `sweep`.
    A point that fails has nan in its records, and its reason among the labels. Raises ValueError
    for input that is wrong, before anything runs.
    """
    names = listed(channels) or []
    if not names:
        raise ValueError("dataset: give at least one channel, such as bodies/slider/ax")
    if isinstance(noise, str) and noise.strip().endswith("%"):
        checks.share("noise", noise)
    mounting = quantity(mounting, "rad")
    checks.non_negative("mounting", mounting)
    partners = [crossed(n)[0] for n in names] if mounting else []
    ranges = dict(ranges) if ranges else usual(case, fixed or {})
    drawn = sampled(points, seed=seed, **ranges)
    runs = sweep(
        case,
        drawn,
        Path(folder) / "sweep",
        fixed=dict(fixed or {}),
        channels=[f"{name}*" for name in dict.fromkeys([*names, *partners])],
        turns=turns + settle,
        settle=settle,
        samples_per_turn=samples_per_turn,
        workers=workers,
        progress=progress,
    )
    about = {
        "case": str(case),
        "channels": json.dumps(names),
        "seed": seed,
        "turns": turns,
        "settle": settle,
        "samples_per_turn": samples_per_turn,
        "noise": str(noise),
        "lowpass": json.dumps(lowpass),
        "mounting": mounting,
        "fixed": json.dumps(dict(fixed or {}), default=str),
    }
    about["command"] = command(about | {"points": points}, ranges, fixed or {}, lowpass)
    return _written(Path(folder), runs, names, about, noise, lowpass)


def command(about: Mapping, ranges: Mapping, fixed: Mapping, lowpass) -> str:
    """The command that makes the same records."""
    words, parameters = ["clearance", "dataset", about["case"]], find_case(about["case"]).parameters
    for name, (low, high, *log) in ranges.items():
        ends = (parameters[name].value(str(end)) for end in (low, high))
        words += ["-p", f"{name}={':'.join(map(str, [*ends, *log]))}"]
    for name, value in fixed.items():
        words += ["-p", f"{name}={value}"]
    words += ["--channels", ",".join(json.loads(about["channels"]))]
    for option in ["points", "seed", "turns", "settle", "samples_per_turn", "noise", "mounting"]:
        words += [f"--{option.replace('_', '-')}", str(about[option])]
    words += ["--lowpass", "{}:{}".format(*lowpass)] if lowpass else []
    return shlex.join(words)


def column_of(channel: str) -> str:
    """Name of the column of a channel."""
    return channel.replace("/", "_")


def usual(case, fixed: Mapping[str, object]) -> dict[str, tuple]:
    """Ranges of the parameters that are drawn by default."""
    described = find_case(case)
    there = [n for n in USUAL if n in described.parameters and n not in fixed]
    values = {n: abs(varied(load_case(case, **fixed), n).value) for n in there}
    if not values:
        raise ValueError(f"dataset: the case has none of {', '.join(USUAL)}; give ranges")
    return {n: (v / AROUND, v * AROUND, "log") for n, v in values.items()}


def _written(folder: Path, runs: Sweep, names, about: dict, noise, lowpass) -> Path:
    """The file of the records and the card."""
    count, length = len(runs), about["turns"] * about["samples_per_turn"]
    records = {n: np.full((count, length), np.nan, np.float32) for n in names}
    sizes, units = {n: np.full(count, np.nan) for n in names}, {}
    angles = {n: np.full(count, np.nan) for n in names}
    check = partial(checks.non_negative, "noise")
    for index in np.flatnonzero(runs.done):
        random = np.random.default_rng([about["seed"], int(index)])
        mounted, sensors = np.random.default_rng([about["seed"], int(index), 1]), {}
        with runs.run(int(index)) as run:
            for name in names:
                angle = sensors.setdefault(name[:-1], mounted.normal(0.0, about["mounting"]))
                angles[name][index] = angle
                values = filtered(run.time, turned(run, name, angle), lowpass)[-length - 1 : -1]
                sizes[name][index] = sigma = deviation(noise, float(np.ptp(values)), check)
                records[name][index] = values + random.normal(0.0, sigma, length)
                part = name if name in run else f"{name}_x"
                units[name] = run.units(part)
    if not units:
        raise ValueError(f"dataset: no point has a run; {runs.folder} has the reasons")
    parameters = find_case(about["case"]).parameters
    labels = {n: (parameters[n].units, n, np.asarray(v)) for n, v in runs.columns.items()}
    labels["done"] = "1", "whether the run came to its end", runs.done.astype(np.int8)
    columns = {}
    for name, unit in units.items():
        column = column_of(name)
        columns[column] = unit, f"{name} with noise", records[name]
        text = f"standard deviation of the noise of {name}"
        labels[f"noise_{column}"] = unit, text, sizes[name]
        if about["mounting"]:
            text = f"angle at which the sensor of {name} is mounted"
            labels[f"mounting_{column}"] = "rad", text, angles[name]
    angle = np.arange(length) * (360.0 / about["samples_per_turn"])
    columns["angle"] = "deg", "angle of the drive behind the first sample", angle
    tables = {"labels": ({}, labels), "records": ({}, columns)}
    replace_file(folder / CARD, card(runs, names, units, provenance() | about))
    about = {"synthetic": "yes"} | about
    return save_tables(folder / RECORDS, FORMAT, about, tables, dated=False)


def scored(folder: Path, scores: Mapping[str, Mapping[str, float]]) -> None:
    """Add scores of an estimator to the card."""
    path = folder / CARD
    head = path.read_text(encoding="utf-8").partition("\n## Baseline")[0]
    heads = "label", "rms error of its logarithm", "95 % intervals that hold it", "records"
    rows = (
        (n, f"{s['rms_of_logarithm']:.3g}", f"{100.0 * s['inside_95']:.3g} %", s["records"])
        for n, s in scores.items()
    )
    table = markdown(heads, rows)
    text = "\n".join([head.rstrip(), "", "## Baseline", "", "`clearance fit`:", "", *table, ""])
    replace_file(path, text)


def _or_none(text: str) -> str:
    """JSON of an option for readers."""
    return "none" if text in ("null", "{}") else text


def card(runs: Sweep, names, units: Mapping[str, str], about: Mapping[str, object]) -> str:
    """The card of a data set: its nature, contents, source and limits."""
    ends = {n: (min(v), max(v)) for n, v in runs.columns.items()}
    lines = [
        f"# Records of {about['case']}",
        "",
        "**Synthetic**: computed by clearance, no measurement of a machine.",
        "",
        f"- {len(runs)} points, {int(runs.done.sum())} with records; seed {about['seed']}.",
        f"- Each record: {about['turns']} turns after {about['settle']}, "
        f"{about['samples_per_turn']} samples a turn.",
        f"- Channels: {', '.join(f'{n} [{units[n]}]' for n in names)}.",
        f"- Sensor: noise {about['noise']}, low-pass {_or_none(about['lowpass'])}, "
        f"mounted within {about['mounting']:g} rad (standard deviation).",
        *(
            f"- Label {n}: {low:.6g} to {high:.6g} [{runs.definition.units.get(n, '?')}]."
            for n, (low, high) in ends.items()
        ),
        f"- Fixed: {_or_none(about['fixed'])}.",
        f"- The same again: `{about['command']}`.",
        f"- Made by clearance {about['version_clearance']}, numpy {about['version_numpy']}, "
        f"Python {about['version_python']}.",
        "",
        "`records.h5`: `/labels` has a value for each point, in SI; `/records/CHANNEL` a row of "
        "samples for each point, over `/records/angle` [deg]; nan where a run failed.",
        "",
    ]
    return "\n".join(lines)
