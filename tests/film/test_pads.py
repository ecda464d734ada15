"""Oil films of flat pads: rows of another code, the Reynolds equation by quadrature, power, films
with contact.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scipy.integrate import quad

import clearance as cl
from clearance.film import pad_table, table
from clearance.film.pad_law import REST
from clearance.laws.law import PadFace
from clearance.laws.pad import SERIES
from tests.validation.test_guide_slider import FILM_ROWS

FACE = PadFace(0.025, 0.02, 0.01)
SCALE = 8.0 * FACE.viscosity * FACE.width * FACE.half_length**3
LAW = cl.full_pad()


def test_rows():
    """Coefficients at three tilts: the printed digits (1e-10)."""
    rows = [row for row in FILM_ROWS if row["case"] == "pad, full film"]
    assert len(rows) == 9
    for row in rows:
        tau, a = float(row["given"].partition("=")[2]), FACE.half_length
        rates = {"A11": (1.0, 0.0), "A12": (0.0, 1.0 / a), "A22": (0.0, 1.0 / a)}[
            row["quantity"][:3]
        ]
        load, moment, _ = LAW(1e-3, tau * 1e-3 / a, *rates, 0.0, FACE)
        value = moment / a if row["quantity"][:3] == "A22" else load
        assert -value / SCALE * 1e-9 == pytest.approx(float(row["value"]), rel=1e-10, abs=1e-15)


@given(st.floats(-0.95, 0.95), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_reynolds_equation_by_quadrature(tau, closing, turning, sliding):
    """Load, moment and drag from the flow through the gap, integrated numerically: 1e-8 of the
    largest part.

    p' = 12 mu (q(x) - q0) / h^3 with q = (h0' - m U / 2) x + m' x^2 / 2, q0 so that both edges have
    no pressure.
    """
    a, mu, width = FACE.half_length, FACE.viscosity, FACE.width
    gap = 2e-4
    slope, rate, lean, speed = tau * gap / a, 0.1 * closing, 2.0 * turning, 5.0 * sliding
    x, weight = np.polynomial.legendre.leggauss(400)
    x, weight = a * x, a * weight
    h = gap + slope * x
    flow = (rate - 0.5 * slope * speed) * x + 0.5 * lean * x**2
    start = (weight @ (flow / h**3)) / (weight @ h**-3.0)
    gradient = 12.0 * mu * (flow - start) / h**3
    load = -width * (weight @ (x * gradient))
    moment = -width * 0.5 * (weight @ (x**2 * gradient))
    # the moving pad is sheared by mu U / h + h p' / 2 and pushed back by p m
    drag = width * (weight @ (mu * speed / h + 0.5 * h * gradient)) + slope * load
    actual = LAW(gap, slope, rate, lean, speed, FACE)
    size = 12.0 * mu * width * a**3 / (gap * (1.0 - abs(tau))) ** 3
    size *= max(abs(rate) + abs(slope * speed) + a * abs(lean), 1e-6)
    assert actual[0] == pytest.approx(load, abs=1e-8 * size)
    assert actual[1] == pytest.approx(moment, abs=1e-8 * a * size)
    assert actual[2] == pytest.approx(
        drag, abs=1e-8 * max(size * gap / a, mu * width * a * abs(speed) / gap)
    )


@given(st.floats(-0.999, 0.999), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_power_is_taken_out(tau, closing, turning, sliding):
    """-(W h0' + M m') + drag U is never negative, but for rounding."""
    gap = 2e-4
    slope = tau * gap / FACE.half_length
    load, moment, drag = LAW(gap, slope, closing, 40.0 * turning, 50.0 * sliding, FACE)
    parts = load * closing, moment * 40.0 * turning, drag * 50.0 * sliding
    assert parts[2] - parts[0] - parts[1] >= -1e-12 * sum(map(abs, parts))


@pytest.mark.parametrize("state", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.1, -0.3, 4.0)])
def test_series_meets_the_closed_form(state):
    """On both sides of the change, 4e-9 apart: 3e-8, ten slopes of it, and rounding 1e-16 /
    tau^4.
    """
    gap, slope = 2e-4, SERIES * 2e-4 / FACE.half_length
    below, above = (LAW(gap, slope * (1.0 + s * 1e-9), *state, FACE) for s in (-1.0, 1.0))
    assert below == pytest.approx(above, rel=3e-8)


def test_block_sinks_between_two_films():
    """Time from the middle to 0.99 c under 50 N, without mass: a row of another code (10
    digits).
    """
    clearance = 0.5e-3

    def slowness(e):
        loads = [LAW(clearance - side * e, 0.0, -side, 0.0, 0.0, FACE)[0] for side in (1.0, -1.0)]
        return (loads[0] - loads[1]) / 50.0

    (row,) = (row for row in FILM_ROWS if row["id"] == "G21")
    time = quad(slowness, 0.0, 0.99 * clearance, epsrel=1e-12, limit=200)[0]
    assert time == pytest.approx(float(row["value"]), rel=1e-9)


def test_block_tilts_between_two_films():
    """Time from level to psi a / c = 0.9 under 0.5 N m, without inertia: a row of another code.

    It takes the slope for the tilt; they differ by 1e-4 at most.
    """
    clearance = 0.5e-3

    def slowness(psi):
        return -2.0 * LAW(clearance, math.tan(psi), 0.0, 1.0, 0.0, FACE)[1] / 0.5

    (row,) = (row for row in FILM_ROWS if row["id"] == "G22")
    time = quad(slowness, 0.0, 0.9 * clearance / FACE.half_length, epsrel=1e-12)[0]
    assert time == pytest.approx(float(row["value"]), rel=5e-4)


TABLE = cl.pad_table()


def scaled(tau, width, rates):
    """Load and moment over a, of a pad of half length 1 with mu B 8 a^3 / h0^3 = 1, from the
    table.
    """
    gap = 0.01
    face = PadFace(1.0, 2.0 * width, gap**3 / (16.0 * width))
    return TABLE(gap, tau * gap, *rates, 0.0, face)


CAVITATING = [row for row in FILM_ROWS if row["case"] == "pad, finite width, P >= 0"]
STATES = {
    "G24": (0.0, 1.0, (-1.0, 0.0)),
    "G28": (0.6, 0.5, (-1.0, 0.0)),
    "G32": (-0.8, 2.0, (-0.5, 0.8)),
}


@pytest.mark.slow
def test_rows_of_cavitating_pads_of_finite_width():
    """Another code's load and moment: 5e-4 of the load, the table's error between its nodes."""
    assert len(CAVITATING) == 6
    for load, moment in zip(CAVITATING[::2], CAVITATING[1::2], strict=True):
        values = scaled(*STATES[load["id"]])
        expected = float(load["value"]), float(moment["value"])
        assert values[:2] == pytest.approx(expected, abs=5e-4 * expected[0])


def test_squeezed_rectangle():
    """A level pad that closes: the series of Reynolds' equation over a rectangle; the table's
    median error, 1e-5.
    """
    n = np.arange(1, 200, 2)
    series = 1.0 - 192.0 / np.pi**5 * (np.tanh(n * np.pi / 2.0) / n**5).sum()
    assert scaled(0.0, 1.0, (-1.0, 0.0))[0] == pytest.approx(series, rel=1e-5)


def test_error_of_the_table():
    """As the guide has it; a solver on finer grids decides."""
    film_table = table.between(pad_table.PadKey(1.0))
    assert film_table.error < 1.4e-3
    assert film_table.error_median < 1e-5


WIDE = FACE._replace(width=100.0 * 2.0 * FACE.half_length)
COARSE = cl.pad_table(nodes=17, mesh=(32, 32))


@pytest.mark.parametrize(("film", "close"), [(LAW, 1e-9), (COARSE, 0.01)], ids=["full", "table"])
@pytest.mark.parametrize("ratio", [1.5, 4.0])
def test_drag_of_a_slider_bearing(film, close, ratio):
    """The pad moves and is tilted: its drag is the closed form of the flat guide's friction.

    With K = h1 / h2, L = 2a and s = mu U B L / h2, friction is s (4 ln K / (K - 1) - 6 / (K + 1))
    on the guide and s (6 / (K + 1) - 2 ln K / (K - 1)) on the pad. They differ by slope x load.
    Tolerances: 1e-9 of the full film, 1 % of the table, whose pad of B / L = 100 leaks.
    """
    least, speed, length = 1e-4, 0.5, 2.0 * WIDE.half_length
    slope, gap = (ratio - 1.0) * least / length, 0.5 * (ratio + 1.0) * least
    load, _, drag = film(gap, slope, 0.0, 0.0, speed, WIDE)
    size = WIDE.viscosity * speed * WIDE.width * length / least
    steep = math.log(ratio) / (ratio - 1.0)
    guide, pad = 4.0 * steep - 6.0 / (ratio + 1.0), 6.0 / (ratio + 1.0) - 2.0 * steep
    assert drag == pytest.approx(size * guide, rel=close)
    assert drag - slope * load == pytest.approx(size * pad, rel=close)


STATE = st.tuples(*[st.floats(-0.99, 0.99)] + 3 * [st.floats(-1.0, 1.0)])
SHORT = FACE._replace(width=FACE.half_length)  # B / 2a = 0.5, of which a row needs the table too


def in_table(tau, closing, turning, sliding, gap=2e-4):
    """Load, moment, drag and the rates that go with them."""
    rates = closing, 40.0 * turning, 50.0 * sliding
    return TABLE(gap, tau * gap / SHORT.half_length, *rates, SHORT), rates


@given(STATE)
def test_a_mirrored_pad_has_the_opposite_moment(state):
    """Exactly so in the table; 1e-12 of the closing pad's load for rounding."""
    tau, closing, turning, sliding = state
    here, _ = in_table(tau, closing, turning, sliding)
    there, _ = in_table(-tau, closing, -turning, -sliding)
    size = in_table(tau, -abs(closing) - abs(turning) - abs(sliding) - 1e-6, 0.0, 0.0)[0][0]
    assert there[0] == pytest.approx(here[0], abs=1e-12 * size)
    assert there[1] == pytest.approx(-here[1], abs=1e-12 * size)
    assert there[2] == pytest.approx(-here[2], abs=1e-12 * (size + abs(here[2])))


