"""Points of a branch in its file, from which an interrupted `follow` goes on."""

from pathlib import Path

import numpy as np

from clearance.motions.branch import Point
from clearance.motions.maps import Place
from clearance.results.reading import Damaged, Reader, open_checked

FILE = "follow.h5"
FORMAT, FORMAT_VERSION = "clearance-branch", 1
TURNS = "turns"  # files of version 0.2 have none
PARTS = ("y", "carried", "touching", "speeds", "ages", TURNS)  # of a place


def places(points: list[Point]) -> dict[str, tuple[str, str, np.ndarray]]:
    """Columns that bring points back: where they stand, their tangents, phases and outputs."""
    rows = {part: [getattr(p.passage, part) for p in points] for part in PARTS}
    drives = max((row.size for row in rows[TURNS]), default=0)
    rows[TURNS] = [np.resize(row, drives) for row in rows[TURNS]]  # zeros for none
    columns = {part: ("1", f"{part} of the place", np.array(rows[part])) for part in PARTS}
    columns["phase"] = ("turns", "phase of the section", np.array([p.phase for p in points]))
    columns["tangent"] = ("1", "tangent of the curve", _padded([p.tangent for p in points]))
    columns["outputs"] = ("1", "outputs", _padded([p.outputs.ravel() for p in points]))
    return columns


def _padded(rows: list[np.ndarray]) -> np.ndarray:
    """Rows of one length, nan behind the shorter ones."""
    longest = max((row.size for row in rows), default=0)
    return np.array([np.pad(row, (0, longest - row.size), constant_values=np.nan) for row in rows])


def opened(folder: Path) -> Reader:
    """The file in a folder. Raises ValueError for one that cannot be read."""
    return open_checked(folder / FILE, "clearance branch", FORMAT, FORMAT_VERSION)


def asked(folder: Path) -> tuple[dict, str, list[dict]] | None:
    """The request that a folder's branch answers, why that ended, and the inputs of its points,
    none where a file does not state them; None without a branch.
    """
    if not (folder / FILE).exists():
        return None
    with opened(folder) as reader:
        inputs = reader.document("", "made", list) if "made" in reader.attributes() else []
        return dict(reader.document("", "request")), reader.attribute("", "ended"), inputs


def points(folder: Path) -> list[Point]:
    """Points of a folder's branch, without the derivatives of their maps.

    Raises Damaged where columns are missing, or are none of a branch.
    """
    with opened(folder) as reader:
        parameter = str(reader.attribute("", "parameter"))
        branch, places = (
            {name: reader.column(f"{group}/{name}") for name in reader.names(group)}
            for group in ("branch", "places")
        )
    lengths = {len(np.atleast_1d(c)) for c in (*branch.values(), *places.values())}
    try:
        (count,) = lengths
        return [_point(branch, places, parameter, i) for i in range(count)]
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise Damaged(
            f"{folder / FILE}: its columns are not those of a branch: {error}; "
            "remove it to begin anew"
        ) from None


def _point(branch: dict, places: dict, parameter: str, i: int) -> Point:
    period = int(branch["period"][i])
    outputs, tangent = (
        row[np.isfinite(row)] for row in (places["outputs"][i], places["tangent"][i])
    )
    values = [
        branch[f"multiplier_{k}_real"][i] + 1j * branch[f"multiplier_{k}_imaginary"][i]
        for k in range(1, tangent.size)
    ]
    unstated = np.full(len(branch[parameter]), np.nan)  # in files that have no errors
    errors = [branch.get(f"multiplier_{k}_error", unstated)[i] for k in range(1, tangent.size)]
    return Point(
        float(branch[parameter][i]),
        period,
        float(branch["duration"][i]),
        np.array(values),
        np.array(errors),
        float(branch["slope"][i]),
        int(branch["contacts"][i]),
        outputs.reshape(period, -1) if outputs.size else np.zeros((0, 0)),
        float(places["phase"][i]),
        Place(**{part: places[part][i] for part in PARTS if part != TURNS or part in places}),
        tangent,
        np.zeros((0, 0)),
        str(branch["kind"][i]),
        int(branch["branch"][i]),
    )
