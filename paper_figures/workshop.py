"""Common parts of the scripts of figures: results that are stored, pictures as PNG and PDF, tables,
notes.

A script is a module of this folder with a docstring (its title, then a paragraph for each of
`PARTS`) and a function `draw(work)`, which `clearance figures NAME` calls. The function requests
results from `work` and hands it the drawing. Results lie under `DIR/results`, or in a folder given.
They are used again as long as the scene, the options, the case and the code of the physics are the
same.
"""

import ast
import csv
import hashlib
import inspect
import json
import logging
import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

from clearance.postprocess.figures import save

import clearance as cl
from clearance.files.locks import Lock
from clearance.files.sealed import digest_of_code
from clearance.results.record import Record
from clearance.results.result import Result
from clearance.scene.catalogue import find_case
from clearance.sweeping.index import Sweep
from clearance.sweeping.points import Points
from clearance.values.checks import known

FOLDER = Path(__file__).parent
#: folders that are installed into the package
BESIDE = ("cases", "postprocess", "paper_figures")
#: modules of this folder that draw nothing themselves
SHARED = (
    "__init__",
    "workshop",
    "gallery",
    "completeness",
    "operation_counts",
    "ball_joint_bench",
    "ball_joint_studies",
    "ball_joint_variants",
    "ball_joint_response",
    "ablation",
    "film_ladder",
    "films",
    "peers",
    "physics",
    "stress",
    "work_precision",
)
KINDS = (".png", ".pdf")
#: groups of figures in their order, by the source they answer
GROUPS = {
    "feeder": "Six-bar rocking feeder (Jin et al. 2023)",
    "chains": "Open and closed chains with joint friction (Guo, Ju and Wang 2024)",
    "manipulator": "Mobile manipulator (Chacko and Khan 2017)",
    "ball joint": "Ball joint (Pfitzer et al. 2025)",
    "joints": "Models and dynamics of joints with clearance and friction",
    "evidence": "Evidence of the code",
    "measured": "Measurements of the code",
}
#: the group whose figures measure the code, most of them its run times: they are drawn one at a
#: time, by name or on request
TIMED = "measured"
#: paragraphs of a script's docstring: one of GROUPS, the questions of the source, the reproduced
#: part, the assumptions. The last has numbers that cannot be compared because the source gives
#: none.
PARTS = ("Group", "Answers", "Reproduced", "Assumed", "Not comparable")
#: packages on whose sources no result depends
WITHOUT_PHYSICS = ("commands", "studies")


def names() -> list[str]:
    """Names of all figures, which are those of their scripts: group by group, then by the
    alphabet.
    """
    order, scripts = list(GROUPS), (p.stem for p in FOLDER.glob("*.py") if p.stem not in SHARED)
    return sorted(scripts, key=lambda name: (order.index(about(name)[1]["Group"]), name))


def about(name: str) -> tuple[str, dict[str, str]]:
    """Title of a figure and the paragraphs of its docstring by PARTS.

    Raises ValueError for a paragraph that is missing and for an unknown group.
    """
    text = ast.get_docstring(ast.parse((FOLDER / f"{name}.py").read_text(encoding="utf-8"))) or ""
    title, *paragraphs = [" ".join(p.split()) for p in text.split("\n\n")]
    parts = dict(p.split(": ", 1) for p in paragraphs if p.partition(": ")[0] in PARTS)
    if missing := [p for p in PARTS if p not in parts]:
        raise ValueError(
            f"paper_figures/{name}.py: its docstring has no paragraph '{missing[0]}: ...'"
        )
    if parts["Group"] not in GROUPS:
        groups = ", ".join(GROUPS)
        raise ValueError(
            f"paper_figures/{name}.py: no group {parts['Group']!r}; there are {groups}"
        )
    return title.rstrip("."), parts


def timed(name: str) -> bool:
    """True for a figure that measures the code, most of them run times."""
    return about(name)[1]["Group"] == TIMED


def listing(names: list[str]) -> list[str]:
    """Names and titles in print, under the titles of their groups; names of a group that stand
    apart repeat it.
    """
    lines, width, last = [], max(map(len, names)), None
    for name in names:
        title, parts = about(name)
        if parts["Group"] != last:
            last = parts["Group"]
            lines += ["", GROUPS[last]]
        lines.append(f"  {name:<{width}}  {title}")
    return lines[1:]