@given(STATE)
@example((0.0, 0.0237, -0.02303, 0.4264))  # the wetted area begins
def test_power_is_taken_out_by_the_table(state):
    """-(W h0' + M m') + drag U is not negative, but for the table's error: 1e-4 of the largest
    power.
    """
    (load, moment, drag), (closing, turning, sliding) = in_table(*state)
    a, slope = SHORT.half_length, state[0] * 2e-4 / SHORT.half_length
    u, w = closing - 0.5 * slope * sliding - REST, a * turning
    assume(math.hypot(u, w) > 1e-9)
    largest = LAW(2e-4, slope, -math.hypot(u, w), 0.0, 0.0, SHORT)[0]
    power = drag * sliding - load * closing - moment * turning
    assert power >= -1e-4 * largest * math.hypot(u, w)


def test_a_gap_that_opens_everywhere_is_empty():
    """No load, no moment, no drag: 1e-4 of those of the closing pad, which splines reach across 45
    degrees.
    """
    opening, _ = in_table(0.5, 0.1, 0.01, 0.0)
    closing, _ = in_table(0.5, -0.1, -0.01, 0.0)
    assert np.abs(opening).max() < 1e-4 * np.abs(closing).max()


@given(
    st.floats(-0.99, 0.99), st.floats(-5.0, -1.3), st.floats(-3.0, 1.0),
    *[st.floats(-math.pi, math.pi)] * 2, *[st.floats(-9.0, 0.0)] * 2,
)  # fmt: skip
def test_ranges8_the_wetted_area_does_not_jump_where_squeeze_and_wedge_turn_round(
    tau, thin, fast, here, there, near, far
):
    """Drag of the sliding over that of a level pad: its change by (u, w) is bounded by 20 over
    U (h0 / a)^2, for any directions of both; 1e-9 for rounding.
    """
    a, speed = SHORT.half_length, 10.0**fast
    gap = a * 10.0**thin
    slope, unresolved = tau * gap / a, speed * (gap / a) ** 2
    level = 2.0 * SHORT.viscosity * SHORT.width * a / gap * speed
    drags, places = [], []
    for angle, size in ((here, near), (there, far)):
        u, w = (unresolved * 10.0**size * f(angle) for f in (math.cos, math.sin))
        load, _, drag = TABLE(gap, slope, u + 0.5 * slope * speed, w / a, speed, SHORT)
        drags.append((drag - 0.5 * slope * load) / level)
        places.append(complex(u, w))
    bound = 20.0 * abs(places[0] - places[1]) / unresolved
    assert abs(drags[0] - drags[1]) < bound * max(1.0, abs(math.atanh(tau) / (tau or 1.0))) + 1e-9


