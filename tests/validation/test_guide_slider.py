"""The slider with clearance in its guide: rows computed independently of this package, to their
printed digits.

Inputs: Flores, Leine and Glocker, Multibody Syst. Dyn. 23 (2010) 165, with compliant corners, K =
1e8 N/m^1.5. The rows were computed with another formulation by DOP853 at 1e-12 with located
contacts; two tolerances agree to 3e-7.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

import clearance as cl


def table(name: str) -> list[dict[str, str]]:
    """Rows of a file beside this one."""
    return list(csv.DictReader((Path(__file__).parent / name).read_text().splitlines()))


ROWS, FILM_ROWS = table("slide_rows.csv"), table("pad_rows.csv")
CORNERS = {"1": "(-1, -1)", "2": "(1, -1)", "3": "(-1, 1)", "4": "(1, 1)"}
MOTIONS = {
    "level": ({"friction": "none"}, "K 1e8, e 0.9, no friction, level"),
    "tilting": (
        {"friction_coefficient": 0.01, "tilt_rate": -0.01},
        "K 1e8, e 0.9, coulomb 0.01, psi' = -0.01 rad/s",
    ),
}


def tolerance(time: float) -> float:
    """Share of a row that the two formulations may differ by: impacts magnify differences as they
    go on.
    """
    return 1e-6 if time <= 0.02 else 1e-5


def contacts(result) -> list[tuple[float, str, str]]:
    """Time, corner and kind of each start and end of a contact, in order of time."""
    events, actual = result.events, []
    for time, duration, spot in zip(
        events["time"], events["duration"], events["joint"], strict=True
    ):
        corner = CORNERS[spot.partition("/")[2]]
        actual += [(time, corner, "touches"), (time + duration, corner, "leaves")]
    return sorted(actual)


@pytest.mark.parametrize("motion", MOTIONS)
def test_rows(motion, validated):
    """Contacts of all corners, crank angle and speed, and tilt up to 40 ms.

    Of two corners that touch together either may stand first.
    """
    numbers, motion_text = MOTIONS[motion]
    contact = "lankarani_nikravesh(stiffness=1e8)"
    scene = cl.load_case("guide_slider", contact=contact, restitution=0.9, **numbers)
    result = cl.simulate(scene, until=0.05, rtol=1e-11, samples=51)
    done, options = (
        contacts(result),
        {"source": "plain model, DOP853 at 1e-12", "kind": "independent"},
    )
    values = {
        "crank angle": result["crank"].theta,
        "crank speed": result["crank"].omega,
        "tilt": result.joint("guide").tilt,
    }
    rows = [row for row in ROWS if row["given"] == motion_text]
    assert len(rows) > 12
    for row in rows:
        quantity, value = row["quantity"], float(row["value"])
        if quantity.startswith("event"):
            time, corner, action = done[int(quantity.split(":")[0].removeprefix("event ")) - 1]
            assert motion == "level" or quantity.endswith(f"corner {corner} {action}")
            validated(
                f"time of contacts, {motion} slider",
                time,
                value,
                tolerance(value),
                unit="s",
                **options,
            )
        else:
            name, _, time = quantity.removesuffix(" s").partition(" at ")
            here = np.argmin(abs(result.time - float(time)))
            actual, units = values[name][here], row["unit"]
            allowed = tolerance(float(time))
            validated(f"{name}, {motion} slider", actual, value, allowed, unit=units, **options)


@pytest.mark.slow
def test_two_films(validated):
    """Both faces in oil, the crank at constant speed: offset, tilt and energy taken out.

    The reference lets the faces slide at the block's own speed and its drag do no work on the
    turning; the part b psi' of the speed is 1e-4 of what tilts the block and 1e-4 of the energy.
    """
    clearance = 0.4e-3
    parts = cl.load_case("guide_slider", friction="none")
    guide = cl.ClearancePrismatic(
        parts.joints[-1].a,
        parts.joints[-1].b,
        name="guide",
        clearance=clearance,
        overlap=0.1,
        height=0.05,
        width=0.02,
        contact=cl.hertz(stiffness=1e8),
        film=cl.full_pad(),
        transition=cl.superposed(),
        lubricant=cl.Lubricant(0.01),
        offset=0.3 * clearance,
        tilt=0.2 * clearance / 0.05,
    )
    drive = cl.Drive(parts.bodies[0], speed=60.0, start=0.0)
    result = cl.simulate(
        cl.Scene(*parts.joints[:-1], guide, drive), until=0.1, rtol=1e-8, samples=101
    )
    actual = result.joint("guide")
    values = {
        "e / c": actual.offset / clearance,
        "psi a / c": actual.tilt * 0.05 / clearance,
        "energy taken out": actual.dissipated,
    }
    rows = [row for row in FILM_ROWS if row["case"] == "slider-crank in two films"]
    options = {"source": "plain model in its own coordinates", "kind": "independent"}
    for row in rows:
        here = np.argmin(abs(result.time - float(row["given"].split("=")[1].removesuffix(" s"))))
        name = row["quantity"]
        value = float(row["value"])
        validated(
            f"{name}, slider in two films",
            values[name][here],
            value,
            1.2e-4,
            unit=row["unit"],
            **options,
        )
    assert np.abs(result.energy.residual).max() < 1e-6 * actual.dissipated[-1]
