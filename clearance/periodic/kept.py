"""Points of a branch in its file, from which an interrupted `follow` goes on."""

import json
from pathlib import Path

import h5py
import numpy as np

from clearance.periodic.branch import Point
from clearance.periodic.maps import Place

FILE = "follow.h5"
PARTS = ("y", "carried", "touching", "speeds", "ages")  # of a place


def places(points: list[Point]) -> dict[str, tuple[str, str, np.ndarray]]:
    """Columns that bring points back: where they stand, their tangents, phases and outputs."""
    columns = {
        part: ("1", f"{part} of the place", np.array([getattr(p.place, part) for p in points]))
        for part in PARTS
    }
    columns["phase"] = ("turns", "phase of the section", np.array([p.phase for p in points]))
    columns["tangent"] = ("1", "tangent of the curve", _padded([p.tangent for p in points]))
    columns["outputs"] = ("1", "outputs", _padded([p.outputs.ravel() for p in points]))
    return columns


def _padded(rows: list[np.ndarray]) -> np.ndarray:
    """Rows of one length, nan behind the shorter ones."""
    longest = max((row.size for row in rows), default=0)
    return np.array([np.pad(row, (0, longest - row.size), constant_values=np.nan) for row in rows])


def asked(folder: Path) -> tuple[dict, str] | None:
    """The request that a folder's branch answers, and why that ended; None without one."""
    path = folder / FILE
    if not path.exists():
        return None
    try:
        with h5py.File(path) as file:
            request = file.attrs.get("request")
            return None if request is None else (json.loads(request), str(file.attrs["ended"]))
    except (OSError, ValueError, KeyError) as error:
        raise ValueError(f"{path} cannot be read ({error}); give another folder") from None


def points(folder: Path) -> list[Point]:
    """Points of a folder's branch, without the derivatives of their maps."""
    try:
        with h5py.File(folder / FILE) as file:
            branch, places = ({n: d[()] for n, d in file[g].items()} for g in ("branch", "places"))
    except (OSError, KeyError) as error:
        raise ValueError(f"{folder / FILE} cannot be read ({error}); give another folder") from None
    columns = list(branch)
    return [_point(branch, places, columns[0], i) for i in range(len(branch[columns[0]]))]


def _point(branch: dict, places: dict, parameter: str, i: int) -> Point:
    period = int(branch["period"][i])
    outputs, tangent = (
        row[np.isfinite(row)] for row in (places["outputs"][i], places["tangent"][i])
    )
    values = [
        branch[f"multiplier_{k}_real"][i] + 1j * branch[f"multiplier_{k}_imaginary"][i]
        for k in range(1, tangent.size)
    ]
    return Point(
        float(branch[parameter][i]),
        period,
        float(branch["duration"][i]),
        np.array(values),
        float(branch["slope"][i]),
        int(branch["contacts"][i]),
        outputs.reshape(period if outputs.size else 0, -1),
        float(places["phase"][i]),
        Place(*(places[part][i] for part in PARTS)),
        tangent,
        np.zeros((0, 0)),
        branch["kind"][i].decode(),
        int(branch["branch"][i]),
    )
