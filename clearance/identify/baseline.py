"""Scores of `cl.fit` on a data set: the baseline that other estimators are compared with."""

import json
import math
from pathlib import Path

import numpy as np

from clearance.identify.free import bounded
from clearance.identify.measured import Measured
from clearance.identify.scene_fit import Curve, Problem
from clearance.identify.scene_parameters import fitted
from clearance.results.reading import open_checked
from clearance.scene.catalogue import find_case
from clearance.sweeping.dataset import KIND, column_of

ROOM = 2.0  # bounds of a label: the ends of its range over and times this


def baseline(path: str | Path, count: int, starts: int = 3) -> dict[str, dict]:
    """Scores of fits to the first records of a data set, by label.

    path: of `records.h5`, see sweeping/dataset.py. The speed is that of the record, other labels
    are fitted with the noise as stated. Scores are the rms error of the logarithm, the share of
    95 % intervals that hold the label, and the number of records.
    Raises ValueError for a data set whose only label is the speed, and for records that `cl.fit`
    refuses, such as of dry contact.
    """
    reader = open_checked(Path(path), *KIND)
    about = reader.attributes()
    labels = {n: reader.column(f"labels/{n}") for n in reader.names("labels")}
    channels = json.loads(about["channels"])
    rows = {c: reader.column(f"records/{column_of(c)}")[:count] for c in channels}
    units = {c: reader.attribute(f"records/{column_of(c)}", "units") for c in channels}
    turns = reader.column("records/angle") / 360.0
    sensor = "noise_", "mounting_"
    names = [n for n in labels if n not in ("done", "speed") and not n.startswith(sensor)]
    if not names:
        raise ValueError(f"{path}: its only label is the speed, which a record states")
    bounds = {n: (labels[n].min() / ROOM, labels[n].max() * ROOM) for n in names}
    case, fixed, lowpass = find_case(about["case"]), json.loads(about["fixed"]), about["lowpass"]
    misses, inside = [], []
    for i in np.flatnonzero(labels["done"][:count]):
        speed = {"speed": float(labels["speed"][i])} if "speed" in labels else {}
        scene, curves = case.scene(**fixed | speed), []
        for c in channels:
            record = Measured(Path(path), c, units[c], "angle", turns, rows[c][i].astype(float))
            noise = float(labels[f"noise_{column_of(c)}"][i])
            curves.append(Curve(record, c, noise, (), json.loads(lowpass)))
        free = [bounded(scene, n, bounds[n]) for n in names]
        result = fitted(Problem(scene, free, curves, float(about["settle"])), starts, 0)
        pairs = [(result.intervals[n], labels[n][i]) for n in names]
        misses.append([math.log(interval.value / true) for interval, true in pairs])
        inside.append([interval.low <= true <= interval.high for interval, true in pairs])
    rms, shares = np.sqrt(np.mean(np.square(misses), axis=0)), np.mean(inside, axis=0)
    scores = zip(names, rms.tolist(), shares.tolist(), strict=True)
    return {
        n: {"rms_of_logarithm": r, "inside_95": s, "records": len(misses)} for n, r, s in scores
    }
