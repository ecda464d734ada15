"""The slider with clearance in its guide: rows computed independently of this package, to their printed digits.

Inputs: Flores, Leine and Glocker, Multibody Syst. Dyn. 23 (2010) 165, with compliant corners, K = 1e8 N/m^1.5. The rows
were computed with another formulation by DOP853 at 1e-12 with located contacts; two tolerances agree to 3e-7.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

import clearance as cl

ROWS = list(csv.DictReader((Path(__file__).parent / "slide_rows.csv").read_text().splitlines()))
CORNERS = {"1": "(-1, -1)", "2": "(1, -1)", "3": "(-1, 1)", "4": "(1, 1)"}
MOTIONS = {
    "level": ({"friction": "none"}, "K 1e8, e 0.9, no friction, level"),
    "tilting": (
        {"friction_coefficient": 0.01, "tilt_rate": -0.01},
        "K 1e8, e 0.9, coulomb 0.01, psi' = -0.01 rad/s",
    ),
}


def tolerance(time: float) -> float:
    """Share of a row that the two formulations may differ by: impacts magnify differences as they go on."""
    return 1e-6 if time <= 0.02 else 1e-5


def contacts(result) -> list[tuple[float, str, str]]:
    """Time, corner and kind of each start and end of a contact, in order of time."""
    events, found = result.events, []
    for time, duration, spot in zip(events["time"], events["duration"], events["joint"], strict=True):
        corner = CORNERS[spot.partition("/")[2]]
        found += [(time, corner, "touches"), (time + duration, corner, "leaves")]
    return sorted(found)


@pytest.mark.parametrize("motion", MOTIONS)
def test_rows(motion, validated):
    """Contacts of all corners, crank angle and speed, and tilt up to 40 ms.

    Of two corners that touch together either may stand first.
    """
    numbers, given = MOTIONS[motion]
    contact = "lankarani_nikravesh(stiffness=1e8)"
    scene = cl.load_case("guide_slider", contact=contact, restitution=0.9, **numbers)
    result = cl.simulate(scene, until=0.05, rtol=1e-11, samples=51)
    done, options = contacts(result), {"source": "plain model, DOP853 at 1e-12", "kind": "independent"}
    values = {
        "crank angle": result["crank"].theta, "crank speed": result["crank"].omega, "tilt": result.joint("guide").tilt
    }  # fmt: skip
    rows = [row for row in ROWS if row["given"] == given]
    assert len(rows) > 12
    for row in rows:
        what, value = row["quantity"], float(row["value"])
        if what.startswith("event"):
            time, corner, action = done[int(what.split(":")[0].removeprefix("event ")) - 1]
            assert motion == "level" or what.endswith(f"corner {corner} {action}")
            validated(f"time of contacts, {motion} slider", time, value, tolerance(value), unit="s", **options)
        else:
            name, _, time = what.removesuffix(" s").partition(" at ")
            here = np.argmin(abs(result.time - float(time)))
            found, units = values[name][here], row["unit"]
            allowed = tolerance(float(time))
            validated(f"{name}, {motion} slider", found, value, allowed, unit=units, **options)
