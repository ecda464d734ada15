"""Tables of runs for other programs: CSV, MATLAB, LaTeX; two runs side by side."""

import csv
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from clearance.files.locks import replacing
from clearance.metrics.metrics import metrics
from clearance.results.record import Record
from clearance.results.stream import fits_path
from clearance.values.checks import meant

RELATIVE = 1e-12  # difference of two numbers over the larger one that is rounding
#: letters that LaTeX reads as commands
ESCAPED = str.maketrans({c: f"\\{c}" for c in "_%&#$"})


def channels_of(run: Record, patterns: Sequence[str] | None = None) -> list[str]:
    """Paths of stored channels that patterns fit, such as "joints/B/*"; all without patterns.

    Raises ValueError for a pattern that fits none.
    """
    if patterns is None:
        return list(run.channels)
    chosen: dict[str, None] = {}
    for pattern in [patterns] if isinstance(patterns, str) else patterns:
        fits = [p for p in run.channels if fits_path(p, pattern)]
        if not fits:
            raise ValueError(f"no channel {pattern!r}{meant(pattern, run.channels)}")
        chosen |= dict.fromkeys(fits)
    return list(chosen)


def to_csv(run: Record, path: str | Path, channels: Sequence[str] | None = None) -> Path:
    """Write channels along time as CSV with units in the heads; `cl.compare` and `cl.fit` read it.

    channels: paths or patterns, such as "bodies/slider/*"; default all. Raises ValueError for a
    channel that is not stored.
    """
    names = channels_of(run, channels)
    heads = ["time [s]", *(f"{name} [{run.units(name)}]" for name in names)]
    columns = [run.time, *(run.values(name) for name in names)]
    with replacing(Path(path)) as temporary, open(temporary, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(heads)
        writer.writerows([repr(float(v)) for v in row] for row in zip(*columns, strict=True))
    return Path(path)


def to_mat(run: Record, path: str | Path, channels: Sequence[str] | None = None) -> Path:
    """Write channels for MATLAB: bodies.slider.ax and so on, time, units of each, metrics.

    channels: as in `to_csv`. Raises ValueError for a channel that is not stored.
    """
    from scipy.io import savemat

    data: dict = {"time": run.time, "case_name": run.attributes["case"], "units": {}}
    for name in channels_of(run, channels):
        for tree, value in ((data, run.values(name)), (data["units"], run.units(name))):
            *groups, last = name.split("/")
            for group in groups:
                tree = tree.setdefault(group, {})
            tree[last] = value
    data["metrics"] = {name: m.value for name, m in _metrics(run).items()}
    with replacing(Path(path)) as temporary:
        savemat(temporary, data, appendmat=False, long_field_names=True, oned_as="column")
    return Path(path)


def to_latex(
    run: Record, path: str | Path | None = None, metrics: Sequence[str] | None = None
) -> str:
    """A LaTeX table of the metrics of a run with their stated errors.

    path: of a file that it is written to.

    metrics: names or patterns, such as "joint_B_*"; default all. Raises ValueError for a metric
    that the run does not have.
    """
    every = _metrics(run)
    chosen = [n for p in metrics or ["*"] for n in every if fits_path(n, p)]
    if not chosen:
        raise ValueError(f"no metric {metrics!r}{meant(str(metrics[0]), every)}")
    lines = ["\\begin{tabular}{lrl}", "\\hline", "quantity & value & unit \\\\", "\\hline"]
    for name in dict.fromkeys(chosen):
        one = every[name]
        row = run.errors.get(name)
        number = _with_error(one.value, row.total if row and row.value == one.value else 0.0)
        units = "" if one.units in ("-", "1") else one.units
        lines.append(f"{one.text.translate(ESCAPED)} & ${number}$ & {units} \\\\")
    text = "\n".join([*lines, "\\hline", "\\end{tabular}", ""])
    if path is not None:
        with replacing(Path(path)) as temporary:
            temporary.write_text(text, encoding="utf-8")
    return text


def _metrics(run: Record) -> dict:
    """Metrics of a run by name; none where it lacks their channels."""
    try:
        return metrics(run)
    except KeyError:
        return {}


def _with_error(value: float, error: float) -> str:
    """A number with its error in LaTeX, to the last digit that the error has."""
    if not math.isfinite(value):
        return "\\infty" if value > 0.0 else "-"
    if not 0.0 < error < math.inf:
        return _powers(f"{value:.6g}")
    power = math.floor(math.log10(error))
    error = math.ceil(error / 10.0**power) * 10.0**power
    if -6 <= power < 0 and abs(value) < 1e6:
        return f"{value:.{-power}f} \\pm {error:.{-power}f}"
    digits = max(math.floor(math.log10(abs(value))) - power, 0) if value else 0
    return f"{_powers(f'{value:.{digits}e}')} \\pm {_powers(f'{error:.0e}')}"


def _powers(text: str) -> str:
    number, _, power = text.partition("e")
    return f"{number} \\cdot 10^{{{int(power)}}}" if power else number


@dataclass(frozen=True)
class Difference:
    """A number of two runs. errors: stated of both, added, None where one is not stated."""

    name: str
    first: float
    second: float
    units: str
    errors: float | None

    @property
    def change(self) -> float:
        """Second less first."""
        return self.second - self.first

    @property
    def relative(self) -> float:
        """Change over the first; infinite where that is 0."""
        return self.change / abs(self.first) if self.first else math.copysign(math.inf, self.change)

    @property
    def beyond(self) -> bool:
        """True where the change is larger than both errors together, or than rounding."""
        least = RELATIVE * max(abs(self.first), abs(self.second))
        return abs(self.change) > max(self.errors or 0.0, least)


def differences(first: Record, second: Record) -> list[Difference]:
    """Metrics that both runs have, with their changes and stated errors."""
    ones, others = _metrics(first), _metrics(second)
    rows = []
    for name in (n for n in ones if n in others):
        values = ones[name].value, others[name].value
        if not all(map(math.isfinite, values)):
            continue
        stated = [run.errors.get(name) for run in (first, second)]
        errors = None if None in stated else sum(e.total for e in stated)
        rows.append(Difference(name, *values, ones[name].units, errors))
    return rows


def changed_facts(first: Record, second: Record) -> Iterator[tuple[str, object, object]]:
    """Facts that two runs do not share: case, parameters, tolerance, method, numbers of scenes."""
    facts = [_facts(run) for run in (first, second)]
    for name in dict.fromkeys([*facts[0], *facts[1]]):
        pair = tuple(f.get(name) for f in facts)
        if pair[0] != pair[1]:
            yield name, *("default" if v is None else v for v in pair)


def _facts(run: Record) -> dict[str, object]:
    """Facts about a run by name; those of its scene by their path."""
    about = {"case": run.attributes["case"], "status": run.status}
    about |= {n: run.solver.get(n) for n in ("method", "rtol")}
    if not math.isnan(end := float(run.time[-1]) if run.time.size else math.nan):
        about["length [s]"] = end
    about |= {f"parameter {n}": v for n, v in json.loads(run.attributes["parameters"]).items()}
    return about | dict(_leaves("", _by_file(run.scene)))


def _by_file(scene: dict) -> dict:
    """A scene whose laws go by the names of their files: a case and a scene file load the same
    file as two modules.
    """
    text = json.dumps(scene)
    for module, source in scene.get("sources", {}).items():
        text = text.replace(f'"{module}', f'"{Path(source["file"]).name}')
    return json.loads(text)


def _leaves(path: str, value: object) -> Iterator[tuple[str, object]]:
    """Numbers and words of plain data, by their paths; parts by their names."""
    if isinstance(value, dict):
        for name, entry in value.items():
            yield from _leaves(f"{path}/{name}" if path else name, entry)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for i, entry in enumerate(value):
            yield from _leaves(f"{path}/{entry.get('name', i)}", entry)
    else:
        yield path, value