def chosen(patterns: list[str], names: list[str]) -> list[str]:
    """Names that a pattern fits, in the order of the patterns and then of the groups; all where
    none is given.

    Raises ValueError for a pattern that fits none.
    """
    for pattern in patterns:
        if not any(fnmatch(n, pattern) for n in names):
            known("no figure", pattern, names)
    return list(dict.fromkeys(n for p in patterns or ["*"] for n in names if fnmatch(n, p)))


class Workshop:
    """Place where the pictures and tables of one figure are made, with a note of its sources.

    folder: of pictures and tables; name: of the figure, stem of its files; quick: a coarse preview,
        for which scripts request `less`; fresh: runs of before are not used again; `say`: called
        with a text on each piece of work; results: folder of runs and sweeps, which several folders
        of pictures may share (default `results` in the first one).
    """

    def __init__(
        self,
        folder: Path,
        name: str,
        quick: bool = False,
        fresh: bool = False,
        say: Callable[[str], None] = lambda text: None,
        results: Path | None = None,
    ):
        self.folder, self.name, self.quick, self.fresh, self.say = (
            Path(folder),
            name,
            quick,
            fresh,
            say,
        )
        self.shared = Path(results) if results else self.folder / "results"
        self.files: list[str] = []
        self.results: list[dict] = []

    def less(self, full, quick):
        """`full`, or `quick` in a preview."""
        return quick if self.quick else full

    # --- results
    def run(self, case: str, parameters: Mapping | None = None, **options) -> Result:
        """The result of `cl.simulate(cl.load_case(case, **parameters), **options)`.

        No second run states errors, unless options has `error`: no figure shows them.
        """
        return self._result(cl.simulate, case, parameters, {"error": None} | options)

    def inverse(self, case: str, parameters: Mapping | None = None, **options) -> Record:
        """The record of `cl.inverse_dynamics(cl.load_case(case, **parameters), **options)`."""
        return self._result(cl.inverse_dynamics, case, parameters, options)

    def _result(
        self, call: Callable, case: str, parameters: Mapping | None, options: dict
    ) -> Result:
        parameters = dict(parameters or {})
        scene = cl.load_case(case, **parameters)
        note = {"call": call.__name__, "case": case, "parameters": parameters, "options": options}
        name = f"{Path(case).stem}-{_digest(case, call.__name__, options, scene.to_json())}.h5"
        path = self.shared / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with Lock(path.with_suffix(".lock"), wait=True):  # another figure may need the same
            if self.fresh or not _whole(path):
                self.say(f"{case}: {_listed(parameters | options)}")
                with _named(f"{self.name}: {case} with {_listed(parameters) or 'its defaults'}"):
                    call(scene, path=path, **options).close()
        result = cl.open_result(path)
        self.results.append({"file": self._relative(path)} | note)
        return result

    def sweep(self, case: str, points: Points, *, fixed: Mapping | None = None, **options) -> Sweep:
        """The sweep of `cl.sweep(case, points, fixed=fixed, **options)`; all its points have to
        succeed.
        """
        fixed = dict(fixed or {})
        note = {"call": "sweep", "case": case, "parameters": fixed, "options": options}
        path = (
            self.shared
            / f"{Path(case).stem}-sweep-{_digest(case, note, points.columns, points.axes)}"
        )
        if self.fresh:
            shutil.rmtree(path, ignore_errors=True)

        def progress(p):
            self.say(f"{case}: {p.before + p.done} of {p.total} points")

        path.parent.mkdir(parents=True, exist_ok=True)
        with Lock(path.with_suffix(".lock"), wait=True), _named(f"{self.name}: {case}"):
            result = cl.sweep(
                case, points, path, fixed=fixed, progress=progress, retry_failed=True, **options
            )
        swept = {n: [min(v), max(v), len(set(v))] for n, v in points.columns.items()}
        self.results.append(
            {"file": self._relative(path)} | note | {"swept": swept, "points": len(points)}
        )
        if not result.done.all():
            raise RuntimeError(
                f"{path}: {int((~result.done).sum())} of {len(points)} points did not run"
            )
        return result

    def life(self, case, parameters: Mapping | None = None, **plan) -> cl.Life:
        """The life of `cl.wear(case, **plan, **parameters)`, of a case or a scene."""
        parameters = dict(parameters or {})
        scene = case if isinstance(case, cl.Scene) else cl.load_case(case, **parameters)
        note = {"call": "wear", "case": scene.name, "parameters": parameters, "options": plan}
        text = json.dumps([plan, scene.to_json(), _sources()], sort_keys=True, default=str)
        digest = hashlib.sha256(text.encode()).hexdigest()[:12]
        path = self.shared / f"{scene.name}-life-{digest}"
        if self.fresh:
            shutil.rmtree(path, ignore_errors=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        with Lock(path.with_suffix(".lock"), wait=True), _named(f"{self.name}: {scene.name}"):
            self.say(f"{scene.name}: {_listed(parameters | plan)}")
            result = cl.wear(scene, directory=path, **plan)
        self.results.append({"file": self._relative(path)} | note)
        return result

    def study(self, write: Callable[[Path], Path], **note) -> None:
        """Keep the data of a study: write(folder) gives the file; note: parameters behind it."""
        path = write(self.folder / "results" / self.name)
        self.results.append({"file": self._relative(path)} | note)

    # --- pictures and tables
    def keep(self, figure, suffix: str = "") -> None:
        """Save a figure in all kinds."""
        self.drawing(lambda path: save(figure, path, dpi=150), suffix=suffix)

    def drawing(self, draw: Callable, *arguments, suffix: str = "", **more) -> None:
        """Save in all kinds what draw(*arguments, path, **more) draws; suffix: distinguishes the
        pictures of a script.
        """
        for kind in KINDS:
            path = self._file(suffix, kind)
            draw(*arguments, path, **more)

    def table(
        self, heads: Sequence[str], rows: Sequence[Sequence], suffix: str = "", remarks: str = ""
    ) -> None:
        """Save a table as Markdown, with remarks below, and as CSV; cells are texts or numbers
        (four digits).
        """
        cells = [[f"{c:.4g}" if isinstance(c, float) else str(c) for c in row] for row in rows]
        lines = ["| " + " | ".join(row) + " |" for row in (heads, ["---"] * len(heads), *cells)]
        self._file(suffix, ".md").write_text(
            "\n".join([*lines, "", *([remarks, ""] if remarks else [])])
        )
        with self._file(suffix, ".csv").open("w", newline="") as file:
            csv.writer(file).writerows([heads, *rows])

    def text(self, lines: Sequence[str], suffix: str = "") -> None:
        """Save a table that is Markdown already."""
        self._file(suffix, ".md").write_text("\n".join([*lines, ""]))

    def _file(self, suffix: str, kind: str) -> Path:
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{self.name}{'_' * bool(suffix)}{suffix}{kind}"
        self.files.append(path.name)
        return path

    def _relative(self, path: Path) -> str:
        return Path(os.path.relpath(path, self.folder)).as_posix()


def _listed(values: Mapping) -> str:
    return ", ".join(f"{k}={v}" for k, v in values.items())


@contextmanager
def _named(words: str) -> Iterator[None]:
    """Warnings meanwhile begin with these words: a figure and a run."""

    def name(record: logging.LogRecord) -> bool:
        if record.levelno >= logging.WARNING:
            record.msg, record.args = f"{words}: {record.getMessage()}", ()
        return True

    loggers = [logging.getLogger(n) for n in ("clearance", "clearance.sweep")]
    for logger in loggers:
        logger.addFilter(name)
    try:
        yield
    finally:
        for logger in loggers:
            logger.removeFilter(name)


def _whole(path: Path) -> bool:
    """True for the result of a run that came to its end."""
    try:
        with cl.open_result(path) as result:
            return result.complete
    except (OSError, ValueError, KeyError):  # there is none, or not all of one
        return False


def _digest(case: str, *parts) -> str:
    """Name of all that a result of a case depends on."""
    source = find_case(case).path.read_text(encoding="utf-8")
    text = json.dumps([*parts, source, _sources()], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


@cache
def _sources() -> str:
    """Digest of the package's code, without what only shows or measures."""
    root, beside = Path(inspect.getfile(cl)).parent, {*WITHOUT_PHYSICS, *BESIDE}
    paths = sorted(root.rglob("*.py"))
    return digest_of_code(*(p for p in paths if p.relative_to(root).parts[0] not in beside))
