"""Every film solver against the published and the closed films of `states.py`."""

import math

import numpy as np
import pytest

from clearance.film import bands, fem
from clearance.film.bearing import FilmSolution, Groove
from clearance.film.conserving import MemoryFilm
from clearance.laws.film import wet_film_torques
from tests.film.states import (
    BUTENSCHOEN,
    DEGREES,
    GRIDS,
    KINDS,
    LINE,
    MU,
    OCVIRK,
    RAIMONDI,
    SOMMERFELD,
    C,
    R,
    bearing,
    force,
    moving,
    rows,
    sommerfeld,
)  # fmt: skip

FAST = ""
ELEMENTS = ", finite elements"
OIL = ", finite elements with oil kept"
MEMORY = ", film with memory"
FAR = {FAST: 1.0, ELEMENTS: 0.9, OIL: 0.8, MEMORY: 0.95}  # largest eps that the mesh is for
MESHES = {FAST: (128, 16), ELEMENTS: (64, 8), OIL: (128, 16), MEMORY: (96, 8)}


def solve(solver, of, *state, mesh=None) -> FilmSolution:
    """The film of a bearing in one state, by a solver that is named as its rows are."""
    mesh = mesh or MESHES[solver]
    if solver == FAST:
        return bands.solve(of, *state, mesh)
    if solver != MEMORY:
        return fem.solve(of, *state, mesh)
    # theta is fixed to the bearing: the line is at the widest gap of a journal displaced along +x
    turned = bearing(clearance=0.1 * C, grooves=(Groove(math.pi),))
    x, y, shear, flow = MemoryFilm(turned, mesh).steady(state[0], 0.0, state[2])
    size = of.force_scale / turned.force_scale
    return FilmSolution(of, *[None] * 4, x * size, y * size, shear, 10.0 * flow, 0, 0)


def slow(*values):
    """A case of the slow tests."""
    return pytest.param(*values, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("solver", "slenderness"),
    [(FAST, 1.0), slow(FAST, 0.25), (ELEMENTS, 1.0), slow(ELEMENTS, 0.25)],
)
def test_squeeze(solver, slenderness, validated):
    """Butenschoen's pure squeeze within 0.5 %, where negative eps is a gap that opens.

    His digits near contact, B/D = 1, have 0.44 %.
    """
    for row in rows("squeeze"):
        eps, way = abs(row["eps"]), math.copysign(1.0, row["eps"])
        if row["slenderness"] == slenderness and eps <= FAR[solver]:
            film = solve(solver, bearing(slenderness), eps, way, 0.0)
            label = f"So of squeeze, L/D {slenderness:g}{solver}"
            validated(label, sommerfeld(film), row["So"], 5e-3, **BUTENSCHOEN)
            assert abs(film.tangential) < 1e-9 * film.load
            assert film.radial * way < 0.0


@pytest.mark.parametrize(
    ("solver", "slenderness", "mesh"),
    [
        *((solver, 1.0, None) for solver in FAR),
        slow(FAST, 0.25, None),
        slow(ELEMENTS, 0.25, None),
        slow(MEMORY, 1.0, (256, 24)),
    ],
)
def test_rotation(solver, slenderness, mesh, validated):
    """Butenschoen's film from the widest gap: So 0.5 % (0.6 % at eps 0.99), 0.1 degrees, flow
    0.6 %.

    Within 0.3 % (elements 3e-5), 0.05 degrees and 0.1 % of the film on three grids.
    """
    more = {"cavitation": "mass_conserving"} if solver == OIL else {}
    of = bearing(slenderness, grooves=LINE, **more)
    for row in rows("rotation"):
        if row["slenderness"] != slenderness or row["eps"] > FAR[solver]:
            continue
        film = solve(solver, of, row["eps"], 0.0, 1.0, mesh=mesh)
        actual = sommerfeld(film), math.degrees(film.attitude_angle), film.side_flow / (R * R * C)
        bounds = 6e-3 if row["eps"] > 0.985 else 5e-3, 0.1, 6e-3
        for grids, source in (("", BUTENSCHOEN), ("_on_grids", GRIDS)):
            for name, value, bound in zip(("So", "attitude", "flow"), actual, bounds, strict=True):
                unit = DEGREES if name == "attitude" else {}
                label = f"{name} of rotation, L/D {slenderness:g}{solver}"
                if not math.isnan(row[name + grids]):
                    validated(label, value, row[name + grids], bound, **unit, **source)
            bounds = 3e-3, 0.05, 1e-3
        assert math.sin(film.centre_of_pressure) > 0.0  # journal pressed the way it turns


@pytest.mark.parametrize(
    ("solver", "mesh", "wet"),
    [(FAST, None, 0.72), (ELEMENTS, None, 0.72), (MEMORY, None, 1.0), slow(MEMORY, (256, 24), 1.0)],
)
def test_raimondi(solver, mesh, wet, validated):
    """Raimondi and Boyd's chart of L/D 1: S within 1 %, 0.4 degrees, friction on the journal 1 %.

    At eps 0.4 they are off by 1.4 % and 0.53 degrees. Their friction counts the cavitated arc as
    full of oil, K = 2 pi / sqrt(1 - eps^2); the wet area alone gives 30 to 41 % less, and up to 17
    % less with the streamers of a film with memory. The bearing's is below the journal's by e F_t.
    """
    for row in rows("raimondi"):
        eps, off = row["eps"], row["eps"] == 0.4
        film = solve(solver, bearing(grooves=LINE), eps, 0.0, 1.0, mesh=mesh)
        angle, number = math.degrees(film.attitude_angle), 0.5 / math.pi / sommerfeld(film)
        name = f"L/D 1{solver}"
        validated(f"S, {name}", number, row["s"], 0.015 if off else 0.01, **RAIMONDI)
        bound = 0.6 if off else 0.4
        validated(f"attitude, {name}", angle, row["attitude"], bound, **DEGREES, **RAIMONDI)
        rubs = []
        for shear in (2.0 * math.pi / math.sqrt(1.0 - eps * eps), film.shear):
            journal, other = wet_film_torques(
                eps, film.tangential, shear, 1.0, 0.0, R, C, 2.0 * R, MU
            )
            assert journal + other == pytest.approx(-eps * C * film.tangential, rel=1e-9)
            rubs.append(-journal / (film.load * C))
        validated(f"friction times R/c, {name}", rubs[0], row["friction"], 0.01, **RAIMONDI)
        assert 0.55 * row["friction"] < rubs[1] < wet * row["friction"]