@pytest.mark.parametrize(
    ("film", "transition"),
    [(LAW, cl.superposed(smallest_gap=0.02)), (LAW, cl.load_sharing()), (TABLE, cl.load_sharing())],
    ids=lambda bound: bound.law.name,
)
def test_edges_touch_through_the_film(film, transition):
    """A torque presses a block in oil onto corners across: at rest their couple is the torque.

    Within 1e-3; the ledger closes within a thousand tolerances of what the torque put in.
    """
    body = cl.Body("block", 0.1, 5e-5, points={"P": (0, 0)})
    guide = cl.ClearancePrismatic(
        cl.ground,
        body["P"],
        name="guide",
        clearance=1e-4,
        overlap=0.05,
        height=0.03,
        width=0.02 if film == LAW else SHORT.width,
        contact=cl.hertz(stiffness=1e9),
        film=film,
        transition=transition,
        roughness=1e-6,
        lubricant=cl.Lubricant(0.02),
        tilt=4e-3,
    )
    scene = cl.Scene(guide, cl.Torque(body, 5.0), gravity=(0.0, 0.0))
    result = cl.simulate(scene, until=0.2, rtol=1e-5, samples=401)
    actual = result.joint("guide")
    assert actual.mode[-1] == 3.0
    assert actual.moment[-1] == pytest.approx(-5.0, rel=1e-3)
    couple = 2.0 * actual.contact_force_4[-1] * 0.025
    assert couple == pytest.approx(5.0, rel=0.02)
    assert np.abs(result.energy.residual).max() < 1e-2 * result.energy.input[-1]


def test_what_a_film_needs():
    """Missing lubricant, width and transition are named; a transition needs a film."""
    body = cl.Body("block", 0.1, 5e-5, points={"P": (0, 0)})
    values = {
        "clearance": 1e-4,
        "overlap": 0.05,
        "height": 0.03,
        "contact": cl.hertz(stiffness=1e9),
        "name": "g",
    }
    for more, message in (
        ({}, "film needs lubricant"),
        ({"lubricant": cl.Lubricant(0.05)}, "film needs the width"),
        ({"lubricant": cl.Lubricant(0.05), "width": 0.02}, "film needs a transition"),
    ):
        with pytest.raises(ValueError, match=f"joint g: {message}"):
            cl.ClearancePrismatic(cl.ground, body["P"], film=cl.full_pad(), **values, **more)
    with pytest.raises(ValueError, match="joint g: transition superposed needs a film"):
        cl.ClearancePrismatic(cl.ground, body["P"], transition=cl.superposed(), **values)
