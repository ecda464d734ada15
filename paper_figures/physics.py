"""Cost of choices of physics, and how far each is from the finest: models, film laws, contact laws
of one case.
"""

import math
import statistics
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from clearance.files.texts import markdown
from clearance.mechanism.build import build
from clearance.results.tables import columns_of, save_tables
from clearance.run.options import Span
from clearance.run.run import Run
from clearance.scene.catalogue import Case
from clearance.scene.joint_options import CONTACTS, FILMS, TRANSITIONS
from clearance.scene.scene import Scene
from clearance.simulation import SimulationError, simulate
from clearance.values import checks

RTOL = 1e-8
REPEATS = 5
SAMPLES = 200  # a turn
SETTLED = 0.5  # share of the run that is left out: the start belongs to no model


@dataclass
class Choice:
    """One choice: case parameters, run time, distance from the finest."""

    name: str
    model: str
    parameters: dict
    seconds: float = math.nan
    distance: float = math.nan
    peak: float = math.nan
    note: str = ""


@dataclass
class Comparison:
    """All choices of a case."""

    title: str
    measure: str
    finest: str
    choices: list[Choice]
    remarks: list[str]


FRICTIONS_SHOWN = ("coulomb", "stribeck", "lugre")


def ladder(case: Case, values: dict, contacts: Iterable[str] = CONTACTS) -> list[Choice]:
    """Choices of the case, coarse to fine; all are compared with the last."""
    parameters = case.parameters
    if "model" not in parameters:
        raise ValueError(
            f"case {case.name} has no parameter model: there is no choice of physics to compare"
        )
    chosen = ("model", "contact", "film", "film_torques", "friction", "transition")
    free = {k: v for k, v in values.items() if k not in chosen}
    finest = list(FILMS)[-1]

    def choice(name: str, model: str, **more) -> Choice:
        return Choice(
            name,
            model,
            {k: v for k, v in (free | {"model": model} | more).items() if k in parameters},
        )

    return [
        choice("ideal joints", "ideal"),
        *(choice(f"dry, {c}", "dry", contact=c, friction="none") for c in contacts),
        *(choice(f"dry, friction {f}", "dry", friction=f) for f in FRICTIONS_SHOWN),
        *(choice(f"film, {f}", "lubricated", film=f) for f in FILMS),
        choice(f"film, {finest}, no drag torques", "lubricated", film=finest, film_torques=False),
        *(
            choice(f"mixed, {finest}, transition {t}", "mixed", film=finest, transition=t)
            for t in TRANSITIONS
        ),
    ]


def compare(
    case: Case,
    values: dict,
    turns: float | None,
    until: float | None,
    progress: Callable[[str], None] = lambda text: None,
    contacts: Iterable[str] = CONTACTS,
) -> Comparison:
    """Run every choice at a tolerance that leaves only the physics, and measure its distance from
    the finest.

    contacts: names of the dry contact laws.
    """
    choices = ladder(case, values, contacts)
    if turns is not None and until is not None:
        raise ValueError("give either turns or until, not both")
    for name, value in (("turns", turns), ("until", until)):
        if value is not None:
            checks.positive(name, value)
    span = {"until": until} if until is not None else {"turns": 6.0 if turns is None else turns}
    rows = {}
    for choice in choices:
        progress(choice.name)
        try:
            scene = case.scene(**choice.parameters)
            rows[choice.name] = _reactions(scene, span)
            choice.seconds = _seconds(scene, span)
        except (SimulationError, ValueError) as reason:
            choice.note = str(reason)
    finest = choices[-1].name
    if finest not in rows:
        raise ValueError(f"the finest choice cannot run: {choices[-1].note}")
    size = np.sqrt((rows[finest] ** 2).mean())
    for choice in choices:
        if choice.name in rows:
            choice.distance = float(
                np.sqrt(((rows[choice.name] - rows[finest]) ** 2).mean()) / size
            )
            choice.peak = float(np.abs(rows[choice.name]).max())
    parameters = " ".join(
        f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in values.items()
    )
    remarks = ["dry runs are chaotic: their distance is one sample of a statistical quantity"]
    return Comparison(
        f"{case.name} {parameters}".strip(),
        "rms of the drive's effort over its rms",
        finest,
        choices,
        remarks,
    )


def _reactions(scene: Scene, span: dict) -> np.ndarray:
    """The drive's effort over the settled part of a run."""
    samples = SAMPLES if scene.turn else 400
    result = simulate(scene, rtol=RTOL, samples_per_turn=samples, error=None, **span)
    name = next(iter(result.file["drives"]))
    channel = "torque" if "torque" in result.file[f"drives/{name}"] else "force"
    values = getattr(result.drive(name), channel)
    result.close()
    return values[int(SETTLED * len(values)) :]


def _seconds(scene: Scene, span: dict) -> float:
    """CPU time of the compiled loop at rtol 1e-6 with all outputs, warm, median of repeats."""
    mechanism = build(scene)
    until = span.get("until") or span["turns"] * scene.turn
    samples = round(SAMPLES * until / scene.turn) + 1 if scene.turn else 401
    seconds = []
    for _ in range(REPEATS + 1):
        run = Run(mechanism, Span(until, samples))
        run.trajectory()
        seconds.append(run.cpu)
    return statistics.median(seconds[1:])


def table(study: Comparison) -> list[str]:
    """The price list as Markdown."""
    heads = study.title, "CPU time", "distance from the finest", "largest effort"
    rows = []
    for c in study.choices:
        cells = f"{c.seconds * 1e3:.3g} ms", f"{c.distance:.2g}", f"{c.peak:.4g}"
        rows.append((c.name, *(("-",) * 3 if c.note else cells)))
    return markdown(heads, rows)


def describe(study: Comparison) -> list[str]:
    """Notes to the table."""
    return [
        f"distance = {study.measure}, from '{study.finest}', second half of the run, rtol "
        f"{RTOL:g};",
        "CPU time of the integration with all outputs at rtol 1e-6, warm, median of repeats",
        *study.remarks,
        *(f"{c.name}: {c.note}" for c in study.choices if c.note),
    ]


def plain(study: Comparison) -> dict:
    """The comparison as one JSON document."""
    return {
        "title": study.title,
        "measure": study.measure,
        "finest": study.finest,
        "choices": [{k: v for k, v in vars(c).items() if k != "parameters"} for c in study.choices],
    }


def save(study: Comparison, folder: str | Path) -> Path:
    """The comparison as HDF5."""
    about = {
        "name": ("1", "choice"),
        "seconds": ("s", "CPU time of the integration, warm"),
        "distance": ("1", study.measure),
    }
    columns = columns_of(study.choices, about)
    attributes = {"title": study.title, "finest": study.finest}
    return save_tables(
        Path(folder) / "physics.h5", "clearance-physics", attributes, {"choices": ({}, columns)}
    )