@pytest.mark.parametrize("solver", [FAST, ELEMENTS])
@pytest.mark.parametrize("kind", [*list(KINDS)[:1], *map(slow, list(KINDS)[1:])])
def test_force_map(solver, kind, validated):
    """All directions of motion within 1e-3, eps up to 0.99; finite elements 2e-3 up to 0.8."""
    for row in rows("map"):
        wanted = complex(row[f"{kind} radial"], row[f"{kind} tangential"])
        if row["eps"] > FAR[solver] or np.isnan(wanted):
            continue
        state = moving(row["eps"], math.radians(row["degrees"]))
        actual = complex(*force(solve(solver, bearing(**KINDS[kind]), *state)))
        bound = 1e-3 if solver == FAST else 2e-3
        validated(f"force of any motion ({kind}){solver}", actual, wanted, bound, **GRIDS)


LONG = {  # cavitation -> grooves, So and attitude of the table
    "none": ((), "full"),
    "gumbel": ((), "cut"),
    "reynolds": (LINE, "rupture"),
    "mass_conserving": (LINE, "rupture"),
}


@pytest.mark.parametrize(
    ("solver", "kind", "tolerance", "degrees"),
    [
        *((FAST, kind, 1e-3, 0.02) for kind in list(LONG)[:3]),
        (ELEMENTS, "none", 2e-5, 1e-9),
        (ELEMENTS, "gumbel", 2e-5, 1e-3),
        (ELEMENTS, "reynolds", 3e-4, 0.01),
        (ELEMENTS, "mass_conserving", 5e-3, 0.15),
    ],
)
def test_long(solver, kind, tolerance, degrees, validated):
    """Twice the film of L/D 40 less that of 20 is the infinitely long one.

    The ends of a long bearing take the same load whatever its length, 5 % of it at L/D 20. What is
    left is the error around, of order 2 (fast) and 4, 4, 2 to 4 and 2 (elements).
    """
    grooves, name = LONG[kind]
    around, axial = (128, 8) if solver == FAST else (64, 4)
    for row in rows("long"):
        if solver != FAST and row["eps"] not in (0.1, 0.5, 0.8):
            continue
        shorter, longer = (
            solve(solver, bearing(20.0 * k, cavitation=kind, grooves=grooves), row["eps"], 0.0, 1.0,
                  mesh=(around, axial * k))
            for k in (1, 2)
        )  # fmt: skip
        load, label = row[f"so_{name}"], f"long ({kind}){solver}"
        share = 0.11 if kind == "mass_conserving" else 0.07
        assert sommerfeld(shorter) == pytest.approx(load, rel=share)
        radial, tangential = 2.0 * force(longer) - force(shorter)
        actual = 0.5 * math.hypot(radial, tangential)
        validated(f"So, {label}", actual, load, tolerance, **SOMMERFELD)
        angle = math.degrees(math.atan2(tangential, -radial))
        wanted = row.get(f"attitude_{name}", 90.0)
        validated(f"attitude, {label}", angle, wanted, degrees, **DEGREES, **SOMMERFELD)


@pytest.mark.parametrize("solver", [FAST, ELEMENTS])
def test_short(solver, validated):
    """Ocvirk's pi film, from L/D 0.05 and 0.025 extrapolated: 1e-4 (4e-4 at eps 0.9), 5e-3 degrees.

    What a finite length adds is of second order in L/D: 0.1 % at eps 0.05, 2.6 % at 0.9. Oil that
    leaves: 2 L/D eps, 0.1 % at L/D 0.05.
    """
    motions = {"rotation": (0.0, 1.0), "closing": (1.0, 0.0), "opening": (-1.0, 0.0)}
    label, mesh = f"short{solver}", (128 if solver == FAST else 64, 8)
    for row in rows("short"):
        eps, lengths = row["eps"], (0.05, 0.025)
        if eps > 0.9:
            continue
        for name, state in motions.items():
            films = [
                solve(solver, bearing(x, cavitation="gumbel"), eps, *state, mesh=mesh)
                for x in lengths
            ]
            long, short = (sommerfeld(f) / x**2 for f, x in zip(films, lengths, strict=True))
            bound = 4e-4 if eps > 0.8 else 1e-4
            actual = (4.0 * short - long) / 3.0
            validated(f"So / (L/D)^2, {label}", actual, row[name], bound, **OCVIRK)
            assert long == pytest.approx(row[name], rel=0.03)
            if name == "rotation":
                long, short = (math.degrees(f.attitude_angle) for f in films)
                angle = (4.0 * short - long) / 3.0
                validated(f"attitude, {label}", angle, row["attitude"], 5e-3, **DEGREES, **OCVIRK)
                flow, leaves = films[0].side_flow, 2.0 * lengths[0] * eps * C * R * R
                validated(f"side flow, {label}", flow, leaves, 1e-3, unit="m3/s", **OCVIRK)
