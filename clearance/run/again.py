"""A result again: its scene and the options of its run, from its file."""

from pathlib import Path

import numpy as np

from clearance.results.result import DIMENSIONS, Result, open_result
from clearance.run.start import Beginning
from clearance.scene.scene import Scene

#: attributes with the origin of a scene
ORIGIN = ("case_file", "defaults", "resolved")
#: groups of a result file whose columns are numbers of the motion
COMPARED = (
    "time",
    "bodies",
    "joints",
    "drives",
    "springs",
    "nodes",
    "energy",
    "events",
    "extremes",
    "integrals",
)


def again(path: str | Path | Result) -> tuple[Scene, dict]:
    """Scene of a result and arguments of `simulate`, which make the same result again.

    `scene, options = cl.again("run.h5")`, then `cl.simulate(scene, **options)`: the same numbers to
    the last bit with the same versions of clearance, numpy and numba on the same kind of processor.
    Laws of your own are run from the text that the file has. Raises ValueError with the reason for
    A file that cannot be made again. It is of an older version, of a run with changed numbers, of a
    periodic motion (`--steady`), or `Scene.from_json` refuses it.
    """
    result = path if isinstance(path, Result) else open_result(path)
    reader = result.reader
    attributes = result.attributes
    name = Path(result.path).name
    options = dict(reader.document("", "options")) if "options" in attributes else {}
    if not options:
        raise ValueError(
            f"{name} does not hold the options of its run: "
            "it was written by an older clearance, or not by a run"
        )
    if reader.has("changes"):
        raise ValueError(
            f"{name} cannot be made again: "
            "its numbers were changed on the way, by a program that no file has"
        )
    if reader.has("steady"):
        raise ValueError(
            f"{name} is a periodic motion; solve it again: {attributes.get('command')}"
        )
    scene = Scene.from_json(attributes["scene"])
    scene.parameters.update(reader.document("", "parameters"))
    scene.origin.update({n: str(attributes[n]) for n in ORIGIN if n in attributes})
    if (start := options.get("start")) is not None:
        options["start"] = Beginning(
            **{k: tuple(v) if isinstance(v, list) else v for k, v in start.items()}
        )
    return scene, options


def versions(result: Result) -> dict[str, str]:
    """Versions that a file was made with, by name."""
    return {n: str(v) for n, v in result.attributes.items() if n.startswith("version_")}


def differences(first: Result, second: Result) -> dict[str, float]:
    """Columns that are not the same to the last bit, with their largest relative difference."""
    largest: dict[str, float] = {}
    without = {f"{group}/{name}" for group, name in DIMENSIONS.items()}
    for path in first.reader.columns():
        if path in without or path.partition("/")[0] not in COMPARED:
            continue
        before = first.reader.column(path)
        now = second.reader.column(path) if second.reader.has(path) else None
        if now is None or before.shape != now.shape:
            largest[path] = np.inf
        elif not _same(before, now):
            largest[path] = _apart(before, now)
    return largest


def _same(before: np.ndarray, now: np.ndarray) -> bool:
    """True for the same bits, or the same texts."""
    if before.dtype.kind in "US":
        return np.array_equal(before, now)
    return before.tobytes() == now.tobytes()


def _apart(before: np.ndarray, now: np.ndarray) -> float:
    """Largest difference over the largest value; infinite for texts."""
    if before.dtype.kind not in "fi":
        return np.inf
    size = np.max(np.abs(before), initial=1e-300)
    return float(np.max(np.abs(before - now), initial=0.0) / size)
